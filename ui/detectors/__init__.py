"""The page Detectors, and what it adds to the dashboard.

`ui.detectors.confined` is loaded in processes that must not load Streamlit: nor does this file.
"""

from typing import Final

from ui.subjects import Document, Page

PAGES: Final = (Page("detectors", "Detectors", "Detect", after="stability", shown=()),)
DOCUMENTS: Final = (Document("detectors", "Detectors", after="formats"),)
