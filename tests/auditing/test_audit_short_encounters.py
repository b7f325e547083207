from __future__ import annotations

import pytest
from audit_comparison import codes, find
from builders import Box, Place, make_dataset

from nvcore.dataset import Dataset
from nvcore.findings import Severity
from nvcore.params import Params


def people(n_short: int, n_long: int, *, step: int = 1, h: float = 100) -> Dataset:
    """People seen in one frame, one after the other, and people seen in three, apart from them."""
    boxes = [Box(step * i, 50 + 200 * (i % 2), 200, 40, h, track=i) for i in range(n_short)]
    boxes += [
        Box(step * (3 * i + j), 500, 200, 40, h, track=100 + i)
        for i in range(n_long)
        for j in range(3)
    ]
    place = Place(range(0, 40 * step, step), 640, 480, 10.0)
    return make_dataset(boxes, places=[place])


def test_mostly_short_encounters_are_a_warning() -> None:
    finding = find(people(11, 9), "short-encounters")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "truth", 11)
    assert "11 of 20 near encounters are one evaluated frame long." in finding.message


@pytest.mark.parametrize(
    ("n_short", "n_long", "h"),
    # 20 px of 480 are below the midpoint of 48 px
    [(10, 10, 100), (9, 0, 100), (11, 0, 20)],
    ids=["half of them short", "few of them", "far away"],
)
def test_short_encounters_are_no_finding(n_short: int, n_long: int, h: float) -> None:
    assert "short-encounters" not in codes(people(n_short, n_long, h=h))


def test_sampled_frames_are_named_as_the_reason() -> None:
    message = find(people(11, 9, step=20), "short-encounters").message
    assert "every 20th frame is evaluated" in message
    assert "linked" not in message


def test_linked_tracks_are_named_as_the_reason() -> None:
    # 12 people, each in one frame at a place of their own: nobody overlaps anybody
    boxes = [Box(i, 50 * i, 200, 40, 100) for i in range(12)]
    made = make_dataset(boxes, n_frames=12, width=640, height=480)
    finding = find(made, "short-encounters")
    assert finding.count == 12
    assert "pedestrians without track ids were linked" in finding.message


def test_an_unknown_horizon_is_left_to_the_analysis() -> None:
    assert "short-encounters" not in codes(people(11, 0), Params(proximity="horizon"))
    assert "short-encounters" in codes(people(11, 0), Params(proximity="horizon", horizon=100))
