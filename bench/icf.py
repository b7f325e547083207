"""Measure the time of the ICF detector on two grids of windows, against numpy.

    python -m bench.icf [--models DIR] [--pictures 10]

The module trains two models on the real signs (`$NVCORE_REALDATA`) and keeps them in the folder:
one with a window of 64 px as in the Aalborg report, at 1360x800 px, scales 1.0 to 1.7, stride 6,
and one of 30 px at 640x480, scales 1.0 to 2.4, stride 6. Times are those of `detect`: windows,
suppression, and reading the limit in each box. Decoding and resizing are done before, and decoding
is timed separately. The last result is the accuracy lost by approximating every other scale's
channels.
"""

from __future__ import annotations

import argparse
import statistics
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np

from nvcore.metrics.detection import WindowGrid, scale_steps
from nvcore.subjects.detectors.icf import (
    SIGNS,
    IcfDetector,
    IcfSettings,
    read_model,
    train,
    write_model,
)
from nvcore.subjects.detectors.icf.cascade import floors
from nvcore.subjects.detectors.icf.channels import (
    channel_planes,
    integral_images,
    levels,
    rescaled,
    resized,
)
from nvcore.subjects.detectors.suppression import suppress
from scripts.detectors.sign_data import TESTED, held_out, read_crops, read_scenes
from scripts.detectors.sign_data import SignScenes as SignScenes
from scripts.realdata import realdata

TREES = (64, 256, 686)
"""Numbers of trees. The report's detector has 686."""


@dataclass(frozen=True)
class Grid:
    """Grid of windows, with their number by the report's formula."""

    name: str
    settings: IcfSettings
    size: tuple[int, int]
    by_formula: int


def of_window(side: int, scales: tuple[float, ...]) -> IcfSettings:
    """Return settings with a window of a size whose object fills 5/6 of it."""
    return replace(
        SIGNS, window_width=side, window_height=side, object_width=side * 5 / 6,
        object_height=side * 5 / 6, scales=scales, stride=6, features=2000,
        trees_per_round=TREES, negatives=5000, negatives_per_round=3000, copies=2,
    )  # fmt: skip


GRIDS = (
    Grid("report", of_window(64, scale_steps(1.0, 1.7, 0.1)), (1360, 800), 122_648),
    Grid("vga", of_window(30, scale_steps(1.0, 2.4, 0.1)), (640, 480), 46_453),
)


def trained(grid: Grid, folder: Path, realdata: Path) -> IcfDetector:
    path = folder / f"icf-{grid.name}.npz"
    if not path.exists():
        print(f"training {path} ...")
        scenes = [s for s in read_scenes(realdata / "gtsdb" / "train") if s.number % 4 != TESTED]
        crops, _ = held_out(read_crops(realdata / "gtsrb"))
        parts = SignScenes(scenes[::2], crops[::2])
        write_model(train(parts, grid.settings, name=grid.name, label="speed limit"), path)
    return read_model(path)


def numpy_loop(detector: IcfDetector, picture: np.ndarray, every: int) -> tuple[float, int]:
    """Return seconds of a plain loop, extrapolated from a sample, and number of windows."""
    model = detector.model
    settings, trees = model.settings, model.trees
    lowest, restarts = floors(settings, model.calibration)
    assert not restarts.any()
    maps = detector.score_maps(picture)
    seconds, n = 0.0, 0
    for score_map, (level,) in zip(maps, levels(*picture.shape[1::-1], settings), strict=True):
        planes = channel_planes(resized(picture, level.width, level.height), settings)
        sums = integral_images(planes)
        rows, columns = level.grid(settings)
        n += rows * columns
        for window in range(0, rows * columns, every):
            row, column = divmod(window, columns)
            start = perf_counter()
            y, x = row * settings.stride, column * settings.stride
            total, tree = 0.0, 0
            while tree < len(trees):
                node = 0
                for depth in (0, 1):
                    channel, x0, y0, x1, y1 = model.features[trees.feature[tree, node], :5]
                    plane = sums[channel]
                    value = (
                        plane[y + y1, x + x1] - plane[y + y0, x + x1]
                        - plane[y + y1, x + x0] + plane[y + y0, x + x0]
                    )  # fmt: skip
                    is_right = value >= trees.threshold[tree, node]
                    node = (1 + is_right) if depth == 0 else 2 * (node - 1) + is_right
                total += trees.leaves[tree, node]
                tree += 1
                if total < lowest[tree - 1]:
                    total = np.nan
                    break
            seconds += perf_counter() - start
            assert np.array_equal(total, score_map.score[row, column], equal_nan=True)
    return seconds * every, n


