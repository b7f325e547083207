"""Figures of the report, and how they are put into a page."""

from __future__ import annotations

import base64
import gzip
import json

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest
from approach import ALL, LATE, met
from builders import at, make_dataset, result_of
from plotly.offline import get_plotlyjs

from nvcore.evidence.measures import significance_table
from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.figures.style import LOOK
from nvcore.report.html.charts import figure_json, interval_plot, packed_plotly
from nvcore.report.section import Fold, Table
from nvcore.report.sections.evidence import subgroups_section


@pytest.fixture(scope="module")
def evidence() -> pd.DataFrame:
    """12 pedestrians of two frames each; X finds 9 of them, Y 3 others."""
    truth = [at(2 * t + f, 50, track=t) for t in range(12) for f in range(2)]
    return significance_table(result_of(make_dataset(truth, truth[:18], truth[18:], n_frames=24)))


@pytest.fixture
def with_intervals(evidence: pd.DataFrame) -> pd.DataFrame:
    """The evidence with intervals of 0.1 about all differences."""
    difference = evidence["difference"]
    return evidence.assign(low=difference - 0.1, high=difference + 0.1)


def annotations(figure: go.Figure) -> list[str]:
    return [note.text for note in figure.layout.annotations]


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


def test_intervals_lie_right_where_x_is_better_whichever_way_is_better(with_intervals):
    table = with_intervals.set_index("figure")
    shown = table.loc[["encounters_detected", "mean_similarity", "share_low"]].reset_index()
    assert shown["difference"].tolist()[0] == 0.5
    figure = interval_plot(shown)
    assert figure.layout.xaxis.range[0] < 0 < figure.layout.xaxis.range[1]
    assert shown["better"].tolist()[2] == "lower"
    assert figure.layout.xaxis3.range[0] > 0 > figure.layout.xaxis3.range[1]  # runs backwards
    points = [trace for trace in figure.data if trace.mode == "markers"]
    assert [trace.marker.color for trace in points] == [LOOK["light"].x] * 3
    assert [trace.x[0] for trace in points] == pytest.approx(
        shown["difference"].to_numpy() * [100, 1, 100]
    )


def test_intervals_are_those_of_the_table_shares_in_percentage_points(evidence):
    known = evidence.set_index("figure").loc["encounters_detected"]
    figure = interval_plot(evidence)
    lines = [trace for trace in figure.data if trace.mode == "lines"]
    assert list(lines[0].x) == pytest.approx([100 * known.low, 100 * known.high])
    text = "share of encounters detected, within<br>these recordings: <b>+50.0 pp</b>"
    assert text in annotations(figure)


def test_a_figure_without_interval_has_no_place_on_an_axis(with_intervals):
    row = with_intervals["figure"] == "mean_similarity"
    ends = {name: with_intervals[name].mask(row) for name in ("low", "high")}
    without = with_intervals.assign(**ends)
    drawn, fewer = (
        sum(trace.mode == "markers" for trace in interval_plot(table).data)
        for table in (with_intervals, without)
    )
    assert fewer == drawn - 1
    (text,) = [text for text in annotations(interval_plot(without)) if "mean similarity" in text]
    assert text.endswith("(no interval can be given)")


def test_an_axis_of_no_difference_still_has_ticks_that_differ(evidence):
    flat = evidence[evidence["figure"] == "encounters_detected"].assign(
        low=0.0, high=0.0, difference=0.0
    )
    figure = interval_plot(flat)
    assert list(figure.layout.xaxis.range) == [-1, 1]  # percentage points
    empty = interval_plot(evidence.assign(difference=np.nan))
    assert "No measure" in annotations(empty)[0]


def test_who_detects_more_is_of_encounters_detected_alone():
    result = met((ALL, LATE), (ALL, ALL))
    section = subgroups_section(result, subgroup_table(result))
    (fold,) = [block for block in section.blocks if isinstance(block, Fold)]
    tables = {block.title: block for block in fold.blocks if isinstance(block, Table)}
    groups = [row[:2] for row in tables["Encounters detected by subgroup"].rows]
    assert len(groups) == len(set(groups))
    assert tables["Encounters detected by subgroup"].rows[0][2:5] == ("2", "1", "1")


def test_groups_with_neither_interval_nor_test_are_left_out_and_counted():
    result = met((ALL, LATE), (ALL, ALL))
    whole = subgroup_table(result)
    overall = whole[whole["figure"] == "mean_similarity"].head(1)
    tested = overall.assign(factor="tag", group="night", p=0.5, low=np.nan)
    unknown = tested.assign(group="day", p=np.nan)
    rows = pd.concat([whole[whole["factor"] == "all"], tested, unknown], ignore_index=True)
    section = subgroups_section(result, rows).worded(result.objects)
    (fold,) = [block for block in section.blocks if isinstance(block, Fold)]
    _, similarity = fold.blocks
    assert [row[:2] for row in similarity.rows] == [("all", ""), ("tag", "night")]
    (left_out,) = section.blocks[-1].texts
    assert left_out.startswith("1 row with too little data")
