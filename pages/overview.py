"""Overview: the verdict, the scorecard, who detects whom, and the moments that matter."""

import streamlit as st

from nvcore.comparison import Result
from nvcore.report.equal_alarms import equal_alarms_of
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
        known = companions.known_companions(result)
        scorecard.scorecard(result, known)
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
    if known is None and equal_alarms_of(result, of_both) is not None:
        st.rerun()  # the scorecard, which is above, shows it
    plan.draw(result, table, of_both)
    with verdict:
        more = plan.known_sentence(result)
        scorecard.verdict_box(result, state.findings(), table, of_both, more)


st.title("Overview")
draw()
