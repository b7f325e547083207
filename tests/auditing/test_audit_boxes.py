from __future__ import annotations

import numpy as np
from audit_comparison import N, codes, dataset, find, truth_walk, walk, with_lines
from builders import Box, Place, make_dataset

from nvcore.auditing import audit
from nvcore.auditing.boxes import repeated_rows
from nvcore.dataset import Dataset
from nvcore.findings import Severity


def test_a_box_wholly_outside_the_picture_is_a_warning() -> None:
    made = dataset(x=[*walk(), Box(3, 641, 100, 40, 100, score=0.6)])
    assert find(made, "outside-picture").severity is Severity.WARNING


def test_a_box_cut_by_the_edge_is_no_finding() -> None:
    assert codes(dataset(x=[*walk(), Box(3, 610, 100, 40, 100, score=0.6)])) == []


def test_a_box_with_most_of_its_area_outside_is_a_note() -> None:
    made = dataset(x=[*walk(), Box(3, 630, 100, 40, 100, score=0.6)])
    assert find(made, "mostly-outside-picture").severity is Severity.NOTE


def test_many_boxes_outside_point_to_the_image_size() -> None:
    made = dataset(width=150.0, height=480.0)
    assert "--size" in next(f for f in audit(made) if f.code == "outside-picture").advice


def test_boxes_in_fractions_of_the_picture_are_an_error() -> None:
    fractions = [Box(f, 0.3, 0.4, 0.1, 0.2, score=0.5 + f / 100) for f in range(N)]
    finding = find(dataset(x=fractions), "boxes-in-fractions")
    assert (finding.severity, finding.count) == (Severity.ERROR, N)


def test_the_same_detection_twice_in_a_frame_is_a_warning() -> None:
    finding = find(dataset(x=[*walk(), walk()[5]]), "duplicate-box")
    assert (finding.severity, finding.count) == (Severity.WARNING, 1)
    assert "frame 5" in finding.example


def test_the_same_truth_box_twice_in_a_frame_is_a_warning() -> None:
    made = dataset([*truth_walk(), truth_walk()[5]._replace(track=2)])
    finding = find(made, "duplicate-box")
    assert (finding.severity, finding.subject) == (Severity.WARNING, "truth")
    assert "can never be detected" in finding.advice


def test_the_same_box_in_two_frames_is_no_double() -> None:
    still = [Box(f, 100, 200, 40, 100, track=1, score=0.5 + f / 100) for f in range(N)]
    assert "duplicate-box" not in codes(dataset(still, still, still))


def test_the_same_box_by_two_systems_is_no_double() -> None:
    made = make_dataset(truth_walk(), walk(), walk(), n_frames=N, width=640, height=480)
    assert "duplicate-box" not in codes(made)


def test_repeated_ignore_regions_are_no_finding() -> None:
    region = Box(3, 400, 100, 50, 50, ignore=True)
    assert codes(dataset([*truth_walk(), region, region])) == []


def test_repeated_rows_are_found_as_comparing_all_pairs_finds_them() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.integers(0, 40, 200), rng.integers(0, 5, 200) / 2
    expected = [i for i in range(200) if any(a[j] == a[i] and b[j] == b[i] for j in range(i))]
    assert repeated_rows(np.arange(200), (a, b)).tolist() == expected


def test_minus_zero_repeats_zero() -> None:
    assert repeated_rows(np.arange(2), (np.array([0.0, -0.0]),)).tolist() == [1]


def test_a_track_id_twice_in_a_frame_is_an_error() -> None:
    # peers.md 41: another tool accepted it silently
    made = with_lines(dataset([*truth_walk(), Box(7, 400, 200, 40, 100, track=1)]))
    finding = find(made, "duplicate-track")
    assert (finding.severity, finding.count) == (Severity.ERROR, 1)
    assert finding.example == "line 9, recording r0, frame 7"


def test_an_ignore_region_may_share_a_track_id() -> None:
    region = Box(7, 400, 200, 40, 100, track=1, ignore=True)
    assert codes(dataset([*truth_walk(), region])) == []


def test_boxes_without_a_track_id_share_none() -> None:
    made = dataset([*walk(), Box(7, 400, 200, 40, 100)])
    assert "duplicate-track" not in codes(made)


def gap_of(n_frames: int, fps: float = 10) -> Dataset:
    """A track of 10 frames, unseen for a while, seen for 10 frames again."""
    seen = [*range(10), *range(10 + n_frames, 20 + n_frames)]
    boxes = [Box(f, 100 + f, 200, 40, 100, track=4, score=0.5 + f / 500) for f in seen]
    return dataset(boxes, boxes, boxes, n_frames=max(seen) + 1, fps=fps)


def test_a_track_id_used_again_after_a_long_gap_is_a_warning() -> None:
    finding = find(gap_of(60), "track-reused")
    assert (finding.severity, finding.count) == (Severity.WARNING, 1)
    assert "id 4, after 6.1 s" in finding.message
    assert finding.example == "recording r0, frame 70"


def test_a_track_id_used_again_after_a_short_gap_is_no_finding() -> None:
    assert "track-reused" not in codes(gap_of(40))


def test_a_long_gap_of_few_listed_frames_is_no_finding() -> None:
    assert "track-reused" not in codes(gap_of(9, fps=1))


def test_the_same_id_in_two_recordings_is_no_reuse() -> None:
    boxes = [*walk(track=1), *walk(track=1, recording=1)]
    places = [Place(range(N), 640, 480, 1.0), Place(range(N), 640, 480, 1.0)]
    assert codes(dataset(boxes, boxes, boxes, places=places)) == []


def test_boxes_mostly_outside_count_when_the_size_is_in_doubt() -> None:
    # x = 100 + 3 f, 40 px wide, of 190 px: less than half is inside from frame 24 on. X has four
    # such boxes of 28, none wholly outside, and one that is
    x = [*walk(stop=28), walk()[39]]
    made = dataset(x=x, width=190.0, height=480.0)
    found = {one.code: one for one in audit(made) if one.subject == "x"}
    assert found["outside-picture"].count == 1
    assert found["mostly-outside-picture"].count == 4
    for code in ("outside-picture", "mostly-outside-picture"):
        assert "check the image size (--size)" in found[code].advice.lower()


def test_a_few_boxes_mostly_outside_do_not_put_the_size_in_doubt() -> None:
    made = dataset(x=[*walk(), Box(3, 630, 100, 40, 100, score=0.6)])
    assert find(made, "mostly-outside-picture").advice.startswith("Nothing to do")
