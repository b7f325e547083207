"""Descriptions of pages, filters and figures that subjects add to the dashboard."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.comparison.compare import Result
from nvcore.evidence.looks import ONLY_LOOK, Look
from nvcore.settings.stages import Stage, shown_results

if TYPE_CHECKING:
    from nvcore.inputs.session import Session
    from ui.jobs.page_run import Aside as Aside
    from ui.session.routes import Place as Place
    from ui.subjects.people.studies import Studies
    from ui.widgets.drawing import Sight as Sight

    AnyStudies = Studies[Any, Any]
    MakeFiles = Callable[[Session, Session], Mapping[str, "MadeFile"]]

Section = Literal["Compare", "Evidence", "Lab", "Help"]
"""Headings of the navigation."""


@dataclass(frozen=True)
class Page:
    """Page of the dashboard and how it uses the comparison.

    Attributes
    ----------
    key
        Name of its script, ``pages/<key>.py``, and of its address.
    title, section
        Title in the navigation, and the heading above it.
    icon
        Icon shown there in place of the title. Empty: the title.
    tab_of
        Key of the page that has it as a tab, instead of an entry of its own.
    lacks
        Returns what the comparison lacks for this page, as a short sentence. Empty: nothing.
    asks
        Question of the page, for a link to it at the end of the Overview. Empty: no link.
    after
        Key of the page that it follows (see `nvcore.common.subject.in_place`).
    shown
        Results that it shows. None: all results. Settings that do not affect them are quiet in the
        sidebar.
    own
        Stages that it is about. Their settings come first in its sidebar, unfolded.
    controls
        Settings of these stages for which the page has buttons. The sidebar leaves them out.
    idle
        Returns settings that have no effect on the page as it is, besides those that `shown` makes
        quiet.
    is_folded
        True if the settings are folded away although they affect the page.
    script
        Path of its script if it is not ``pages/<key>.py``.
    """

    key: str
    title: str
    section: Section
    after: str = ""
    shown: tuple[Stage, ...] | None = None
    own: tuple[Stage, ...] = ()
    controls: tuple[str, ...] = ()
    idle: Callable[[], frozenset[str]] = frozenset
    is_folded: bool = False
    script: str = ""
    icon: str = ""
    tab_of: str = ""
    lacks: Callable[[], str] = str
    asks: str = ""

    def stages(self) -> tuple[Stage, ...]:
        """Return the stages whose results the page shows for the open comparison."""
        if self.lacks():
            return ()
        return shown_results() if self.shown is None else self.shown


@dataclass(frozen=True)
class Document:
    """Page of the documentation, ``docs/<key>.md``. `after` is as in `Page`."""

    key: str
    title: str
    after: str = ""


@dataclass(frozen=True)
class MadeFile:
    """File that the app made from the open comparison, for exported sessions to refer to."""

    path: Path
    meaning: str


@dataclass(frozen=True)
class TimelinePlot:
    """Figure over time below the lanes on the Timeline page.

    Attributes
    ----------
    applies
        Returns whether a comparison has the data to show.
    make
        Returns the figure for the result, the recording's row and the theme. A mark's
        ``customdata`` is its row in ``dataset.frames`` and in ``result.encounters`` (-1: none).
    """

    key: str
    applies: Callable[[Result], bool]
    make: Callable[[Result, int, Theme], go.Figure]


@dataclass(frozen=True)
class EncounterFilter:
    """Filter that a subject adds to the Encounters page.

    Attributes
    ----------
    name
        Name of its entry in the address.
    label, help
        Label and help text of the widget.
    choices
        Choices in words, by value.
    values
        Returns the value of each encounter, shape (n_encounters,).
    applies
        Returns whether a comparison has the data for it.
    """

    name: str
    label: str
    help: str
    choices: Mapping[str, str]
    values: Callable[[Result], np.ndarray]
    applies: Callable[[Result], bool]


@dataclass(frozen=True)
class ColumnLook:
    """Heading and format by which pages show a column of the report's tables.

    Attributes
    ----------
    heading
        Heading without the system's letter. Empty: derived from the column's name.
    form
        Format of a number that is not whole.
    is_share
        True if it is shown in percent.
    words
        Returns a value in words. None: values are shown as they are.
    """

    heading: str = ""
    form: str = ".2f"
    is_share: bool = False
    words: Callable[[str], str | None] | None = None


@dataclass(frozen=True)
class AddedEncounters:
    """Additions to the Encounters page.

    Attributes
    ----------
    draw_head, draw_text, draw_ways
        Draw below the heading of an encounter, below its picture, and among its buttons.
    filters
        Filters of the list.
    columns
        Names of its main columns.
    """

    draw_head: Callable[[Result, int], None] = lambda _result, _encounter: None
    draw_text: Callable[[Result, int], None] = lambda _result, _encounter: None
    draw_ways: Callable[[Result, int], None] = lambda _result, _encounter: None
    filters: Sequence[EncounterFilter] = ()
    columns: Sequence[str] = ()


class SubjectPages:
    """Pages of a subject, and its additions to others. Methods import what they return.

    Attributes
    ----------
    pages, documents
        Its pages, and those of its documentation.
    timeline_plots
        Figures on the Timeline page.
    column_looks
        Looks of its columns, by name.
    preloaded
        Modules that `ui.confined.nursery` loads before it forks, none of them loading Streamlit.
    """

    pages: Sequence[Page] = ()
    documents: Sequence[Document] = ()
    timeline_plots: Sequence[TimelinePlot] = ()
    column_looks: ClassVar[Mapping[str, ColumnLook]] = {}
    preloaded: Sequence[str] = ()

    def encounters(self) -> AddedEncounters:
        """Return its part of the Encounters page."""
        return AddedEncounters()

    def sights(self) -> Sequence[Sight]:
        """Return how eyes see pictures of visible light."""
        return ()

    def made_files(self) -> Sequence[MakeFiles]:
        """Return functions of the open session and of the one to write: files by name there."""
        return ()

    def asides(self) -> Sequence[Aside]:
        """Return its runs that go on while the visitor is on other pages."""
        return ()

    def routes(self) -> Sequence[Place]:
        """Return its routes."""
        return ()

    def count_look(self, result: Result) -> Look:
        """Count a verdict that is shown, where it keeps count of these."""
        del result
        return ONLY_LOOK

    def studies(self) -> Sequence[AnyStudies]:
        """Return its tasks for studies with people."""
        return ()


@cache
def subject_pages() -> tuple[SubjectPages, ...]:
    """Return the pages of all subjects, in the order in which they are listed."""
    known: tuple[SubjectPages, ...] = import_module("ui.subjects.registry").SUBJECTS
    return known


def count_look(result: Result) -> Look:
    """Count a verdict that is shown."""
    looks = [subject.count_look(result) for subject in subject_pages()]
    return max(looks, key=lambda look: look.factor)


def all_sights() -> list[Sight]:
    """Return how eyes see pictures of visible light, of all subjects."""
    return [sight for subject in subject_pages() for sight in subject.sights()]
