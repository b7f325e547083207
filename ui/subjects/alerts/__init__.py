"""The Alerts page, and additions to the rest of the dashboard."""

from typing import ClassVar

from nvcore.subjects.alerts.figures import alerts_over_time
from nvcore.subjects.alerts.settings import ALERTS, IN_TIME, SPEEDING
from nvcore.subjects.alerts.steps import alerts_in
from ui import subject
from ui.subjects.alerts.policy import find_idle


class AlertsPages(subject.SubjectPages):
    pages = (
        subject.Page(
            "alerts",
            "Alerts",
            "Compare",
            after="time_left",
            shown=(ALERTS, IN_TIME, SPEEDING),
            own=(ALERTS, IN_TIME, SPEEDING),
            controls=("alerts",),
            idle=find_idle,
            asks="Which alerts would reach the driver?",
        ),
    )
    documents = (subject.Document("alerts", "Alerts", after="time_left"),)
    timeline_plots = (
        subject.TimelinePlot(
            "alerts_over_time", lambda result: alerts_in(result).is_asked, alerts_over_time
        ),
    )
    column_looks: ClassVar = {
        "lead_s": subject.ColumnLook("lead (s)", "+.2f"),
        "encounter": subject.ColumnLook("{One}"),
    }
