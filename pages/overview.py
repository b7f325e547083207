"""Overview: the verdict, the scorecard, who detects whom, and the moments that matter."""

import streamlit as st

from ui.overview import evidence, moments, scorecard, venn
from ui.session import state
from ui.session.evidence import measure_evidence
from ui.shell.messages import one_system_only

st.title("Overview")
result = state.result()
if result is None:
    one_system_only()
else:
    verdict = st.container()  # filled last: it waits for the audit
    left, right = st.columns([1.15, 1], gap="large")
    with left:
        scorecard.scorecard(result)
    with right:
        venn.draw(result)
    moments.draw(result)
    scorecard.by_recording(result)
    found = measure_evidence()
    evidence.draw(result, found)
    with verdict:
        scorecard.verdict_box(result, state.findings(), found)
