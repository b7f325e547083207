"""Recordings whose truth is nearly that of another one: exported or annotated twice."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import Box, Place, at, make_dataset

import nvcore as nv
from bench.claims import SCENARIOS, draw_dataset
from bench.drives import WIDTH, draw_drives
from nvcore.auditing.copies import audit_copies
from nvcore.common.findings import Severity
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.copies import units_of
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.units import find_units

SIDES = ["x", "y", "w", "h"]
SAMPLE = Path(__file__).parents[2] / "sample_data"

Change = Callable[[pd.DataFrame], pd.DataFrame]


def rounded(decimals: int) -> Change:
    return lambda boxes: boxes.assign(**boxes[SIDES].round(decimals).clip(lower=1))


def moved(boxes: pd.DataFrame) -> pd.DataFrame:
    return boxes.assign(x=boxes["x"] + 1)


def mirrored(boxes: pd.DataFrame) -> pd.DataFrame:
    return boxes.assign(x=WIDTH - boxes["x"] - boxes["w"])


def halved(boxes: pd.DataFrame) -> pd.DataFrame:
    return boxes.assign(**boxes[SIDES] / 2)


def cropped(boxes: pd.DataFrame) -> pd.DataFrame:
    """The left 20 px are cut off."""
    left = (boxes["x"] - 20).clip(lower=0)
    right = boxes["x"] + boxes["w"] - 20
    return boxes.assign(x=left, w=right - left)[right - left > 1]


def jittered(boxes: pd.DataFrame) -> pd.DataFrame:
    noise = np.random.default_rng(1).normal(0, 0.02, (len(boxes), 4))
    return boxes.assign(**boxes[SIDES] + noise)


def redrawn(boxes: pd.DataFrame) -> pd.DataFrame:
    """Somebody else draws boxes by hand, begins or ends with some a bit later, forgets others."""
    rng = np.random.default_rng(2)
    n, h = len(boxes), boxes["h"]
    w = boxes["w"] * np.exp(rng.normal(0, 0.06, n))
    tall = h * np.exp(rng.normal(0, 0.04, n))
    x = boxes["x"] + boxes["w"] / 2 + rng.normal(0, 0.03, n) * h - w / 2
    y = boxes["y"] + h / 2 + rng.normal(0, 0.03, n) * h - tall / 2
    person = boxes.groupby(["recording", "track"])["frame_index"]
    age, left = person.rank() - 1, person.rank(ascending=False) - 1
    late = pd.Series(rng.integers(0, 4, 1000)[(7 * boxes["track"]) % 1000], boxes.index)
    is_kept = (rng.random(n) > 0.05) & (np.where(boxes["track"] % 2, age, left) >= late)
    tracks = rng.permutation(1000)[boxes["track"]]
    return boxes.assign(x=x, y=y, w=w, h=tall, track=tracks)[is_kept]


KINDS = {
    "0.1 px": (rounded(1), "the same but for rounding"),
    "1 px": (rounded(0), "the same but for rounding"),
    "moved": (moved, "moved by 1.0, 0.0 px"),
    "mirrored": (mirrored, "mirrored"),
    "halved": (halved, "scaled by 0.5"),
    "cropped": (cropped, "moved by -20.0, 0.0 px"),
    "jittered": (jittered, "the same but for rounding"),
    "redrawn": (redrawn, "annotated again"),
}


def with_copies(dataset: Dataset, change: Change, *, later: int = 0) -> Dataset:
    """Every recording twice: the second time with changed truth, and frame numbers."""
    n, n_frames = len(dataset.recordings), len(dataset.frames)
    recording = dataset.frame_columns.recording
    boxes = dataset.boxes.assign(recording=recording[dataset.boxes["frame_index"]])
    truth, detections = boxes[boxes["source"] == 0], boxes[boxes["source"] > 0]
    second = pd.concat([change(truth), detections])
    second["frame_index"] += n_frames
    both = pd.concat([boxes, second], ignore_index=True).drop(columns="recording")
    frames = [dataset.frame_columns.frame[recording == row] for row in range(n)]
    facts = dataset.recordings[["width", "height", "fps"]]
    recordings = pd.concat([facts, facts], ignore_index=True)
    recordings.insert(0, "name", [f"r{row}" for row in range(2 * n)])
    listed = [*frames, *(own + later for own in frames)]
    return dataset_from_tables(recordings, listed, both, dataset.systems)


def drives(seed: int = 5, n: int = 6) -> Dataset:
    return draw_drives("equal", n, np.random.default_rng(seed))


@pytest.mark.parametrize("kind", KINDS)
def test_every_recording_that_was_nearly_copied_is_found(kind: str):
    change, relation = KINDS[kind]
    dataset = with_copies(drives(), change, later=100)
    assert sorted((copy.first, copy.second) for copy in dataset.copies) == [
        (row, row + 6) for row in range(6)
    ]
    assert {copy.relation for copy in dataset.copies} == {relation}
    assert {copy.shift_frames for copy in dataset.copies} == {100}
    assert min(copy.share for copy in dataset.copies) > 0.9
    assert units_of(dataset).tolist() == [f"r{row}" for row in range(6)] * 2


def test_near_copies_are_a_warning_that_says_how_they_relate():
    dataset = with_copies(drives(), mirrored, later=100)
    (finding,) = audit_copies(dataset)
    assert (finding.severity, finding.code) == (Severity.WARNING, "nearly-copied-recording")
    assert finding.count == 6
    assert ", 100 % of the smaller, mirrored, +100 frames apart)" in finding.message
    assert finding.message.endswith(" and 3 other pairs.")


def test_tests_count_near_copies_once():
    units = find_units(compare(with_copies(drives(), redrawn)))
    assert (len(units), units.n_recordings) == (6, 12)


def test_units_that_are_stated_for_both_settle_it():
    dataset = with_copies(drives(), redrawn)
    named = dataset.recordings.assign(unit=dataset.recordings["name"])
    stated = replace(dataset, recordings=named)
    assert [*audit_copies(stated)] == []
    assert units_of(stated).tolist() == named["name"].tolist()


def test_copies_of_copies_are_one_unit_and_the_same_boxes_stay_an_error():
    dataset = with_copies(with_copies(drives(), rounded(0)), lambda boxes: boxes)
    assert units_of(dataset).tolist() == [f"r{row}" for row in range(6)] * 4
    severities = [finding.severity for finding in audit_copies(dataset)]
    assert severities == [Severity.ERROR, Severity.WARNING]


def test_copies_of_a_part_are_found():
    sample = nv.load(SAMPLE / "session.toml")  # of 300 frames each
    dataset = with_copies(sample, lambda boxes: halved(boxes[boxes["frame_index"] % 300 >= 60]))
    found = {(copy.first, copy.second) for copy in dataset.copies}
    n = len(sample.recordings)
    assert all(second == first + n for first, second in found)
    assert len(found) >= 0.7 * n


@pytest.mark.parametrize("seed", range(4))
def test_recordings_of_different_people_are_not_linked(seed: int):
    rng = np.random.default_rng(seed)
    assert drives(100 + seed, 60).copies == ()
    for scenario in ("equal", "lengths"):
        assert draw_dataset(SCENARIOS[scenario], 60, rng).copies == ()


def scene(boxes: Callable[[int, np.random.Generator], Iterable[Box]], n: int = 4) -> Dataset:
    """Recordings of a kind, each drawn by itself, and no box exactly where another is."""
    rng = np.random.default_rng(1)
    truth = [
        box._replace(recording=row, x=box.x + rng.normal(0, 0.1))
        for row in range(n)
        for box in boxes(row, rng)
    ]
    places = [Place(range(300), width=640, height=480)] * n
    return make_dataset(truth, places=places, is_independent=False)


def standing(row: int, rng: np.random.Generator) -> list[Box]:
    return [at(frame, 300, track=1) for frame in range(120)]


def parked(row: int, rng: np.random.Generator) -> list[Box]:
    """Five people who stand at the same places, and one who passes at a time of its own."""
    first = int(rng.integers(10, 100))
    still = [
        at(frame, 60 + 90 * who, h=40 + 10 * who, track=who)
        for frame in range(150)
        for who in range(5)
    ]
    return still + [at(first + age, 600 - 15 * age, track=9) for age in range(30)]


def walking(row: int, rng: np.random.Generator) -> list[Box]:
    """Eight people of one height at one speed, who come whenever they like."""
    return [
        at(start + age, 20 + 4 * age, track=who)
        for who, start in enumerate(rng.integers(0, 150, 8))
        for age in range(150)
    ]


def approaching(row: int, rng: np.random.Generator) -> list[Box]:
    """One person whom the car approaches, as fast in each recording."""
    start = int(rng.integers(0, 50))
    distance = [60 - 0.5 * age for age in range(100)]
    return [
        at(start + age, 320 + 1500 / d, h=1500 / d, foot=200 + 1000 / d, track=1)
        for age, d in enumerate(distance)
    ]


@pytest.mark.parametrize("boxes", [standing, parked, walking, approaching])
def test_what_looks_alike_anywhere_is_no_copy(boxes: Callable[..., list[Box]]):
    assert scene(boxes).copies == ()


@pytest.mark.parametrize(("n_boxes", "n_found"), [(39, 0), (50, 6)])
def test_recordings_with_fewer_than_40_boxes_say_nothing(n_boxes: int, n_found: int):
    dataset = draw_dataset(SCENARIOS["equal"], 6, np.random.default_rng(1))  # of 60 boxes each
    truth = dataset.boxes[dataset.boxes["source"] == 0]
    recording = dataset.frame_columns.recording[truth["frame_index"]]
    few = truth.groupby(recording).sample(n_boxes, random_state=1).sort_index()
    short = replace(dataset, boxes=few.reset_index(drop=True))
    assert len(with_copies(short, moved).copies) == n_found


def test_recordings_without_or_with_few_boxes_do_not_hide_the_others():
    dataset = with_copies(drives(), redrawn)
    truth = dataset.boxes["source"] == 0
    recording = dataset.frame_columns.recording[dataset.boxes["frame_index"]]
    is_first_of_its = dataset.boxes["frame_index"].isin(dataset.frame_columns.first)
    is_kept = ~(truth & (np.isin(recording, (0, 11)) | ((recording == 2) & ~is_first_of_its)))
    frame = dataset.frames["frame"].where(dataset.frames["recording"] != 2, 1_000_000)
    frame += np.arange(len(frame)) * (dataset.frames["recording"] == 2)
    sparse = replace(
        dataset,
        boxes=dataset.boxes[is_kept].reset_index(drop=True),
        frames=dataset.frames.assign(frame=frame),
    )
    found = [(copy.first, copy.second) for copy in sparse.copies]
    assert sorted(found) == [(1, 7), (3, 9), (4, 10)]


def test_the_sample_recordings_are_no_copies():
    for session in (SAMPLE / "session.toml", SAMPLE / "speed_signs" / "session.toml"):
        assert nv.load(session).copies == ()


@pytest.mark.realdata
def test_real_recordings_are_found_only_if_drawn_again(realdata: Path):
    folder = realdata / "mot15"
    mot = nv.load(truth=folder, x=f"{folder}/*/det_frcnn/det.txt", y=f"{folder}/*/res_devkit/*.txt")
    folder = realdata / "kaist"
    results = (folder / "results" / f"{name}_result.txt" for name in ("MBNet", "MLPD"))
    x, y = results
    kaist = nv.load(truth=folder / "KAIST_annotation.json", x=x, y=y, fps=20)
    for dataset in (mot, kaist):
        assert dataset.copies == ()
        n = len(dataset.recordings)
        for change in (mirrored, halved):
            found = {(copy.first, copy.second) for copy in with_copies(dataset, change).copies}
            assert found == {(row, row + n) for row in range(n)}
    found = {(copy.first, copy.second) for copy in with_copies(mot, redrawn).copies}
    assert found == {(row, row + 4) for row in range(4)}
