"""Performance of a detector of speed limits on scenes: curves, misses, windows, time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import process_time

import numpy as np
import pandas as pd

import nvcore as nv
from nvcore.dataset import Dataset
from nvcore.metrics.detection import DetectionCurve, detection_curve, detection_outcomes, pr_auc
from nvcore.metrics.detection.miss_rate import log_average_miss_rate
from nvcore.metrics.matching import match_system
from nvcore.metrics.shares import share_of
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS
from nvcore.subjects.detectors.icf import IcfDetector
from nvcore.subjects.detectors.icf.cascade import passes
from nvcore.subjects.detectors.icf.channels import check_picture
from nvcore.subjects.detectors.icf.windows import object_windows, window_values
from nvcore.subjects.detectors.suppression import suppress
from scripts.detectors.sign_data import Crop, SignScene, read_rgb

SIZE = (1360, 800)
LEAST_PX = 20
"""Minimum height of a sign. Smaller signs are neither missed nor false."""
PRECISION = 0.95
RESAMPLED = 1000
SEED = 1


@dataclass(frozen=True)
class Run:
    """Detections of all scenes as plain CSV tables, with windows, features and seconds used."""

    truth: pd.DataFrame
    boxes: pd.DataFrame
    n_windows: int
    n_features: int
    seconds: float


def run(scenes: Sequence[SignScene], detector: IcfDetector) -> Run:
    """Run a detector over scenes at every confidence that its cascade passes."""
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
        detections = suppress(detector.candidates(maps), settings.overlap, settings.overlap_of)
        detections = detector.classified(picture, detections)
        seconds += process_time() - start
        n_windows += sum(score_map.n_windows for score_map in maps)
        n_features += sum(score_map.n_features for score_map in maps)
        limits = [""] * len(detections) if detections.label is None else detections.label
        kinds = [f"speed limit {limit}" for limit in limits]
        columns = (detections.x, detections.y, detections.w, detections.h, detections.score, kinds)
        boxes += [(frame, *box) for box in zip(*columns, strict=True)]
    return Run(
        pd.DataFrame(truth, columns=["frame", "x", "y", "w", "h", "ignore", "class"]),
        pd.DataFrame(boxes, columns=["frame", "x", "y", "w", "h", "score", "class"]),
        n_windows,
        n_features,
        seconds,
    )


def dataset_of(result: Run, n_scenes: int) -> Dataset:
    """Convert a run to a dataset of nvcore."""
    return nv.load(
        truth=result.truth,
        x=result.boxes,
        size=SIZE,
        fps=1,
        frames=range(n_scenes),
        objects="speed sign",
    )


def read_right(dataset: Dataset) -> str:
    """Return how many signs found at any confidence have their limit read right."""
    (system,) = dataset.systems
    partner = match_system(dataset, system, None, Params()).truth_det
    read = dataset.system(system).label
    if not (read >= 0).any():
        return "–"
    is_right = read[partner[partner >= 0]] == dataset.truth.label[partner >= 0]
    return share_text(int(is_right.sum()), len(is_right))


def missed(of: DetectionCurve) -> int:
    """Count signs missed at the lowest threshold with a precision of 95 % or more."""
    reached = of.tp[of.precision >= PRECISION]
    return of.n_truth - int(reached.max(initial=0))


def first_with_all(of: DetectionCurve) -> int:
    """Return the point of the highest threshold that finds as many signs as the lowest one."""
    return int(np.argmax(of.tp))


def area_interval(dataset: Dataset) -> tuple[float, float]:
    """Return the 95 % interval of the area under the curve, by resampling scenes."""
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
    """Performance of a detector on scenes.

    Attributes
    ----------
    n_scenes, n_signs
        Numbers of scenes and of signs that count.
    area, low, high
        Area under the curve of precision and recall, with its 95 % interval.
    missed
        Misses at the lowest threshold with a precision of 95 % or more.
    recall, false_positives, fppw
        Values at the highest threshold that finds as many signs as any (`first_with_all`).
    miss_rate
        Log-average miss rate.
    read_right
        Share of found signs whose limit is read right, in words.
    windows, features, seconds
        Windows per scene, features per window, processor seconds per scene.
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
    """Measure the performance of a detector on these scenes."""
    result = run(scenes, detector)
    dataset = dataset_of(result, len(scenes))
    curve = detection_curve(dataset, dataset.systems[0], Params())
    low, high = area_interval(dataset)
    windows = result.n_windows / len(scenes)
    at = first_with_all(curve)
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
    """Count crops whose window the cascade rejects."""
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


def share_text(n_right: int, n_signs: int) -> str:
    """Format a share with its 95 % interval (Wilson)."""
    if not n_signs:
        return "–"
    read = share_of(n_right, n_signs)
    return f"{n_right} of {n_signs} ({read.share:.1%}, {read.low:.1%} to {read.high:.1%})"
