"""Figures of encounters, recordings and fusion."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from figure_parts import trace, words

from nvcore.figures import dots
from nvcore.figures import encounters as module
from nvcore.figures.dots import recordings_plot
from nvcore.figures.encounters import (
    fusion_plot,
    lead_bins,
    lead_time_plot,
    miss_classes_plot,
    position_map,
)
from nvcore.objects import PEDESTRIAN

NAMES = ("FIR", "NIR")


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


def recordings(*pairs: tuple[float, float], column: str = "mean_similarity") -> pd.DataFrame:
    x, y = zip(*pairs, strict=True) if pairs else ((), ())
    names = [f"{i:04d}" for i in range(len(pairs))]
    return pd.DataFrame({"recording": names, f"{column}_x": x, f"{column}_y": y}, dtype=object)


def fusion(rate: float = 30.0, encounters: int = 10) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "system": ["x", "y", "x_or_y", "x_and_y"], "name": ["FIR", "NIR", "<b>", "both"],
            "encounters_detected": [7, 6, 9, 4], "encounters": encounters,
            "false_alert_episodes": [rate, 2 * rate, 3 * rate, 0 * rate],
        }
    )  # fmt: skip


def test_miss_classes_are_counted_for_each_system_without_distant_encounters() -> None:
    figure = miss_classes_plot(SIX, NAMES, theme="light", objects=PEDESTRIAN)
    x, y = trace(figure, "X: FIR"), trace(figure, "Y: NIR")
    assert list(x.customdata) == ["never", "late", "dropout", "lost_early", "brief", "none"]
    assert x.y.tolist() == [1, 1, 0, 0, 0, 3]
    assert y.y.tolist() == [2, 1, 0, 0, 0, 2]
    assert "5 encounters" in words(figure)
    assert figure.layout.yaxis.title.text == "encounters"


def test_every_miss_class_has_its_label_upright_on_lines_that_fit() -> None:
    along = miss_classes_plot(SIX, NAMES, theme="light", objects=PEDESTRIAN).layout.xaxis
    assert along.ticktext[-1] == "no<br>failure"
    assert along.tickangle == 0


def test_without_anything_to_draw_a_figure_says_so() -> None:
    for figure, told in (
        (miss_classes_plot(SIX[:0], NAMES, theme="light", objects=PEDESTRIAN), "widen the filters"),
        (position_map(SIX[:0], theme="light", objects=PEDESTRIAN), "widen the filters"),
        (lead_time_plot(SIX[2:3], theme="light", objects=PEDESTRIAN), "matched by both systems"),
        (recordings_plot(recordings(), NAMES, theme="light"), "no recording"),
        (fusion_plot(fusion(encounters=0), theme="light"), "no encounter"),
    ):
        assert told in words(figure)
        assert not figure.data


def test_lead_times_right_of_zero_are_those_where_x_is_first() -> None:
    figure = lead_time_plot(SIX, theme="light", objects=PEDESTRIAN)
    x, y = trace(figure, "X first"), trace(figure, "Y first")
    assert [x.x[i] for i in np.flatnonzero(x.y)] == [pytest.approx(0.8)]
    assert [y.x[i] for i in np.flatnonzero(y.y)] == [pytest.approx(-1.6)]
    assert trace(figure, "at the same time").y.tolist() == [1]
    told = "3 encounters matched by both: X first in 1, Y in 1; median +0.00 s"
    assert told in words(figure)


def test_a_small_lead_in_the_bin_of_zero_is_still_a_lead() -> None:
    lead_s = [0.0, 0.1, 0.1, -0.1, 15.0]  # so long a lead makes bins of two seconds
    figure = lead_time_plot(
        pd.DataFrame({"lead_time_s": lead_s}), theme="light", objects=PEDESTRIAN
    )
    count = {
        part.name: dict(zip(part.x.tolist(), part.y.tolist(), strict=True)) for part in figure.data
    }
    assert count["at the same time"] == {0: 1}
    assert count["Y first"] == {0: 1}
    assert count["X first"] == {0: 2, 16: 1}
    assert figure.layout.barmode == "stack"  # in one bin the three stand on each other


@pytest.mark.parametrize("reach", [0.0, 0.04, 0.5, 1.8, 7.0, 60.0, 1000.0])
def test_the_bins_of_lead_time_are_few_hold_all_and_one_is_centred_at_zero(reach: float) -> None:
    lead_s = np.linspace(-reach, reach, 81)
    centre, width = lead_bins(lead_s)
    assert len(centre) <= 25
    assert 0 in centre.tolist()
    assert centre[-1] + width / 2 >= reach * (1 - 1e-12)
    figure = lead_time_plot(
        pd.DataFrame({"lead_time_s": lead_s}), theme="light", objects=PEDESTRIAN
    )
    assert sum(int(part.y.sum()) for part in figure.data) == len(lead_s)


def test_the_map_marks_each_encounter_by_who_misses_it() -> None:
    figure = position_map(SIX, theme="light", objects=PEDESTRIAN)
    rows = {part.name: part.customdata.tolist() for part in figure.data}
    assert rows == {
        "distant (1)": [15], "detected by both (2)": [10, 11], "missed by X (1)": [13],
        "missed by Y (1)": [12], "missed by both (1)": [14],
    }  # fmt: skip
    missed = trace(figure, "missed by X (1)")
    assert (missed.x.tolist(), missed.y.tolist()) == ([pytest.approx(0.3)], [pytest.approx(30)])
    assert "&lt;b&gt;r" in missed.text[0]
    assert len({part.marker.symbol for part in figure.data[1:]}) == 4  # told without colour


def test_marks_of_the_map_are_larger_the_more_the_failure_weighs() -> None:
    figure = position_map(SIX, theme="light", objects=PEDESTRIAN)
    by_row = {
        row: size
        for part in figure.data
        for row, size in zip(part.customdata, part.marker.size, strict=True)
    }
    assert by_row[10] == by_row[15] == module.MAP_SIZES[0]  # no severity, distant
    assert by_row[14] == module.MAP_SIZES[1]
    assert by_row[11] < by_row[12] < by_row[13] < by_row[14]
    assert "severity X 0.30 s, Y 0.60 s" in trace(figure, "missed by X (1)").text[0]
    assert "severity" not in trace(figure, "distant (1)").text[0]


def test_a_bar_of_a_miss_class_tells_what_its_failures_weigh() -> None:
    figure = miss_classes_plot(SIX, NAMES, theme="light", objects=PEDESTRIAN)
    never, late = trace(figure, "Y: NIR").hovertext[:2]
    assert never.endswith("severity in all 1.20 s")  # 2 * (0.2 + 0.4)
    assert late.endswith("severity in all 0.00 s")


def test_the_map_thins_out_those_who_are_seen_before_those_who_are_missed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "MAX_MARKS", 6)
    seen = [("both", "none", "none", 0.0)] * 10
    figure = position_map(
        table(*seen, ("x_only", "none", "never", np.nan)), theme="light", objects=PEDESTRIAN
    )
    assert len(trace(figure, "detected by both (10)").x) == 5
    assert len(trace(figure, "missed by Y (1)").x) == 1
    assert "11 encounters, 6 of them drawn" in words(figure)


def test_recordings_are_sorted_by_how_much_better_x_is() -> None:
    pairs = recordings((0.8, 0.9), (0.9, 0.7), (0.5, 0.5), (np.nan, 0.9))
    figure = recordings_plot(pairs, NAMES, theme="light")
    assert trace(figure, "X: FIR").customdata.tolist() == [1, 2, 0]
    assert trace(figure, "X: FIR").x.tolist() == [0.9, 0.5, 0.8]
    assert trace(figure, "Y: NIR").x.tolist() == [0.7, 0.5, 0.9]
    assert figure.layout.yaxis.ticktext == ("0001", "0002", "0000")
    assert "3 recordings; X is better in 1, Y in 1; best for X on top" in words(figure)


def test_less_saliency_is_better() -> None:
    saliency = recordings((2.0, 0.5), (0.5, 2.0), column="saliency")
    figure = recordings_plot(saliency, NAMES, theme="light", measure="saliency")
    assert trace(figure, "X: FIR").customdata.tolist() == [1, 0]


def test_a_small_difference_looks_small_and_no_recording_lies_outside_the_axis() -> None:
    similarity = recordings_plot(recordings((0.873, 0.95)), NAMES, theme="light")
    assert similarity.layout.xaxis.range == pytest.approx((0.485, 1.015))
    saliency = recordings((0.02, 0.03), column="saliency")
    figure = recordings_plot(saliency, NAMES, theme="light", measure="saliency")
    assert figure.layout.xaxis.range == pytest.approx((-0.03, 1.03))
    wide = recordings_plot(recordings((0.2, 0.95), (0.4, 0.3)), NAMES, theme="light")
    assert wide.layout.xaxis.range[0] < 0.2


def test_of_many_recordings_those_with_the_largest_differences_are_drawn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(dots, "MAX_RECORDINGS", 2)
    pairs = recordings((0.8, 0.9), (0.9, 0.4), (0.5, 0.5))
    figure = recordings_plot(pairs, NAMES, theme="light")
    assert trace(figure, "X: FIR").customdata.tolist() == [1, 0]
    assert "3 recordings, the 2 that differ most drawn" in words(figure)


def test_fusion_shows_encounters_against_false_alerts() -> None:
    figure = fusion_plot(fusion(), theme="light")
    assert {part.name: (part.x[0], part.y[0]) for part in figure.data} == {
        "X": (30, 7), "Y": (60, 6), "X or Y": (90, 9), "X and Y": (0, 4),
    }  # fmt: skip
    assert "&lt;b&gt;" in trace(figure, "X or Y").hovertext[0]
    assert "10 encounters" in words(figure)


def test_systems_at_one_place_have_one_label_and_marks_inside_each_other() -> None:
    table = fusion()
    table.loc[table["system"] == "y", ["false_alert_episodes", "encounters_detected"]] = 30, 7
    figure = fusion_plot(table, theme="light")
    x, y = trace(figure, "X"), trace(figure, "Y")
    assert (x.text[0], y.text[0]) == ("X = Y", "")
    assert x.marker.size > y.marker.size == trace(figure, "X or Y").marker.size
