"""Ratings: whether people find annoying what saliency says is annoying."""

import streamlit as st

from ui.ratings import conduct, links, participant, results
from ui.session import state
from ui.shell.messages import one_system_only
from ui.widgets.text import docs_link

if links.is_participant():
    participant.draw()
elif (result := state.result()) is None:
    st.title("Ratings")
    participant.draw_waiting()
    one_system_only()
else:
    st.title("Ratings")
    st.caption(
        "People watch clips, each a recording with the boxes of one system, and rate how annoying "
        "it would be to drive with. Saliency claims to say the same without asking anybody; here "
        f"the two are compared ({docs_link('Ratings', 'ratings', doc='ratings')})."
    )
    participant.draw_waiting()
    if conduct.choose_part() == conduct.RESULTS:
        results.draw(result)
    else:
        conduct.draw(result)
