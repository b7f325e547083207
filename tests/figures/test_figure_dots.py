"""Dots with intervals: subgroups, recordings, and the power of a planned study."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import at, make_dataset, result_of
from drives import quiet_drives
from figure_parts import trace, words

from nvcore.comparison.compare import Result
from nvcore.evidence.planning import plan_recordings
from nvcore.evidence.planning.plan import PlanSize
from nvcore.evidence.planning.power import PowerPoint
from nvcore.evidence.subgroups import ALL
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.figures import dots
from nvcore.figures.dots import forest_in_words, power_plot, recordings_plot, subgroup_forest
from nvcore.figures.style import LOOK

NAMES = ("FIR", "NIR")


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
    assert points.text[0].startswith("of 24 encounters: both 12, only X 0, only Y 4, neither 8<br>")
    labels = list(figure.layout.yaxis.ticktext)
    assert labels[0] == "<b>all</b>"
    assert {"place: centre", "place: edge"} <= set(labels)
    edge = labels.index("place: edge")
    assert points.x[edge] == pytest.approx(-100 * 4 / 12)
    assert points.marker.color[edge] == LOOK["light"].y
    assert points.marker.size[0] == 16
    assert "12: X 0 %, Y 33 %" in words(figure)
    interval = trace(figure, "95 % interval")
    assert interval.x[0] == pytest.approx(100 * detected["low"][0])
    assert interval.y[:5].tolist() == pytest.approx([0, 0, np.nan, 1, 1], nan_ok=True)
    least, most = figure.layout.xaxis.range
    assert least < 100 * detected["low"].min()
    assert most > 100 * detected["high"].max()


def test_a_lower_figure_has_the_colour_of_who_is_better_and_says_which_side(result: Result) -> None:
    rows = subgroup_table(result, ["saliency"])
    figure = subgroup_forest(rows, theme="light")
    points = trace(figure, "difference")
    edge = list(figure.layout.yaxis.ticktext).index("place: edge")
    assert points.x[edge] > 0  # X misses more
    assert points.marker.color[edge] == LOOK["light"].y
    assert "encounters detected by both 12, only X 0" in points.text[0]
    assert figure.layout.xaxis.title.text == "difference in seconds (left: X is better)"
    assert f"X {rows['x'].iloc[edge]:.2f}, Y {rows['y'].iloc[edge]:.2f}" in words(figure)


def test_a_group_says_its_p_corrected_and_whether_it_has_an_interval(
    detected: pd.DataFrame,
) -> None:
    rows = detected.assign(p=0.02, p_corrected=np.nan, label="miss rate, <b>mine</b>")
    rows.loc[1, ["low", "high"]] = float("nan")
    figure = subgroup_forest(rows, theme="light")
    assert words(figure).count("; p 0.02") == 1  # of all
    assert "Miss rate, &lt;b&gt;mine" in words(figure)  # a protocol's name is text
    points = trace(figure, "difference")
    assert list(points.marker.symbol)[:2] == ["square", "square-open"]
    rows.loc[1, "p_corrected"] = 0.08
    figure = subgroup_forest(rows, theme="light")
    assert "; p 0.02 (0.08)" in words(figure)
    assert "p = 0.02, 0.08 for all groups" in trace(figure, "difference").text[1]


# a share, a rate with a unit, and one that is defined in no group
@pytest.mark.parametrize("key", ["share_low", "false_alert_episodes_per_hour", "alerted"])
def test_a_measure_is_drawn_for_the_groups_in_which_it_is_defined(result: Result, key: str) -> None:
    rows = subgroup_table(result, [key])
    drawn = subgroup_forest(rows, theme="dark")
    n_defined = np.isfinite(rows["difference"]).sum()
    assert len(drawn.layout.yaxis.ticktext or ()) == n_defined
    assert (rows["label"].iloc[0][1:] in words(drawn)) == (n_defined > 0)
    if not n_defined:
        assert "no group in which this measure is defined" in words(drawn)


def test_a_plot_without_anything_to_compare_is_a_sentence() -> None:
    label = "share of encounters detected"
    columns = {"figure": "encounters_detected", "label": label, "difference": 0.0}
    table = pd.DataFrame([{"factor": factor, **columns} for factor in (ALL, "distance", "place")])
    same = "Share of encounters detected: X and Y are the same in all 2 groups."
    assert forest_in_words(table) == same
    assert "no groups" in forest_in_words(table[:1])
    assert forest_in_words(table.assign(difference=[0.0, 0.1, 0.0])) == ""


def recordings(*pairs: tuple[float, float], column: str = "mean_similarity") -> pd.DataFrame:
    x, y = zip(*pairs, strict=True) if pairs else ((), ())
    names = [f"{i:04d}" for i in range(len(pairs))]
    return pd.DataFrame({"recording": names, f"{column}_x": x, f"{column}_y": y}, dtype=object)


def test_recordings_are_sorted_by_how_much_better_x_is() -> None:
    pairs = recordings((0.8, 0.9), (0.9, 0.7), (0.5, 0.5), (np.nan, 0.9))
    figure = recordings_plot(pairs, NAMES, theme="light")
    assert trace(figure, "X: FIR").customdata.tolist() == [1, 2, 0]
    assert trace(figure, "X: FIR").x.tolist() == [0.9, 0.5, 0.8]
    assert trace(figure, "Y: NIR").x.tolist() == [0.7, 0.5, 0.9]
    assert trace(figure, "X: FIR").text[0].endswith("X 0.900   Y 0.700   X − Y +0.200")
    joined = trace(figure, "difference")
    assert joined.x[:5].tolist() == pytest.approx([0.9, 0.7, np.nan, 0.5, 0.5], nan_ok=True)
    assert trace(figure, "recordings").x.tolist() == pytest.approx([0.8, 0.5, 0.85])
    assert figure.layout.yaxis.ticktext == ("0001", "0002", "0000")
    assert "3 recordings; X is better in 1, Y in 1; best for X on top" in words(figure)
    # less saliency is better
    saliency = recordings((2.0, 0.5), (0.5, 2.0), column="saliency")
    figure = recordings_plot(saliency, NAMES, theme="light", measure="saliency")
    assert trace(figure, "X: FIR").customdata.tolist() == [1, 0]
    assert "no recording" in words(recordings_plot(recordings(), NAMES, theme="light"))


def test_a_small_difference_looks_small_and_no_recording_lies_outside_the_axis() -> None:
    similarity = recordings_plot(recordings((0.873, 0.95)), NAMES, theme="light")
    assert similarity.layout.xaxis.range == pytest.approx((0.485, 1.015))
    saliency = recordings((0.02, 0.03), column="saliency")
    figure = recordings_plot(saliency, NAMES, theme="light", measure="saliency")
    assert figure.layout.xaxis.range == pytest.approx((-0.03, 1.03))
    wide = recordings_plot(recordings((0.2, 0.95), (0.4, 0.3)), NAMES, theme="light")
    assert wide.layout.xaxis.range[0] < 0.2


def test_of_many_recordings_those_with_the_largest_differences_are_drawn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(dots, "MAX_RECORDINGS", 2)
    pairs = recordings((0.8, 0.9), (0.9, 0.4), (0.5, 0.5))
    figure = recordings_plot(pairs, NAMES, theme="light")
    assert trace(figure, "X: FIR").customdata.tolist() == [1, 0]
    assert "3 recordings, the 2 that differ most drawn" in words(figure)
    assert "on top" not in words(figure)  # there is no room for both


def test_each_assumption_has_its_line_with_the_interval_of_the_simulation() -> None:
    plan = plan_recordings(result_of(quiet_drives(4)))
    figure = power_plot(replace(plan, sizes=()), theme="dark")
    assert not figure.data
    assert words(figure) == " | No study was simulated."
    points = (PowerPoint(10, 0.5, 0.4, 0.6, 200), PowerPoint(81, 0.9, 0.8, 0.95, 200))
    sizes = (
        PlanSize("as named", 0.1, points=points),
        PlanSize("equal", 0.0, points=points[:1]),
        PlanSize("as found", 0.2),  # not simulated
    )
    figure = power_plot(replace(plan, sizes=sizes), theme="light")
    named, equal = figure.data
    assert (named.x, named.y, equal.x) == ((10, 81), (0.5, 0.9), (10,))
    assert named.error_y.array == pytest.approx((0.1, 0.05))
    assert named.error_y.arrayminus == pytest.approx((0.1, 0.1))
    assert named.name.replace("\xa0", " ") == "difference as named (+0.100 s per encounter)"
    assert equal.name == "X and Y equal"
    assert (named.line.dash, equal.line.dash) == ("solid", "dash")
    assert named.text[0].replace("\xa0", " ").endswith("50 % of 200 studies (40 % to 60 %)")
    assert figure.layout.shapes[0].y0 == plan.power
    assert figure.layout.xaxis.type == "log"
    assert figure.layout.xaxis.tickvals == (10, 20, 50)
    linear = power_plot(replace(plan, sizes=sizes[1:]), theme="light").layout.xaxis
    assert (linear.type, linear.rangemode) == (None, "tozero")
