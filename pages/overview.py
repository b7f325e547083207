"""Overview page: the verdict, who detects whom, where to look first, and the scorecard."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.jobs import companions
from ui.session.results import input_findings, known_evidence, measure_evidence
from ui.shell.messages import draw_operating_point, needs_comparison
from ui.views.overview import more, plan, scorecard, strip, venn, verdict


@needs_comparison
def draw(result: Result) -> None:
    """Draw the verdict, then its basis."""
    draw_operating_point(result)
    room, before = verdict.VerdictBox(result), known_evidence(result)
    # otherwise the previous content stays until there is a newer one
    is_new = not room.holds_last()
    if is_new:
        room.draw_known(before)
    left, right = st.columns([1.5, 1], gap="large")
    with left:
        venn.draw(result)
    with right:
        venn.draw_worst(result)
    strip.draw(result)
    table = scorecard.Scorecard(result)
    if before is None and is_new:
        table.draw(None)
    measured = measure_evidence(result)
    table.draw(measured)
    with room.headline:
        of_both = companions.wait_for_companions(result, measured)
    room.draw(input_findings(), measured, of_both, plan.known_plan(result))
    more.draw(result, measured, of_both)


st.title("Overview")
draw()
