"""Driver page: whom the driver sees unaided, and which system warns of the others."""

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.driver.comparison.notes import counts, no_claim, view_notes
from nvcore.subjects.driver.comparison.steps import driver_in
from ui.session import state
from ui.shell.messages import draw_notices, needs_comparison
from ui.subjects.driver import course, listed, regions, run
from ui.widgets.text import docs_link, plain


@needs_comparison
def draw(result: Result) -> None:
    """Draw who sees whom and the encounters behind it, or how to obtain detectability."""
    st.caption(
        state.say(
            "A warning is worth most where the driver does not see the {one} unaided. "
            "{detectability} is the share of drivers who would see the {one}: 0 none, 1 all.",
            detectability=docs_link("Detectability", "whom-the-driver-sees", doc="driver"),
        )
    )
    if not driver_in(result).has_any:
        run.draw_notes()
        run.draw_missing()
        run.draw(is_known=False)
        run.draw_commands()
        return
    draw_notices(result)
    for doubt in no_claim(result):
        st.warning(plain(state.say(doubt)), icon=":material/warning:")
    first, *others = view_notes(result)
    st.markdown(plain(state.say(first)))
    region = regions.draw(result)
    with st.expander("What this rests on"):
        st.markdown("\n".join(f"- {plain(state.say(note))}" for note in others))
        st.caption(state.say(counts(result)))
    run.draw_notes()
    run.draw(is_known=True)
    regions.draw_over_threshold(result)
    encounter = listed.draw(result, region)
    if encounter is not None:
        course.draw(result, encounter)


st.title("Driver")
draw()
