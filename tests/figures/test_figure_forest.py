"""The forest plot of subgroups."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import trace, words

from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.figures.forest import subgroup_forest
from nvcore.figures.style import LOOK
from nvcore.measures import EVIDENCE_KEYS


def table(figure: str = "encounters_detected"):
    """24 pedestrians, two frames each: X finds the 12 in the middle, Y those and 4 at the edge."""
    places = [Place(range(48))]
    truth = [at(2 * i + f, 50 if i < 12 else 4, track=i) for i in range(24) for f in range(2)]
    dataset = make_dataset(truth, truth[:24], truth[:32], places=places)
    result = result_of(dataset, saliency_aggregate="sum")
    return subgroup_table(result, [figure])


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


def test_a_lower_figure_has_the_colour_of_who_is_better_and_says_which_side():
    rows = table("saliency")
    figure = subgroup_forest(rows, theme="light")
    points = trace(figure, "difference")
    edge = list(figure.layout.yaxis.ticktext).index("place: edge")
    assert points.x[edge] > 0  # X misses more
    colour = points.marker.color[edge]
    detected = subgroup_forest(table(), theme="light")
    at = list(detected.layout.yaxis.ticktext).index("place: edge")
    assert colour == trace(detected, "difference").marker.color[at] == LOOK["light"].y
    assert figure.layout.xaxis.title.text == "difference in seconds (left: X is better)"
    assert f"X {rows['x'].iloc[edge]:.2f}, Y {rows['y'].iloc[edge]:.2f}" in words(figure)


def test_groups_in_which_a_figure_is_undefined_are_left_out():
    rows = table("mean_similarity")
    figure = subgroup_forest(rows, theme="light")
    assert set(rows["factor"]) >= {"all", "place"}
    assert list(figure.layout.yaxis.ticktext) == ["<b>all</b>"]


@pytest.mark.parametrize("key", EVIDENCE_KEYS)
def test_every_measure_can_be_drawn(key: str):
    rows = table(key)
    drawn = subgroup_forest(rows, theme="dark")
    title = rows["label"].iloc[0]
    assert (title[1:] in words(drawn)) == np.isfinite(rows["x"]).any()


def test_a_protocol_s_name_in_the_label_is_text():
    rows = table("log_average_miss_rate")
    rows["label"] = "log-average miss rate, <b>mine</b>"
    rows[["x", "y", "difference"]] = 0.5
    assert "miss rate, &lt;b&gt;mine" in words(subgroup_forest(rows, theme="light"))


def test_without_encounters_it_says_so() -> None:
    result = result_of(make_dataset(n_frames=3))
    figure = subgroup_forest(subgroup_table(result, ["encounters_detected"]), theme="light")
    assert "no group in which this figure is defined" in words(figure)
