"""Figures of ratings."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from figure_parts import trace, words

from nvcore.subjects.ratings.agreement import Agreement
from nvcore.subjects.ratings.figures import participants_plot, rating_plot
from nvcore.subjects.ratings.trend import fit_trend
from nvcore.subjects.ratings.validation import Correlation


def clips(n: int = 12) -> pd.DataFrame:
    rank = np.arange(1.0, n + 1)
    return pd.DataFrame(
        {
            "clip": [f"<b>drive {i}" for i in range(n)],
            "recording": [f"drive {i}" for i in range(n)],
            "system": ["FIR", "NIR"] * (n // 2),
            "mean_rank": rank,
            "n_ratings": 5,
            "saliency_s": rank**2,
        }
    )


def drawn(table: pd.DataFrame, *correlations: Correlation):
    return rating_plot(table, correlations, ("FIR", "NIR"), theme="light")


def test_each_clip_stands_at_its_rank_and_saliency_with_the_coefficient_told() -> None:
    undefined = Correlation("Kendall's tau", np.nan, np.nan, np.nan, np.nan, "too few")
    figure = drawn(clips(), undefined, Correlation("Pearson's r", 0.97, 0.9, 0.99, 0.0))
    of_x = trace(figure, "X: FIR")
    assert list(of_x.x) == [1, 3, 5, 7, 9, 11]
    assert list(of_x.y) == [1, 9, 25, 49, 81, 121]
    assert "12 clips; Pearson's r 0.97 (95 %: 0.90 to 0.99)" in words(figure)
    assert of_x.text[0] == (
        "&lt;b&gt;drive 0, boxes of X<br>mean rank 1.0 of 5 ratings<br>saliency 1.00 s"
    )
    assert "No clip has both" in words(drawn(clips(0)))


def test_the_plot_has_the_trend_with_its_interval_and_names_the_clip_far_from_it() -> None:
    table = clips()
    table["saliency_s"] = 2 * table["mean_rank"] + np.resize([0.1, -0.1, 0.05, -0.05], 12)
    table.loc[3, "saliency_s"] = 30.0
    figure = drawn(table)
    (line,) = [part for part in figure.data if part.name.startswith("trend: ")]
    band = trace(figure, "interval of the trend")
    assert "s per rank (95 %:" in line.name
    half = len(line.x)
    assert (np.array(band.y[:half]) >= np.array(line.y)).all()
    assert (np.array(band.y[half:])[::-1] <= np.array(line.y)).all()
    (named,) = figure.layout.annotations
    assert named.text == "&lt;b&gt;drive 3, Y"
    assert (named.x, named.y) == (4.0, 30.0)
    assert named.xanchor == "left"  # there is room on the right
    assert named.yshift > 0  # away from the line
    low, high = figure.layout.yaxis.range
    assert low == 0
    assert high == pytest.approx(1.06 * max(30.0, *band.y))


def test_five_outliers_are_named_at_most_and_few_clips_have_no_trend() -> None:
    table = clips(64)
    table["saliency_s"] = np.where(np.arange(64) % 8 == 0, 200.0, table["mean_rank"])
    assert np.count_nonzero(fit_trend(table).is_outlier) == 8
    assert len(drawn(table).layout.annotations) == 5
    assert [part.name for part in drawn(clips(4)).data] == ["X: FIR", "Y: NIR"]


def test_participants_who_go_another_way_are_marked() -> None:
    people = pd.DataFrame(
        {
            "participant": ["A", "B", "C"],
            "agreement": [0.9, -0.4, np.nan],
            "is_outlier": [False, True, False],
        }
    )
    figure = participants_plot(Agreement(4, 5, 0, 0.4, 0.02, "", people), theme="light")
    assert list(figure.data[0].x) == [-0.4, 0.9]
    assert list(figure.data[0].marker.symbol) == ["x", "circle"]
    assert list(figure.layout.yaxis.ticktext) == ["B", "A"]
    assert "2 participants; 1 ranking differently" in words(figure)
