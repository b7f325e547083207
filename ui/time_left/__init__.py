"""The page Time left, and what it adds to the dashboard."""

from typing import Final

from nvcore.time_left.settings import CONFIRMED, CONTACT, TIME_LEFT, URGENCY
from ui.subjects import Page

PAGES: Final = (
    Page(
        "time_left",
        "Time left",
        "Compare",
        after="encounters",
        shown=(TIME_LEFT,),
        own=(URGENCY, CONTACT, CONFIRMED),
    ),
)
ENCOUNTER_TEXT: Final = "encounter:draw_text"
ENCOUNTER_WAYS: Final = "encounter:draw_ways"
COLUMN_LOOKS: Final = "looks:LOOKS"
