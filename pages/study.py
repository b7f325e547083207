"""Study page: ask people, picture by picture, whether they would have seen a pedestrian."""

import streamlit as st

from ui.subjects.driver.study.touch_studies import TOUCH
from ui.subjects.people import conduct, participant
from ui.subjects.people.studies import is_participant
from ui.widgets.text import docs_link

if is_participant():
    participant.draw(TOUCH)
else:
    st.title("Study")
    st.caption(
        "How soon after the light has changed do people find a pedestrian in a picture? The "
        "answers train the estimate of what a driver would have seen "
        f"({docs_link('Study', 'study', doc='study')})."
    )
    conduct.draw(TOUCH)
