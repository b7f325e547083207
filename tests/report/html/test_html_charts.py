"""The figure of the report's intervals, figures in a page, and tables of subgroups."""

from __future__ import annotations

import base64
import gzip
import json

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from approach import ALL, LATE, met
from plotly.offline import get_plotlyjs

from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.figures.style import LOOK
from nvcore.report.html.charts import figure_json, interval_plot, packed_plotly
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


def test_plotly_is_packed_whole_and_the_same_each_time():
    packed = base64.b64decode(packed_plotly())
    assert gzip.decompress(packed).decode() == get_plotlyjs()
    assert packed[4:8] == bytes(4)  # no time
    assert len(packed) < 2_500_000


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


def test_a_table_of_subgroups_leaves_out_and_counts_groups_with_too_little_data():
    result = met((ALL, LATE), (ALL, ALL))
    whole = subgroup_table(result, ["encounters_detected", "mean_similarity"])
    overall = whole[whole["figure"] == "mean_similarity"].head(1)
    tested = overall.assign(factor="tag", group="night", p=0.5, low=np.nan)
    unknown = tested.assign(group="day", p=np.nan)
    rows = pd.concat([whole[whole["factor"] == "all"], tested, unknown], ignore_index=True)
    section = subgroups_section(result, rows).worded(result.objects)
    (fold,) = [block for block in section.blocks if isinstance(block, Fold)]
    detected, similarity = fold.blocks
    assert detected.title == "Encounters detected by subgroup"
    assert [row[:2] for row in detected.rows] == [("all", "")]
    assert detected.rows[0][2:5] == ("2", "1", "1")
    assert [row[:2] for row in similarity.rows] == [("all", ""), ("tag", "night")]
    (left_out,) = section.blocks[-1].texts
    assert left_out.startswith("1 row with too little data")
