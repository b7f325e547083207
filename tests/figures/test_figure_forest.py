"""The forest plot of subgroups."""

from __future__ import annotations

import pytest
from builders import Place, at, compare, make_dataset
from figure_parts import trace, words

from nvcore.figures.forest import subgroup_forest
from nvcore.subgroups import subgroup_table


def table():
    """24 pedestrians, one frame each: X finds the 12 in the middle, Y those and 4 at the edge."""
    places = [Place(range(24))]
    truth = [at(i, 50 if i < 12 else 4, track=i) for i in range(24)]
    result = compare(make_dataset(truth, truth[:12], truth[:16], places=places))
    return subgroup_table(result)


def test_each_group_stands_with_difference_interval_and_counts() -> None:
    rows = table()
    figure = subgroup_forest(rows, theme="light")
    points = trace(figure, "difference")
    assert list(points.x) == pytest.approx((100 * rows["difference"]).tolist())
    assert points.x[0] == pytest.approx(-100 * 4 / 24)
    labels = list(figure.layout.yaxis.ticktext)
    assert labels[0] == "<b>all</b>"
    assert {"place: centre", "place: edge"} <= set(labels)
    edge = labels.index("place: edge")
    assert points.x[edge] == pytest.approx(-100 * 4 / 12)
    assert "12: X 0%, Y 33%" in words(figure)
    assert trace(figure, "95 % interval").x[0] == pytest.approx(100 * rows["low"][0])
    least, most = figure.layout.xaxis.range
    assert least < 100 * rows["low"].min()
    assert most > 100 * rows["high"].max()


def test_a_group_without_interval_is_open() -> None:
    rows = table()
    rows.loc[1, ["low", "high"]] = float("nan")
    symbols = list(trace(subgroup_forest(rows, theme="dark"), "difference").marker.symbol)
    assert symbols[0] == "square"
    assert symbols[1] == "square-open"


def test_without_encounters_it_says_so() -> None:
    result = compare(make_dataset(n_frames=3))
    figure = subgroup_forest(subgroup_table(result), theme="light")
    assert "no encounter near enough" in words(figure).lower()
