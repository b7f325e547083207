"""Detection curves for tests: written down point by point, or of datasets drawn at random."""

from __future__ import annotations

import numpy as np
from builders import Box, Place, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics.detection.curves import DetectionCurve
from nvcore.settings.protocols import PROTOCOLS


def curve_of(
    tp: list[int], fp: list[int], *, n_truth: int, n_images: int = 100, is_ranked: bool = True
) -> DetectionCurve:
    """A curve with these points, thresholds 1, 1/2, 1/3, ..."""
    threshold = 1 / np.arange(1, len(tp) + 1)
    return DetectionCurve("x", PROTOCOLS["all"], threshold, np.array(tp, dtype=np.int64),
                          np.array(fp, dtype=np.int64), n_truth, n_images, is_ranked)  # fmt: skip


def random_boxes(
    seed: int, *, n_frames: int = 40, n_scores: int | None = None, share_scored: float = 1.0
) -> tuple[list[Box], list[Box], list[Place]]:
    """Truth with ignore regions, detections on and beside it, and two recordings.

    `n_scores`: so many different scores only; None: all differ.
    """
    rng = np.random.default_rng(seed)
    truth, boxes = [], []
    for frame in range(n_frames):
        recording = frame % 2
        for _ in range(rng.integers(0, 5)):
            x, y, w, h = rng.uniform([0, 0, 8, 15], [80, 70, 20, 60])
            truth.append(Box(frame, x, y, w, h, ignore=bool(rng.random() < 0.2),
                             occlusion=int(rng.integers(-1, 3)), recording=recording))  # fmt: skip
            for _ in range(rng.integers(0, 3)):
                dx, dy, dw, dh = rng.normal(0, 2.5, 4)
                boxes.append(Box(frame, x + dx, y + dy, abs(w + dw) + 1, abs(h + dh) + 1,
                                 recording=recording))  # fmt: skip
        for _ in range(rng.integers(0, 3)):
            boxes.append(Box(frame, *rng.uniform([0, 0, 8, 15], [80, 70, 20, 60]),
                             recording=recording))  # fmt: skip
    score = rng.permutation(len(boxes)) / len(boxes)
    if n_scores is not None:
        score = np.floor(score * n_scores) / n_scores
    score[rng.random(len(boxes)) >= share_scored] = np.nan
    scored = [box._replace(score=float(s)) for box, s in zip(boxes, score, strict=True)]
    places = [Place(range(i, n_frames, 2)) for i in (0, 1)]
    return truth, scored, places


def random_dataset(seed: int, **options: float) -> Dataset:
    """The same as a dataset; the system is "x"."""
    truth, found, places = random_boxes(seed, **options)  # type: ignore[arg-type]
    return make_dataset(truth, found, places=places)
