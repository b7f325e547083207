"""Workspace of one browser session: its comparison, its pictures and its own folder on disk."""

from __future__ import annotations

import os
import secrets
import shutil
import threading
import weakref
from collections import Counter, OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, TypeVar

import numpy as np
from anyio import CapacityLimiter

from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from nvcore.pictures.base import Pictures
from nvcore.pictures.recordings import RecordingPictures
from nvcore.settings.params import Params
from ui.access.people import owner_of_session
from ui.confined.pictures import PictureProcess
from ui.confined.process import MODELS, Process
from ui.session.lifetime import end_with_session, new_folder

if TYPE_CHECKING:
    from ui.jobs.background import BackgroundJob

T = TypeVar("T")
PICTURES: Final = "pictures"
"""Folder of the session's pictures."""
MOST_READS: Final = 4
"""Largest number of pictures read at a time for one session."""
NONE_VISIBLE: Final = RecordingPictures()
Kind = Literal["video", "zip", "image"]


class Caching:
    """Thread-safe cache of values by kind and key."""

    def __init__(self) -> None:
        self._caches: dict[str, OrderedDict[Hashable, Any]] = {}
        self._caches_lock = threading.Lock()

    def cached(self, kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
        """Return the cached value for this key, or compute it by `make`.

        Parameters
        ----------
        kind
            Name of the cache.
        key
            Everything that the value depends on.
        make
            Computes the value. If two threads do so at once, the first value is kept.
        most
            Size of the cache. The least recently used value is dropped first.
        """
        value: T
        with self._caches_lock:
            cache = self._caches.setdefault(kind, OrderedDict())
            if key in cache:
                cache.move_to_end(key)
                value = cache[key]
                return value
        new = make()  # without the lock, because it takes long and may end the run
        with self._caches_lock:
            cache = self._caches.setdefault(kind, OrderedDict())
            value = cache.setdefault(key, new)
            cache.move_to_end(key)
            while len(cache) > most:
                cache.popitem(last=False)
        return value

    def peek(self, kind: str, key: Hashable) -> Any:
        """Return the cached value for this key, or None."""
        with self._caches_lock:
            cache = self._caches.get(kind)
            return None if cache is None else cache.get(key)

    def forget_values(self) -> None:
        """Empty the cache."""
        with self._caches_lock:
            self._caches.clear()


@dataclass(frozen=True)
class Stored:
    """A picture file in the session's folder: its safe name and its kind.

    `form` is the number of the upload form, in which no other file has its name. Files of earlier
    forms are open.
    """

    name: str
    kind: Kind
    n_bytes: int
    form: int = 0

    @property
    def place(self) -> PurePosixPath:
        """Path within the session's folder."""
        images = ["images"] if self.kind == "image" else []
        return PurePosixPath(PICTURES, str(self.form), *images, self.name)

    @property
    def source(self) -> PurePosixPath:
        """Path that a recording names: the video or archive, or the folder of single pictures."""
        return self.place.parent if self.kind == "image" else self.place


@dataclass(frozen=True)
class Opened:
    """The open session with changes made on the pages, its data, and a label.

    Attributes
    ----------
    dataset
        The recordings that the session compares.
    whole
        All recordings. It is `dataset` if the session compares all.
    """

    session: Session
    dataset: Dataset
    label: str
    whole: Dataset

    @classmethod
    def of(cls, session: Session, whole: Dataset, label: str) -> Opened:
        """Open data, restricted to the recordings that the session chooses.

        Raises
        ------
        InputError
            If the session chooses none of them.
        """
        session = session.choosing_from(whole.recordings["name"].tolist())
        if session.codes_file is not None:  # read with the data
            session = replace(session, codes=whole.settings.codes, codes_file=None)
        whole = whole if whole.settings is session else whole.with_settings(session)
        return cls(session, whole.only(session.only_tags, session.only), label, whole)

    @cached_property
    def params(self) -> Params:
        """The parameters that the session starts with."""
        return self.dataset.params_of()

    @property
    def rows(self) -> np.ndarray:
        """Rows of the recordings that are compared."""
        names = self.whole.recordings["name"].isin(self.dataset.recordings["name"])
        return np.flatnonzero(names)


class Compared(NamedTuple):
    """A result and its version in addresses, which are replaced together."""

    result: Result
    version: str


_workspaces: weakref.WeakValueDictionary[str, Workspace] = weakref.WeakValueDictionary()


class Workspace(Caching):
    """Workspace of one browser session, in whose store (`ui.session.store`) it lives and ends.

    The frame, box and upload routes find it by its token, which only the session's own browser
    knows, and are for its owner alone.

    Attributes
    ----------
    token
        Unguessable name of the workspace in URLs.
    owner
        Key of the person who has logged in (`ui.access.people`). Empty if log-in is off.
    folder
        Folder for its uploads, mode 0700, removed with the workspace.
    opened
        The open comparison, or None before one is opened. Pages use `ui.session.state.opened`.
    n_opened
        Number of comparisons opened so far.
    compared
        The newest result, which the routes read boxes from, with its version.
    pictures
        Pictures of the open recordings, by recording index.
    visible
        Pictures of visible light that some recordings have as well.
    stored
        Uploaded pictures by place, written by `ui.session.uploads`.
    form
        Number of the form that is being filled in, see `Stored`.
    form_folder
        Folder of its annotations. None if it has none yet.
    used_bytes
        Size of all uploads.
    numbers
        Numbers for the names of new folders.
    upload_bytes
        Share of `used_bytes` that belongs to annotations and outputs of runs, by folder.
    lock
        Held while uploads and their sizes are changed.
    picture_process
        Process that opens and reads pictures.
    model_process
        Process that opens and runs models.
    picture_turns
        Limits how many pictures the browser reads at a time, so that slow ones do not block the
        threads of other visitors.
    refusal
        Reason why the last annotation file was refused. Empty once the page has shown it.
    notes
        Values that a page remembers under its own key. They outlast `forget`, unlike cached values,
        and a reload, unlike the store.
    """

    def __init__(self) -> None:
        super().__init__()
        self.owner = owner_of_session()
        self.token = secrets.token_urlsafe(24)
        self.folder = new_folder()
        self.opened: Opened | None = None
        self.n_opened = 0
        self.compared: Compared | None = None
        self.pictures = RecordingPictures()
        self.visible = RecordingPictures()
        self._all_pictures = RecordingPictures()
        self._all_visible = RecordingPictures()
        self.lock = threading.Lock()
        self.picture_process = PictureProcess()
        self.model_process = Process(MODELS)
        self.picture_turns = CapacityLimiter(MOST_READS)
        self.stored: dict[PurePosixPath, Stored] = {}
        self.form = 0
        self.form_folder: Path | None = None
        self.used_bytes = 0
        self.upload_bytes = Counter[Path]()
        self.numbers = count(1)
        self.refusal = ""
        self.notes: dict[str, Any] = {}
        self._jobs: dict[str, BackgroundJob[Any]] = {}
        self._n_changes = 0
        self._remove = weakref.finalize(self, shutil.rmtree, self.folder, ignore_errors=True)
        _workspaces[self.token] = self
        end_with_session(self)

    @property
    def sent(self) -> list[Path]:
        """Uploaded videos, archives and folders of single pictures, newest first."""
        files = reversed(list(self.stored.values()))
        return [self.folder / source for source in dict.fromkeys(file.source for file in files)]

    @property
    def result(self) -> Result | None:
        """The newest result."""
        return None if self.compared is None else self.compared.result

    @property
    def version(self) -> str:
        """Version of the result, for addresses that browsers may cache."""
        return "" if self.compared is None else self.compared.version

    @property
    def pictures_version(self) -> str:
        """Version of the pictures, for addresses that browsers may cache."""
        return str(self._n_changes)

    def job(self, kind: str) -> Any:
        """Return the newest job of this kind, running or ended, or None."""
        return self._jobs.get(kind)

    def drop_job(self, kind: str) -> None:
        """Stop the job of this kind and remove its output."""
        job = self._jobs.pop(kind, None)
        if job is not None:
            job.discard()

    @property
    def is_busy(self) -> bool:
        """Whether any job is still running."""
        return any(job.is_busy for job in self._jobs.values())

    def put_job(self, kind: str, job: BackgroundJob[Any]) -> None:
        """Keep the job until there is a newer one of its kind, or until `forget`."""
        self.drop_job(kind)
        self._jobs[kind] = job

    def forget(self, *, keeps_outputs: bool = False) -> None:
        """Clear cached values and drop jobs. `keeps_outputs` spares ended jobs that outlast it."""
        for kind, job in list(self._jobs.items()):
            if not (keeps_outputs and job.outlasts and not job.is_busy):
                self.drop_job(kind)
        self.compared = None
        self.forget_values()

    def path_in(self, folder: Path, path: Path) -> str:
        """Return a path as a session in `folder` names it.

        It is relative within the folder and among uploads, and absolute elsewhere.
        """
        is_near = path.is_relative_to(folder) or (
            path.is_relative_to(self.folder) and folder.is_relative_to(self.folder)
        )
        return Path(os.path.relpath(path, folder)).as_posix() if is_near else str(path)

    def picture_of(self, recording: int, row: int) -> tuple[Pictures | None, int]:
        """Return a recording's pictures, and the index (-1: none) of the one for a frame's row."""
        pictures = self.pictures.sources.get(recording)
        return pictures, -1 if pictures is None else int(self.pictures.indices[recording][row])

    def show(
        self, opened: Opened, pictures: RecordingPictures, visible: RecordingPictures = NONE_VISIBLE
    ) -> Opened:
        """Switch to another comparison and its pictures, and return it."""
        self.forget()  # first, so that no job reads closed pictures
        self.close_pictures()
        self._all_pictures, self._all_visible = pictures, visible
        self._look_at(opened)
        self.n_opened += 1
        return opened

    def look_at(self, opened: Opened, *, keeps_outputs: bool = False) -> None:
        """Switch to other recordings of the same data. Pictures stay open (see `forget`)."""
        self.forget(keeps_outputs=keeps_outputs)
        self._look_at(opened)

    def _look_at(self, opened: Opened) -> None:
        self.opened = opened
        number_of = {int(row): number for number, row in enumerate(opened.rows)}
        self.pictures = self._all_pictures.renumbered(number_of)
        self.visible = self._all_visible.renumbered(number_of)
        self._n_changes += 1

    def close_pictures(self) -> None:
        """Close the picture files. No recording has pictures until new ones are set."""
        opened = (*self._all_pictures.sources.values(), *self._all_visible.sources.values())
        sources = {id(source): source for source in opened}
        self._all_pictures = self._all_visible = RecordingPictures()
        self.pictures = self.visible = RecordingPictures()
        self._n_changes += 1
        for source in sources.values():
            source.close()

    def close(self) -> None:
        """Drop everything, remove the folder and invalidate the token."""
        _workspaces.pop(self.token, None)
        self.opened = None
        self.notes.clear()
        self.forget()  # first, so that no job reads closed pictures
        self.close_pictures()
        self.picture_process.close()
        self.model_process.close()
        self._remove()


def workspace_of(token: str) -> Workspace | None:
    """Return the workspace with that token, or None if its session has ended."""
    return _workspaces.get(token)


def used_by_all() -> int:
    """Return the size of all sessions' uploads, bytes."""
    return sum(space.used_bytes for space in list(_workspaces.values()))


def opened_by_others(space: Workspace) -> list[Opened]:
    """Return the comparisons that other sessions have open, each shared one once."""
    others = {
        id(other.opened.whole.frames): other.opened
        for other in list(_workspaces.values())
        if other is not space and other.opened is not None
    }
    return list(others.values())
