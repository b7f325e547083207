"""Ratings: whether people find annoying what saliency says is annoying."""

import streamlit as st

from ui import ratings_conduct, ratings_links, ratings_participant, ratings_results, state
from ui.empty import one_system_only
from ui.text import docs_link

if ratings_links.is_participant():
    ratings_participant.draw()
elif (result := state.result()) is None:
    st.title("Ratings")
    ratings_participant.draw_waiting()
    one_system_only()
else:
    st.title("Ratings")
    st.caption(
        "People watch clips, each a recording with the boxes of one system, and rate how annoying "
        "it would be to drive with. Saliency claims to say the same without asking anybody; here "
        f"the two are compared ({docs_link('Ratings', 'ratings', doc='ratings')})."
    )
    ratings_participant.draw_waiting()
    if ratings_conduct.choose_part() == ratings_conduct.RESULTS:
        ratings_results.draw(result)
    else:
        ratings_conduct.draw(result)
