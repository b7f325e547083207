"""Time left page: whether braking still helps when a system has confirmed a pedestrian."""

from typing import Final

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.time_left.steps import time_left_in
from ui.session import state, store
from ui.shell.messages import draw_notices, needs_comparison
from ui.subjects.time_left import approaches, listed, numbers, speeds
from ui.subjects.time_left.listed import open_encounter
from ui.widgets.choices import look_closer
from ui.widgets.text import docs_link

MEANING: Final = (
    "Could braking still have helped when a system had found the {one}? An encounter is {urgent} "
    "if the car comes so near that a warning is too late to stop. From the last chance on it is "
    "too late: the driver has to be warned before."
)


@needs_comparison
def draw(result: Result) -> None:
    """Draw numbers and urgent encounters, then one further section at a time."""
    objects = result.dataset.objects
    if not objects.is_on_road:
        st.info(
            f"A car passes {objects.plural} and does not brake for them: no time is left to judge."
        )
        return
    if (opened := store.URGENT_ENCOUNTER.pop()) is not None:
        open_encounter(result, *opened)
    draw_notices(result)
    numbers.draw(result)
    has_urgent = time_left_in(result).is_urgent.any()
    if has_urgent:
        approaches.draw(result, approaches.urgent_of(result))
    parts = {"speeds": "If the car were slower or faster"}
    if has_urgent:
        parts |= {"classes": state.say("By class of {one}"), "encounters": "One by one"}
    match look_closer(parts, store.TIME_LEFT_PART):
        case "speeds":
            speeds.draw(result)
        case "classes":
            numbers.draw_by_class(result)
        case "encounters":
            urgent = approaches.urgent_of(result)
            approaches.draw_margins(result, urgent)
            listed.draw(urgent)


def explain() -> str | None:
    """Return the page's help text, or None if there is no comparison."""
    if state.result() is None:
        return None
    return state.say(MEANING, urgent=docs_link("urgent", "the-last-chance"))


st.title("Time left", help=explain())
draw()
