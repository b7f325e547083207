"""Texts and layout that all figures share."""

from __future__ import annotations

import numpy as np
import pytest

from nvcore.common.wording import count_text
from nvcore.figures.over_time import decimate, evenly
from nvcore.figures.style import EDGE_PX, HEADING_PX, LOOK, plain


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("<b>A & B</b>", "&lt;b&gt;A &amp; B&lt;/b&gt;"),
        ("%{x} of $x^2$", "%&#123;x} of &#36;x^2&#36;"),
        ("two\nlines, left\u202eright", "two lines, left right"),
        ("a" * 31 + "b" * 20, f"{'a' * 15}…{'b' * 16}"),
        (7, "7"),
    ],
)
def test_a_name_from_a_file_is_shown_as_plain_text_cut_in_the_middle(name: object, shown: str):
    assert plain(name) == shown


def test_of_the_top_only_the_heading_is_fixed():
    look = LOOK["light"]
    assert look.layout()["margin"]["t"] == EDGE_PX
    with_title = look.layout(title="Similarity", height=200, margin={"l": 50})
    assert with_title["margin"] == {"l": 50, "r": 16, "t": EDGE_PX + HEADING_PX, "b": EDGE_PX}
    assert with_title["legend"]["y"] * 200 == pytest.approx(200 - EDGE_PX - HEADING_PX)
    assert tuple(look.empty("Nobody.").layout.meta)[1] == "Nobody."


def test_a_count_carries_its_noun():
    assert [count_text(n, "frame") for n in (0, 1, 3000)] == ["0 frames", "1 frame", "3,000 frames"]


def test_decimation_keeps_the_ends_the_smallest_and_the_largest_value():
    values = np.random.default_rng(1).random(30_000)
    rows = decimate(values, n_points=100)
    assert len(rows) <= 100
    assert {0, 29_999, values.argmin(), values.argmax()} <= {*rows.tolist()}
    assert np.all(np.diff(rows) > 0)
    assert decimate(np.zeros(5), n_points=5).tolist() == [0, 1, 2, 3, 4]
    assert evenly(11, n_points=3).tolist() == [0, 5, 10]
    assert evenly(2, n_points=3).tolist() == [0, 1]
