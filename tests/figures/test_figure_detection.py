"""Figures of detection curves."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from curve_scenes import curve_of
from figure_parts import trace, words

from nvcore.figures.curves import MAX_POINTS, CurveKind, curve_plot, legend_text
from nvcore.metrics.detection.curve_summary import summarise_curve
from nvcore.metrics.detection.curves import DetectionCurve
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.published import PublishedPoint

X = curve_of([1, 2, 3], [0, 10, 100], n_truth=4)
Y = replace(curve_of([1, 4], [1, 1], n_truth=4), system="y")
NOTHING = curve_of([], [], n_truth=4)
SOME_SCORES = curve_of([1, 2], [1, 2], n_truth=4, is_ranked=False)
POINT = replace(curve_of([3], [2], n_truth=4, is_ranked=False), threshold=np.array([np.inf]))


def plot(*curves: DetectionCurve, kind: CurveKind = "miss_rate", **more: Any) -> Any:
    """The curves, every detection counting unless thresholds are given."""
    thresholds = more.pop("thresholds", (None, None))
    return curve_plot(curves, thresholds, kind, theme="light", objects=PEDESTRIAN, **more)


def edge_of(log_axis: Any, label: str = "0") -> float:
    """Where zeros stand on an axis."""
    assert log_axis.type == "log"
    # of an axis along the bottom it is a line lower than the lowest tick's, which is near
    assert log_axis.ticktext[0].removeprefix("<br>") == label
    assert 10 ** log_axis.range[0] < log_axis.tickvals[0] < log_axis.tickvals[1]
    return float(log_axis.tickvals[0])


def test_zeros_stand_at_the_edge_of_a_logarithmic_axis() -> None:
    figure = plot(X, Y)
    left, bottom = edge_of(figure.layout.xaxis), edge_of(figure.layout.yaxis)
    assert list(trace(figure, "X: x").x) == pytest.approx([left, 0.1, 1.0])
    assert list(trace(figure, "X: x").y) == pytest.approx([0.75, 0.5, 0.25])
    assert list(trace(figure, "Y: y").y) == pytest.approx([0.75, bottom])  # its last has no miss
    reached = trace(figure, "Y at the edge")
    assert (reached.x[0], reached.y[0]) == pytest.approx((0.01, bottom))
    assert not [part for part in figure.data if part.name == "X at the edge"]


def test_a_perfect_system_is_drawn_and_in_the_legend() -> None:
    perfect = curve_of([4], [0], n_truth=4)
    figure = plot(perfect, Y)
    drawn, mark = trace(figure, "X: x"), trace(figure, "X as set")
    corner = edge_of(figure.layout.xaxis), edge_of(figure.layout.yaxis)
    assert (drawn.x[0], drawn.y[0]) == (mark.x[0], mark.y[0]) == pytest.approx(corner)
    assert drawn.mode == "markers"  # a line of one point cannot be seen
    assert drawn.showlegend


def test_what_is_below_the_axis_stands_at_its_edge_which_then_says_so() -> None:
    few = curve_of([1, 2], [1, 2], n_truth=4, n_images=5000)
    figure = plot(few)
    left = edge_of(figure.layout.xaxis, "< 0.001")
    assert list(trace(figure, "X: x").x) == pytest.approx([left, left])


def test_an_axis_without_zeros_has_no_edge_and_reaches_to_the_last_point() -> None:
    many = curve_of([1, 2], [100, 5000], n_truth=4)
    xaxis = plot(many).layout.xaxis
    assert list(xaxis.ticktext) == ["0.001", "0.01", "0.1", "1", "10", "100"]
    assert 10 ** xaxis.range[1] >= xaxis.tickvals[-1] == 100  # a tick beyond it has no label


@pytest.mark.parametrize(
    ("kind", "legend", "axes", "x", "y"),
    [
        ("precision_recall", "X: x, AP 0.306", ("recall", "precision"), [0.25, 0.5, 0.75],
         [1, 2 / 12, 3 / 103]),
        ("roc", "X: x", ("false positives per image", "detection rate"), [0.1, 1],
         [0.25, 0.5, 0.75]),
        ("roc_windows", "X: x", ("false positives per window", "detection rate"), [1e-4, 1e-3],
         [0.25, 0.5, 0.75]),
        ("f1", "X: x, best 0.400", ("score threshold", "F1"), [1, 1 / 2, 1 / 3],
         [0.4, 0.25, 6 / 107]),
    ],
)  # fmt: skip
def test_each_kind_has_its_own_axes(
    kind: CurveKind, legend: str, axes: tuple[str, str], x: list[float], y: list[float]
) -> None:
    summaries = summarise_curve(X, None), None
    figure = plot(X, Y, kind=kind, windows_per_image=1000, summaries=summaries, hint="")
    assert figure.layout.title.text.endswith("large marks: thresholds in use</span>")
    titles = figure.layout.xaxis.title.text, figure.layout.yaxis.title.text
    assert tuple(title.partition(" (")[0] for title in titles) == axes
    line = trace(figure, legend)
    if kind.startswith("roc"):
        x = [edge_of(figure.layout.xaxis), *x]
    assert list(line.x) == pytest.approx(x)
    assert list(line.y) == pytest.approx(y)


@pytest.mark.parametrize(
    ("tp", "words"),
    [
        ([1, 2], "LAMR 59.9 %"),  # (0.75 ** 4 * 0.5 ** 5) ** (1 / 9)
        ([1, 4], "LAMR 0 % (0 at 5 of 9 references)"),
        ([4, 4], "LAMR 0 % (nothing missed)"),
    ],
)
def test_the_legend_says_why_a_log_average_is_0(tp: list[int], words: str) -> None:
    summary = summarise_curve(curve_of(tp, [0, 10], n_truth=4), None)
    assert legend_text(summary, "miss_rate") == words
    assert legend_text(summarise_curve(NOTHING, None), "precision_recall") == "AP 0.000"


@pytest.mark.parametrize(
    ("curve", "kind", "name"),
    [
        (NOTHING, "miss_rate", "no detections"),
        (SOME_SCORES, "precision_recall", "points: some scores are missing"),
        (POINT, "precision_recall", "no scores: a point"),
        (POINT, "f1", "no scores: F1 0.667"),
    ],
)
def test_without_a_curve_the_legend_says_what_there_is_instead(
    curve: DetectionCurve, kind: CurveKind, name: str
) -> None:
    drawn = trace(plot(X, curve, kind=kind), f"Y: x, {name}")
    assert (drawn.mode, drawn.showlegend) == ("markers", True)


@pytest.mark.parametrize(
    ("curve", "kind", "told"),
    [
        (curve_of([0], [5], n_truth=0), "precision_recall", "No box of the truth counts"),
        (X, "roc_windows", "number of windows"),
        (NOTHING, "miss_rate", "no detections"),
        (POINT, "f1", "There are no scores"),
    ],
)
def test_a_figure_with_nothing_to_draw_says_why(
    curve: DetectionCurve, kind: CurveKind, told: str
) -> None:
    assert told in words(plot(curve, curve, kind=kind))


def test_a_click_tells_whose_threshold_it_is_and_a_point_without_scores_sets_none() -> None:
    figure = plot(X, POINT)
    clicked = [list(point) for point in trace(figure, "X, points").customdata]
    assert clicked == [["x", 1], ["x", 1 / 2], ["x", 1 / 3]]
    assert [list(point) for point in trace(figure, "Y, points").customdata] == [["y", None]]


def test_the_threshold_in_use_has_a_mark_which_is_promised_only_where_it_is() -> None:
    used = plot(X, Y, kind="precision_recall", thresholds=(0.5, None))
    mark = trace(used, "X as set")
    assert (mark.x[0], mark.y[0]) == pytest.approx((0.5, 2 / 12))
    assert trace(used, "Y as set").x[0] == 1
    assert "large marks: thresholds in use; click" in words(used)
    # above all scores there is no precision, but everybody is missed
    above = plot(X, Y, kind="precision_recall", thresholds=(2.0, 2.0))
    assert not [part for part in above.data if part.name.endswith("as set")]
    assert "large mark" not in words(above)
    figure = plot(X, Y, kind="miss_rate", thresholds=(2.0, None))
    mark = trace(figure, "X as set")
    assert (mark.x[0], mark.y[0]) == (edge_of(figure.layout.xaxis), 1)


@pytest.mark.parametrize("kind", ["miss_rate", "precision_recall", "f1"])
def test_a_long_curve_is_thinned_and_keeps_its_ends(kind: CurveKind) -> None:
    n = 20_000
    fp = np.arange(1, n + 1)
    tp = np.floor(1000 * (1 - np.exp(-fp / 3000))).astype(int)
    long = curve_of(list(tp), list(fp), n_truth=1001)
    line = trace(plot(long, Y, kind=kind), "X: x")
    assert 40 < len(line.x) <= MAX_POINTS + 2
    whole = {"miss_rate": long.fppi, "precision_recall": long.recall, "f1": long.threshold}[kind]
    assert (line.x[0], line.x[-1]) == (whole[0], whole[-1])


def test_a_published_point_is_marked_where_both_of_its_values_are_known() -> None:
    points = (
        PublishedPoint(name="report <b>", recall=0.9, precision=0.2),
        PublishedPoint(name="paper", miss_rate=0.25, fppi=0.0),
    )

    def marked(kind: CurveKind) -> dict[str, tuple[float, float]]:
        figure = plot(X, Y, kind=kind, published=points)
        named = [part for part in figure.data if str(part.name).endswith("(published)")]
        assert all(part.showlegend and "<b>" not in part.name for part in named)
        return {part.name.partition(" ")[0]: (part.x[0], part.y[0]) for part in named}

    assert marked("precision_recall") == {"report": pytest.approx((0.9, 0.2))}
    miss_rate = plot(X, Y, kind="miss_rate", published=points)
    left = edge_of(miss_rate.layout.xaxis)
    assert marked("miss_rate") == {"paper": pytest.approx((left, 0.25))}
    assert marked("roc")["paper"][1] == pytest.approx(0.75)
    assert marked("f1") == {}
