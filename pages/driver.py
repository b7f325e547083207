"""Driver: whom the driver sees by himself, and who warns him of the others."""

import streamlit as st

from nvcore.comparison import Result
from nvcore.driver.comparison.said import counts, no_claim, view_facts
from nvcore.driver.comparison.steps import driver_in
from ui.driver import course, listed, missing, regions, run, threshold
from ui.session import state
from ui.shell.messages import draw_operating_point, draw_warnings, needs_comparison
from ui.widgets.text import docs_link, plain


@needs_comparison
def draw(result: Result) -> None:
    """Who sees whom, then the encounters behind it; without detectability, how to get it."""
    st.caption(
        state.say(
            "A warning is worth most where the driver does not see the {one} himself. "
            "{detectability} is the share of drivers who would see the {one}: 0 none, 1 all.",
            detectability=docs_link("Detectability", "whom-he-sees", doc="driver"),
        )
    )
    run.draw_notes()
    if not driver_in(result).has_any:
        missing.draw()
        run.draw(is_known=False)
        missing.draw_commands()
        return
    run.draw(is_known=True)
    draw_warnings(result)
    draw_operating_point(result)
    for doubt in no_claim(result):
        st.warning(plain(state.say(doubt)), icon=":material/warning:")
    st.markdown("\n\n".join(plain(state.say(fact)) for fact in view_facts(result)))
    st.caption(state.say(counts(result)))
    region = regions.draw(result)
    threshold.draw(result)
    encounter = listed.draw(result, region)
    if encounter is not None:
        course.draw(result, encounter)


st.title("Driver")
draw()
