"""The Alerts page, and additions to the rest of the dashboard."""

from typing import Final

from nvcore.subjects.alerts.figures import alerts_over_time
from nvcore.subjects.alerts.settings import ALERTS, IN_TIME, SPEEDING
from nvcore.subjects.alerts.steps import alerts_in
from ui.subject import ColumnLook, Document, Page, TimelinePlot
from ui.subjects.alerts.policy import find_idle

PAGES: Final = (
    Page(
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
DOCUMENTS: Final = (Document("alerts", "Alerts", after="time_left"),)
TIMELINE_PLOTS: Final = (
    TimelinePlot("alerts_over_time", lambda result: alerts_in(result).is_asked, alerts_over_time),
)
COLUMN_LOOKS: Final = {
    "lead_s": ColumnLook("lead (s)", "+.2f"),
    "encounter": ColumnLook("{One}"),
}
