"""The pages Driver and Study, and what they add to the dashboard.

`ui.driver.confined` is loaded in processes that must not load Streamlit: nor does this file.
"""

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
PRELOADED: Final = ("ui.driver.confined",)
"""It takes half a second."""
SIGHT: Final = "known:SIGHT"
MADE_FILES: Final = "known:made_files"
ASIDE: Final = "finished:ASIDE"
ROUTES: Final = "study.routes:ROUTES"
STUDIES: Final = "study.files:STUDIES"
ENCOUNTER_HEAD: Final = "encounter:draw_head"
ENCOUNTER_FILTER: Final = "encounter:FILTER"
ENCOUNTER_COLUMNS: Final = "encounter:COLUMNS"
COLUMN_LOOKS: Final = "encounter:LOOKS"
