"""Page Ratings, and its additions to the dashboard."""

from typing import Final

from nvcore.settings.stages import SALIENCY
from ui.subject import Document, Page

PAGES: Final = (
    Page("ratings", "Ratings", "Lab", after="study", shown=(SALIENCY,), is_folded=True),
)
DOCUMENTS: Final = (Document("ratings", "Ratings", after="validation"),)
STUDIES: Final = "sessions:STUDIES"
