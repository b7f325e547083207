"""The pages Driver and Study, and what they add to the dashboard."""

from typing import Final

from nvcore.driver.comparison.settings import DRIVER
from nvcore.stages import ENCOUNTERS, SEVERITY
from nvcore.time_left.settings import TIME_LEFT
from ui.subjects import Document, Page

PAGES: Final = (
    Page(
        "driver",
        "Driver",
        "Compare",
        after="time_left",
        shown=(ENCOUNTERS, SEVERITY, TIME_LEFT, DRIVER),
        own=(DRIVER,),
    ),
    Page("study", "Study", "Evidence", after="ratings", shown=()),
)
DOCUMENTS: Final = (
    Document("driver", "The driver", after="formats"),
    Document("study", "Study", after="ratings"),
)
ASIDE: Final = "finished:ASIDE"
ROUTES: Final = "study.routes:ROUTES"
STUDIES: Final = "study.files:STUDIES"
ENCOUNTER_HEAD: Final = "encounter:draw_head"
ENCOUNTER_FILTER: Final = "encounter:FILTER"
ENCOUNTER_COLUMNS: Final = "encounter:COLUMNS"
COLUMN_LOOKS: Final = "encounter:LOOKS"
