"""Time left: whether braking could still have helped when a system had found the pedestrian."""

import streamlit as st

from nvcore.comparison import Result
from nvcore.time_left.steps import time_left_in
from ui.session import state, store
from ui.shell.messages import draw_notices, needs_comparison
from ui.time_left import approaches, listed, numbers, speeds
from ui.time_left.listed import open_encounter
from ui.widgets.text import docs_link


@needs_comparison
def draw(result: Result) -> None:
    """The numbers, then the encounters behind them, and what the speed changes."""
    objects = result.dataset.objects
    if not objects.is_on_road:
        st.info(
            f"A car passes {objects.plural} and does not brake for them: no time is left to judge."
        )
        return
    if (opened := store.URGENT_ENCOUNTER.pop()) is not None:
        open_encounter(result, *opened)
    st.caption(
        state.say(
            "Could braking still have helped when a system had found the {one}? An encounter is "
            "{urgent} if the car comes so near that a warning is too late to stop. From the "
            "last chance on it is too late: the driver has to be warned before.",
            urgent=docs_link("urgent", "the-last-chance"),
        )
    )
    draw_notices(result)
    numbers.draw(result)
    if time_left_in(result).is_urgent.any():
        urgent = approaches.urgent_of(result)
        approaches.draw(result, urgent)
    speeds.draw(result)
    numbers.draw_by_class(result)
    if time_left_in(result).is_urgent.any():
        st.header("One by one")
        approaches.draw_margins(result, urgent)
        listed.draw(urgent)


st.title("Time left")
draw()
