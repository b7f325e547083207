"""Train a detector of speed limits on real signs, and measure it on signs that it has not seen.

    python -m scripts.train_signs [--model FILE] [--evaluate] [--left-out FILE]

Trains on the scenes and crops of `scripts.sign_data` (some ten minutes on two free cores), writes
the model, and the names of what was left out because it resembles a sign of a test scene: crops,
and with `--strict` scenes, too. `--evaluate` only measures a model that is there, `--reader` only
trains and measures what reads the limit in a box (half a minute), and puts it into a model that is
there. The data are those in `$NVCORE_REALDATA` (default: `../shared/realdata`); their licence is
for research, so that models of them do not ship.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import pandas as pd

import nvcore as nv
from nvcore.dataset import Dataset
from nvcore.detection import DetectionCurve, detection_curve, detection_outcomes, pr_auc
from nvcore.detection.miss_rate import log_average_miss_rate
from nvcore.detectors.classifier import Classifier, train_classifier
from nvcore.detectors.icf import (
    SIGNS,
    IcfDetector,
    IcfModel,
    IcfSettings,
    read_model,
    train,
    write_model,
)
from nvcore.detectors.icf.cascade import passes
from nvcore.detectors.icf.channels import check_picture
from nvcore.detectors.icf.windows import object_windows, window_values
from nvcore.detectors.suppression import suppress
from nvcore.metrics.matching import match_system
from nvcore.metrics.shares import share_of
from nvcore.params import Params
from nvcore.protocols import PROTOCOLS
from scripts.sign_data import (
    CHOOSING,
    SPEED_LIMITS,
    TESTED,
    Crop,
    LazyScenes,
    SignScene,
    held_out,
    read_crops,
    read_rgb,
    read_scenes,
    unlike,
    unlike_scenes,
)

ROOT = Path(__file__).resolve().parents[1]
SIZE = (1360, 800)
LEAST_PX = 20
"""Smaller signs are neither missed nor false."""
PRECISION = 0.95
LOWEST = -1e6
"""A threshold that every window passes which the cascade lets through."""
RESAMPLED = 1000
MOVED = (0.08, 0.15)
"""Shares of their sides by which boxes are moved and resized, as those of a detector may be."""
EVERY = 6
"""Every sixth crop and scene with a sign is held out of the training for calibration."""
SEED = 1
Boxes = Iterable[tuple[np.ndarray, np.ndarray, Sequence[str]]]
"""Pictures, the boxes in each, and what each limit says."""


@dataclass(frozen=True)
class Run:
    """Detections of all scenes: tables as of plain CSV; windows, features, seconds that it took."""

    truth: pd.DataFrame
    boxes: pd.DataFrame
    n_windows: int
    n_features: int
    seconds: float


def run(scenes: Sequence[SignScene], detector: IcfDetector) -> Run:
    """Run a detector over scenes, at every confidence that its cascade lets through."""
    truth, boxes = [], []
    n_windows = n_features = 0
    seconds = 0.0
    for frame, scene in enumerate(scenes):
        for (x, y, w, h), limit in zip(scene.boxes, scene.limits, strict=True):
            truth.append((frame, x, y, w, h, int(min(w, h) < LEAST_PX), f"speed limit {limit}"))
        picture = scene.read()
        start = process_time()
        maps = detector.score_maps(picture)
        settings = detector.model.settings
        found = suppress(detector.candidates(maps), settings.overlap, settings.overlap_of)
        found = detector.classified(picture, found)
        seconds += process_time() - start
        n_windows += sum(score_map.n_windows for score_map in maps)
        n_features += sum(score_map.n_features for score_map in maps)
        limits = [""] * len(found) if found.label is None else found.label
        kinds = [f"speed limit {limit}" for limit in limits]
        columns = (found.x, found.y, found.w, found.h, found.score, kinds)
        boxes += [(frame, *box) for box in zip(*columns, strict=True)]
    return Run(
        pd.DataFrame(truth, columns=["frame", "x", "y", "w", "h", "ignore", "class"]),
        pd.DataFrame(boxes, columns=["frame", "x", "y", "w", "h", "score", "class"]),
        n_windows,
        n_features,
        seconds,
    )


def dataset_of(result: Run, n_scenes: int) -> Dataset:
    """The run as data of the product."""
    return nv.load(
        truth=result.truth,
        x=result.boxes,
        size=SIZE,
        fps=1,
        frames=range(n_scenes),
        objects="speed sign",
    )


def read_right(dataset: Dataset) -> str:
    """How many of the signs that are found at any confidence have their limit read right."""
    (system,) = dataset.systems
    partner = match_system(dataset, system, None, Params()).truth_det
    read = dataset.system(system).label
    if not (read >= 0).any():
        return "–"
    is_right = read[partner[partner >= 0]] == dataset.truth.label[partner >= 0]
    return share_text(int(is_right.sum()), len(is_right))


def missed(of: DetectionCurve) -> int:
    """Signs missed at the lowest threshold with a precision of 95 % or more."""
    reached = of.tp[of.precision >= PRECISION]
    return of.n_truth - int(reached.max(initial=0))


def area_interval(dataset: Dataset) -> tuple[float, float]:
    """95 % interval of the area under the curve, by resampling scenes."""
    outcomes = detection_outcomes(dataset, dataset.systems[0], Params())
    truth = outcomes.truth.truth.frame_index[outcomes.truth.counts]
    n = len(dataset.frames)
    rng = np.random.default_rng(SEED)
    areas = []
    for _ in range(RESAMPLED):
        times = np.bincount(rng.integers(0, n, n), minlength=n)
        weight = times[outcomes.frame_index]
        curve = DetectionCurve(
            system="",
            protocol=PROTOCOLS["all"],
            threshold=outcomes.score,
            tp=np.cumsum(weight * outcomes.is_match),
            fp=np.cumsum(weight * ~outcomes.is_match),
            n_truth=int(times[truth].sum()),
            n_images=n,
        )
        areas.append(pr_auc(curve))
    low, high = np.nanpercentile(areas, [2.5, 97.5])
    return float(low), float(high)


@dataclass(frozen=True)
class Measured:
    """How well a detector does on scenes.

    Attributes
    ----------
    n_scenes, n_signs
        Scenes, and signs in them that count.
    area, low, high
        Area under the curve of precision and recall, with its 95 % interval.
    missed
        At the lowest threshold with a precision of 95 % or more.
    recall, false_positives, fppw
        At the lowest threshold of all.
    miss_rate
        Log-average.
    read_right
        Limits of the signs found that are read right, in words.
    windows, features, seconds
        Windows a scene, features a window, seconds of processor time a scene.
    """

    n_scenes: int
    n_signs: int
    area: float
    low: float
    high: float
    missed: int
    recall: float
    false_positives: int
    fppw: float
    miss_rate: float
    read_right: str
    windows: float
    features: float
    seconds: float

    def __str__(self) -> str:
        return (
            f"{self.n_signs} signs in {self.n_scenes} scenes; PR-AUC {self.area:.4f} "
            f"({self.low:.4f} to {self.high:.4f}); missed at a precision of 95 %: {self.missed}; "
            f"highest recall {self.recall:.3f} with {self.false_positives} false positives "
            f"({self.fppw:.2e} per window); log-average miss rate {self.miss_rate:.3f}; "
            f"limits of the signs found read right: {self.read_right}; "
            f"{self.windows:,.0f} windows a scene, {self.features:.1f} features a window, "
            f"{self.seconds:.2f} s of processor time a scene"
        )


def measure(scenes: Sequence[SignScene], detector: IcfDetector) -> Measured:
    """How well the detector does on these scenes."""
    result = run(scenes, detector)
    dataset = dataset_of(result, len(scenes))
    curve = detection_curve(dataset, dataset.systems[0], Params())
    low, high = area_interval(dataset)
    windows = result.n_windows / len(scenes)
    at = int(np.argmax(curve.tp))
    return Measured(
        n_scenes=len(scenes),
        n_signs=curve.n_truth,
        area=pr_auc(curve),
        low=low,
        high=high,
        missed=missed(curve),
        recall=float(curve.recall[at]),
        false_positives=int(curve.fp[at]),
        fppw=float(curve.fppw(windows)[at]),
        miss_rate=log_average_miss_rate(curve),
        read_right=read_right(dataset),
        windows=windows,
        features=result.n_features / result.n_windows,
        seconds=result.seconds / len(scenes),
    )


def rejected(crops: Sequence[Crop], detector: IcfDetector) -> int:
    """Crops whose window the cascade rejects."""
    model = detector.model
    plain = replace(model.settings, copies=0)
    rng = np.random.default_rng(SEED)
    windows = [
        window
        for crop in crops
        for window in object_windows(check_picture(read_rgb(crop.path), True), crop.box, plain, rng)
    ]
    sums = model.trees.running_sums(window_values(windows, plain, model.features))
    return int((~passes(model.settings, model.calibration, sums)).any(axis=1).sum())


@dataclass(frozen=True)
class Examples:
    """What there is to learn, none of it for testing.

    Attributes
    ----------
    scenes, crops
        Of the training.
    alike
        Names of the crops and scenes that were left out, since they resemble a sign of a scene
        for testing.
    """

    scenes: list[SignScene]
    crops: list[Crop]
    alike: list[str]

    def parts(self) -> list[LazyScenes]:
        """What is trained on, and what rejection is calibrated on."""
        limits = [crop for crop in self.crops if crop.is_speed_limit]
        with_signs = [scene for scene in self.scenes if len(scene.boxes)]
        calibrating = {crop.path.name for crop in limits[::EVERY]}
        calibrating |= {scene.path.name for scene in with_signs[::EVERY]}
        return [
            LazyScenes(
                [scene for scene in self.scenes if (scene.path.name in calibrating) == is_out],
                [crop for crop in self.crops if (crop.path.name in calibrating) == is_out],
            )
            for is_out in (False, True)
        ]


def examples(realdata: Path, *, choosing: bool, strict: bool = False) -> Examples:
    """Scenes and crops to train on.

    Parameters
    ----------
    choosing
        Leave out the scenes on which settings are chosen, too.
    strict
        Leave out scenes with a sign that resembles one for testing, too, not only such crops.
    """
    scenes = read_scenes(realdata / "gtsdb" / "train")
    tested = [scene for scene in scenes if scene.number % 4 == TESTED]
    tested += read_scenes(realdata / "gtsdb" / "report")
    out = {TESTED, CHOOSING} if choosing else {TESTED}
    crops, _ = held_out(read_crops(realdata / "gtsrb"))
    crops, alike = unlike(crops, tested)
    holding = [scene for scene in scenes if scene.number % 4 not in out]
    if strict:
        holding, more = unlike_scenes(holding, tested)
        alike += more
    return Examples(holding, crops, alike)


def train_signs(of: Examples, settings: IcfSettings = SIGNS, seed: int = SEED) -> IcfModel:
    """A model of these examples."""
    parts = of.parts()
    start = perf_counter()

    def progress(share: float, what: str) -> None:
        print(f"\r{share:4.0%} {what:40s} {perf_counter() - start:5.0f} s", end="", flush=True)

    model = train(
        parts[0],
        settings,
        name="speed limits",
        label="speed limit",
        seed=seed,
        held_out=parts[1],
        progress=progress,
    )
    print(f"\r{'trained':45s} {perf_counter() - start:5.0f} s")
    return model


def train_reader(realdata: Path) -> Classifier:
    """The classifier alone that a model of `train_signs` has."""
    scenes, _ = examples(realdata, choosing=False).parts()
    start = perf_counter()
    holding = [scene for scene in scenes if scene.labels]
    boxes = ((scene.picture, scene.boxes, scene.labels) for scene in holding)
    reader = train_classifier(boxes, seed=SEED)
    assert reader is not None
    n_signs = sum(len(scene.labels) for scene in holding)
    print(f"trained to read the limits of {n_signs} signs in {perf_counter() - start:.0f} s")
    return reader


def read_in_boxes(name: str, reader: Classifier, boxes: Boxes) -> str:
    """How many limits are read right in the boxes of the truth, in a sentence."""
    n_signs = n_right = 0
    for picture, of_picture, limits in boxes:
        best = reader.probabilities(picture, of_picture).argmax(axis=1)
        n_signs += len(limits)
        n_right += sum(reader.classes[i] == limit for i, limit in zip(best, limits, strict=True))
    return f"{name}: {share_text(n_right, n_signs)} read right"


def reading_in_truth(realdata: Path, reader: Classifier) -> list[str]:
    """How well limits are read where the truth says that there is a sign, in sentences."""
    scenes = read_scenes(realdata / "gtsdb" / "train")
    report = read_scenes(realdata / "gtsdb" / "report")
    tested = [scene for scene in scenes if scene.number % 4 == TESTED]
    _, crops = held_out(read_crops(realdata / "gtsrb"))
    boxes_of: list[tuple[str, Boxes]] = [
        (name, ((scene.read(), scene.boxes, scene.limits) for scene in part if scene.limits))
        for name, part in (("scenes for testing", tested), ("scenes of the report", report))
    ]
    rng = np.random.default_rng(SEED)
    for share in (0.0, *MOVED):
        of_crops = [
            (read_rgb(crop.path), moved(crop.box, share, rng)[None], (SPEED_LIMITS[crop.sign],))
            for crop in crops
        ]
        how = f", boxes moved and resized by up to {share:.0%}" if share else ""
        boxes_of.append((f"crops held out{how}", of_crops))
    return [read_in_boxes(name, reader, boxes) for name, boxes in boxes_of]


def moved(box: np.ndarray, share: float, rng: np.random.Generator) -> np.ndarray:
    """A box whose centre lies elsewhere and whose sides are others, by up to a share of them."""
    across, down, growth = rng.uniform(-share, share, 3)
    size = box[2:] * (1 + growth)
    centre = box[:2] + box[2:] * (0.5 + np.array([across, down]))
    return np.concatenate([centre - size / 2, size])


def share_text(n_right: int, n_signs: int) -> str:
    """A share with its 95 % interval (Wilson)."""
    if not n_signs:
        return "–"
    read = share_of(n_right, n_signs)
    return f"{n_right} of {n_signs} ({read.share:.1%}, {read.low:.1%} to {read.high:.1%})"


def main() -> None:
    """Train, write, measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--model", type=Path, default=Path("signs.npz"))
    parser.add_argument("--left-out", type=Path, default=Path("left_out.txt"))
    parser.add_argument("--evaluate", action="store_true")
    parser.add_argument(
        "--choosing", action="store_true", help="leave out and measure on what settings are for"
    )
    parser.add_argument(
        "--reader",
        action="store_true",
        help="train and measure the classifier of limits alone, and put it into the model",
    )
    parser.add_argument(
        "--strict", action="store_true", help="no scenes with a sign like one tested, either"
    )
    options = parser.parse_args()
    realdata = Path(os.environ.get("NVCORE_REALDATA", ROOT.parent / "shared" / "realdata"))
    if options.reader:
        reader = train_reader(realdata)
        if options.model.is_file():
            write_model(replace(read_model(options.model).model, classifier=reader), options.model)
        print(*reading_in_truth(realdata, reader), sep="\n")
        return
    if not options.evaluate:
        of = examples(realdata, choosing=options.choosing, strict=options.strict)
        model = train_signs(of)
        write_model(model, options.model)
        options.left_out.write_text("".join(f"{name}\n" for name in sorted(of.alike)))
        print(f"{len(of.alike)} crops and scenes with a sign that resembles one of a test scene: "
              f"{options.left_out}")  # fmt: skip
        print(f"{model.n_objects} windows of objects, {model.n_background} of background")
    detector = read_model(options.model).run_with(threshold=LOWEST)
    scenes = read_scenes(realdata / "gtsdb" / "train")
    if options.choosing:
        chosen = [scene for scene in scenes if scene.number % 4 == CHOOSING]
        print("for choosing settings:", measure(chosen, detector))
        return
    tested = [scene for scene in scenes if scene.number % 4 == TESTED]
    print(f"signs of {LEAST_PX} px and more:", measure(tested, detector))
    print("as in the report:", measure(read_scenes(realdata / "gtsdb" / "report"), detector))
    _, crops = held_out(read_crops(realdata / "gtsrb"))
    print(f"rejected of {len(crops)} crops held out: {rejected(crops, detector)}")
    reader = detector.model.classifier
    if reader is not None:
        print(*reading_in_truth(realdata, reader), sep="\n")


if __name__ == "__main__":
    main()
