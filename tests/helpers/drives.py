"""Drives on which X is better than Y, and their evidence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from builders import NAN, Box, Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.evidence.measures import significance_table


def drives(n: int) -> Dataset:
    """n recordings of 5 pedestrians, 4 frames each; X detects more, at about equal false alarms."""
    rng, alarms = np.random.default_rng(0), np.random.default_rng(35)
    truth, x, y = [], [], []
    for number in range(n):
        for track in range(5):
            centre = 50 + 10 * rng.random()
            hard = rng.random()
            for frame in range(4 * track, 4 * track + 4):
                truth.append(at(frame, centre, track=track, recording=number))
                if hard < 0.9:
                    x.append(at(frame, centre + 0.3 * rng.random(), recording=number))
                if hard + 0.1 * rng.normal() < 0.6:
                    y.append(at(frame, centre + 0.3 * rng.random(), recording=number))
                if alarms.random() < 0.05:
                    x.append(at(frame, 80, recording=number))
                if rng.random() < 0.05:
                    y.append(at(frame, 20, recording=number))
    return make_dataset(truth, x, y, places=[Place(range(20)) for _ in range(n)])


def quiet_drives(n: int) -> Dataset:
    """The same without false alarms."""
    dataset = drives(n)
    centre = dataset.boxes["x"] + dataset.boxes["w"] / 2
    return replace(dataset, boxes=dataset.boxes[centre.between(45, 65)])


def turned_by_strict_pairing(n: int = 12) -> Dataset:
    """n recordings in which Y's false alarms stand beside the pedestrians that it misses.

    Y misses half of the frames, and has a false alarm 10 px beside the pedestrian there; X misses a
    quarter, and has as many false alarms at the picture's edge.
    """
    truth, x, y = [], [], []
    for number in range(n):
        for frame in range(20):
            truth.append(at(frame, 50, track=1, recording=number, w=10))
            if frame % 4:
                x.append(at(frame, 50, recording=number, w=10))
            if frame % 2:
                x.append(at(frame, 5, recording=number, w=10))
            y.append(at(frame, 50 if frame % 4 > 1 else 60, recording=number, w=10))
    return make_dataset(truth, x, y, places=[Place(range(20))] * n)


def detector(
    seed: int, *, share: float = 0.85, cut: float = 0.0, n: int = 12, has_scores: bool = True
) -> list[Box]:
    """Of four pedestrians in 20 frames of n recordings, and an alarm in about every other frame."""
    rng, boxes = np.random.default_rng(seed), []
    for number in range(n):
        for frame in range(20):
            for centre in (20, 40, 60, 80):
                hit, score = rng.random() < share, rng.random()
                if hit:
                    boxes.append(at(frame, centre, recording=number, score=score))
            alarm, score = rng.random() < 0.5, 0.9 * rng.random()
            if alarm:
                boxes.append(at(frame, 5, recording=number, score=score))
    boxes = [box for box in boxes if box.score >= cut]
    return boxes if has_scores else [box._replace(score=NAN) for box in boxes]


def at_thresholds(scores: bool = True, n: int = 8) -> Result:
    """One detector twice: X with all its boxes, Y with those of a score of 0.5 or more."""
    rng = np.random.default_rng(5)
    truth, boxes = [], []
    for number in range(n):
        for frame in range(20):
            for track, centre in enumerate((20, 40, 60, 80)):
                truth.append(at(frame, centre, track=track, recording=number))
                if rng.random() < 0.9:
                    boxes.append(at(frame, centre, recording=number, score=rng.random()))
            if rng.random() < 0.5:
                boxes.append(at(frame, 5, recording=number, score=0.6 * rng.random()))
    strict = [box for box in boxes if box.score >= 0.5]
    if not scores:
        boxes, strict = ([box._replace(score=NAN) for box in some] for some in (boxes, strict))
    return result_of(make_dataset(truth, boxes, strict, places=[Place(range(20))] * n))


def by_figure(result: Result) -> pd.DataFrame:
    return significance_table(result).set_index("figure")
