"""Figures of encounters and fusion, and of how near one pedestrian counts."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from builders import at, make_dataset
from figure_parts import trace, words

from nvcore.comparison.compare import compare
from nvcore.figures import encounters as module
from nvcore.figures.encounters import (
    fusion_plot,
    lead_bins,
    lead_time_plot,
    miss_classes_plot,
    position_map,
    weightings_plot,
)
from nvcore.figures.style import LOOK, faded
from nvcore.settings.objects import PEDESTRIAN
from nvcore.tables.encounters.weightings import compare_weightings

LOOKS = {"theme": "light", "objects": PEDESTRIAN}


def table(*rows: tuple[str, str | None, str | None, float]) -> pd.DataFrame:
    """Encounters of (category, class for X, class for Y, lead time), numbered from 10."""
    columns = ["category", "miss_class_x", "miss_class_y", "lead_time_s"]
    encounters = pd.DataFrame(rows, columns=columns, index=10 + np.arange(len(rows)))
    place = np.arange(len(rows)) / 10
    return encounters.assign(
        recording="<b>r</b>", track=7, lateral_position=place, peak_height=100 * place,
        severity_s_x=np.where(encounters["category"] == "distant", np.nan, place),
        severity_s_y=np.where(encounters["category"] == "distant", np.nan, 2 * place),
    )  # fmt: skip


SIX = table(
    ("both", "none", "late", 0.8),
    ("both", "none", "none", 0.0),
    ("x_only", "none", "never", np.nan),
    ("y_only", "late", "none", -1.6),
    ("neither", "never", "never", np.nan),
    ("distant", None, None, np.nan),
)


def fusion(encounters: int = 10) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "system": ["x", "y", "x_or_y", "x_and_y"], "name": ["FIR", "NIR", "<b>", "both"],
            "encounters_detected": [7, 6, 9, 4], "encounters": encounters,
            "false_alert_episodes": [30, 60, 90, 0],
        }
    )  # fmt: skip


def test_miss_classes_are_counted_for_each_system_without_distant_encounters() -> None:
    figure = miss_classes_plot(SIX, ("FIR", "NIR"), **LOOKS)
    x, y = trace(figure, "X: FIR"), trace(figure, "Y: NIR")
    assert list(x.customdata) == ["never", "late", "dropout", "lost_early", "brief", "none"]
    assert x.y.tolist() == x.text.tolist() == [1, 1, 0, 0, 0, 3]
    assert y.y.tolist() == [2, 1, 0, 0, 0, 2]
    # Y, the dashed one, is outlined
    colours = LOOK["light"].x, faded(LOOK["light"].y, 0.3)
    assert (x.marker.color, y.marker.color) == colours
    never, late = y.hovertext[:2]
    assert never.endswith("severity in all 1.20 s")  # 2 * (0.2 + 0.4)
    assert late.endswith("severity in all 0.00 s")
    assert "5 encounters" in words(figure)
    assert figure.layout.yaxis.title.text == "encounters"
    # every class has its label, upright on lines that fit
    assert figure.layout.xaxis.ticktext[-1] == "no<br>failure"
    assert figure.layout.xaxis.tickangle == 0


def test_without_anything_to_draw_a_figure_says_so() -> None:
    for figure, told in (
        (miss_classes_plot(SIX[:0], ("FIR", "NIR"), **LOOKS), "widen the filters"),
        (position_map(SIX[:0], **LOOKS), "widen the filters"),
        (lead_time_plot(SIX[2:3], **LOOKS), "matched by both systems"),
        (fusion_plot(fusion(encounters=0), theme="light"), "no encounter"),
    ):
        assert told in words(figure)
        assert not figure.data


def test_lead_times_right_of_zero_are_those_where_x_is_first() -> None:
    figure = lead_time_plot(SIX, **LOOKS)
    x, y = trace(figure, "X first"), trace(figure, "Y first")
    assert (x.x.tolist(), x.y.tolist()) == ([pytest.approx(0.8)], [1])
    assert (y.x.tolist(), y.y.tolist()) == ([pytest.approx(-1.6)], [1])
    assert trace(figure, "at the same time").y.tolist() == [1]
    told = "3 encounters matched by both: X first in 1, Y in 1; median +0.00 s"
    assert told in words(figure)
    assert figure.layout.yaxis.dtick == 1


def test_a_small_lead_in_the_bin_of_zero_is_still_a_lead() -> None:
    lead_s = [0.0, 0.1, 0.1, -0.1, 15.0]  # so long a lead makes bins of two seconds
    figure = lead_time_plot(pd.DataFrame({"lead_time_s": lead_s}), **LOOKS)
    count = {
        part.name: dict(zip(part.x.tolist(), part.y.tolist(), strict=True)) for part in figure.data
    }
    assert count["at the same time"] == {0: 1}
    assert count["Y first"] == {0: 1}
    assert count["X first"] == {0: 2, 16: 1}
    assert figure.layout.barmode == "stack"  # in one bin the three stand on each other
    assert figure.layout.xaxis.range == (-18, 18)  # a bin's width beyond the outermost


@pytest.mark.parametrize("reach", [0.0, 0.04, 1.8, 60.0, 1000.0])
def test_the_bins_of_lead_time_are_few_hold_all_and_one_is_centred_at_zero(reach: float) -> None:
    lead_s = np.linspace(-reach, reach, 81)
    centre, width = lead_bins(lead_s)
    assert 5 <= len(centre) <= 25
    assert 0 in centre.tolist()
    assert centre[-1] + width / 2 >= reach * (1 - 1e-12)
    figure = lead_time_plot(pd.DataFrame({"lead_time_s": lead_s}), **LOOKS)
    assert sum(int(part.y.sum()) for part in figure.data) == len(lead_s)


def test_the_map_marks_each_encounter_by_who_misses_it() -> None:
    figure = position_map(SIX, **LOOKS)
    rows = {part.name: part.customdata.tolist() for part in figure.data}
    assert rows == {
        "distant (1)": [15], "detected by both (2)": [10, 11], "missed by X (1)": [13],
        "missed by Y (1)": [12], "missed by both (1)": [14],
    }  # fmt: skip
    missed = trace(figure, "missed by X (1)")
    assert (missed.x.tolist(), missed.y.tolist()) == ([pytest.approx(0.3)], [pytest.approx(30)])
    assert "&lt;b&gt;r" in missed.text[0]
    assert "severity X 0.30 s, Y 0.60 s" in missed.text[0]
    assert "severity" not in trace(figure, "distant (1)").text[0]
    assert len({part.marker.symbol for part in figure.data[1:]}) == 4  # told without colour
    assert missed.marker.color == LOOK["light"].x
    assert figure.layout.yaxis.range == pytest.approx((0, 1.06 * 50))


def test_marks_of_the_map_are_larger_the_more_the_failure_weighs() -> None:
    by_row = {
        row: size
        for part in position_map(SIX, **LOOKS).data
        for row, size in zip(part.customdata, part.marker.size, strict=True)
    }
    assert by_row[10] == by_row[15] == module.MAP_SIZES[0]  # no severity, distant
    assert by_row[14] == module.MAP_SIZES[1]
    assert by_row[11] < by_row[12] < by_row[13] < by_row[14]


@pytest.mark.parametrize(("most", "n_seen", "n_missed"), [(6, 5, 1), (1, 1, 1), (12, 10, 1)])
def test_the_map_thins_out_those_who_are_seen_before_those_who_are_missed(
    monkeypatch: pytest.MonkeyPatch, most: int, n_seen: int, n_missed: int
) -> None:
    monkeypatch.setattr(module, "MAX_MARKS", most)
    seen = [("both", "none", "none", 0.0)] * 10
    figure = position_map(table(*seen, ("x_only", "none", "never", np.nan)), **LOOKS)
    assert len(trace(figure, "detected by both (10)").x) == n_seen
    assert len(trace(figure, "missed by Y (1)").x) == n_missed
    drawn = n_seen + n_missed
    assert (f"11 encounters, {drawn} of them drawn" in words(figure)) == (drawn < 11)


def test_fusion_shows_encounters_against_false_alerts() -> None:
    figure = fusion_plot(fusion(), theme="light")
    assert {part.name: (part.x[0], part.y[0]) for part in figure.data} == {
        "X": (30, 7), "Y": (60, 6), "X or Y": (90, 9), "X and Y": (0, 4),
    }  # fmt: skip
    assert "&lt;b&gt;" in trace(figure, "X or Y").hovertext[0]
    assert "10 encounters" in words(figure)
    assert figure.layout.xaxis.range == pytest.approx((-4.5, 108))


def test_systems_at_one_place_have_one_label_and_marks_inside_each_other() -> None:
    table = fusion()
    table.loc[table["system"] == "y", ["false_alert_episodes", "encounters_detected"]] = 30, 7
    figure = fusion_plot(table, theme="light")
    x, y = trace(figure, "X"), trace(figure, "Y")
    assert (x.text[0], y.text[0], trace(figure, "X or Y").text[0]) == ("X = Y", "", "X or Y")
    assert x.marker.size > y.marker.size == trace(figure, "X or Y").marker.size
    assert x.textfont.color == LOOK["light"].ink


@pytest.mark.parametrize("is_known", [True, False])
def test_a_weight_that_is_known_is_a_curve_and_detections_stand_below(is_known: bool) -> None:
    known = {"distance_m": 30.0} if is_known else {}
    truth = [at(i, 50, track=1, **known) for i in range(3)]
    dataset = make_dataset(truth, [truth[1]], [], horizon=50.0 if is_known else np.nan)
    result = compare(dataset)
    weightings = compare_weightings(result, 0)
    figure = weightings_plot(result, 0, weightings, theme="light")
    kinds = ("height", "horizon", "distance") if is_known else ("height",)
    curves = [part for part in figure.data if (part.name or "").startswith("by ")]
    assert [curve.name for curve in curves] == [f"by {kind}" for kind in kinds]
    for curve, kind in zip(curves, kinds, strict=True):
        np.testing.assert_array_equal(curve.y, weightings.curves[f"k_{kind}"])
        assert curve.text[1] == f"frame 1, 0.10 s<br>k by {kind} {curve.y[1]:.2f}"
    assert len({curve.line.dash for curve in curves}) == len(kinds)
    assert not {curve.line.color for curve in curves} & {LOOK["light"].x, LOOK["light"].y}
    assert "count from k = 0.5 on" in words(figure)
    lane = trace(figure, "X: x")
    assert np.isclose(lane.x, [0.1]).all()
    assert figure.layout.yaxis.range[0] < lane.y[0] < 0
    assert list(lane.text) == ["X detects the pedestrian, frame 1"]
    assert len(trace(figure, "Y: y").x) == 0
