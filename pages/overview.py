"""Overview: the verdict, the scorecard, who detects whom, and the moments that matter."""

import streamlit as st

from nvcore.comparison import Result
from ui.jobs import companions
from ui.overview import evidence, moments, plan, scorecard, strip, venn, verdict
from ui.session.results.evidence import known_evidence, measure_evidence
from ui.session.results.findings import input_findings, known_findings
from ui.shell.messages import draw_operating_point, needs_comparison


@needs_comparison
def draw(result: Result) -> None:
    """The verdict, then what it rests on."""
    draw_operating_point(result)
    room = verdict.Room(result)
    before, known = known_evidence(result), companions.known_companions(result)
    findings = known_findings()
    is_drawn = False
    if before is not None and known is not None and findings is not None:
        room.draw(findings, before, known, plan.known_plan(result))
        is_drawn = True
    if not is_drawn:  # the words come last: they wait for the audit
        room.draw_known(before)
    left, right = st.columns([1.15, 1], gap="large")
    with left:
        table = scorecard.scorecard(result, before)
    with right:
        venn.draw(result)
    strip.draw(result)
    moments.draw(result)
    scorecard.by_recording(result)
    moments.worst_windows(result)
    measured = measure_evidence(result)
    if before is None:
        table.draw(measured)
    evidence.draw(result, measured)
    with room.headline:
        of_both = companions.wait_for_companions(result, measured)
    plan.draw(result, measured, of_both)
    if not is_drawn:
        room.draw(input_findings(), measured, of_both, plan.known_plan(result))


st.title("Overview")
draw()
