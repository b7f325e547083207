"""What one browser session has open: its comparison, its pictures and its own folder on disk."""

from __future__ import annotations

import secrets
import shutil
import threading
import weakref
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from nvcore.analysis import Result
from nvcore.dataset import Dataset
from nvcore.findings import Finding
from nvcore.media.base import Pictures
from nvcore.session import Session
from ui.session_end import end_with_session
from ui.session_folders import new_folder

if TYPE_CHECKING:
    from ui.uploads import Stored

_workspaces: weakref.WeakValueDictionary[str, Workspace] = weakref.WeakValueDictionary()


class Workspace:
    """One per browser session; lives in ``st.session_state`` and ends with it.

    The frame, box and upload routes find it by its token, which is their only guard: it is known
    to the session's own browser alone.

    Attributes
    ----------
    token
        Unguessable name of the workspace in URLs.
    folder
        Own folder for uploads, mode 0700; gone when the workspace is.
    session, dataset, label
        The open comparison and what it is called; None and empty before one is opened.
    findings
        What the audit has to say of it.
    result
        The newest analysis, which the routes read boxes from.
    pictures
        Picture source by recording index; a recording without pictures is absent.
    picture_rows
        Which picture shows each frame of a recording (-1: none), by recording index.
    picture_notes
        By which rule, in words, by recording index.
    stored
        Uploaded pictures, by name; written by `ui.uploads`.
    used_bytes, n_received
        Size of all uploads, and how many there have been.
    lock
        Held while those are changed.
    """

    def __init__(self) -> None:
        self.token = secrets.token_urlsafe(24)
        self.folder = new_folder()
        self.session: Session | None = None
        self.dataset: Dataset | None = None
        self.label = ""
        self.findings: tuple[Finding, ...] = ()
        self.result: Result | None = None
        self.pictures: Mapping[int, Pictures] = {}
        self.picture_rows: Mapping[int, np.ndarray] = {}
        self.picture_notes: Mapping[int, str] = {}
        self.lock = threading.Lock()
        self.stored: dict[str, Stored] = {}
        self.used_bytes = 0
        self.n_received = 0
        self._version = ""
        self._n_changes = 0
        self._remove = weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        _workspaces[self.token] = self
        end_with_session(self)

    @property
    def version(self) -> str:
        """Changes with every analysis and with the pictures: an address that has it may be kept."""
        return f"{self._version}.{self._n_changes}"

    @property
    def pictures_version(self) -> str:
        """Changes with the pictures."""
        return str(self._n_changes)

    @version.setter
    def version(self, version: str) -> None:
        self._version = version

    def close_pictures(self) -> None:
        """Let go of the picture files; no recording has pictures until new ones are set."""
        sources = {id(source): source for source in self.pictures.values()}
        self.pictures, self.picture_rows, self.picture_notes = {}, {}, {}
        self._n_changes += 1
        for source in sources.values():
            source.close()

    def close(self) -> None:
        """Forget everything and remove the folder; the token is unknown from now on."""
        _workspaces.pop(self.token, None)
        self.close_pictures()
        self.session = self.dataset = self.result = None
        self.findings = ()
        self._remove()


def workspace_of(token: str) -> Workspace | None:
    """The workspace with that token; None where the session has ended or never was."""
    return _workspaces.get(token)
