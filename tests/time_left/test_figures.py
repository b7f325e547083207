"""Urgent encounters up to contact, the speed of the car, margins; and all that in the lanes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from approach import ALL, LATE, NEVER, PLACE, approach, met
from builders import at, make_dataset, result_of
from figure_parts import shape, trace, words

from nvcore.api.figures import Figures
from nvcore.comparison.compare import Result, compare
from nvcore.figures.lanes import lanes_figure
from nvcore.figures.style import LOOK
from nvcore.subjects.time_left import figures
from nvcore.subjects.time_left.encounters import urgent_encounters
from nvcore.subjects.time_left.figures import approach_plot, margins_plot, over_speed_plot
from nvcore.subjects.time_left.steps import time_left_in

LAST_CHANCE = 29


@pytest.fixture(scope="module")
def late() -> Result:
    """A pedestrian whom X confirms in time, and Y after the last chance."""
    return met((range(10, 40), LATE))


@pytest.fixture(scope="module")
def three() -> Result:
    """The same, one whom Y never confirms, and one whom both confirm in time."""
    return met((range(10, 40), LATE), (ALL, NEVER), (ALL, ALL))


@pytest.fixture(scope="module")
def still() -> Result:
    """A pedestrian whom the car does not approach."""
    return result_of(make_dataset([at(frame, 50, track=1) for frame in range(20)]))


def up_to_contact(result: Result, **more: int):
    return approach_plot(result, urgent_encounters(result), theme="light", **more)


def test_a_line_runs_from_the_first_sight_to_the_last_annotated_frame_and_on_to_contact(late):
    figure = up_to_contact(late)
    assert trace(figure, "annotated").x[:2].round(6).tolist() == [5.0, 1.1]
    assert trace(figure, "no longer annotated").x[:2].round(6).tolist() == [1.1, 0.0]
    assert trace(figure, "no longer annotated").showlegend is None
    assert np.nanmax(trace(figure, "too late to stop").x) == pytest.approx(2.1)
    chance = trace(figure, "last chance to stop")
    assert chance.x.round(6).tolist() == [2.1]
    assert chance.customdata.tolist() == [[LAST_CHANCE, 0]]
    assert figure.layout.xaxis.range[0] > figure.layout.xaxis.range[1]  # contact is on the right
    # of a legend in the container Plotly reserves the height, in as many rows as it has
    assert (figure.layout.legend.yref, figure.layout.legend.yanchor) == ("container", "top")
    assert figure.layout.margin.t >= 98


def test_each_system_has_a_mark_where_it_confirms_and_an_open_one_where_it_never_does(three):
    figure = up_to_contact(three)
    x, y = trace(figure, "X: x confirms"), trace(figure, "Y: y confirms")
    assert x.x.round(6).tolist() == [4.8, 3.8, 4.8]  # Y never: the faster impact is on top
    assert x.customdata.tolist() == [[42, 1], [12, 0], [82, 2]]
    assert y.x.round(6).tolist() == [1.8, 4.8]
    assert y.customdata.tolist() == [[32, 0], [82, 2]]
    assert x.y[1] < 1 < y.y[0]  # X above Y: rows run downwards
    never = trace(figure, "Y never")
    assert never.x[0] < 0
    assert never.customdata.tolist() == [[40 + LAST_CHANCE, 1]]
    assert "X never" not in [drawn.name for drawn in figure.data]
    assert "Y never confirms the pedestrian: impact at 50 km/h" in never.text[0]
    assert "last chance 2.10 s before contact, at 50 km/h" in never.text[0]
    # impact speeds beside the rows, and their titles above the first
    assert "impact, km/h | X | Y | 0 | <b>50</b> | 0 | <b>31</b> | 0 | 0" in words(figure)
    heads = figure.layout.annotations[:3]
    assert {note.yref for note in heads} == {"y"}
    assert all(figure.layout.yaxis.range[1] < note.y < -0.5 for note in heads)


def test_so_many_rows_at_a_time_keep_the_axis(three):
    whole, second = up_to_contact(three), up_to_contact(three, first=1, most=1)
    assert whole.layout.yaxis.ticktext == ("ped 1, r1", "ped 1, r0", "ped 1, r2")
    assert second.layout.yaxis.ticktext == ("ped 1, r0",)
    assert "3 urgent encounters, the fastest impact on top, 2 to 2 drawn" in words(second)
    assert second.layout.xaxis.range == whole.layout.xaxis.range


def test_what_is_long_before_contact_stands_at_the_edge():
    boxes = approach(range(190), 20)
    result = result_of(
        make_dataset(boxes, boxes, boxes[150:], places=[PLACE._replace(frames=range(190))])
    )
    figure = up_to_contact(result)
    assert np.nanmax(trace(figure, "annotated").x) == 12
    assert trace(figure, "X: x confirms").x.tolist() == [12]
    assert "what was more than 12 s before contact stands at the left edge" in words(figure)


def test_without_urgent_encounters_the_figures_say_so(still):
    result = met((ALL, ALL), reaction_s=0.0)
    urgent = urgent_encounters(result)
    assert "No encounter is urgent" in words(up_to_contact(result))
    assert "No encounter is urgent" in words(margins_plot(result, urgent, theme="light"))
    nobody = over_speed_plot(
        time_left_in(still).over_speed, ("x", "y"), speed_kmh=50, theme="light"
    )
    assert "No encounter is urgent at any speed" in words(nobody)


def test_the_curve_over_speed_has_the_numbers_and_marks_speed_and_turn(late):
    curve = time_left_in(late).over_speed
    figure = over_speed_plot(curve, ("a", "b"), theme="dark", speed_kmh=50)
    x, y = trace(figure, "X: a"), trace(figure, "Y: b")
    urgent = curve[curve["urgent"] > 0]
    assert x.x.tolist() == urgent["speed_kmh"].tolist()
    assert x.y.tolist() == urgent["share_in_time_x"].tolist()
    place = y.x.tolist().index(50)
    assert y.text[place].startswith("50 km/h: 1 urgent<br>Y: 0 in time (0 %), mean impact 31")
    assert shape(figure, "speed").x0 == 50
    assert [part.name for part in figure.layout.shapes] == ["speed"]
    swapped = curve.assign(
        share_in_time_x=np.where(curve["speed_kmh"] < 90, 1.0, 0.0), share_in_time_y=0.5
    )
    turned = over_speed_plot(swapped, ("a", "b"), speed_kmh=None, theme="light")
    assert [part.name for part in turned.layout.shapes] == ["turn 90"]
    assert "turns at 90" in words(turned)
    assert "1 urgent encounter at" in words(figure)
    assert figure.layout.xaxis.title.text == "speed of the car (km/h)"


def test_where_recordings_state_their_speed_the_axis_says_that_it_is_replaced():
    result = met((ALL, LATE), (ALL, LATE))
    assert time_left_in(result).assumed_speed_kmh == 50
    recordings = result.dataset.recordings.assign(speed_kmh=[30.0, np.nan])
    stated = compare(replace(result.dataset, recordings=recordings), result.params)
    assert time_left_in(stated).assumed_speed_kmh is None
    figure = Figures(stated).over_speed()
    assert figure.layout.xaxis.title.text == "speed of all recordings, in place of their own (km/h)"


def test_margins_are_marked_by_who_is_in_time_and_never_stands_at_the_edge():
    result = met((range(10, 40), range(5, 40)), (ALL, LATE), (NEVER, ALL), (NEVER, LATE))
    figure = margins_plot(result, urgent_encounters(result), theme="light")
    both = trace(figure, "both in time (1)")
    assert (both.x.round(6).tolist(), both.y.round(6).tolist()) == ([1.7], [2.2])
    diagonal = trace(figure, "X as early as Y")  # past the mark in its corner
    assert diagonal.showlegend is None
    assert diagonal.x[1] == diagonal.y[1] >= 2.2
    only_x = trace(figure, "only X in time (1)")
    assert only_x.customdata.tolist() == [[40 + LAST_CHANCE, 1]]
    assert (only_x.marker.color, only_x.marker.symbol) == (LOOK["light"].x, "circle")
    only_y, neither = trace(figure, "only Y in time (1)"), trace(figure, "neither in time (1)")
    assert only_y.x[0] == neither.x[0] == figure.layout.xaxis.tickvals[0] < -1
    assert figure.layout.xaxis.ticktext[0] == "never"
    assert "both in time 1, only X in time 1, only Y in time 1, neither in time 1" in words(figure)


def test_corners_and_edges_of_the_margins_hold_what_stands_there(monkeypatch):
    result = met((range(10, 40), range(36, 40)))
    urgent = urgent_encounters(result)
    figure = margins_plot(result, urgent, theme="light")
    assert "never" not in figure.layout.xaxis.ticktext
    assert "stand at the edge" not in words(figure)
    corners = {note.text for note in figure.layout.annotations}
    assert corners == {"both in time", "only Y in time", "neither in time"}  # no mark is there
    monkeypatch.setattr(figures, "MOST_MARGIN_S", 1.5)
    figure = margins_plot(result, urgent, theme="light")
    assert trace(figure, "only X in time (1)").x.tolist() == [1.5]
    assert "margins of more than 1.5 s stand at the edge" in words(figure)


def test_of_very_many_encounters_the_fastest_impacts_are_drawn(three, monkeypatch):
    monkeypatch.setattr(figures, "MOST_MARKS", 1)
    figure = margins_plot(three, urgent_encounters(three), theme="light")
    (drawn,) = (part for part in figure.data if part.mode == "markers")
    assert (drawn.name, drawn.customdata.tolist()) == ("only X in time (2)", [[69, 1]])
    assert "both in time 1" in words(figure)
    assert "the 1 with the fastest impacts drawn" in words(figure)


def test_the_lanes_have_the_last_chance_and_above_them_the_time_to_contact(late):
    figure = lanes_figure(late, 0, theme="light", chosen=0)
    chance = trace(figure, "last chance to stop")
    assert chance.x.tolist() == pytest.approx([2.9])
    assert chance.customdata.tolist() == [[LAST_CHANCE, 0]]
    assert "Y confirms the pedestrian late, 0.30 s after the last chance" in chance.text[0]
    contact = trace(figure, "time to contact")
    assert contact.y[[0, 30]].round(6).tolist() == [5.0, 2.0]
    assert contact.yaxis == "y2"
    assert trace(figure, "2.2 s needed to stop").showlegend is None
    assert "above them the least time to contact, up to 6 s" in words(figure)
    points = trace(figure, "contact")
    assert points.customdata[30].tolist() == [30, 0]
    assert points.text[30] == "pedestrian 1, frame 30, 3.00 s<br>2.00 s to contact, the least"
    assert trace(figure, "frames").text[30].endswith("Y: matched<br>2.0 s to contact")
    lanes, strip = figure.layout.yaxis.domain, figure.layout.yaxis2.domain
    assert lanes[0] == 0 < lanes[1] < strip[0] < strip[1] == 1
    assert figure.layout.xaxis.anchor == "y2"


def test_the_strip_above_the_lanes_reaches_as_far_as_the_car_needs_to_stop():
    result = met((range(10, 40), LATE), deceleration=1.0)
    figure = lanes_figure(result, 0, theme="light")
    assert figure.layout.yaxis2.range == (0, 10)
    assert trace(figure, "8.1 s needed to stop").showlegend is None


def test_where_nobody_is_approached_there_are_lanes_alone(still):
    figure = lanes_figure(still, 0, theme="light")
    assert "yaxis2" not in figure.layout.to_plotly_json()
    assert {"time to contact", "last chance to stop"}.isdisjoint(part.name for part in figure.data)
