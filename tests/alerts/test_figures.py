"""Figures of alerts."""

from __future__ import annotations

import numpy as np
import pytest
from approach import ALL, LATE, met
from figure_parts import trace, words

from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.figures import alert_trade_off, alerts_in_time, alerts_over_time
from nvcore.subjects.alerts.steps import alerts_in


@pytest.fixture(scope="module")
def result() -> Result:
    """A pedestrian in each of two recordings, confirmed in time by X, late by Y in the second."""
    return met((ALL, ALL), (ALL, LATE), alerts="policy")


def test_each_alert_is_a_bar_from_its_onset_in_the_row_of_its_system_and_kind(result: Result):
    figure = alerts_over_time(result, 1, "light")
    table = alerts_in(result).table
    for place, label in enumerate(figure.layout.yaxis.ticktext):
        side, kind = label.lower().split(" ")
        (own,) = table[(table["system"] == side) & (table["kind"] == kind)].to_dict("records")[-1:]
        bar, mark = figure.data[2 * place : 2 * place + 2]
        start_s = own["start_s"]
        assert bar.x[:2].tolist() == pytest.approx([start_s, start_s + own["duration_s"]])
        assert bar.y[:2].tolist() == [place, place]
        assert (mark.x.tolist(), mark.y.tolist()) == ([start_s], [place])
        assert mark.customdata.tolist() == [[40 + own["start_frame"], 1]]
        assert mark.text[0].endswith(f"s, for {own['duration_s']:.1f} s<br>pedestrian 1")
    assert "2 alerts" in words(figure)


def test_shares_in_time_stand_on_their_intervals(result: Result):
    figure = alerts_in_time(result, theme="light")
    table = alerts_in(result).in_time_for_drivers.table
    shares = table[table["measure"] == "share"]
    for letter in "xy":
        own = shares[shares["side"] == letter]
        drawn = trace(figure, f"{letter.upper()}: {letter}")
        assert drawn.x == pytest.approx(100 * own["mean"].to_numpy())
    thin, thick = figure.data[:2]
    assert thick.line.width > thin.line.width
    ends = own[["draws_low", "draws_high"]].to_numpy(dtype=float)[0]
    assert figure.data[4].x[:2] == pytest.approx(100 * ends)
    assert np.mean(figure.data[2].y) < np.mean(figure.data[5].y)  # X above Y
    assert "of 2 urgent encounters" in words(figure)


def test_the_trade_off_is_a_line_over_the_threshold_with_what_is_in_use(result: Result):
    figure = alert_trade_off(result, theme="light")
    curve = alerts_in(result).curve
    for letter in "xy":
        own = curve[(curve["system"] == letter) & (curve["of"] == "policy")]
        line, used = (trace(figure, f"{letter.upper()}: {letter}{of}") for of in ("", ", in use"))
        assert line.x.tolist() == own["unwanted"].tolist()  # too short for a rate an hour
        assert line.y.tolist() == own["in_time"].tolist()
        assert (line.mode, used.mode) == ("lines+markers", "markers")
        assert "alerted in time" in line.text[0]
    assert figure.layout.xaxis.title.text.startswith("unwanted alerts in 8 s")


def test_without_alerts_or_urgency_the_figures_say_so():
    never = met((range(0), range(0)), alerts="policy", reaction_s=0.0)
    assert "Nothing alerts the driver" in words(alerts_over_time(never, 0, "light"))
    assert "Nobody is urgent" in words(alerts_in_time(never, theme="light"))
    assert "No encounter is urgent" in words(alert_trade_off(never, theme="light"))
