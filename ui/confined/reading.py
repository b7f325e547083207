"""Reading of annotation files in a process of their own.

Each function raises InputError if reading exceeds the server's limits on memory or time, and the
errors of the function that it runs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, ParamSpec, TypeVar

from nvcore.dataset import Dataset
from nvcore.inputs.codes import with_codes
from nvcore.inputs.evaluated_frames import parse_frames
from nvcore.inputs.files.find import find_files
from nvcore.inputs.load import load, read_source
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session, Source
from nvcore.inputs.session.recordings_file import read_recordings_file, with_recordings_file
from nvcore.inputs.session.toml import read_session
from ui.confined.process import Allowance, call
from ui.settings.limits import limits_of_environment

P = ParamSpec("P")
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


def _confined(
    function: Callable[P, T], what: str = "reading the files", *, is_small: bool = False
) -> Callable[P, T]:
    """Make a function run in a process of its own.

    Parameters
    ----------
    what
        Subject of error messages.
    is_small
        True for the limits `SMALL`, in place of the server's limits on reading.
    """

    def run(*arguments: P.args, **named: P.kwargs) -> T:
        limits = limits_of_environment()
        allowed = SMALL if is_small else Allowance(limits.reading_mb, limits.reading_s)
        return call(partial(function, *arguments, **named), allowance=allowed, what=what)

    return run


def _find(source: Source, folder: Path, role: Role) -> FilesFound:
    files, file_format = find_files(source, folder, role)
    return FilesFound(tuple(file.path for file in files), file_format.name, file_format.title)


read_confined = _confined(read_source)
find_confined = _confined(_find)
"""Runs `nvcore.inputs.files.find.find_files`, which looks into the files."""
frames_confined = _confined(parse_frames)
session_confined = _confined(read_session, "reading the session file", is_small=True)
"""Confined because parsing keys of thousands of parts takes long."""
recordings_confined = _confined(read_recordings_file, OF_TABLE, is_small=True)
with_codes_confined = _confined(with_codes, "reading the codes", is_small=True)


def load_confined(session: Session) -> Dataset:
    """Run `nvcore.inputs.load.load`, with the server's limit on frames."""
    return _confined(load)(session, max_frames=limits_of_environment().max_frames)


def with_recordings_confined(session: Session) -> Session:
    """Run `nvcore.inputs.session.recordings_file.with_recordings_file` if there is such a file."""
    if session.recordings_file is None:
        return session
    return _confined(with_recordings_file, OF_TABLE, is_small=True)(session)
