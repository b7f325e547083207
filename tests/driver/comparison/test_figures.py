"""Figures of the driver in the comparison: who sees whom, and detectability over time."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from nvcore.driver.comparison.figures import (
    detectability_course_plot,
    driver_threshold_plot,
    driver_venn_plot,
)
from nvcore.driver.comparison.judging import DriverVenn
from nvcore.driver.comparison.kinds import DriverRegion
from nvcore.driver.illumination import Light, LightSource
from nvcore.driver.illumination.clock import adaptation_clock, unknown_clock, with_change
from nvcore.figures.style import LOOK
from nvcore.objects import PEDESTRIAN

COURSE = pd.DataFrame(
    {
        "row": [10, 11, 12],
        "time_s": [0.5, 0.55, 0.6],
        "detectability": [0.1, np.nan, 0.95],
        "sd": [0.2, np.nan, 0.2],
        "is_outside": [False, False, False],
        "is_up_to_relevant": [True, True, False],
    }
)


def venn(**counts: int) -> DriverVenn:
    return DriverVenn({region: counts.get(region.value, 0) for region in DriverRegion})


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_each_of_the_eight_regions_has_its_count_and_can_be_clicked(theme):
    figure = driver_venn_plot(
        venn(driver_x_y=3, y=12, unknown=2), ("A", "<B>"), theme=theme, objects=PEDESTRIAN
    )
    (points,) = figure.data
    assert len(points.customdata) == 8
    at = dict(zip(points.customdata, zip(points.x, points.y, strict=True), strict=True))
    texts = {(note.x, note.y): note.text for note in figure.layout.annotations}
    assert texts[at["y"]] == "<b>12</b>"
    assert texts[at["driver_x_y"]] == "<b>3</b>"
    assert texts[at["nobody"]] == "<b>0</b>"
    assert "Y &lt;B&gt;" in texts.values()
    assert (
        "15 near encounters of which it is known; not drawn: 2 unknown, 0"
        in figure.layout.title.text
    )


def test_where_nothing_is_known_the_diagram_says_so():
    figure = driver_venn_plot(venn(unknown=4), ("A", "B"), theme="light", objects=PEDESTRIAN)
    assert not figure.data
    assert "not known" in figure.layout.annotations[0].text


def test_a_course_marks_known_frames_and_its_band_ends_at_0_and_1():
    figure = detectability_course_plot(COURSE, threshold=0.5, theme="light", objects=PEDESTRIAN)
    band, before, later, outside = figure.data
    shares = [share for share in band.y if share is not None]
    assert (min(shares), max(shares)) == (0, 1)
    assert (list(before.customdata), list(later.customdata)) == ([10], [12])
    assert "2 frames in which it is known, of 3" in figure.layout.title.text
    assert figure.layout.shapes[0].y0 == 0.5
    assert not len(outside.x)
    assert not outside.showlegend


def test_a_course_marks_frames_outside_the_range_of_the_training_below_zero():
    course = COURSE.assign(is_outside=[False, True, True])  # of the second nothing is known
    outside = detectability_course_plot(
        course, threshold=0.5, theme="light", objects=PEDESTRIAN
    ).data[3]
    assert list(outside.x) == [0.6]
    assert outside.y[0] < 0
    assert outside.hoverinfo == "skip"


def test_a_course_of_which_nothing_is_known_says_so():
    unknown = COURSE.assign(detectability=np.nan)
    figure = detectability_course_plot(unknown, threshold=0.5, theme="light", objects=PEDESTRIAN)
    assert "not known how detectable" in figure.layout.annotations[0].text.replace("<br>", " ")


@pytest.mark.parametrize("source", LightSource)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_light_and_clock_stand_below_the_course_with_changes_marked(theme, source):
    times = np.arange(-50, 20) / 10
    light = Light(times, np.where(times < 0.4, 0.9, 0.002), source)
    clock = with_change(adaptation_clock(light, np.arange(20), 10), 10, 0.6)
    simulated = pd.DataFrame(
        {"detectability": [0.1, 0.3, 0.4], "is_simulated": [False, False, True]}
    )
    figure = detectability_course_plot(
        COURSE, threshold=0.5, theme=theme, clock=clock, simulated=simulated, objects=PEDESTRIAN
    )
    would = next(trace for trace in figure.data if trace.name == "simulated")
    assert (list(would.customdata), list(would.y)) == ([12], [0.4])
    assert {trace.yaxis for trace in figure.data} == {None, "y2", "y3"}
    dotted = [shape.x0 for shape in figure.layout.shapes if shape.line.dash == "dot"]
    assert 0.6 in dotted
    assert any("simulated" in str(text.text) for text in figure.layout.annotations)
    is_meter = source is LightSource.METER
    assert ("by the light meter" in figure.layout.title.text) == is_meter
    assert ("a stand-in" in figure.layout.title.text) != is_meter
    assert len(dotted) == len(clock.change_s)


def test_where_nothing_is_known_of_the_light_a_simulated_change_is_drawn_all_the_same():
    clock = with_change(unknown_clock(np.arange(20), 10), 10, 0.55)
    figure = detectability_course_plot(
        COURSE, threshold=0.5, theme="light", clock=clock, objects=PEDESTRIAN
    )
    assert "nothing is known of the light" in figure.layout.title.text
    assert 0.55 in [shape.x0 for shape in figure.layout.shapes]


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
    band = detectability_course_plot(course, threshold=0.5, theme="light", objects=PEDESTRIAN).data[
        0
    ]
    assert list(band.x) == [0.0, 0.1, 0.1, 0.0, None, 0.3, 0.3, None, 0.5, 0.5, None]
    assert [None if y is None else round(y, 6) for y in band.y[5:]] == [
        *(0.7, 0.3, None),
        *(0.7, 0.3, None),
    ]
    unknown = course.assign(sd=np.nan)
    band = detectability_course_plot(
        unknown, threshold=0.5, theme="light", objects=PEDESTRIAN
    ).data[0]
    assert not band.x
    assert not band.showlegend


def test_the_axis_of_adaptation_ends_at_ten_seconds_and_no_light_lies_at_its_bottom():
    times = np.arange(-50, 1000) / 10
    level = np.where(times < 0.4, 900.0, 0.0)
    frames = np.arange(1000)
    clock = adaptation_clock(Light(times, level), frames, 10)
    course = COURSE.assign(time_s=[60.0, 60.1, 60.2])
    figure = detectability_course_plot(
        course, threshold=0.5, theme="light", clock=clock, objects=PEDESTRIAN
    )
    assert figure.layout.yaxis3.range == (0, 10)
    (light,) = (trace for trace in figure.data if trace.name == "light")
    assert np.nanmin(np.array(light.y, float)) == 10.0 ** figure.layout.yaxis2.range[0]
    early = detectability_course_plot(
        COURSE, threshold=0.5, theme="light", clock=clock, objects=PEDESTRIAN
    )
    assert early.layout.yaxis3.range == (0, 5)


def test_a_simulated_observer_is_named_where_the_numbers_stand():
    figure = detectability_course_plot(
        COURSE,
        threshold=0.5,
        theme="light",
        caution="learnt from simulated subjects",
        objects=PEDESTRIAN,
    )
    assert "learnt from simulated subjects" in figure.layout.title.text


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


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_over_the_threshold_each_count_is_a_line_that_is_told_without_its_colour(theme):
    figure = driver_threshold_plot(
        COUNTS, ("A", "<B>"), threshold=0.5, theme=theme, objects=PEDESTRIAN
    )
    assert [list(line.y) for line in figure.data] == [[5, 4, 3], [2, 3, 4], [1, 1, 2], [1, 2, 2]]
    assert [line.name for line in figure.data] == [
        "the driver sees",
        "useful alerts of X: A",
        "useful alerts of Y: &lt;B&gt;",
        "unprotected by both",
    ]
    assert len({line.line.dash for line in figure.data}) == 4
    symbols = [line.marker.symbol for line in figure.data]
    assert not {symbols[0], symbols[3]} & {symbols[1], symbols[2]}
    x, y = (figure.data[row].line for row in (1, 2))
    assert (x.color, y.color) == (LOOK[theme].x, LOOK[theme].y)
    assert (x.dash, y.dash) == (LOOK[theme].dash("x"), LOOK[theme].dash("y"))
    assert "9 near encounters of which it is known" in figure.layout.title.text
    assert figure.layout.yaxis.title.text == "encounters"


@pytest.mark.parametrize(("threshold", "side"), [(0.62, "left"), (0.9, "right")])
def test_the_threshold_that_is_set_is_marked_wherever_it_is(threshold, side):
    figure = driver_threshold_plot(
        COUNTS, ("A", "B"), threshold=threshold, theme="light", objects=PEDESTRIAN
    )
    assert [line.x0 for line in figure.layout.shapes] == [threshold]
    (text,) = figure.layout.annotations
    assert (text.text, text.xanchor) == (f"now {threshold:g}", side)


def test_over_the_threshold_of_nobody_known_a_sentence_stands():
    figure = driver_threshold_plot(
        COUNTS.iloc[:0], ("A", "B"), threshold=0.5, theme="light", objects=PEDESTRIAN
    )
    assert not figure.data
    assert "Of no encounter is it known" in figure.layout.annotations[0].text.replace("<br>", " ")
