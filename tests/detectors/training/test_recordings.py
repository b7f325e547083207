"""What of a session is learned, held out, ignored, and noted."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from places import SAMPLE

import nvcore as nv
from nvcore.common.errors import InputError, ParameterError
from nvcore.dataset import Dataset
from nvcore.pictures import RecordingPictures, session_pictures
from nvcore.subjects.detectors.calls.arguments import TrainArguments
from nvcore.subjects.detectors.icf import PEDESTRIANS
from nvcore.subjects.detectors.training.overlap import trained_part
from nvcore.subjects.detectors.training.recordings import MOST_OBJECTS, session_shots
from nvcore.subjects.detectors.training.shots import TrainingData

N_FRAMES = 40


class Still:
    """Grey pictures of half the recordings' size."""

    n, width, height, name = N_FRAMES, 160, 120, "still"

    def read(self, index: int) -> np.ndarray:
        return np.full((self.height, self.width), index, np.uint8)


def made(rows: list[tuple[str, int, float, float, float, float, int, int]]) -> Dataset:
    columns = ["recording", "frame", "x", "y", "w", "h", "track", "ignore"]
    truth = pd.DataFrame(rows, columns=columns)
    return nv.load(truth=truth, x=truth.assign(score=1.0), size=(320, 240), fps=10,
                   frames=range(N_FRAMES))  # fmt: skip


def learned(**changes: Any) -> TrainArguments:
    return TrainArguments(None, "model.npz", **changes)


def shots_of(dataset: Dataset, **choice: Any) -> TrainingData:
    n = len(dataset.recordings)
    pictures = RecordingPictures(
        {number: Still() for number in range(n)},  # type: ignore[misc]
        {number: np.arange(N_FRAMES) for number in range(n)},
    )
    return session_shots(dataset, pictures, PEDESTRIANS, learned(**choice))


def walkers(*recordings: str, tracks: int = 2) -> Dataset:
    return made(
        [
            (name, frame, 20.0 + 60 * track, 40, 20, 60, track, 0)
            for name in recordings
            for frame in range(N_FRAMES)
            for track in range(tracks)
        ]
    )


def test_boxes_are_in_pixels_of_the_pictures():
    shot = shots_of(walkers("a")).shots[3]
    both = np.concatenate([shot.learned, shot.held_out])
    assert sorted(both.tolist()) == [[10, 20, 10, 30], [40, 20, 10, 30]]
    assert (shot.read() == 3).all()


def test_what_cannot_be_learned_is_neither_object_nor_background():
    whole, low, cut_off, flagged = (
        (100.0, 40, 20, 60, 0, 0),
        (150.0, 40, 8, 25, 1, 0),
        (-4.0, 40, 20, 60, 2, 0),
        (200.0, 40, 20, 60, 3, 1),
    )
    rows = [("a", 0, *box) for box in (whole, low, cut_off, flagged)]
    shot = shots_of(made([*rows, ("a", 9, *whole)]), split="time").shots[0]
    assert shot.learned.tolist() == [[50, 20, 10, 30]]
    assert len(shot.ignored) == 3
    lower = shots_of(made([*rows, ("a", 9, *whole)]), split="time", least_height=25).shots[0]
    assert len(lower.learned) == 2


def test_boxes_to_learn_have_the_class_of_the_truth():
    columns = ["recording", "frame", "x", "y", "w", "h", "track", "class"]
    rows = [
        ("a", frame, 20.0 + 60 * track, 40, 20, 60, track, name)
        for frame in range(N_FRAMES)
        for track, name in enumerate(("speed limit 30", "speed limit 50", "speed limit"))
    ]
    truth = pd.DataFrame(rows, columns=columns)
    dataset = nv.load(truth=truth, x=truth.assign(score=1.0), size=(320, 240), fps=10,
                      frames=range(N_FRAMES), objects="speed sign")  # fmt: skip
    for shot in shots_of(dataset, share=0.3).shots:
        place = {10: "30", 40: "50", 70: ""}
        assert [place[int(x)] for x in shot.learned[:, 0]] == [*shot.labels]
        assert len(shot.labels) == 2
    assert not any(map(any, (shot.labels for shot in shots_of(walkers("a")).shots)))


def test_frames_without_a_box_are_background():
    shots = shots_of(made([("a", 0, 100, 40, 20, 60, 0, 0), ("a", 30, 100, 40, 20, 60, 1, 0)]))
    assert len(shots.shots) == N_FRAMES
    assert all(shot.has_background for shot in shots.shots)


def test_an_object_is_learned_or_held_out_as_a_whole():
    given = shots_of(walkers("a", "b", tracks=4), share=0.25, seed=3)
    assert given.held_out == "2 of 8 physical objects"
    for name in "ab":
        own = [shot for shot in given.shots if shot.source == name]
        learned = {tuple(box) for shot in own for box in shot.learned}
        held_out = {tuple(box) for shot in own for box in shot.held_out}
        assert not learned & held_out
        assert len(learned | held_out) == 4


