"""Figures of the driver in the comparison: who sees whom, and detectability over time."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import pytest
from figure_parts import trace, words

from nvcore.figures.style import LOOK
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.driver.comparison import figures
from nvcore.subjects.driver.comparison.judging import DriverRegion
from nvcore.subjects.driver.illumination import Light, LightSource
from nvcore.subjects.driver.illumination.clock import adaptation_clock, with_change

OUTSIDE = "estimated outside the range of the training"
COURSE = pd.DataFrame(
    {
        "row": [10, 11, 12],
        "time_s": [0.5, 0.55, 0.6],
        "detectability": [0.1, np.nan, 0.95],
        "sd": [0.2, np.nan, 0.2],
        "is_outside": [False, True, True],
        "is_up_to_relevant": [True, True, False],
    }
)
COUNTS = pd.DataFrame(
    {
        "driver_threshold": [0.45, 0.5, 0.55],
        "known": 9,
        "seen": [5, 4, 3],
        "useful_x": [2, 3, 4],
        "useful_y": [1, 1, 2],
        "nobody": [1, 2, 2],
    }
)
plot_course = partial(
    figures.detectability_course_plot, threshold=0.5, theme="light", objects=PEDESTRIAN
)
plot_counts = partial(
    figures.driver_threshold_plot, names=("A", "<B>"), theme="light", objects=PEDESTRIAN
)


def plot_venn(**counts: int):
    venn = {region: counts.get(region.value, 0) for region in DriverRegion}
    return figures.driver_venn_plot(venn, ("A", "<B>"), theme="dark", objects=PEDESTRIAN)


def test_each_of_the_eight_regions_has_its_count_and_can_be_clicked():
    figure = plot_venn(driver_x_y=3, y=12, unknown=2)
    (points,) = figure.data
    assert len(points.customdata) == 8
    at = dict(zip(points.customdata, zip(points.x, points.y, strict=True), strict=True))
    texts = {(note.x, note.y): note.text for note in figure.layout.annotations}
    assert [texts[at[region]] for region in ("y", "driver_x_y", "nobody")] == [
        f"<b>{n}</b>" for n in (12, 3, 0)
    ]
    assert "Y &lt;B&gt;" in texts.values()
    told = "15 near encounters of which it is known; not drawn: 2 unknown, 0"
    assert told in figure.layout.title.text


def test_where_nothing_is_known_the_figures_say_so():
    unknown = COURSE.assign(detectability=np.nan)
    for figure, told in (
        (plot_venn(unknown=4), "not known"),
        (plot_course(unknown), "not known how detectable"),
        (plot_counts(COUNTS.iloc[:0], threshold=0.5), "Of no encounter is it known"),
    ):
        assert not figure.data
        assert told in words(figure)


def test_a_course_marks_known_frames_and_its_band_ends_at_0_and_1():
    figure = plot_course(COURSE, caution="learnt from simulated subjects")
    band, before, later, outside = figure.data
    shares = [share for share in band.y if share is not None]
    assert (min(shares), max(shares)) == (0, 1)
    assert (list(before.customdata), list(later.customdata)) == ([10], [12])
    told = "2 frames in which it is known, of 3; learnt from simulated subjects"
    assert told in figure.layout.title.text
    assert figure.layout.shapes[0].y0 == 0.5
    # outside the range of the training: below zero, if it is known
    assert (outside.name, list(outside.x), outside.hoverinfo) == (OUTSIDE, [0.6], "skip")
    assert outside.y[0] < 0
    inside = trace(plot_course(COURSE.assign(is_outside=False)), OUTSIDE)
    assert not len(inside.x)
    assert not inside.showlegend


def test_the_band_is_drawn_only_where_the_deviation_is_known():
    course = pd.DataFrame(
        {
            "row": [10, 11, 12, 13, 15],
            "time_s": [0.0, 0.1, 0.2, 0.3, 0.5],
            "detectability": 0.5,
            "sd": [0.1, 0.1, np.nan, 0.2, 0.2],
            "is_outside": False,
            "is_up_to_relevant": True,
        }
    )
    band = plot_course(course).data[0]
    assert list(band.x) == [0.0, 0.1, 0.1, 0.0, None, 0.3, 0.3, None, 0.5, 0.5, None]
    ends = [None if y is None else round(y, 6) for y in band.y[5:]]
    assert ends == [0.7, 0.3, None, 0.7, 0.3, None]
    band = plot_course(course.assign(sd=np.nan)).data[0]
    assert not band.x
    assert not band.showlegend


@pytest.mark.parametrize(
    ("source", "told", "colour"),
    [
        (LightSource.METER, "; light by the light meter", "light"),
        (LightSource.PICTURE, "; light by the pictures' mean luminance, a stand-in", "dark"),
    ],
)
def test_light_and_clock_stand_below_the_course_with_changes_marked(source, told, colour):
    times = np.arange(-50, 20) / 10
    light = Light(times, np.where(times < 0.4, 0.9, 0.002), source)
    clock = with_change(adaptation_clock(light, np.arange(20), 10), 10, 0.6)
    simulated = pd.DataFrame(
        {"detectability": [0.1, 0.3, 0.4], "is_simulated": [False, False, True]}
    )
    figure = plot_course(COURSE, theme=colour, clock=clock, simulated=simulated)
    would = trace(figure, "simulated")
    assert (list(would.customdata), list(would.y)) == ([12], [0.4])
    assert {part.yaxis for part in figure.data} == {None, "y2", "y3"}
    dotted = [shape.x0 for shape in figure.layout.shapes if shape.line.dash == "dot"]
    assert 0.6 in dotted
    assert len(dotted) == len(clock.change_s)
    assert "simulated: dark" in words(figure)
    assert told in figure.layout.title.text


def test_where_nothing_is_known_of_the_light_a_simulated_change_is_drawn_all_the_same():
    clock = with_change(adaptation_clock(None, np.arange(20), 10), 10, 0.55)
    figure = plot_course(COURSE, clock=clock)
    assert "nothing is known of the light" in figure.layout.title.text
    assert 0.55 in [shape.x0 for shape in figure.layout.shapes]


def test_the_axis_of_adaptation_ends_at_ten_seconds_and_no_light_lies_at_its_bottom():
    times = np.arange(-50, 1000) / 10
    level = np.where(times < 0.4, 900.0, 0.0)
    clock = adaptation_clock(Light(times, level), np.arange(1000), 10)
    figure = plot_course(COURSE.assign(time_s=[60.0, 60.1, 60.2]), clock=clock)
    assert figure.layout.yaxis3.range == (0, 10)
    light = trace(figure, "light")
    assert np.nanmin(np.array(light.y, float)) == 10.0 ** figure.layout.yaxis2.range[0]
    assert plot_course(COURSE, clock=clock).layout.yaxis3.range == (0, 5)


@pytest.mark.parametrize(("threshold", "side"), [(0.62, "left"), (0.9, "right")])
def test_over_the_threshold_each_count_is_a_line_that_is_told_without_its_colour(threshold, side):
    figure = plot_counts(COUNTS, threshold=threshold)
    assert [list(line.y) for line in figure.data] == [[5, 4, 3], [2, 3, 4], [1, 1, 2], [1, 2, 2]]
    assert [line.name for line in figure.data] == [
        "the driver sees",
        "useful alerts of X: A",
        "useful alerts of Y: &lt;B&gt;",
        "unprotected by both",
    ]
    assert figure.data[1].text[0] == "threshold 0.45<br>useful alerts of X: A: 2 encounters"
    assert len({line.line.dash for line in figure.data}) == 4
    symbols = [line.marker.symbol for line in figure.data]
    assert not {symbols[0], symbols[3]} & {symbols[1], symbols[2]}
    for letter, drawn in zip("xy", figure.data[1:3], strict=True):
        look = LOOK["light"]
        assert (drawn.line.color, drawn.line.dash) == (look.of(letter), look.dash(letter))
    assert "9 near encounters of which it is known" in figure.layout.title.text
    assert figure.layout.yaxis.title.text == "encounters"
    assert [line.x0 for line in figure.layout.shapes] == [threshold]
    (text,) = figure.layout.annotations
    assert (text.text, text.xanchor) == (f"now {threshold:g}", side)
