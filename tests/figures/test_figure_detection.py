"""Figures of detection curves."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from curve_scenes import curve_of
from figure_parts import trace, words

from nvcore.detection.curve_summary import summarise_curve
from nvcore.figures.detection import MAX_POINTS, CurveKind, curve_plot, legend_figure

X = curve_of([1, 2, 3], [0, 10, 100], n_truth=4)
Y = replace(curve_of([1, 4], [1, 1], n_truth=4), system="y")


def edge_of(log_axis: Any, label: str = "0") -> float:
    """Where zeros stand on an axis."""
    assert log_axis.type == "log"
    assert log_axis.ticktext[0] == label
    assert 10 ** log_axis.range[0] < log_axis.tickvals[0] < log_axis.tickvals[1]
    return float(log_axis.tickvals[0])


def test_zeros_stand_at_the_edge_of_a_logarithmic_axis() -> None:
    figure = curve_plot((X, Y), (None, None), "miss_rate", theme="light")
    left, bottom = edge_of(figure.layout.xaxis), edge_of(figure.layout.yaxis)
    assert list(trace(figure, "X: x").x) == pytest.approx([left, 0.1, 1.0])
    assert list(trace(figure, "X: x").y) == pytest.approx([0.75, 0.5, 0.25])
    assert list(trace(figure, "Y: y").y) == pytest.approx([0.75, bottom])  # its last has no miss
    reached = trace(figure, "Y at the edge")
    assert (reached.x[0], reached.y[0]) == pytest.approx((0.01, bottom))
    assert reached.marker.symbol == "diamond-open"
    assert not [one for one in figure.data if one.name == "X at the edge"]


def test_a_perfect_system_is_drawn_and_in_the_legend() -> None:
    perfect = curve_of([4], [0], n_truth=4)
    legend = legend_figure(summarise_curve(perfect, None), "miss_rate")
    figure = curve_plot((perfect, Y), (None, None), "miss_rate", theme="dark",
                        summaries=(legend, ""))  # fmt: skip
    drawn = trace(figure, "X: x, LAMR 0% (nobody missed)")
    corner = edge_of(figure.layout.xaxis), edge_of(figure.layout.yaxis)
    assert (drawn.x[0], drawn.y[0]) == pytest.approx(corner)
    assert drawn.mode == "markers"  # a line of one point cannot be seen
    assert drawn.showlegend
    assert (trace(figure, "X as set").x[0], trace(figure, "X as set").y[0]) == pytest.approx(corner)


def test_what_is_below_the_axis_stands_at_its_edge_which_then_says_so() -> None:
    few = curve_of([1, 2], [1, 2], n_truth=4, n_images=5000)
    figure = curve_plot((few,), (None,), "miss_rate", theme="light")
    left = edge_of(figure.layout.xaxis, "< 0.001")
    assert list(trace(figure, "X: x").x) == pytest.approx([left, left])


def test_an_axis_without_zeros_has_no_edge_and_reaches_to_the_last_point() -> None:
    many = curve_of([1, 2], [100, 5000], n_truth=4)
    xaxis = curve_plot((many,), (None,), "miss_rate", theme="light").layout.xaxis
    assert list(xaxis.ticktext) == ["0.001", "0.01", "0.1", "1", "10", "100"]
    assert xaxis.range[0] < -3  # room beside the first label
    assert 10 ** xaxis.range[1] >= xaxis.tickvals[-1] == 100  # a tick beyond it has no label


@pytest.mark.parametrize(
    ("tp", "words"),
    [
        ([1, 2], "LAMR 59.9%"),  # (0.75 ** 4 * 0.5 ** 5) ** (1 / 9)
        ([1, 4], "LAMR 0% (0 at 5 of 9 references)"),
        ([4, 4], "LAMR 0% (nobody missed)"),
    ],
)
def test_the_legend_says_why_a_log_average_is_0(tp: list[int], words: str) -> None:
    summary = summarise_curve(curve_of(tp, [0, 10], n_truth=4), None)
    assert legend_figure(summary, "miss_rate") == words


def test_without_a_curve_the_legend_says_what_there_is_instead() -> None:
    nothing = curve_of([], [], n_truth=4)
    some = curve_of([1, 2], [1, 2], n_truth=4, is_ranked=False)
    figure = curve_plot((nothing, some), (None, None), "miss_rate", theme="light",
                        summaries=[legend_figure(summarise_curve(one, None), "precision_recall")
                                   for one in (nothing, some)])  # fmt: skip
    assert trace(figure, "X: x, no detections, AP 0.000").showlegend
    assert trace(figure, "Y: x, points: some scores are missing").mode == "markers"


def test_f1_of_a_system_without_scores_is_a_number_in_the_legend() -> None:
    point = replace(curve_of([3], [2], n_truth=4, is_ranked=False), threshold=np.array([np.inf]))
    figure = curve_plot((X, point), (None, None), "f1", theme="light")
    assert trace(figure, "Y: x, no scores: F1 0.667").showlegend
    alone = curve_plot((point, point), (None, None), "f1", theme="light")
    assert "There are no scores" in words(alone)


def test_a_point_without_scores_sets_no_threshold() -> None:
    point = replace(curve_of([3], [2], n_truth=4, is_ranked=False), threshold=np.array([np.inf]))
    figure = curve_plot((X, point), (None, None), "miss_rate", theme="light")
    assert [list(one) for one in trace(figure, "Y, points").customdata] == [["y", None]]
    assert "without scores<br>miss rate 0.250, 0.02 false" in trace(figure, "Y, points").text[0]


@pytest.mark.parametrize(
    ("kind", "first"),
    [
        ("miss_rate", "miss rate 0.500, 0.1 false positives per image"),
        ("precision_recall", "recall 0.500, precision 0.167"),
        ("roc", "detection rate 0.500, 0.1 false positives per image"),
        ("roc_windows", "detection rate 0.500, 0.0001 false positives per window"),
        ("f1", "F1 0.250"),
    ],
)
def test_what_the_axes_show_stands_first(kind: CurveKind, first: str) -> None:
    figure = curve_plot((X, Y), (None, None), kind, theme="light", windows_per_image=1000)
    assert trace(figure, "X, points").text[1].split("<br>")[1] == first


def test_marks_are_promised_only_where_they_are() -> None:
    both = curve_plot((X, Y), (None, None), "precision_recall", theme="light")
    assert "large marks: thresholds in use; click" in both.layout.title.text
    one = curve_plot((X, Y), (2.0, None), "precision_recall", theme="light")
    assert "large mark: threshold of Y in use" in one.layout.title.text
    none = curve_plot((X, Y), (2.0, 2.0), "precision_recall", theme="light")
    assert "large mark" not in none.layout.title.text
    printed = curve_plot((X, Y), (None, None), "roc", theme="light", hint="higher is better")
    assert printed.layout.title.text.count("click") == 0
    assert "in use; higher is better" in printed.layout.title.text


def test_a_threshold_above_all_scores_misses_everybody_on_the_axes_that_have_it() -> None:
    figure = curve_plot((X, Y), (2.0, None), "miss_rate", theme="light")
    mark = trace(figure, "X as set")
    assert (mark.x[0], mark.y[0]) == (edge_of(figure.layout.xaxis), 1)


def test_precision_over_recall_with_the_operating_point() -> None:
    figure = curve_plot((X, Y), (0.5, None), "precision_recall", theme="dark",
                        summaries=("AP 0.5", ""))  # fmt: skip
    line = trace(figure, "X: x, AP 0.5")
    assert list(line.x) == pytest.approx([0.25, 0.5, 0.75])
    assert list(line.y) == pytest.approx([1, 2 / 12, 3 / 103])
    mark = trace(figure, "X as set")
    assert (mark.x[0], mark.y[0]) == pytest.approx((0.5, 2 / 12))
    assert trace(figure, "Y as set").x[0] == 1


def test_a_click_tells_whose_threshold_it_is() -> None:
    figure = curve_plot((X, Y), (None, None), "roc", theme="light")
    assert [list(one) for one in trace(figure, "X, points").customdata] == [
        ["x", 1],
        ["x", 1 / 2],
        ["x", 1 / 3],
    ]
    assert [one[0] for one in trace(figure, "Y, points").customdata] == ["y", "y"]


def test_a_threshold_above_all_scores_has_no_mark() -> None:
    figure = curve_plot((X, Y), (2.0, None), "precision_recall", theme="light")
    assert not [one for one in figure.data if one.name == "X as set"]


def test_false_positives_per_window_need_the_number_of_windows() -> None:
    assert "number of windows" in words(
        curve_plot((X, Y), (None, None), "roc_windows", theme="dark")
    )
    figure = curve_plot((X, Y), (None, None), "roc_windows", theme="dark", windows_per_image=1000)
    assert list(figure.layout.xaxis.ticktext) == ["0", "1e-5", "1e-4", "0.001"]
    left = edge_of(figure.layout.xaxis)
    assert list(trace(figure, "X: x").x) == pytest.approx([left, 0.0001, 0.001])


def test_a_system_without_scores_is_a_point() -> None:
    point = curve_of([3], [2], n_truth=4, is_ranked=False)
    figure = curve_plot((point, Y), (None, None), "precision_recall", theme="light")
    assert trace(figure, "X: x, no scores: a point").mode == "markers"


def test_no_truth_says_so() -> None:
    empty = curve_of([0], [5], n_truth=0)
    assert "No pedestrian counts" in words(
        curve_plot((empty, empty), (None, None), "precision_recall", theme="light")
    )


@pytest.mark.parametrize("kind", ["miss_rate", "precision_recall", "f1"])
def test_a_long_curve_is_thinned_and_keeps_its_ends(kind: str) -> None:
    n = 20_000
    fp = np.arange(1, n + 1)
    tp = np.floor(1000 * (1 - np.exp(-fp / 3000))).astype(int)
    long = curve_of(list(tp), list(fp), n_truth=1001)
    line = trace(curve_plot((long, Y), (None, None), kind, theme="light"), "X: x")
    assert 40 < len(line.x) <= MAX_POINTS + 2
    whole = {"miss_rate": long.fppi, "precision_recall": long.recall, "f1": long.threshold}[kind]
    assert line.x[0] == whole[0]
    assert line.x[-1] == whole[-1]


def test_what_stands_at_a_point_is_the_curve_s_there() -> None:
    curve = curve_of([0, 1, 2], [0, 10, 100], n_truth=4)
    texts = trace(curve_plot((curve,), (None,), "f1", theme="light"), "X, points").text
    assert "recall 0.250, precision 0.091<br>0.1 false positives per image" in texts[1]
    assert "precision nan" in texts[0]


def test_a_curve_of_many_points_costs_no_array_for_each(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    monkeypatch.setattr(
        "nvcore.detection.curves._ratio", lambda part, whole: made.append(1) or part / whole
    )
    n = np.arange(1, 501)
    curve_plot((curve_of(n, n, n_truth=500),), (None,), "precision_recall", theme="light")
    assert len(made) < 10
