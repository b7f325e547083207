from __future__ import annotations

import pytest
from audit_comparison import N, codes, dataset, find, reported, truth_walk, walk
from builders import Box, Place

from nvcore.common.findings import Severity
from nvcore.comparison.compare import compare

TWO = (Place(range(N), 640, 480, 10.0),) * 2
BOTH = (*walk(track=1), *walk(track=1, recording=1))


def long_walk(first: int, stop: int, h: float = 100) -> list[Box]:
    return [Box(f, 100 + f, 200, 40, h, track=1, score=0.5 + f / 500) for f in range(first, stop)]


def test_a_source_without_boxes_is_an_error() -> None:
    # Another tool gives minus infinity and NaN without truth
    assert reported(dataset([]), "no-pedestrian") == ("error", "truth", 0)
    assert reported(dataset(y=[]), "no-detections")[:2] == ("error", "y")


def test_a_recording_without_pedestrians_is_a_note() -> None:
    # Its detections are false alarms and count; the audit only mentions it
    made = dataset(walk(track=1), BOTH, BOTH, places=TWO)
    assert reported(made, "recording-without-pedestrians") == ("note", "truth", 1)
    assert find(made, "recording-without-pedestrians").message.endswith(": r1.")
    assert compare(made).x.false_alarms.sum() == N


@pytest.mark.parametrize(("first", "stop"), [(0, 50), (50, 100)])
def test_detections_in_a_half_of_the_recording_are_a_warning(first: int, stop: int) -> None:
    truth = long_walk(0, 100)
    made = dataset(truth, long_walk(first, stop), truth, n_frames=100)
    assert reported(made, "detections-in-part-of-recording")[:2] == ("warning", "x")
    message = find(made, "detections-in-part-of-recording").message
    assert f"frames {first} to {stop - 1} of 0 to 99" in message


def test_truth_of_ignore_regions_only_is_an_error_that_says_so() -> None:
    made = dataset([box._replace(ignore=True) for box in truth_walk()])
    assert "ignore regions" in find(made, "no-pedestrian").message


def test_a_dataset_without_boxes_is_audited() -> None:
    assert codes(dataset([], [], [])) == ["no-pedestrian", "no-detections", "no-detections"]


def test_a_recording_with_truth_and_without_detections_is_a_warning() -> None:
    finding = find(dataset(BOTH, BOTH, walk(), places=TWO), "recording-without-detections")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "y", 1)
    assert finding.example == "recording r1, frame 0"


def test_a_silent_recording_without_truth_is_no_finding() -> None:
    made = dataset(walk(track=1), walk(), walk(), places=TWO)
    assert codes(made) == ["recording-without-pedestrians"]


def test_detections_on_every_third_frame_are_a_warning() -> None:
    finding = find(dataset(x=walk(step=3)), "detections-every-nth-frame")
    assert (finding.severity, finding.subject) == (Severity.WARNING, "x")
    assert "every 3rd evaluated frame" in finding.message


def test_detections_with_one_odd_frame_are_not_regular() -> None:
    assert codes(dataset(x=[*walk(step=3), walk()[7]])) == []


def test_truth_on_every_second_frame_is_a_warning() -> None:
    made = dataset(truth_walk(step=2), walk(), walk())
    finding = find(made, "truth-every-nth-frame")
    assert finding.severity is Severity.WARNING
    assert "every 2nd evaluated frame" in finding.message


def test_each_recording_has_its_own_step() -> None:
    x = [*walk(step=2), *walk(recording=1)]
    finding = find(dataset(BOTH, x, BOTH, places=TWO), "detections-every-nth-frame")
    assert finding.message.endswith(": r0.")


def test_silence_while_pedestrians_are_far_away_or_of_a_rare_detector_is_no_finding() -> None:
    near = long_walk(50, 100)
    assert codes(dataset([*long_walk(0, 50, h=20), *near], near, near, n_frames=100)) == []
    truth = long_walk(0, 100)
    rare = [truth[f] for f in (0, 1, 13, 22, 38, 45, 50)]
    assert codes(dataset(truth, rare, truth, n_frames=100)) == []
