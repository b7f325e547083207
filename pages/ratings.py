"""Ratings page: whether people are annoyed by what saliency predicts."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.session.store import RATINGS_PART
from ui.shell.messages import needs_comparison
from ui.subjects.people import conduct, participant
from ui.subjects.people.studies import is_participant
from ui.subjects.ratings import groups, results, sessions
from ui.widgets.text import docs_link


@needs_comparison
def draw(result: Result) -> None:
    """Draw the results, or the current rating session."""
    objects = result.dataset.objects
    if not objects.is_on_road:
        st.info(
            "The ratings ask how annoying it is to drive with a system that draws boxes around "
            f"what is on the road: not asked of {objects.plural}."
        )
    elif RATINGS_PART.get() == "results":
        results.draw(result)
    else:
        conduct.draw(sessions.SESSIONS)


if is_participant():
    participant.draw(sessions.SESSIONS)
else:
    st.title("Ratings")
    st.caption(
        "People watch clips, each with the boxes of one system, and rate how annoying it would be "
        "to drive with. Saliency claims to say the same without asking anybody; here the two are "
        f"compared ({docs_link('Ratings', 'ratings', doc='ratings')})."
    )
    sessions.draw_waiting()
    if sessions.choose_part() == "groups":
        groups.draw()
    else:
        draw()
