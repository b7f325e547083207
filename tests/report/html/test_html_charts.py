"""The figure of the report's intervals, figures in a page, and tables of subgroups."""

from __future__ import annotations

import base64
import gzip
import json

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest
from builders import make_dataset, result_of

from nvcore.figures.style import LOOK
from nvcore.report.html import charts
from nvcore.report.html.charts import figure_json, interval_plot
from nvcore.report.section import Fold
from nvcore.report.sections.evidence import subgroups_section

EVIDENCE = pd.DataFrame(
    [
        ("encounters_detected", "share of encounters detected, within these recordings",
         "higher", 0.5, 0.25, 0.75),
        ("mean_similarity", "mean similarity", "higher", 0.5, -0.1, 1.0),
        ("share_low", "share of frames with low similarity", "lower", -0.25, -0.5, 0.0),
    ],
    columns=["figure", "label", "better", "difference", "low", "high"],
)  # fmt: skip


def annotations(figure: go.Figure) -> list[str]:
    return [note.text for note in figure.layout.annotations]


def test_plotly_is_packed_whole_and_the_same_each_time(monkeypatch: pytest.MonkeyPatch):
    script = "window.Plotly = 'á';" * 1000
    monkeypatch.setattr(charts, "get_plotlyjs", lambda: script)
    packed = base64.b64decode(charts.packed_plotly.__wrapped__())
    assert gzip.decompress(packed).decode() == script
    assert packed[4:8] == bytes(4)  # no time
    assert len(packed) < len(script) / 50


def test_json_of_a_figure_cannot_end_its_script_and_means_the_same():
    text = "</script><!-- & \u2028"
    written = figure_json(go.Figure(go.Scatter(x=np.arange(3.0), y=[1, 2, 3], name=text)))
    assert not set(written) & set("<>&\u2028")
    assert json.loads(written)["data"][0]["name"] == text


def test_intervals_lie_right_where_x_is_better_whichever_way_is_better():
    figure = interval_plot(EVIDENCE)
    assert figure.layout.xaxis.range[0] < 0 < figure.layout.xaxis.range[1]
    assert figure.layout.xaxis3.range[0] > 0 > figure.layout.xaxis3.range[1]  # runs backwards
    lines, points = (
        [trace for trace in figure.data if trace.mode == mode] for mode in ("lines", "markers")
    )
    assert [trace.marker.color for trace in points] == [LOOK["light"].x] * 3
    assert [trace.x[0] for trace in points] == [50, 0.5, -25]  # shares in percentage points
    assert [tuple(line.x) for line in lines] == [(25, 75), (-0.1, 1), (-50, 0)]
    text = "share of encounters detected, within<br>these recordings: <b>+50.0 pp</b>"
    assert annotations(figure)[0] == text


def test_a_measure_without_interval_has_no_place_on_an_axis():
    ends = EVIDENCE[["low", "high"]].mask(EVIDENCE["figure"] == "mean_similarity")
    figure = interval_plot(EVIDENCE.assign(**ends))
    assert sum(trace.mode == "markers" for trace in figure.data) == 2
    assert annotations(figure)[1].endswith("(no interval can be given)")
    figure = interval_plot(EVIDENCE.assign(low=np.nan))
    assert "too few data for any interval" in figure.layout.title.text
    assert figure.layout.xaxis.visible is False


def test_an_axis_of_no_difference_still_has_ticks_that_differ():
    figure = interval_plot(EVIDENCE.head(1).assign(low=0.0, high=0.0, difference=0.0))
    assert list(figure.layout.xaxis.range) == [-1, 1]  # percentage points
    assert figure.data[1].marker.color == LOOK["light"].muted
    empty = interval_plot(EVIDENCE.assign(difference=np.nan))
    assert "No measure" in annotations(empty)[0]


def test_tables_of_subgroups_leave_out_and_count_groups_with_too_little_data():
    unknown = dict.fromkeys(["difference", "low", "high", "p", "p_corrected"], np.nan)
    counts = {"n": 2, "unit": "encounters", "both": 2, "x_only": 1, "y_only": 1, "neither": 0}
    common = {**unknown, **counts, "x": 1.0, "y": 0.5, "label": "a measure", "note": ""}
    rows = pd.DataFrame(
        [
            {**common, "figure": "encounters_detected", "factor": "all", "group": "all"},
            {**common, "figure": "mean_similarity", "factor": "all", "group": "all"},
            {**common, "figure": "mean_similarity", "factor": "tag", "group": "night", "p": 0.5},
            {**common, "figure": "mean_similarity", "factor": "tag", "group": "day"},
        ]
    )
    result = result_of(make_dataset(n_frames=1))
    section = subgroups_section(result, rows).worded(result.objects)
    (fold,) = [block for block in section.blocks if isinstance(block, Fold)]
    detected, similarity = fold.blocks
    assert detected.title == "Encounters detected by subgroup"
    assert [row[:6] for row in detected.rows] == [("all", "", "2", "2", "1", "1")]
    assert [row[:2] for row in similarity.rows] == [("all", ""), ("tag", "night")]
    (left_out,) = section.blocks[-1].texts
    assert left_out.startswith("1 row with too little data")
