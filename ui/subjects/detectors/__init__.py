"""The page Detectors, and what it adds to the dashboard.

`ui.subjects.detectors.confined` is loaded in processes that must not load Streamlit: nor does this
file.
"""

from ui import subject


def _lacks() -> str:
    from ui.session import state  # loads Streamlit

    return "" if state.workspace().pictures.sources else "Needs pictures."


class DetectorsPages(subject.SubjectPages):
    pages = (
        subject.Page("detectors", "Detectors", "Lab", after="systems", shown=(), lacks=_lacks),
    )
    documents = (subject.Document("detectors", "Detectors", after="formats"),)
