"""Figures of detection curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from curve_scenes import curve_of
from figure_parts import trace, words

from nvcore.figures.detection import MAX_POINTS, curve_plot

X = curve_of([1, 2, 3], [0, 10, 100], n_truth=4)
Y = replace(curve_of([1, 4], [1, 1], n_truth=4), system="y")


def test_miss_rate_over_fppi_leaves_out_what_a_log_axis_cannot_show() -> None:
    figure = curve_plot((X, Y), (None, None), "miss_rate", theme="light")
    assert list(trace(figure, "X: x").x) == pytest.approx([0.1, 1.0])
    assert list(trace(figure, "X: x").y) == pytest.approx([0.5, 0.25])
    assert list(trace(figure, "Y: y").y) == pytest.approx([0.75])  # its last has no miss
    assert figure.layout.xaxis.type == figure.layout.yaxis.type == "log"


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
    assert list(trace(figure, "X: x").x) == pytest.approx([0.0001, 0.001])


def test_a_system_without_scores_is_a_point() -> None:
    point = curve_of([3], [2], n_truth=4, is_ranked=False)
    figure = curve_plot((point, Y), (None, None), "precision_recall", theme="light")
    assert trace(figure, "X: x").mode == "markers"


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
    monkeypatch.setattr("nvcore.curves._ratio", lambda part, whole: made.append(1) or part / whole)
    n = np.arange(1, 501)
    curve_plot((curve_of(n, n, n_truth=500),), (None,), "precision_recall", theme="light")
    assert len(made) < 10