def measure(grid: Grid, detector: IcfDetector, pictures: list[np.ndarray]) -> None:
    settings = detector.model.settings
    side = settings.window_width
    counted = {
        count: float(WindowGrid(side, side, 6, settings.scales, count).per_image(*grid.size))
        for count in ("area", "whole")
    }
    assert abs(counted["area"] - grid.by_formula) < 1
    detector.detect(pictures[0])
    whole, scanning, features, after, classes = [], [], [], [], []
    for picture in pictures:
        start = perf_counter()
        detector.detect(picture)
        whole.append(perf_counter() - start)
        maps = detector.score_maps(picture)
        start = perf_counter()
        boxes = suppress(detector.candidates(maps), settings.overlap, settings.overlap_of)
        middle = perf_counter()
        detector.classified(picture, boxes)
        after.append(middle - start)
        classes.append(perf_counter() - middle)
        features.append(sum(m.n_features for m in maps) / sum(m.n_windows for m in maps))
    closed = without_windows(detector)
    for picture in pictures:
        start = perf_counter()
        closed.score_maps(picture)
        scanning.append(perf_counter() - start)
    median = statistics.median(whole)
    print(
        f"{grid.name}: {grid.size[0]}x{grid.size[1]}, {counted['whole']:,.0f} whole windows "
        f"({grid.by_formula:,} by the formula), {len(detector.model.trees)} trees: "
        f"{1000 * median:.0f} ms ({1000 * min(whole):.0f} to {1000 * max(whole):.0f}), "
        f"{1 / median:.1f} pictures a second; {statistics.mean(features):.1f} features a window; "
        f"channels and integral images {1000 * statistics.median(scanning):.0f} ms of it, "
        f"suppression {1000 * statistics.median(after):.1f} ms, "
        f"classes of the boxes {1000 * statistics.median(classes):.1f} ms"
    )
    seconds, n = numpy_loop(detector, pictures[0], every=200)
    print(f"  windows by a plain loop over numpy arrays: {seconds:.1f} s for {n:,}; "
          f"{seconds / max(whole[0] - scanning[0], 1e-3):,.0f} times as long as here")  # fmt: skip


def approximation_error(
    detector: IcfDetector, picture: np.ndarray, scale: float, near: float
) -> dict[str, float]:
    """Return the mean absolute error of approximated channels relative to the channel's mean."""
    model, sides = detector.model, np.array(picture.shape[1::-1])
    sizes = [(sides / at + 1e-6).astype(int).tolist() for at in (scale, near)]
    exact, planes = (channel_planes(resized(picture, *size), model.settings) for size in sizes)
    apart = np.abs(rescaled(planes, *sizes[0], model.powers).astype(float) - exact)
    ratio = apart.mean(axis=(1, 2)) / exact.mean(axis=(1, 2))  # NaN if a channel is all 0
    return dict(zip(model.channels, ratio.tolist(), strict=True))


def show_approximation(detector: IcfDetector, pictures: list[np.ndarray]) -> None:
    """Print the error of channels approximated from the previous scale."""
    scales = detector.model.settings.scales
    errors = [
        approximation_error(detector, picture, scale, before)
        for picture in pictures
        for before, scale in zip(scales[::2], scales[1::2], strict=False)
    ]
    means = {name: statistics.mean(error[name] for error in errors) for name in errors[0]}
    told = ", ".join(f"{name} {mean:.3f}" for name, mean in means.items())
    print("  every other scale approximated: mean absolute error of a pixel, as a share of the "
          f"mean of the channel: {told}")  # fmt: skip


def without_windows(detector: IcfDetector) -> IcfDetector:
    """Return the same detector without windows, which leaves only channels and integral images."""
    nowhere = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return detector.run_with(region=nowhere)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--models", type=Path, default=Path())
    parser.add_argument("--pictures", type=int, default=10)
    options = parser.parse_args()
    folder = realdata()
    scenes = read_scenes(folder / "gtsdb" / "train")
    scenes = [scene for scene in scenes if scene.number % 4 == TESTED][: options.pictures]
    reading = []
    decoded = []
    for scene in scenes:
        start = perf_counter()
        decoded.append(scene.read())
        reading.append(perf_counter() - start)
    print(f"decoding a scene: {1000 * statistics.median(reading):.0f} ms")
    for grid in GRIDS:
        pictures = [cv2.resize(picture, grid.size) for picture in decoded]
        detector = trained(grid, options.models, folder)
        measure(grid, detector, pictures)
        show_approximation(detector, pictures)


if __name__ == "__main__":
    main()
