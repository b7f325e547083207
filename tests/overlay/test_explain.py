"""What the numbers of a frame are made of, in words."""

from __future__ import annotations

import numpy as np
import pytest
from builders import at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.figures.overlay import explain
from nvcore.figures.overlay.explain import explain_boxes, explain_similarity
from nvcore.tables.boxes.states import gather_boxes


@pytest.fixture(scope="module")
def far() -> Result:
    """Two pedestrians of 20 px whom nobody detects, far below the height that counts, 45 px."""
    truth = [at(0, 50, track=1, h=20), at(0, 10, track=2, h=20)]
    settings = {"proximity": "height", "midpoint": 45.0, "spread": 10.0, "edge_weight": 0.0}
    return result_of(make_dataset(truth), alpha=0.9, **settings)


def test_somebody_too_far_to_count_has_the_mark_and_it_is_said_why(far: Result):
    first, second = explain_boxes(far, 0)
    assert first.title == "Pedestrian 1: too far to count, not detected by X and Y"
    k = 1 / (1 + np.exp(2.5))
    assert f"weight {k:.2f}, does not count as a miss (from 0.5)" in first.lines[0]
    assert f"Takes {0.9 * k:.3f} of X's similarity" in first.lines[1]
    (mark,) = [line for line in first.lines if line.startswith("▼")]
    assert "Costs X and Y the most" in mark
    assert "also somebody too far to count can have it" in mark
    assert not any(line.startswith("▼") for line in second.lines)
    assert f"but pedestrian 1 takes {0.9 * k:.3f}, and only the largest is taken" in second.lines[1]


def test_a_high_similarity_without_a_match_is_explained(far: Result):
    text = explain_similarity(far, 0, "x")
    lost = 1 - far.x.similarity[0]
    assert f"Misses take {lost:.3f}: pedestrian 1, 20 px tall" in text
    assert "All 2 not detected are too far to count" in text


def test_a_missed_pedestrian_who_counts_says_what_is_near_him():
    truth = [at(0, 50, track=7), at(0, 20, track=8)]
    x = [at(0, 50), at(0, 26)]  # 2 px wide: the second does not overlap
    result = result_of(make_dataset(truth, x, [at(0, 50.5)]))
    seven, eight, *detections = explain_boxes(result, 0)
    assert seven.title == "Pedestrian 7: detected by X and Y"
    assert eight.title == "Pedestrian 8: missed by X and Y"
    assert "X: not detected, 6 px to the nearest detection" in eight.lines[1]
    assert "Y in the whole encounter: not detected in any frame that counts" in eight.lines[-1]
    assert (seven.encounter, eight.encounter) == (0, 1)
    assert [reason.title for reason in detections] == [
        "Detection of X: matches pedestrian 7",
        "Detection of X: false alarm",
        "Detection of Y: matches pedestrian 7",
    ]
    assert [reason.truth for reason in detections] == [0, -1, 0]
    assert "6 px to the nearest pedestrian" in detections[1].lines[1]


@pytest.mark.parametrize(
    ("x", "settings", "words"),
    [
        (
            [at(0, 50, score=0.2), at(0, 9, score=0.9)],
            {"threshold_x": 0.5},
            "has score 0.20, below",
        ),
        ([at(0, 50, w=5.0)], {}, "best IoU 0.40, a match needs 0.5"),
        ([], {"pairing": "matched"}, "X: not detected. Takes"),
        ([], {}, "X: no detection that counts in this frame"),
    ],
    ids=["below the threshold", "too little overlap", "strict pairing", "none"],
)
def test_why_a_pedestrian_is_not_detected(x, settings, words):
    result = result_of(make_dataset([at(0, 50, track=1)], x), **settings)
    assert words in explain_boxes(result, 0)[0].lines[1]


def test_boxes_are_explained_in_the_order_in_which_they_are_drawn():
    truth = [at(1, 50, track=1), at(1, 80, w=10, ignore=True)]
    x = [at(1, 80, score=0.9), at(1, 50, score=0.1), at(1, 50, score=0.8)]
    result = result_of(make_dataset(truth, x, n_frames=2), threshold_x=0.5)
    boxes, reasons = gather_boxes(result, 1, 2), explain_boxes(result, 1)
    assert len(reasons) == len(boxes.truth.frame) + len(boxes.x.frame) + len(boxes.y.frame) == 4
    assert reasons[1].title == "Ignored by the ground truth"
    assert [reason.title for reason in reasons[2:]] == [
        "Detection of X on an ignored region",
        "Detection of X: matches pedestrian 1",
    ]
    assert explain_boxes(result, 0) == []


def test_a_frame_with_very_many_boxes_is_not_explained(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(explain, "MOST_BOXES", 1)
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)]))
    assert explain_boxes(result, 0) == []
    assert "Nothing that costs is missed" in explain_similarity(result, 0, "x")
