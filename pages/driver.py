"""Driver: whom the driver sees by himself, and who warns him of the others."""

import streamlit as st

from nvcore.comparison import Result
from nvcore.report.verdict.driver import describe_doubt, describe_driver
from ui.driver import course, listed, missing, regions, run
from ui.driver.counts import describe_counts
from ui.session import state
from ui.shell.messages import draw_as_set_note, draw_warnings, needs_comparison
from ui.widgets.text import docs_link, plain


@needs_comparison
def draw(result: Result) -> None:
    """Who sees whom, then the encounters behind it; without detectability, how to get it."""
    st.caption(
        state.words(
            "A warning is worth most where the driver does not see the pedestrian himself. "
            f"{docs_link('Detectability', 'whom-he-sees', doc='driver')} is the share of drivers "
            "who would see him: 0 nobody, 1 everybody."
        )
    )
    run.draw_notes()
    if not result.driver.has_any:
        missing.draw()
        run.draw(is_known=False)
        missing.draw_commands()
        return
    run.draw(is_known=True)
    draw_warnings(result)
    draw_as_set_note(result)
    sentences = describe_driver(result)
    if doubt := describe_doubt(result):  # the first of them
        st.warning(plain(doubt), icon=":material/warning:")
        sentences = sentences[1:]
    st.markdown("\n\n".join(map(plain, sentences)))
    st.caption(state.words(describe_counts(result)))
    region = regions.draw(result)
    encounter = listed.draw(result, region)
    if encounter is not None:
        course.draw(result, encounter)


st.title("Driver")
draw()
