"""The pages Driver and Study, and what they add to the dashboard."""

from typing import Final

from ui.subjects import Document, Page

PAGES: Final = (Page("study", "Study", "Evidence", after="ratings", shown=()),)
DOCUMENTS: Final = (Document("study", "Study", after="ratings"),)
ASIDE: Final = "finished:ASIDE"
ROUTES: Final = "study.routes:ROUTES"
STUDIES: Final = "study.files:STUDIES"
ENCOUNTER_HEAD: Final = "encounter:draw_head"
ENCOUNTER_FILTER: Final = "encounter:FILTER"
ENCOUNTER_COLUMNS: Final = "encounter:COLUMNS"
COLUMN_LOOKS: Final = "encounter:LOOKS"
