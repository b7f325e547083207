"""Annotation files, read in a process of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.inputs.codes import with_codes
from nvcore.inputs.evaluated_frames import parse_frames
from nvcore.inputs.files import find_files
from nvcore.inputs.load import load, read_source
from nvcore.inputs.readers.base import Reading, Role
from nvcore.inputs.recordings_file import read_recordings_file, with_recordings_file
from nvcore.inputs.session import RecordingEntry, Session, Source
from nvcore.inputs.session_toml import read_session
from ui.confined.process import Allowance, call
from ui.settings.limits import limits_of_environment

WHAT = "reading the files"
SMALL: Final = Allowance(memory_mb=1000, seconds=20.0)
"""For a session file or a table of recordings of the largest size."""


@dataclass(frozen=True)
class FilesFound:
    """The files of a source, and name and title of their format."""

    paths: tuple[Path, ...]
    format: str
    title: str


def load_confined(session: Session) -> Dataset:
    """As `nvcore.inputs.load.load`.

    Raises
    ------
    InputError
        Also if it takes more frames, memory or time than the server allows.
    """
    read = partial(load, max_frames=limits_of_environment().max_frames)
    return call(read, session, allowance=_allowance(), what=WHAT)


def read_confined(source: Source, **options: Any) -> Reading:
    """As `nvcore.inputs.load.read_source`.

    Raises
    ------
    InputError
        Also if it takes more memory or time than the server allows.
    """
    return call(partial(read_source, **options), source, allowance=_allowance(), what=WHAT)


def find_confined(source: Source, folder: Path, role: Role) -> FilesFound:
    """As `nvcore.inputs.files.find_files`, which looks into the files.

    Raises
    ------
    InputError
        Also if it takes more memory or time than the server allows.
    """
    return call(_find, source, folder, role, allowance=_allowance(), what=WHAT)


def frames_confined(path: str, folder: Path) -> NDArray[np.int64]:
    """As `nvcore.inputs.evaluated_frames.parse_frames`.

    Raises
    ------
    InputError
        Also if it takes more memory or time than the server allows.
    """
    return call(parse_frames, path, folder, allowance=_allowance(), what=WHAT)


def session_confined(path: Path) -> Session:
    """As `nvcore.inputs.session_toml.read_session`.

    Raises
    ------
    InputError
        Also if it takes too much memory or time, as keys of thousands of parts do.
    """
    return call(read_session, path, allowance=SMALL, what="reading the session file")


def recordings_confined(path: Path, name: str) -> dict[str, tuple[int, RecordingEntry]]:
    """As `nvcore.inputs.recordings_file.read_recordings_file`.

    Raises
    ------
    InputError
        Also if it takes too much memory or time.
    """
    what = "reading the table of recordings"
    return call(read_recordings_file, path, name, allowance=SMALL, what=what)


def with_recordings_confined(session: Session) -> Session:
    """As `nvcore.inputs.recordings_file.with_recordings_file`.

    Raises
    ------
    InputError
        Also if it takes too much memory or time.
    """
    if session.recordings_file is None:
        return session
    what = "reading the table of recordings"
    return call(with_recordings_file, session, allowance=SMALL, what=what)


def with_codes_confined(session: Session, names: Sequence[str]) -> Session:
    """As `nvcore.inputs.codes.with_codes`.

    Raises
    ------
    InputError
        Also if it takes too much memory or time.
    """
    return call(with_codes, session, names, allowance=SMALL, what="reading the codes")


def _find(source: Source, folder: Path, role: Role) -> FilesFound:
    files, file_format = find_files(source, folder, role)
    return FilesFound(tuple(file.path for file in files), file_format.name, file_format.title)


def _allowance() -> Allowance:
    limits = limits_of_environment()
    return Allowance(limits.reading_mb, limits.reading_s)
