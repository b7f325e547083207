from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from audit_comparison import N, codes, dataset, find, reported, truth_walk, walk, with_lines
from builders import Box, Place, make_dataset

from nvcore.auditing import audit
from nvcore.auditing.boxes import repeated_rows
from nvcore.common.findings import Remedy, Step
from nvcore.dataset import Dataset

STILL = [Box(f, 100, 200, 40, 100, track=1, score=0.5 + f / 100) for f in range(N)]
FRACTIONS = [Box(f, 0.3, 0.4, 0.1, 0.2, score=0.5 + f / 100) for f in range(N)]
REGION = Box(7, 400, 200, 40, 100, track=1, ignore=True)


def with_box(x: float) -> dict[str, Any]:
    """X with a box more at this place, 40 px wide in a picture of 640."""
    return {"x": [*walk(), Box(3, x, 100, 40, 100, score=0.6)]}


def gap_of(n_frames: int, fps: float = 10) -> dict[str, Any]:
    """A track of 10 frames, unseen for a while, seen for 10 frames again."""
    seen = [*range(10), *range(10 + n_frames, 20 + n_frames)]
    boxes = [Box(f, 100 + f, 200, 40, 100, track=4, score=0.5 + f / 500) for f in seen]
    return {"truth": boxes, "x": boxes, "y": boxes, "n_frames": max(seen) + 1, "fps": fps}


def two_recordings() -> dict[str, Any]:
    boxes = [*walk(track=1), *walk(track=1, recording=1)]
    places = [Place(range(N), 640, 480, 1.0)] * 2
    return {"truth": boxes, "x": boxes, "y": boxes, "places": places}


FINDINGS = {
    "a box wholly outside": (with_box(641), "outside-picture", "warning", "x", 1),
    "most of a box outside": (with_box(630), "mostly-outside-picture", "note", "x", 1),
    "fractions of the picture": ({"x": FRACTIONS}, "boxes-in-fractions", "error", "x", N),
    "a detection twice": ({"x": [*walk(), walk()[5]]}, "duplicate-box", "warning", "x", 1),
    "a truth box twice": (
        {"truth": [*truth_walk(), truth_walk()[5]._replace(track=2)]},
        "duplicate-box",
        "warning",
        "truth",
        1,
    ),
    # Another tool accepted it silently
    "a track id twice": (
        {"truth": [*truth_walk(), REGION._replace(ignore=False)]},
        "duplicate-track",
        "error",
        "truth",
        1,
    ),
    "a track id after a long gap": (gap_of(60), "track-reused", "warning", "truth", 1),
}


@pytest.mark.parametrize("case", FINDINGS)
def test_is_reported(case: str) -> None:
    given, code, *expected = FINDINGS[case]
    assert reported(dataset(**given), code) == tuple(expected)


NO_FINDINGS = {
    "a box cut by the edge": with_box(610),
    "an ignore region twice": {"truth": [*truth_walk(), *[REGION._replace(track=-1)] * 2]},
    "an ignore region of a pedestrian's track": {"truth": [*truth_walk(), REGION]},
    "two recordings with the same track id": two_recordings(),
}


@pytest.mark.parametrize("case", NO_FINDINGS)
def test_is_not_reported(case: str) -> None:
    assert codes(dataset(**NO_FINDINGS[case])) == []


@pytest.mark.parametrize(
    ("made", "code"),
    [
        (dataset(STILL, STILL, STILL), "duplicate-box"),
        (make_dataset(STILL, STILL, STILL, n_frames=N, width=640, height=480), "duplicate-box"),
        (dataset([*walk(), Box(7, 400, 200, 40, 100)]), "duplicate-track"),
        (dataset(**gap_of(40)), "track-reused"),
        (dataset(**gap_of(9, fps=1)), "track-reused"),
    ],
    ids=["other frames", "other systems", "no track ids", "short gap", "few listed frames"],
)
def test_what_is_no_double_is_not_reported(made: Dataset, code: str) -> None:
    assert code not in codes(made)


def test_findings_say_where_and_what_follows() -> None:
    made = with_lines(dataset([*truth_walk(), Box(7, 400, 200, 40, 100, track=1)]))
    assert find(made, "duplicate-track").example == "line 9, recording r0, frame 7"
    made = dataset([*truth_walk(), truth_walk()[5]._replace(track=2)])
    assert "can never be detected" in find(made, "duplicate-box").advice
    finding = find(dataset(**gap_of(60)), "track-reused")
    assert "id 4, after 6.1 s" in finding.message
    assert finding.example == "recording r0, frame 70"


def test_repeated_rows_are_found_as_comparing_all_pairs_finds_them() -> None:
    rng = np.random.default_rng(1)
    frames = np.sort(rng.integers(0, 8, 200))
    boxes = [Box(frame, *rng.integers(1, 3, 4) / 2) for frame in frames.tolist()]
    expected = [i for i in range(200) if boxes[i] in boxes[:i]]
    assert repeated_rows(make_dataset(boxes, n_frames=8).truth).tolist() == expected
    crowd = [Box(0, x % 1100, 0.0, 1, 1) for x in range(1103)]
    assert repeated_rows(make_dataset(crowd).truth).tolist() == [1100, 1101, 1102]
    signed = [Box(0, 0.0, 0, 1, 1), Box(0, -0.0, 0, 1, 1)]
    assert repeated_rows(make_dataset(signed).truth).tolist() == [1]


def test_boxes_mostly_outside_count_when_the_size_is_in_doubt() -> None:
    # x = 100 + 3 f, 40 px wide, of 190 px: less than half is inside from frame 24 on. X has four
    # such boxes of 28, none wholly outside, and one that is
    made = dataset(x=[*walk(stop=28), walk()[39]], width=190.0, height=480.0)
    findings = {finding.code: finding for finding in audit(made) if finding.subject == "x"}
    for code, count in (("outside-picture", 1), ("mostly-outside-picture", 4)):
        assert findings[code].count == count
        assert findings[code].steps == (Step(Remedy.SIZE),)


def test_a_few_boxes_mostly_outside_do_not_put_the_size_in_doubt() -> None:
    finding = find(dataset(**with_box(630)), "mostly-outside-picture")
    assert finding.advice.startswith("Nothing to do")


def test_boxes_to_be_ignored_bridge_the_gap_of_a_track():
    seen = [Box(frame, 10, 10, 40, 100, track=1) for frame in (*range(10), *range(200, 210))]
    ignored = [Box(frame, 10, 10, 40, 100, track=1, ignore=True) for frame in range(10, 200)]
    detections = [Box(frame, 10, 10, 40, 100) for frame in range(210)]
    places = [Place(range(210), fps=20.0)]
    assert "track-reused" in codes(make_dataset(seen, detections, places=places))
    assert "track-reused" not in codes(make_dataset(seen + ignored, detections, places=places))
