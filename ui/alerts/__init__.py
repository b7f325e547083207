"""The page Alerts, and what it adds to the dashboard."""

from typing import Final

from nvcore.alerts.settings import ALERTS
from ui.subjects import ColumnLook, Document, Page

PAGES: Final = (
    Page(
        "alerts",
        "Alerts",
        "Compare",
        after="time_left",
        shown=(ALERTS,),
        own=(ALERTS,),
        asks="Which alerts would reach the driver?",
    ),
)
DOCUMENTS: Final = (Document("alerts", "Alerts", after="time_left"),)
COLUMN_LOOKS: Final = {
    "lead_s": ColumnLook("lead (s)", "+.2f"),
    "encounter": ColumnLook("{One}"),
}
