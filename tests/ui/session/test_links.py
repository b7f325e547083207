"""What an address asks for is checked, and told where it is not possible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.params import Params
from ui.session.address import changed_parameters, read_parameters, read_place

NAMES = ["a", "b"]
NUMBERS = {0: np.array([0, 1, 2]), 1: np.array([10, 30, 50])}


def place(name: str | None, frame: str | None) -> tuple[tuple[int, int], list[str]]:
    return read_place(name, frame, NAMES, NUMBERS.__getitem__)


def test_a_link_names_recording_and_frame():
    assert place("b", "30") == ((1, 1), [])


def test_without_a_place_it_is_the_first_frame():
    assert place(None, None) == ((0, 0), [])


def test_a_frame_that_is_not_evaluated_gives_the_nearest_and_says_so():
    found, wrong = place("b", "44")
    assert found == (1, 2)
    assert "not an evaluated one" in wrong[0]


def test_an_unknown_recording_gives_the_first_and_says_so():
    found, wrong = place("<b>", "1")
    assert found == (0, 1)
    assert "no such recording" in wrong[0]


@pytest.mark.parametrize("frame", ["", "x", "1e3", "1" * 40, "٣", "--1"])
def test_a_frame_that_is_no_number_is_told(frame: str):
    found, wrong = place("a", frame)
    assert found == (0, 0)
    assert wrong == ["its frame is no number"]


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
