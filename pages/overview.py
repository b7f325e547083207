"""Overview: the verdict, the scorecard, who detects whom, and the moments that matter."""

import streamlit as st

from ui import overview_evidence, overview_moments, overview_scorecard, overview_venn, state
from ui.empty import one_system_only
from ui.evidence import evidence

st.title("Overview")
result = state.result()
if result is None:
    one_system_only()
else:
    verdict = st.container()  # filled last: it waits for the audit
    left, right = st.columns([1.15, 1], gap="large")
    with left:
        overview_scorecard.scorecard(result)
    with right:
        overview_venn.draw(result)
    overview_moments.draw(result)
    overview_scorecard.by_recording(result)
    found = evidence()
    overview_evidence.draw(result, found)
    with verdict:
        overview_scorecard.verdict_box(result, state.findings(), found)
