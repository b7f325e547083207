"""Annotation files, read in a process of their own.

Each function raises InputError if reading exceeds the server's limits on memory or time, and the
errors of the function that it runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

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

T = TypeVar("T")

SMALL: Final = Allowance(memory_mb=1000, seconds=20.0)
"""Limits for a session file or a table of recordings of the largest size."""
OF_TABLE: Final = "reading the table of recordings"


@dataclass(frozen=True)
class FilesFound:
    """Files of a source, with name and title of their format."""

    paths: tuple[Path, ...]
    format: str
    title: str


def load_confined(session: Session) -> Dataset:
    """Run `nvcore.inputs.load.load`, with the server's limit on frames."""
    return _read(partial(load, max_frames=limits_of_environment().max_frames), session)


def read_confined(source: Source, **options: Any) -> Reading:
    """Run `nvcore.inputs.load.read_source`."""
    return _read(partial(read_source, **options), source)


def find_confined(source: Source, folder: Path, role: Role) -> FilesFound:
    """Run `nvcore.inputs.files.find_files`, which looks into the files."""
    return _read(_find, source, folder, role)


def frames_confined(path: str, folder: Path) -> NDArray[np.int64]:
    """Run `nvcore.inputs.evaluated_frames.parse_frames`."""
    return _read(parse_frames, path, folder)


def session_confined(path: Path) -> Session:
    """Run `nvcore.inputs.session_toml.read_session`: keys of thousands of parts take long."""
    return call(read_session, path, allowance=SMALL, what="reading the session file")


def recordings_confined(path: Path, name: str) -> dict[str, tuple[int, RecordingEntry]]:
    """Run `nvcore.inputs.recordings_file.read_recordings_file`."""
    return call(read_recordings_file, path, name, allowance=SMALL, what=OF_TABLE)


def with_recordings_confined(session: Session) -> Session:
    """Run `nvcore.inputs.recordings_file.with_recordings_file` if there is such a file."""
    if session.recordings_file is None:
        return session
    return call(with_recordings_file, session, allowance=SMALL, what=OF_TABLE)


def with_codes_confined(session: Session, names: Sequence[str]) -> Session:
    """Run `nvcore.inputs.codes.with_codes`."""
    return call(with_codes, session, names, allowance=SMALL, what="reading the codes")


def _read(function: Callable[..., T], *arguments: Any) -> T:
    limits = limits_of_environment()
    allowance = Allowance(limits.reading_mb, limits.reading_s)
    return call(function, *arguments, allowance=allowance, what="reading the files")


def _find(source: Source, folder: Path, role: Role) -> FilesFound:
    files, file_format = find_files(source, folder, role)
    return FilesFound(tuple(file.path for file in files), file_format.name, file_format.title)
