"""What an address asks for is checked, and told where it is not possible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.settings.params import Params
from ui.session.address import changed_parameters, read_parameters, read_place, read_systems

NAMES = ["a", "b"]
NUMBERS = {0: np.array([0, 1, 2]), 1: np.array([10, 30, 50])}


@pytest.mark.parametrize(
    ("name", "frame", "where", "why"),
    [
        ("b", "30", (1, 1), ""),
        (None, None, (0, 0), ""),
        ("b", "44", (1, 2), "not an evaluated one"),  # the nearest
        ("<b>", "1", (0, 1), "no such recording"),
        *(("a", text, (0, 0), "its frame is no number") for text in ("", "x", "1e3", "٣", "--1")),
        ("a", "1" * 40, (0, 0), "its frame is no number"),
    ],
)
def test_a_link_names_recording_and_frame_and_what_is_wrong_with_them_is_told(
    name: str | None, frame: str | None, where: tuple[int, int], why: str
):
    place, wrong = read_place(name, frame, NAMES, NUMBERS.__getitem__)
    assert place == where
    assert why in "".join(wrong)
    assert bool(wrong) == bool(why)


@pytest.mark.parametrize(
    ("x", "y", "pair", "is_wrong"),
    [
        (None, None, None, False),
        ("b", "a", ("b", "a"), False),
        ("a", None, None, True),
        ("a", "a", None, True),
        ("a", "<b>", None, True),
    ],
)
def test_a_link_names_both_systems_or_none(
    x: str | None, y: str | None, pair: tuple[str, str] | None, is_wrong: bool
):
    read, wrong = read_systems(x, y, NAMES)
    assert (read, bool(wrong)) == (pair, is_wrong)


def test_parameters_of_the_address_are_numbers_and_choices():
    given, wrong = read_parameters({"alpha": "0.4", "match": "lateral", "other": "1"})
    assert (given, wrong) == ({"alpha": 0.4, "match": "lateral"}, [])


@pytest.mark.parametrize(
    "query", [{"alpha": "7"}, {"alpha": "nan"}, {"alpha": "x"}, {"match": "eval(1)"}]
)
def test_an_impossible_value_is_told_and_not_used(query: dict[str, str]):
    given, wrong = read_parameters(query)
    assert given == {}
    assert "is not possible" in wrong[0]


def test_only_what_was_changed_stands_in_the_address():
    start = Params(threshold_x=0.5)
    live = replace(start, alpha=0.45, match="lateral")
    assert changed_parameters(start, start) == {}
    assert changed_parameters(live, start) == {"alpha": "0.45", "match": "lateral"}


def test_what_stands_in_the_address_is_read_back():
    live = replace(Params(), alpha=0.1 + 0.2, midpoint=31.5, distance="ground")
    given, _ = read_parameters(changed_parameters(live, Params()))
    assert given["alpha"] == pytest.approx(live.alpha, abs=1e-9)
    assert (given["midpoint"], given["distance"]) == (31.5, "ground")


def test_a_cleared_context_or_threshold_is_in_the_link_and_no_other_setting_can_be_cleared():
    start, live = Params(edge_weight=0.7, threshold_y=0.5), Params()
    assert changed_parameters(live, start) == {"edge_weight": "none", "threshold_y": "none"}
    given, wrong = read_parameters({"edge_weight": "none", "midpoint": "none", "alpha": "none"})
    assert given == {"edge_weight": None}
    assert len(wrong) == 2
