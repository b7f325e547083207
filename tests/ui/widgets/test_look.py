"""Which of a recording's two pictures are seen: from browsers and addresses, checked."""

from __future__ import annotations

import math

import pytest

from ui.widgets.drawing import Look, from_address, read_look, to_address


@pytest.mark.parametrize(
    "look",
    [
        *(Look(), Look("visible", seen_s=0.5), Look("blended", 0.25), Look("both", seen_s=10.0)),
        Look("visible", seen_s="clock"),
    ],
)
def test_what_the_browser_sends_is_taken(look: Look):
    assert read_look(look._asdict()) == look


@pytest.mark.parametrize("sent", [None, "visible", {}, {"picture": "<img>"}, {"picture": ["own"]}])
def test_what_is_no_choice_is_not_taken(sent: object):
    assert read_look(sent) is None


@pytest.mark.parametrize("number", [-1, 99, math.nan, math.inf, "0.5", True, None])
def test_numbers_that_cannot_be_are_as_if_unsaid(number: object):
    sent = {"picture": "blended", "blend": number, "seen_s": number}
    assert read_look(sent) == Look("blended")


def test_an_address_says_only_what_is_not_as_usual():
    assert to_address(Look(blend=0.3)) == {}
    assert to_address(Look("blended", 0.3)) == {"picture": "blended", "blend": "0.3"}
    assert to_address(Look("both", seen_s=1.5)) == {"picture": "both", "seen_s": "1.5"}


@pytest.mark.parametrize(
    "look",
    [
        *(Look("own", seen_s=1.5), Look("own", seen_s="clock"), Look("both", seen_s=0.0)),
        *(Look("visible"), Look("blended", 0.3, 2.0), Look("blended", 0.3, "clock")),
    ],
)
def test_a_look_comes_back_from_its_address(look: Look):
    assert from_address(to_address(look)) == look


@pytest.mark.parametrize("query", [{}, {"alpha": "0.4"}, {"picture": "x", "seen_s": "clock"}])
def test_an_address_that_says_nothing_of_it_is_no_look(query: dict[str, str]):
    assert from_address(query) is None
