"""What the boxes of a frame are in a comparison: as the comparison itself has it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from nvcore.dataset import Dataset
from nvcore.dataset.schema import DetectionState
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.metrics.matching import match_system
from nvcore.settings.params import Params
from nvcore.subjects.detectors.base import Detections
from pages import FRAMES, write
from ui.subjects.detectors.outcome import Outcome, outcome_of

PICTURE = np.zeros((240, 320), np.uint8)
"""Half as large as the recording."""
SIDES = [(100, 100, 40, 80), (104, 100, 40, 80), (300, 200, 20, 60), (500, 300, 30, 60)]
SCORES = [0.9, 0.8, 0.7, 0.6]


def opened(folder: Path):
    """Two pedestrians a frame, the second 20 px higher than the third box; the system is `SIDES`.

    The comparison's threshold leaves the last box out.
    """
    boxes = "".join(
        f"night,{frame},{','.join(map(str, sides))},{score}\n"
        for frame in FRAMES
        for sides, score in zip(SIDES, SCORES, strict=True)
    )
    truth = "".join(
        f"night,{frame},100,100,40,80,1\nnight,{frame},300,180,20,60,2\n" for frame in FRAMES
    )
    return load(read_session(write(folder, {"one": boxes}, truth=truth)))


def candidates() -> Detections:
    sides = np.array(SIDES, float).T / 2
    return Detections(*sides, score=np.array(SCORES))


def test_boxes_are_matched_as_in_the_comparison(tmp_path: Path):
    dataset = opened(tmp_path)
    is_counting = np.array([True, True, True, False])
    for params in (Params(), Params(iou=0.6), Params(match="lateral")):
        outcome = outcome_of(dataset, 7, PICTURE, candidates(), is_counting, params, classes=())
        matches = match_system(dataset, "one", 0.65, params)
        expected = matches.state[dataset.system("one").rows_of(7, 8)]
        np.testing.assert_array_equal(outcome.states, expected)
        missed = ~matches.is_matched[dataset.truth.rows_of(7, 8)]
        assert outcome.n_missed == missed.sum()
    strict = outcome_of(dataset, 7, PICTURE, candidates(), is_counting, Params(iou=0.6), classes=())
    assert strict.n_of(DetectionState.MATCHED) == 1
    assert strict.n_of(DetectionState.FALSE_ALARM) == 2
    np.testing.assert_allclose(strict.iou, [1, 36 / 44, 0.5, 0])


def test_truth_that_is_ignored_is_neither_missed_nor_a_false_alarm(tmp_path: Path):
    dataset = opened(tmp_path)
    boxes = dataset.boxes.assign(
        ignore=(dataset.boxes["source"] == 0) & (dataset.boxes["x"] == 300)
    )
    outcome = outcome_in(replace(dataset, boxes=boxes), candidates())
    assert outcome.states[2] == DetectionState.ABSORBED
    assert (len(outcome.truth), len(outcome.ignored), outcome.n_missed) == (1, 1, 0)


def outcome_in(dataset: Dataset, boxes: Detections, *classes: str) -> Outcome:
    """Of boxes that all count, in the first frame."""
    return outcome_of(
        dataset, 0, PICTURE, boxes, np.ones(len(boxes), bool), Params(), classes=classes
    )


def test_boxes_of_other_classes_are_left_out_as_when_they_are_read(tmp_path: Path):
    dataset = opened(tmp_path)
    labels = np.array(["person", "person", "car", "car"], dtype=object)
    outcome = outcome_in(dataset, replace(candidates(), label=labels), "person", "car")
    assert outcome.states.tolist() == [
        DetectionState.MATCHED, DetectionState.FALSE_ALARM, DetectionState.BELOW,
        DetectionState.BELOW,
    ]  # fmt: skip
    strange = replace(candidates(), label=np.full(4, "30", dtype=object))
    outcome = outcome_in(dataset, strange, "30", "50")
    assert outcome.n_of(DetectionState.BELOW) == 0  # no class is called so: all are read


def test_a_picture_without_anybody_is_read_as_the_pictures_of_the_run_are(tmp_path: Path):
    """The detector knows persons, and finds cars alone in this picture."""
    cars = replace(candidates(), label=np.full(4, "car", dtype=object))
    outcome = outcome_in(opened(tmp_path), cars, "person", "car")
    assert outcome.n_of(DetectionState.BELOW) == 4
    assert outcome.n_missed == 2
