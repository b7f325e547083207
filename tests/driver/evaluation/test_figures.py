"""Figures of an evaluation of what the driver sees, from small tables."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from figure_parts import trace, words

from nvcore.subjects.driver.evaluation.figures import (
    detectability_histograms_plot,
    detectability_plot,
    estimates_plot,
    estimator_errors_plot,
    feature_pairs_plot,
    pair_ranks_plot,
)

ERRORS = pd.DataFrame(
    {
        "period_s": [0.5, 3.0, np.nan],
        "n": [51, 50, 101],
        "switched": [0.05, 0.07, 0.06],
        "single": [0.06, 0.09, 0.075],
        "constant": [0.1, 0.12, 0.11],
        "published_switched": [0.069, 0.134, np.nan],
        "published_single": [np.nan, np.nan, np.nan],
    }
)
PAIRS = pd.DataFrame(
    [
        (0.5, 1, "luminance_sd", "edge_contrast", 0.04),
        (0.5, 2, "width_px", "height_px", 0.09),
        (3.0, 1, "luminance_sd", "edge_contrast", 0.05),
        (3.0, 2, "width_px", "height_px", 0.06),
    ],
    columns=["period_s", "rank", "feature_1", "feature_2", "error"],
)
RANKS = pd.DataFrame({"period_1_s": [0.5], "period_2_s": [3.0], "spearman": [0.25]})
PERIODS = pd.DataFrame(
    [(0.5, 51, 0.2, 0.25, 0.5, 0.0), (3.0, 51, 0.6, 0.3, 0.1, 0.2)],
    columns=["period_s", "n", "mean", "sd", "share_zero", "share_one"],
)
HISTOGRAMS = pd.DataFrame(
    {"period_s": [0.5] * 3 + [3.0] * 3, "detectability": [0, 0.5, 1] * 2, "n": [3, 1, 0, 1, 1, 2]}
)
ESTIMATES = pd.DataFrame(
    {
        "image": ["a.jpg", "a.jpg", "b.jpg"],
        "pedestrian": "p1",
        "period_s": [0.5, 3.0, 3.0],
        "detectability": [0.0, 0.5, 1.0],
        "n_subjects": 4,
        "switched": [0.2, 0.4, 0.9],
    }
)


def test_errors_stand_beside_those_of_a_constant_and_of_the_paper_apart_without_colour():
    figure = estimator_errors_plot(ERRORS, theme="light")
    assert [part.name for part in figure.data] == [
        "switched: one for each period",
        "single: one for all",
        "constant: mean of the others",
        "paper, switched",  # that of the single one is not known here
    ]
    assert list(trace(figure, "single: one for all").y) == [0.06, 0.09]  # without the mean
    assert trace(figure, "paper, switched").text[0] == "paper, switched<br>0.5 s: 0.0690"
    assert len({(part.line.dash, part.marker.symbol) for part in figure.data}) == 4
    assert "51 pedestrians at each period" in words(figure)
    assert figure.layout.xaxis.ticktext == ("0.5", "3")
    assert len(estimator_errors_plot(ERRORS, theme="dark", has_published=False).data) == 3


def test_pairs_are_ordered_by_their_rank_and_cells_say_it():
    figure = feature_pairs_plot(PAIRS, theme="light")
    cells = figure.data[0]
    assert figure.layout.yaxis.ticktext == ("Luminance SD + Edge contrast", "Width + Height")
    np.testing.assert_allclose(cells.z, [[0.04, 0.05], [0.09, 0.06]])
    assert [list(row) for row in cells.text] == [["1", "1"], ["2", "2"]]
    assert figure.layout.height == 130 + 2 * 22  # a row for each pair


def test_rank_correlations_fill_both_halves():
    figure = pair_ranks_plot(RANKS, theme="dark")
    assert [list(row) for row in figure.data[0].text] == [["–", "0.25"], ["0.25", "–"]]
    assert figure.layout.height == 130 + 2 * 32
    unknown = pair_ranks_plot(RANKS.assign(spearman=np.nan), theme="dark").data[0]
    assert [list(row) for row in unknown.text] == [["–", "–"]] * 2


def test_detectability_has_its_spread_as_bars():
    line = detectability_plot(PERIODS, theme="light").data[0]
    assert list(line.y) == [0.2, 0.6]
    assert list(line.error_y.array) == [0.25, 0.3]
    assert "50 % seen by nobody" in line.text[0].replace("\xa0", " ")


def test_each_period_has_its_histogram_beside_the_others():
    figure = detectability_histograms_plot(HISTOGRAMS, theme="light")
    assert [list(bars.y) for bars in figure.data] == [[3, 1, 0], [1, 1, 2]]
    assert [note.text for note in figure.layout.annotations] == ["0.5 s", "3 s"]
    first, second = figure.layout.xaxis.domain, figure.layout.xaxis2.domain
    assert first == pytest.approx((0, 0.49))
    assert second == pytest.approx((0.51, 1))
    titles = [figure.layout[name].title.text for name in ("xaxis", "xaxis2")]
    assert titles == ["", "detectability"]
    assert "4 pedestrians at each" in words(figure)


def test_estimates_stand_over_what_was_seen_with_their_correlation():
    figure = estimates_plot(ESTIMATES, theme="light")
    line, marks = figure.data
    assert list(line.x) == list(line.y) == [0, 1]
    assert figure.layout.xaxis.range == figure.layout.yaxis.range == (-0.03, 1.03)
    assert list(marks.x) == [0.2, 0.4, 0.9]
    assert list(marks.y) == [0.0, 0.5, 1.0]
    assert "p1 of b.jpg, 3 s<br>estimate 0.90, seen by 1.00 of 4 subjects" in marks.text[2]
    assert "correlation 0.97" in words(figure)  # 0.35 / sqrt(0.26 * 0.5)
    same = estimates_plot(ESTIMATES.assign(detectability=0.5), theme="light")
    assert "correlation –" in words(same)


def test_without_data_there_is_a_sentence():
    for draw, table in (
        (estimator_errors_plot, ERRORS),
        (estimates_plot, ESTIMATES),
        (feature_pairs_plot, PAIRS),
        (pair_ranks_plot, RANKS),
        (detectability_plot, PERIODS),
        (detectability_histograms_plot, HISTOGRAMS),
    ):
        figure = draw(table.iloc[:0], theme="light")
        assert not figure.data
        assert figure.layout.annotations[0].text.endswith(".")
