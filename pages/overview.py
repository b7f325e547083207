"""Overview: the verdict, the scorecard, who detects whom, and the moments that matter."""

import streamlit as st

from nvcore.comparison import Result
from ui.overview import companions, evidence, moments, plan, scorecard, strip, venn
from ui.session import state
from ui.session.evidence import measure_evidence
from ui.shell.messages import needs_comparison


@needs_comparison
def draw(result: Result) -> None:
    """The verdict, then what it rests on."""
    verdict = st.container()  # filled last: it waits for the audit
    left, right = st.columns([1.15, 1], gap="large")
    with left:
        scorecard.scorecard(result)
    with right:
        venn.draw(result)
    strip.draw(result)
    moments.draw(result)
    scorecard.by_recording(result)
    moments.worst_windows(result)
    table = measure_evidence(result)
    evidence.draw(result, table)
    with verdict:
        of_both = companions.wait_for_companions(result, table)
    plan.draw(result, table, of_both)
    with verdict:
        more = plan.known_sentence(result)
        scorecard.verdict_box(result, state.findings(), table, of_both, more)


st.title("Overview")
draw()
