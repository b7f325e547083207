"""The page Detectors, and what it adds to the dashboard.

`ui.subjects.detectors.confined` is loaded in processes that must not load Streamlit: nor does this
file.
"""

from typing import Final

from ui.subject import Document, Page


def _lacks() -> str:
    from ui.session import state  # loads Streamlit

    return "" if state.workspace().pictures.sources else "Needs pictures."


PAGES: Final = (Page("detectors", "Detectors", "Lab", after="systems", shown=(), lacks=_lacks),)
DOCUMENTS: Final = (Document("detectors", "Detectors", after="formats"),)
