"""What the subjects add to the dashboard."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import numpy as np
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.palette import Theme
from nvcore.stages import Stage
from nvcore.subjects import resolve, subjects

Section = Literal["Compare", "Evidence", "Lab", "Help"]
"""Headings of the navigation."""


@dataclass(frozen=True)
class Page:
    """A page of the dashboard.

    Attributes
    ----------
    key
        Of its script, ``pages/<key>.py``, and of its address.
    title, section
        What it is called in the navigation, and under which heading.
    icon
        What stands for it there in place of its title; empty: the title.
    tab_of
        Key of the page among whose tabs it is, instead of an entry of its own.
    lacks
        What a comparison would need for it to show anything, as a short sentence; empty: it has
        that. None: every comparison has.
    asks
        Its question, for a link to it at the end of the Overview; empty: none.
    after
        Key of the page that it follows; see `nvcore.subjects.in_place`.
    shown
        What it shows of the comparison; None: all results. Settings that move nothing of it are
        quiet in the sidebar.
    own
        Stages that it is about: on it their settings stand first, unfolded.
    controls
        Settings of these stages that the page itself has buttons for: the sidebar leaves them out.
    idle
        Returns the settings that have no effect on the page as it is; None: `shown` tells them.
    is_folded
        Whether the settings are folded away, though they move what it shows.
    script
        Path of its script where that is another one.
    """

    key: str
    title: str
    section: Section
    after: str = ""
    shown: tuple[Stage, ...] | None = None
    own: tuple[Stage, ...] = ()
    controls: tuple[str, ...] = ()
    idle: Callable[[], frozenset[str]] | None = None
    is_folded: bool = False
    script: str = ""
    icon: str = ""
    tab_of: str = ""
    lacks: Callable[[], str] | None = None
    asks: str = ""


@dataclass(frozen=True)
class Document:
    """A page of the documentation, ``docs/<key>.md``; `after` as in `Page`."""

    key: str
    title: str
    after: str = ""


@dataclass(frozen=True)
class MadeFile:
    """A file that the app has made of what is open; the session to be exported names it."""

    path: Path
    meaning: str


@dataclass(frozen=True)
class TimelinePlot:
    """A figure over time below the lanes of the page Timeline.

    Attributes
    ----------
    applies
        Whether a comparison has what it shows.
    make
        Of the result, the recording's row and the theme. A mark's ``customdata`` is the row in
        ``dataset.frames`` and that in ``result.encounters``, -1: nobody.
    """

    key: str
    applies: Callable[[Result], bool]
    make: Callable[[Result, int, Theme], go.Figure]


@cache
def contributed(kind: str) -> tuple[Any, ...]:
    """What each subject adds to a list of the dashboard, of those that add to it.

    Parameters
    ----------
    kind
        Name of what `nvcore.subjects.Subject.ui` has, or of a reference ``"module:name"`` to it:
        ``"PAGES"`` (`Page`), ``"DOCUMENTS"`` (`Document`), ``"ASIDE"`` (`ui.jobs.runs.Aside`),
        ``"ROUTES"`` (`ui.session.routes.Place`), ``"STUDIES"`` (`ui.people.studies.Studies`),
        ``"PRELOADED"`` (modules that `ui.confined.nursery` loads before it forks: none that loads
        Streamlit), ``"TIMELINE_PLOTS"`` (`TimelinePlot`), ``"SIGHT"``
        (`ui.widgets.drawing.Sight`) or ``"MADE_FILES"`` (function of the session and of the one to
        be written: each `MadeFile` by its name in the latter).
    """
    rooms = [subject.ui for _, subject in subjects().values() if subject.ui]
    return tuple(
        resolve(room, added) if isinstance(added, str) else added
        for room in rooms
        if (added := getattr(import_module(room), kind, ""))
    )


@dataclass(frozen=True)
class EncounterFilter:
    """A filter of the page Encounters.

    Attributes
    ----------
    name
        Its entry in the address.
    label, help
        What the widget is called, and its help text.
    choices
        What can be chosen, in words.
    values
        Which of these each encounter is; shape (n_encounters,).
    applies
        Whether a comparison has what it is about.
    """

    name: str
    label: str
    help: str
    choices: Mapping[str, str]
    values: Callable[[Result], np.ndarray]
    applies: Callable[[Result], bool]


@dataclass(frozen=True)
class ColumnLook:
    """How a column of the report's tables looks on pages.

    Attributes
    ----------
    heading
        Its heading, without the system's letter; empty: what follows from its name.
    form
        Format of a number that is not whole.
    is_share
        Whether it is shown in percent.
    words
        What its values are called; None: as they are.
    """

    heading: str = ""
    form: str = ".2f"
    is_share: bool = False
    words: Callable[[str], str | None] | None = None
