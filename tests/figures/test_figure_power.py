"""The power of a planned study over its number of recordings."""

from __future__ import annotations

from builders import result_of
from drives import quiet_drives

from nvcore.arguments.plan import PlanArguments
from nvcore.evidence.planning import plan_recordings
from nvcore.figures.dots import power_plot


def test_each_assumption_has_its_line_with_the_interval_of_the_simulation():
    plan = plan_recordings(
        result_of(quiet_drives(12)), PlanArguments("encounters_detected", difference=0.1)
    )
    figure = power_plot(plan, theme="light")
    named, as_found = figure.data
    assert list(named.x) == [point.n_recordings for point in plan.sizes[0].points]
    assert list(named.y) == [point.power for point in plan.sizes[0].points]
    assert named.name.replace("\xa0", " ") == "difference as named (+10.0 pp)"
    assert (named.line.dash, as_found.line.dash) == ("solid", "dash")
    top = plan.sizes[0].points[0]
    assert named.error_y.array[0] == top.high - top.power
    assert figure.layout.shapes[0].y0 == 0.8


def test_without_a_size_there_is_a_sentence():
    figure = power_plot(plan_recordings(result_of(quiet_drives(4))), theme="dark")
    assert not figure.data
    assert figure.layout.annotations[0].text == "No study was simulated."
