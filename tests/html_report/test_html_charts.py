"""Figures of the report, and how they are put into a page."""

from __future__ import annotations

import base64
import gzip
import json

import numpy as np
import plotly.graph_objects as go
from builders import at, compare, make_dataset
from plotly.offline import get_plotlyjs

from nvcore.figures.style import LOOK
from nvcore.html_report.charts import figure_json, interval_plot, packed_plotly
from nvcore.significance import significance_table

X, Y = LOOK["light"].x, LOOK["light"].y


def one_each():
    """12 pedestrians of one frame each; X finds 9 of them, Y 3 others."""
    truth = [at(t, 50, track=t) for t in range(12)]
    return compare(make_dataset(truth, truth[:9], truth[9:], n_frames=12))


def test_plotly_is_packed_whole_and_the_same_each_time():
    packed = packed_plotly()
    packed_plotly.cache_clear()
    assert packed_plotly() == packed
    assert gzip.decompress(base64.b64decode(packed)).decode() == get_plotlyjs()
    assert len(packed) < 2_500_000


def test_json_of_a_figure_cannot_end_its_script_and_means_the_same():
    text = "</script><!-- & \u2028"
    figure = go.Figure(go.Scatter(x=np.arange(3.0), y=[1, 2, 3], name=text))
    written = figure_json(figure)
    assert not set(written) & set("<>&\u2028")
    assert json.loads(written)["data"][0]["name"] == text


def test_intervals_lie_right_where_x_is_better_whichever_way_is_better():
    evidence = significance_table(one_each()).set_index("figure")
    shown = evidence.loc[["encounters_detected", "mean_similarity", "share_low"]].reset_index()
    assert shown["difference"].tolist()[0] == 0.5
    figure = interval_plot(shown)
    assert figure.layout.xaxis.range[0] < 0 < figure.layout.xaxis.range[1]
    assert shown["better"].tolist()[2] == "lower"
    assert figure.layout.xaxis3.range[0] > 0 > figure.layout.xaxis3.range[1]  # runs backwards
    points = [trace for trace in figure.data if trace.mode == "markers"]
    assert [trace.marker.color for trace in points] == [X, X, X]
    assert [trace.x[0] for trace in points] == shown["difference"].tolist()


def test_intervals_are_those_of_the_table():
    evidence = significance_table(one_each())
    (known,) = [row for row in evidence.itertuples() if row.figure == "encounters_detected"]
    lines = [trace for trace in interval_plot(evidence).data if trace.mode == "lines"]
    assert list(lines[0].x) == [known.low, known.high]


def test_axes_of_shares_are_in_per_cent():
    evidence = significance_table(one_each())
    shown = evidence[evidence["figure"].isin(["encounters_detected", "mean_similarity"])]
    figure = interval_plot(shown, {"encounters_detected"})
    assert figure.layout.xaxis.tickformat == "~%"
    assert figure.layout.xaxis2.tickformat == ""


def test_without_any_figure_it_says_so():
    result = compare(make_dataset(n_frames=3))
    empty = significance_table(result).assign(difference=np.nan)
    assert "No figure" in interval_plot(empty).layout.annotations[0].text
