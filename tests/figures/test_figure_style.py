"""What all figures share."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
import pytest
from figure_parts import words

from nvcore.figures.style import LOOK, empty_figure, faded, layout, plain
from nvcore.figures.time_plot import decimate, evenly
from nvcore.wording import count_text


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("<b>FIR</b>", "&lt;b&gt;FIR&lt;/b&gt;"),
        ("A & B", "A &amp; B"),
        ("%{x}", "%&#123;x}"),
        ("$x^2$", "&#36;x^2&#36;"),
        ("two\nlines", "two lines"),
        ("left\u202eright", "left right"),
        (7, "7"),
    ],
)
def test_a_name_from_a_file_is_shown_as_plain_text(name: object, shown: str) -> None:
    assert plain(name) == shown


def test_a_long_name_is_cut_in_the_middle() -> None:
    assert plain("a" * 20 + "b" * 20, max_length=7) == "aaa…bbb"


def test_a_count_carries_its_noun() -> None:
    assert [count_text(n, "frame") for n in (0, 1, 3000)] == ["0 frames", "1 frame", "3,000 frames"]


def test_a_faded_colour_keeps_its_red_green_and_blue() -> None:
    assert faded("#0067B1", 0.5) == "rgba(0,103,177,0.5)"


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_layout_is_transparent_in_both_themes(theme: str) -> None:
    figure = go.Figure(layout=layout(theme, title="t"))
    assert figure.layout.paper_bgcolor == figure.layout.plot_bgcolor == "rgba(0,0,0,0)"
    assert figure.layout.font.color == LOOK[theme].ink


def test_an_empty_figure_says_why() -> None:
    figure = empty_figure("Nothing is left: widen the filters.", theme="light")
    assert "widen the filters" in words(figure)
    assert not figure.data


def test_decimation_leaves_short_series_as_they_are() -> None:
    assert decimate(np.zeros(5), n_points=5).tolist() == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("seed", range(5))
def test_decimation_keeps_the_smallest_and_the_largest_value(seed: int) -> None:
    values = np.random.default_rng(seed).random(30_000)
    rows = decimate(values, n_points=100)
    assert len(rows) <= 100
    assert values[rows].min() == values.min()
    assert values[rows].max() == values.max()
    assert np.all(np.diff(rows) > 0)
    assert (rows[0], rows[-1]) == (0, 29_999)


def test_even_rows_include_both_ends() -> None:
    assert evenly(11, n_points=3).tolist() == [0, 5, 10]
    assert evenly(2, n_points=3).tolist() == [0, 1]