def test_whole_recordings_are_held_out():
    for choice in ({"hold_out": ("b",)}, {"split": "recording", "share": 0.5, "seed": 0}):
        given = shots_of(walkers("a", "b"), **choice)
        (out,) = {shot.source for shot in given.shots if len(shot.held_out)}
        assert given.held_out == out
        own = [shot for shot in given.shots if shot.source == out]
        assert not any(len(shot.learned) or shot.has_background for shot in own)
        others = [shot for shot in given.shots if shot.source != out]
        assert len(others) == N_FRAMES
        assert not any(len(shot.held_out) for shot in others)


def test_the_end_of_each_recording_is_held_out_after_a_gap():
    given = shots_of(walkers("a", "b"), split="time", share=0.25, gap=5)
    for name in "ab":
        own = [shot for shot in given.shots if shot.source == name]
        learned = [int(shot.read()[0, 0]) for shot in own if len(shot.learned)]
        held_out = [int(shot.read()[0, 0]) for shot in own if len(shot.held_out)]
        assert (learned, held_out) == ([*range(25)], [*range(30, 40)])
        assert len(own) == 35


def test_without_tracks_recordings_or_time_are_split():
    def untracked(dataset: Dataset) -> Dataset:
        return replace(dataset, boxes=dataset.boxes.assign(track=np.int64(-1)))

    assert "last 10 %" in shots_of(untracked(walkers("a"))).held_out
    assert shots_of(untracked(walkers(*"abcd"))).held_out in "abcd"
    with pytest.raises(ParameterError, match="boxes without a track"):
        shots_of(untracked(walkers("a")), split="object")


def test_what_is_noted_is_what_the_audit_knows_also_of_thinned_frames():
    dataset = walkers("a", "b")
    every = shots_of(dataset).trained_on
    assert every == (trained_part(dataset, "a"), trained_part(dataset, "b"))
    assert shots_of(dataset, every=7, hold_out=("b",)).trained_on == every
    part = shots_of(dataset, frames="10:19")
    assert part.trained_on == tuple(trained_part(dataset, name, 10, 19) for name in "ab")
    assert len(part.shots) == 20


def test_many_frames_are_thinned_out():
    dataset = nv.load(SAMPLE)
    pictures = session_pictures(dataset.settings, dataset)  # type: ignore[arg-type]
    given = session_shots(dataset, pictures, PEDESTRIANS, learned(least_height=8))
    n_boxes = sum(len(shot.learned) + len(shot.held_out) for shot in given.shots)
    assert given.every == 2
    assert MOST_OBJECTS / 2 < n_boxes < MOST_OBJECTS
    assert len(given.shots) == 1500


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"hold_out": ("c",)}, "hold_out: there is no recording 'c', or it is not among those cho"),
        ({"hold_out": ("a",)}, "hold_out: every recording chosen is held out; one at least"),
        ({"split": "recording"}, "a single recording cannot be split"),
        ({"frames": "90:"}, "no evaluated frame is in '90:': a has frames 0 to 39"),
        ({"least_height": 200}, "no box of the truth can be learned"),
        ({"split": "person"}, "split: expected one of auto, object, recording and time"),
        ({"every": 0}, "every: expected 1 or more"),
        ({"gap": -1}, "gap: expected 0 or more"),
        ({"share": 1.0}, "share: expected more than 0 and less than 1"),
        ({"least_height": float("nan")}, "least_height: expected 0 px or more"),
    ],
)
def test_what_is_not_possible_is_said(choice: dict[str, object], words: str):
    with pytest.raises((InputError, ParameterError), match=words):
        shots_of(walkers("a"), **choice)


def test_frames_without_a_picture_are_counted():
    dataset = walkers("a", "b")
    index = np.arange(N_FRAMES)
    pictures = RecordingPictures(
        {0: Still(), 1: Still()},  # type: ignore[dict-item]
        {0: np.where(index < 5, -1, index), 1: index},
    )
    assert session_shots(dataset, pictures, PEDESTRIANS, learned()).notes == (
        "5 of 40 frames of a: no picture",
    )
    asked = session_shots(dataset, pictures, PEDESTRIANS, learned(frames="4:"))
    assert asked.notes == ("1 of 36 frames of a: no picture",)


def test_recordings_without_pictures_are_named():
    dataset = walkers("a", "b")
    pictures = RecordingPictures(
        {0: Still()},  # type: ignore[dict-item]
        {0: np.arange(N_FRAMES)},
        notes={1: "there is no such file"},
    )
    given = session_shots(dataset, pictures, PEDESTRIANS, learned())
    assert given.notes == ("b: there is no such file",)
    assert [part.recording for part in given.trained_on] == ["a"]
    with pytest.raises(InputError, match="no evaluated frame has a picture"):
        session_shots(dataset, RecordingPictures(), PEDESTRIANS, learned())
