"""Pages Driver and Study, and their additions to the dashboard.

`ui.subjects.driver.confined` is imported by processes that must not load Streamlit, so neither does
this file.
"""

from typing import Final

from nvcore.settings.stages import ENCOUNTERS, SEVERITY
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.time_left.settings import TIME_LEFT
from ui.subject import Document, Page


def _lacks() -> str:
    from nvcore.subjects.driver.comparison.steps import driver_in
    from ui.session import state  # loads Streamlit

    space = state.workspace()
    is_known = space.result is not None and driver_in(space.result).has_any
    return "" if is_known or space.visible.sources else "Needs pictures of visible light."


PAGES: Final = (
    Page(
        "driver",
        "Driver",
        "Lab",
        after="detectors",
        shown=(ENCOUNTERS, SEVERITY, TIME_LEFT, DRIVER),
        own=(DRIVER,),
        lacks=_lacks,
        asks="Would the driver have seen them?",
    ),
    Page("study", "Study", "Lab", after="driver", shown=()),
)
DOCUMENTS: Final = (
    Document("driver", "The driver", after="formats"),
    Document("driver-reference", "Driver reference", after="driver"),
    Document("study", "Study", after="ratings"),
)
PRELOADED: Final = ("ui.subjects.driver.confined",)
"""Modules to import in advance, which takes half a second."""
SIGHT: Final = "known:SIGHT"
MADE_FILES: Final = "known:made_files"
ASIDE: Final = "run:ASIDE"
ROUTES: Final = "study.routes:ROUTES"
STUDIES: Final = "study.touch_studies:STUDIES"
ENCOUNTER_HEAD: Final = "encounter:draw_head"
ENCOUNTER_FILTER: Final = "encounter:FILTER"
ENCOUNTER_COLUMNS: Final = "encounter:COLUMNS"
COLUMN_LOOKS: Final = "encounter:LOOKS"
