"""The forest plot of subgroups."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from builders import at, make_dataset, result_of
from figure_parts import trace, words

from nvcore.comparison import Result
from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.evidence.subgroups import ALL
from nvcore.figures.dots import forest_in_words, subgroup_forest
from nvcore.figures.style import LOOK
from nvcore.measures.table import EVIDENCE_KEYS


@pytest.fixture(scope="module")
def result() -> Result:
    """24 pedestrians, two frames each: X finds the 12 in the middle, Y those and 4 at the edge."""
    truth = [at(2 * i + f, 50 if i < 12 else 4, track=i) for i in range(24) for f in range(2)]
    dataset = make_dataset(truth, truth[:24], truth[:32], n_frames=48)
    return result_of(dataset, saliency_aggregate="sum")


@pytest.fixture(scope="module")
def detected(result: Result) -> pd.DataFrame:
    return subgroup_table(result, ["encounters_detected"])


def test_each_group_stands_with_difference_interval_and_counts(detected: pd.DataFrame) -> None:
    figure = subgroup_forest(detected, theme="light")
    points = trace(figure, "difference")
    assert list(points.x) == pytest.approx((100 * detected["difference"]).tolist())
    assert points.x[0] == pytest.approx(-100 * 4 / 24)
    labels = list(figure.layout.yaxis.ticktext)
    assert labels[0] == "<b>all</b>"
    assert {"place: centre", "place: edge"} <= set(labels)
    edge = labels.index("place: edge")
    assert points.x[edge] == pytest.approx(-100 * 4 / 12)
    assert points.marker.color[edge] == LOOK["light"].y
    assert "12: X 0 %, Y 33 %" in words(figure)
    assert trace(figure, "95 % interval").x[0] == pytest.approx(100 * detected["low"][0])
    least, most = figure.layout.xaxis.range
    assert least < 100 * detected["low"].min()
    assert most > 100 * detected["high"].max()


def test_pointing_at_a_group_says_who_of_those_compared(detected: pd.DataFrame, result: Result):
    texts = trace(subgroup_forest(detected, theme="light"), "difference").text
    assert texts[0].startswith("of 24 encounters: both 12, only X 0, only Y 4, neither 8<br>")
    saliency = subgroup_forest(subgroup_table(result, ["saliency"]), theme="light")
    assert "encounters detected by both 12, only X 0" in trace(saliency, "difference").text[0]


def test_a_group_without_interval_is_open(detected: pd.DataFrame) -> None:
    rows = detected.copy()
    rows.loc[1, ["low", "high"]] = float("nan")
    symbols = list(trace(subgroup_forest(rows, theme="dark"), "difference").marker.symbol)
    assert symbols[:2] == ["square", "square-open"]


def test_a_lower_figure_has_the_colour_of_who_is_better_and_says_which_side(result: Result) -> None:
    rows = subgroup_table(result, ["saliency"])
    figure = subgroup_forest(rows, theme="light")
    points = trace(figure, "difference")
    edge = list(figure.layout.yaxis.ticktext).index("place: edge")
    assert points.x[edge] > 0  # X misses more
    assert points.marker.color[edge] == LOOK["light"].y
    assert figure.layout.xaxis.title.text == "difference in seconds (left: X is better)"
    assert f"X {rows['x'].iloc[edge]:.2f}, Y {rows['y'].iloc[edge]:.2f}" in words(figure)


@pytest.mark.parametrize("key", EVIDENCE_KEYS)
def test_every_measure_can_be_drawn_for_the_groups_in_which_it_is_defined(
    result: Result, key: str
) -> None:
    rows = subgroup_table(result, [key])
    drawn = subgroup_forest(rows, theme="dark")
    n_defined = np.isfinite(rows["difference"]).sum()
    assert len(drawn.layout.yaxis.ticktext or ()) == n_defined
    assert (rows["label"].iloc[0][1:] in words(drawn)) == (n_defined > 0)
    if not n_defined:
        assert "no group in which this measure is defined" in words(drawn)


def test_a_protocol_s_name_in_the_label_is_text(detected: pd.DataFrame) -> None:
    rows = detected.assign(label="log-average miss rate, <b>mine</b>")
    assert "miss rate, &lt;b&gt;mine" in words(subgroup_forest(rows, theme="light"))


def test_p_of_a_group_stands_beside_the_corrected_one_and_not_without_it(
    detected: pd.DataFrame,
) -> None:
    rows = detected.assign(p=0.02, p_corrected=np.nan)
    assert words(subgroup_forest(rows, theme="light")).count("; p 0.02") == 1  # of all
    rows.loc[1, "p_corrected"] = 0.08
    assert "; p 0.02 (0.08)" in words(subgroup_forest(rows, theme="light"))


def test_a_plot_without_anything_to_compare_is_a_sentence() -> None:
    label = "share of encounters detected"
    columns = {"figure": "encounters_detected", "label": label, "difference": 0.0}
    table = pd.DataFrame([{"factor": factor, **columns} for factor in (ALL, "distance", "place")])
    same = "Share of encounters detected: X and Y are the same in all 2 groups."
    assert forest_in_words(table) == same
    assert "no groups" in forest_in_words(table[:1])
    assert forest_in_words(table.assign(difference=[0.0, 0.1, 0.0])) == ""
