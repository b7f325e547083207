"""The studies of a page: the file of their answers, addresses of participants and conductor.

A participant's address is ``PAGE?study=TOKEN&participant=NAME``, the conductor's
``PAGE?conduct=SECRET``; neither follows from the other.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Generic, Protocol, TypeVar
from urllib.parse import quote, urlsplit

import click
import streamlit as st

from nvcore.errors import InputError
from ui.session.store import CONDUCTED, OWN_STUDIES, Entry
from ui.session.workspace import Workspace

STUDY: Final = "study"
PARTICIPANT: Final = "participant"
CONDUCT: Final = "conduct"
ON_SCREEN: Final = "on_screen"
"""Name among a workspace's notes of what a participant has on the screen; it knows its ``page``."""
LOCAL: Final = ("localhost", "127.0.0.1", "::1")


class AnyStudy(Protocol):
    """A study, with its names in addresses."""

    @property
    def token(self) -> str:
        """For participants."""

    @property
    def conductor(self) -> str:
        """For its conductor."""


class Store(Protocol):
    """A file with the answers of all studies of a page."""

    def study_of_conductor(self, secret: str, /) -> Any:
        """The study of a conductor's name; None: there is none."""


StudyKind = TypeVar("StudyKind", bound=AnyStudy)
StoreKind = TypeVar("StoreKind", bound=Store)


def is_participant() -> bool:
    """Whether the address is a participant's: then nothing else of the app is shown."""
    return STUDY in st.query_params


def enter(token: str, participant: str | None = None) -> None:
    """Show a study to a participant, on this screen."""
    # at once: an address that is emptied first would be that of a page that is left
    st.query_params.from_dict({STUDY: token} | ({PARTICIPANT: participant} if participant else {}))
    st.rerun()


def leave_screen(space: Workspace, page: str = "") -> None:
    """Forget what a participant has on the screen, so that the browser gets and sends nothing.

    Parameters
    ----------
    page
        What is on the screen of this page stays.
    """
    screen = space.notes.get(ON_SCREEN)
    if screen is not None and screen.page != page:
        space.notes.pop(ON_SCREEN, None)


def is_local(address: str) -> bool:
    """Whether the address leads to the machine that it is opened on, whichever that is.

    Examples
    --------
    >>> is_local("http://localhost:8501/page?study=a"), is_local("http://lab-3:8501/page")
    (True, False)
    """
    return urlsplit(address).hostname in LOCAL


@dataclass(frozen=True)
class Studies(Generic[StudyKind, StoreKind]):
    """The studies of one page.

    Attributes
    ----------
    page
        Name of the page in addresses.
    what
        What a study is called.
    prefix
        Tells its entries of the session's store from those of others.
    variable, file_name
        Where answers are kept: the file that this variable of the environment names, else the one
        of this name in the user's own folder.
    open
        Opens that file, which deletes what is over.
    """

    page: str
    what: str
    prefix: str
    variable: str
    file_name: str
    open: Callable[[Path], StoreKind]

    @property
    def _conducted(self) -> Entry[str | None]:
        return CONDUCTED.of(self.prefix)

    def file(self) -> Path:
        """The file of all answers."""
        path = os.environ.get(self.variable)
        return Path(path) if path else Path(click.get_app_dir("nvcore")) / self.file_name

    def store(self) -> StoreKind:
        """All studies, in their file; those that are over are deleted.

        Raises
        ------
        InputError
            If it cannot be used.
        """
        return self.open(self.file())

    def conducted(self) -> StudyKind | None:
        """The study that this person conducts, from the address or this session.

        Raises
        ------
        InputError
            If the address names none that there is.
        """
        key = st.query_params.get(CONDUCT)
        secret = key or self._conducted.get()
        if secret is None:
            return None
        study: StudyKind | None = self.store().study_of_conductor(secret)
        if study is None:
            self._conducted.pop()
            st.query_params.pop(CONDUCT, None)
            raise InputError(f"there is no {self.what} of the name in the address")
        self.conduct(study)
        return study

    def conduct(self, study: StudyKind) -> None:
        """Make this the study that is conducted, in the address as well."""
        own = OWN_STUDIES.of(self.prefix)
        own.set(own.get() | {study.token})
        self._conducted.set(study.conductor)
        if st.query_params.get(CONDUCT) != study.conductor:
            st.query_params[CONDUCT] = study.conductor

    def is_own(self, study: StudyKind) -> bool:
        """Whether this browser session conducts it."""
        return study.token in OWN_STUDIES.of(self.prefix).get()

    def close(self) -> None:
        """Conduct none; the link of the one that was open opens it again."""
        self._conducted.pop()
        st.query_params.pop(CONDUCT, None)

    def addresses(self, study: StudyKind) -> tuple[str, str]:
        """Addresses of the page for participants and for the conductor."""
        page = str(st.context.url or self.page).partition("?")[0]
        return f"{page}?{STUDY}={quote(study.token)}", f"{page}?{CONDUCT}={quote(study.conductor)}"
