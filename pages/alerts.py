"""Alerts page: which detections reach the driver, and which of the alerts were justified."""

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.steps import alerts_in
from ui.session import state
from ui.shell.messages import draw_notices, needs_comparison
from ui.subjects.alerts import in_time, listed, numbers, policy, speeding
from ui.widgets.text import docs_link


@needs_comparison
def draw(result: Result) -> None:
    """Draw the policy, its alerts in numbers and one by one, and whether the driver can react."""
    st.caption(
        state.say(
            "Which detections would reach the driver as alerts, and was each of them worth it? A "
            "policy makes alerts of detections, from what a system knows as it drives; the truth "
            "then says what each alert was: {kinds}.",
            kinds=docs_link(
                "needed, redundant, nuisance or false", "what-an-alert-was-worth", doc="alerts"
            ),
        )
    )
    draw_notices(result)
    speeding.draw(result)
    judged = policy.judged(result)
    policy.draw(judged, is_asked=alerts_in(result).is_asked)
    if not alerts_in(judged).is_asked:
        return
    numbers.draw(judged)
    listed.draw(judged)
    in_time.draw(judged)


st.title("Alerts")
draw()
