from __future__ import annotations

from audit_comparison import N, codes, dataset, find, truth_walk, walk
from builders import Box, Place

from nvcore.findings import Severity


def crowd(right: float, bottom: float, *, recording: int = 0) -> list[Box]:
    """Two pedestrians in each of 40 frames, the second of whom ends at the given edges."""
    boxes = []
    for f in range(N):
        more = {"score": 0.5 + 0.4 * (f % 9) / 8, "recording": recording}
        boxes.append(Box(f, 20, 20, 40, 100, track=1, **more))
        boxes.append(Box(f, right - 40, bottom - 100, 40, 100, track=2, **more))
    return boxes


def of_size(right: float, bottom: float, n: int = 2 * N, **more: float) -> list[str]:
    boxes = crowd(right, bottom)[:n]
    return codes(dataset(boxes, boxes, boxes, **more))


def test_a_picture_twice_as_large_as_the_boxes_reach_is_a_warning() -> None:
    boxes = crowd(639, 479)
    finding = find(dataset(boxes, boxes, boxes, width=1280, height=960), "size-too-large")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "truth", 6 * N)
    assert "beyond x = 639 of 1280 and y = 479 of 960" in finding.message
    assert "the boxes would fit 640x480" in finding.advice


def test_an_edge_that_is_crossed_by_a_little_does_not_change_the_size_that_fits() -> None:
    boxes = crowd(643, 433)
    advice = find(dataset(boxes, boxes, boxes, width=1280, height=1024), "size-too-large").advice
    assert "would fit 640x512" in advice


def test_boxes_that_fit_no_part_of_the_size_are_held_against_usual_sizes() -> None:
    # beyond 3 % of half the width of 1200, within 60 % of it
    boxes = crowd(630, 470)
    advice = find(dataset(boxes, boxes, boxes, width=1200, height=900), "size-too-large").advice
    assert "would fit 640x480" in advice


def test_boxes_larger_than_any_usual_size_are_held_against_the_half() -> None:
    boxes = crowd(1990, 1490)
    advice = find(dataset(boxes, boxes, boxes, width=4000, height=3000), "size-too-large").advice
    assert "would fit 2000x1500" in advice


def test_boxes_that_reach_far_down_fit_their_picture() -> None:
    # 639 of 1280 across, but 577 of 960 down: 60.1 %
    assert "size-too-large" not in of_size(639, 577, width=1280, height=960)


def test_boxes_that_reach_far_right_fit_their_picture() -> None:
    assert "size-too-large" not in of_size(770, 479, width=1280, height=960)


def test_few_boxes_tell_nothing_of_the_size() -> None:
    # 66 boxes of truth, X and Y each: 198 in all
    assert "size-too-large" not in of_size(639, 479, n=66, width=1280, height=960)


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


def test_few_frames_beyond_the_boxes_are_no_finding() -> None:
    # 19 frames are too few
    assert codes(dataset(n_frames=59)) == []


def test_a_small_share_of_frames_beyond_the_boxes_is_no_finding() -> None:
    # 30 of 130 frames: 23 %
    long = [Box(f, 100 + f, 200, 40, 100, track=1, score=0.5 + f / 500) for f in range(100)]
    assert codes(dataset(long, long, long, n_frames=130)) == []


def test_a_false_alarm_late_in_the_recording_shows_that_its_frames_exist() -> None:
    made = dataset(x=[*walk(), Box(58, 300, 200, 40, 100, score=0.6)], n_frames=60)
    assert "frames-beyond-boxes" not in codes(made)


def test_a_recording_without_any_box_has_no_ends() -> None:
    places = [Place(range(N), 640, 480, 10.0), Place(range(N), 640, 480, 10.0)]
    assert codes(dataset(places=places)) == ["recording-without-pedestrians"]
