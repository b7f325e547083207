from __future__ import annotations

from dataclasses import replace
from typing import Any

import pandas as pd
import pytest
from audit_comparison import N, codes, dataset, find, truth_walk, walk
from builders import Box, Place, make_dataset

from nvcore.common.findings import Severity


def crowd(right: float, bottom: float, *, recording: int = 0) -> list[Box]:
    """Two pedestrians in each of 40 frames, the second of whom ends at the given edges."""
    boxes = []
    for f in range(N):
        more = {"score": 0.5 + 0.4 * (f % 9) / 8, "recording": recording}
        boxes.append(Box(f, 20, 20, 40, 100, track=1, **more))
        boxes.append(Box(f, right - 40, bottom - 100, 40, 100, track=2, **more))
    return boxes


def test_a_picture_twice_as_large_as_the_boxes_reach_is_a_warning() -> None:
    boxes = crowd(639, 479)
    finding = find(dataset(boxes, boxes, boxes, width=1280, height=960), "size-too-large")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "truth", 6 * N)
    assert "beyond x = 639 of 1280 and y = 479 of 960" in finding.message
    assert "the boxes would fit 640x480" in finding.advice


@pytest.mark.parametrize(
    ("right", "bottom", "width", "height", "fits"),
    [
        (643, 433, 1280, 1024, "640x512"),
        (630, 470, 1200, 900, "640x480"),
        (1990, 1490, 4000, 3000, "2000x1500"),
    ],
    ids=["crosses an edge by a little", "a usual size, no part of 1200", "no usual size"],
)
def test_the_size_that_would_fit_is_named(
    right: float, bottom: float, width: float, height: float, fits: str
) -> None:
    boxes = crowd(right, bottom)
    finding = find(dataset(boxes, boxes, boxes, width=width, height=height), "size-too-large")
    assert f"would fit {fits}" in finding.advice


@pytest.mark.parametrize(
    ("right", "bottom", "n"),
    # 577 of 960 down are 60.1 %; 66 boxes of truth, X and Y each are 198 in all
    [(639, 577, 2 * N), (770, 479, 2 * N), (639, 479, 66)],
    ids=["far down", "far right", "few boxes"],
)
def test_boxes_fit_their_picture(right: float, bottom: float, n: int) -> None:
    boxes = crowd(right, bottom)[:n]
    assert "size-too-large" not in codes(dataset(boxes, boxes, boxes, width=1280, height=960))


def test_a_size_that_is_not_that_of_a_kitti_recording_is_a_warning() -> None:
    """Its files hold no size; boxes of the truth are cut off at the right edge."""
    boxes = crowd(1224, 369)
    kitti = {"subject": ["truth"], "file": "0016.txt", "sha256": "", "conversion": ""}
    inputs = pd.DataFrame(kitti | {"format": "kitti-tracking"})
    wrong = replace(dataset(boxes, boxes, boxes, width=1242, height=375), inputs=inputs)
    finding = find(wrong, "kitti-size")
    assert (finding.severity, finding.count) == (Severity.WARNING, 1)
    assert "given 1242x375, its boxes end at the edge of 1224x370" in finding.message
    right = replace(dataset(boxes, boxes, boxes, width=1224, height=370), inputs=inputs)
    assert "kitti-size" not in codes(right)
    assert "kitti-size" not in codes(replace(wrong, inputs=inputs.assign(format="csv")))
    few = replace(dataset(boxes[:8], boxes, boxes, width=1242, height=375), inputs=inputs)
    assert "kitti-size" not in codes(few)


def test_recordings_of_one_size_are_looked_at_together() -> None:
    places = [Place(range(N), 1280, 960, 10.0)] * 2
    boxes = [*crowd(400, 300), *crowd(1270, 900, recording=1)]
    assert "size-too-large" not in codes(dataset(boxes, boxes, boxes, places=places))


def test_recordings_of_different_sizes_are_looked_at_apart() -> None:
    places = [Place(range(N), 1280, 960, 10.0), Place(range(N), 640, 480, 10.0)]
    boxes = [*crowd(600, 400), *crowd(600, 400, recording=1)]
    finding = find(dataset(boxes, boxes, boxes, places=places), "size-too-large")
    assert (finding.count, finding.example) == (6 * N, "recording r0")


def test_frame_rates_of_no_camera_are_a_warning() -> None:
    for fps in (241.0, 0.09):
        finding = find(dataset(fps=fps), "implausible-fps")
        assert (finding.severity, finding.count) == (Severity.WARNING, 1)
        assert f"{fps:g} frames per second" in finding.message


def test_unusual_but_possible_frame_rates_are_no_finding() -> None:
    assert codes(dataset(fps=240.0)) == codes(dataset(fps=0.1)) == []


def test_many_frames_after_the_last_box_are_a_warning() -> None:
    finding = find(dataset(n_frames=60), "frames-beyond-boxes")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "truth", 1)
    assert "none after frame 39 of 0 to 59" in finding.message
    assert finding.example == "recording r0, frame 40"


def test_many_frames_before_the_first_box_are_a_warning() -> None:
    late = walk(first=20)
    finding = find(dataset(truth_walk(first=20), late, late), "frames-beyond-boxes")
    assert "none before frame 20 of 0 to 39" in finding.message
    assert finding.example == "recording r0, frame 0"


LONG = [Box(f, 100 + f, 200, 40, 100, track=1, score=0.5 + f / 500) for f in range(100)]


@pytest.mark.parametrize(
    "given",
    [
        {"n_frames": 59},
        {"truth": LONG, "x": LONG, "y": LONG, "n_frames": 130},
        {"x": [*walk(), Box(58, 300, 200, 40, 100, score=0.6)], "n_frames": 60},
    ],
    ids=["19 frames are too few", "30 of 130 are 23 %", "a late false alarm"],
)
def test_few_frames_beyond_the_boxes_are_no_finding(given: dict[str, Any]) -> None:
    assert codes(dataset(**given)) == []


def test_a_recording_without_any_box_has_no_ends() -> None:
    places = [Place(range(N), 640, 480, 10.0), Place(range(N), 640, 480, 10.0)]
    assert codes(dataset(places=places)) == ["recording-without-pedestrians"]


@pytest.mark.parametrize(
    ("numbers", "is_found"),
    [
        ([round(100 * k / 3) for k in range(40)], True),  # milliseconds at 30 Hz
        ([20 * k for k in range(60) if k % 9], False),  # every 20th frame, some without anybody
    ],
    ids=["times", "every 20th frame"],
)
def test_frame_numbers_that_rise_as_times_do_are_told(numbers: list[int], is_found: bool):
    truth = [Box(frame, 10, 10, 40, 80, track=frame) for frame in numbers]
    made = make_dataset(truth, truth, places=[Place(numbers, fps=20.0)])
    assert ("frame-numbers-like-times" in codes(made)) == is_found
