"""Base class of a task on its page: file of answers, addresses, words, and drawing hooks.

A participant's address is ``PAGE?study=TOKEN&participant=CODE``, the conductor's
``PAGE?conduct=SECRET``. None can be derived from another.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Final, Generic, NamedTuple, TypeVar
from urllib.parse import quote, urlsplit

import click
import pandas as pd
import streamlit as st

from nvcore.common.errors import InputError
from nvcore.subjects.people.store import Person, Study, StudyStore
from ui.session.store import CONDUCTED, OWN_STUDIES, Entry
from ui.session.workspace import Workspace
from ui.widgets.table import TableColumn

STUDY: Final = "study"
PARTICIPANT: Final = "participant"
CONDUCT: Final = "conduct"
ON_SCREEN: Final = "on_screen"
"""Key of the workspace's note on the study that a participant has on the screen."""
LOCAL: Final = ("localhost", "127.0.0.1", "::1")

S = TypeVar("S", bound=Study)
B = TypeVar("B", bound=StudyStore[Any])


def is_participant() -> bool:
    """True if the address is a participant's: then nothing else of the app is shown."""
    return STUDY in st.query_params


def enter(token: str, code: str = "") -> None:
    """Show a study to a participant, on this screen."""
    # in one step: emptied first, the address would be that of a page that is left
    st.query_params.from_dict({STUDY: token} | ({PARTICIPANT: code} if code else {}))
    st.rerun()


def leave_screen(space: Workspace, page: str = "") -> None:
    """Forget the study on the participant's screen, unless it belongs to this page.

    The routes then serve no pictures and take no answers.
    """
    screen = space.notes.get(ON_SCREEN)
    if screen is not None and screen.page != page:
        space.notes.pop(ON_SCREEN, None)


def is_local(address: str) -> bool:
    """True if the address leads to the very machine that opens it.

    Examples
    --------
    >>> is_local("http://localhost:8501/page?study=a"), is_local("http://lab-3:8501/page")
    (True, False)
    """
    return urlsplit(address).hostname in LOCAL


class Progress(NamedTuple):
    """Progress of a study: numbers with a help text by label, and columns of a table of people."""

    metrics: Mapping[str, tuple[int, str | None]]
    people: pd.DataFrame
    columns: dict[str, TableColumn]
    note: str = ""


class Studies(Generic[S, B]):
    """Studies of one task: names and labels, and hooks that draw its own parts.

    A task gives all class variables without a value, `draw_trial`, `progress` and `draw_setup`. The
    rest is optional.
    """

    opens: type[B]  # store of the answers

    page: ClassVar[str]  # name of the page in addresses
    what: ClassVar[str]  # a study
    answers: ClassVar[str] = "answers"  # what participants give
    prefix: ClassVar[str]  # start of keys of widgets and of entries in the session's store
    variable: ClassVar[str]  # of the environment: path of the file of answers
    file_name: ClassVar[str]  # of that file in the user's own folder, without the variable
    start: ClassVar[str]  # button of the conductor: start a study
    title: ClassVar[str]  # of a participant's page
    begin: ClassVar[str]  # button of a participant: begin
    here: ClassVar[str]  # button of the conductor: hand over this screen
    back: ClassVar[str]  # button of the conductor: take it back

    def is_ready(self, study: S) -> bool:
        """Return True if the study can be shown. Otherwise, show or do what is needed first."""
        del study
        return True

    def introduce(self, study: S) -> None:
        """Draw a description of the task, before participants agree."""

    def explain(self) -> None:
        """Draw background for participants between terms and form."""

    def usual(self, study: S) -> Mapping[str, float | None]:
        """Return values of the form's number fields before it is filled in."""
        del study
        return {}

    def draw_trial(self, store: B, study: S, person: Person, left: list[Any]) -> bool:
        """Draw the participant's next trial, and return False if there is none.

        Before the first one `ui.subjects.people.participant.draw_code` says the personal code.
        After an answer is kept, the page is rerun.
        """
        raise NotImplementedError

    def draw_end(self, person: Person) -> None:
        """Draw the text after the last trial."""

    def on_back(self) -> None:
        """Restore what participants changed on the conductor's screen."""

    def draw_setup(self) -> None:
        """Draw the form that begins a study."""
        raise NotImplementedError

    def draw_notes(self) -> None:
        """Draw notes for the conductor below the addresses."""

    def draw_downloads(self, store: B, study: S) -> None:
        """Draw the buttons that save tables and settings."""

    def progress(self, store: B, study: S) -> Progress:
        """Return how far the study has come."""
        raise NotImplementedError

    def draw_results(self, store: B, study: S) -> None:
        """Draw results of the answers below the progress."""

    @property
    def _conducted(self) -> Entry[str | None]:
        return CONDUCTED.of(self.prefix)

    def file(self) -> Path:
        """Return the file of all answers."""
        path = os.environ.get(self.variable)
        return Path(path) if path else Path(click.get_app_dir("nvcore")) / self.file_name

    def store(self) -> B:
        """Open the file of all answers, which deletes the studies that are over."""
        return self.opens(self.file())

    def conducted(self) -> tuple[B, S] | None:
        """Return the study that this person conducts, from the address or this session.

        Raises
        ------
        InputError
            If there is no study of the name in the address.
        """
        secret = st.query_params.get(CONDUCT) or self._conducted.get()
        if secret is None:
            return None
        store = self.store()
        study: S | None = store.study_of_conductor(secret)
        if study is None:
            self.close()
            raise InputError(f"there is no {self.what} of the name in the address")
        self.conduct(study)
        return store, study

    def conduct(self, study: S) -> None:
        """Make this the study that is conducted, in the address as well."""
        own = OWN_STUDIES.of(self.prefix)
        own.set(own.get() | {study.token})
        self._conducted.set(study.conductor)
        if st.query_params.get(CONDUCT) != study.conductor:
            st.query_params[CONDUCT] = study.conductor

    def is_own(self, study: S) -> bool:
        """True if this browser session conducts the study."""
        return study.token in OWN_STUDIES.of(self.prefix).get()

    def close(self) -> None:
        """Stop conducting the open study. Its link opens it again."""
        self._conducted.pop()
        st.query_params.pop(CONDUCT, None)

    def addresses(self, study: S, code: str = "") -> tuple[str, str]:
        """Return the addresses for participants (or for the one with this code) and conductor."""
        page = str(st.context.url or self.page).partition("?")[0]
        person = f"&{PARTICIPANT}={quote(code)}" if code else ""
        secret = quote(study.conductor)
        return f"{page}?{STUDY}={quote(study.token)}{person}", f"{page}?{CONDUCT}={secret}"
