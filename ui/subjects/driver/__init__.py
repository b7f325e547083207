"""Pages Driver and Study, and their additions to the dashboard.

`ui.subjects.driver.confined` is imported by processes that must not load Streamlit, so neither does
this file.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.settings.stages import ENCOUNTERS, SEVERITY
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.time_left.settings import TIME_LEFT
from ui import subject


def _lacks() -> str:
    from nvcore.subjects.driver.comparison.steps import driver_in
    from ui.session import state  # loads Streamlit

    space = state.workspace()
    is_known = space.result is not None and driver_in(space.result).has_any
    return "" if is_known or space.visible.sources else "Needs pictures of visible light."


class DriverPages(subject.SubjectPages):
    pages = (
        subject.Page(
            "driver",
            "Driver",
            "Lab",
            after="detectors",
            shown=(ENCOUNTERS, SEVERITY, TIME_LEFT, DRIVER),
            own=(DRIVER,),
            lacks=_lacks,
            asks="Would the driver have seen them?",
        ),
        subject.Page("study", "Study", "Lab", after="driver", shown=()),
    )
    documents = (
        subject.Document("driver", "The driver", after="formats"),
        subject.Document("driver-reference", "Driver reference", after="driver"),
        subject.Document("study", "Study", after="ratings"),
    )
    preloaded = ("ui.subjects.driver.confined",)
    """Modules to import in advance, which takes half a second."""
    column_looks: ClassVar = {
        "detectability_sd": subject.ColumnLook("SD"),
        "within_sd": subject.ColumnLook("Open"),
        "driver_seen_frames": subject.ColumnLook("Frames seen"),
        "driver_frame": subject.ColumnLook("Driver sees in frame"),
    }

    def encounters(self) -> subject.AddedEncounters:
        from ui.subjects.driver.encounter import COLUMNS, FILTER, draw_head

        return subject.AddedEncounters(draw_head, filters=(FILTER,), columns=COLUMNS)

    def sights(self) -> Sequence[subject.Sight]:
        from ui.subjects.driver.known import SIGHT

        return (SIGHT,)

    def made_files(self) -> Sequence[subject.MakeFiles]:
        from ui.subjects.driver.known import made_files

        return (made_files,)

    def asides(self) -> Sequence[subject.Aside]:
        from ui.subjects.driver.run import ASIDE

        return (ASIDE,)

    def routes(self) -> Sequence[subject.Place]:
        from ui.subjects.driver.study.routes import ROUTES

        return ROUTES

    def studies(self) -> Sequence[subject.AnyStudies]:
        from ui.subjects.driver.study.touch_studies import TOUCH

        return (TOUCH,)
