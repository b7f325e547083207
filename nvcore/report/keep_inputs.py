"""That nothing is written over the files it is made from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.errors import InputError
from nvcore.inputs.files import find_files
from nvcore.inputs.session import Session, Source, is_frame_range
from nvcore.pictures import IMAGE_SUFFIXES

if TYPE_CHECKING:
    from nvcore.inputs.readers.base import Role


def replaced_input(outputs: Iterable[Path], inputs: Iterable[Path]) -> Path | None:
    """The first file to write that is also one to read, by whatever name or link; None: none is.

    Parameters
    ----------
    inputs
        Files; of a folder the pictures in it are meant.
    """
    by_path = {file.resolve(): file for file in outputs}
    if not by_path:  # then the inputs need not be looked for
        return None
    by_identity = {_identity(path): file for path, file in by_path.items()}
    by_identity.pop(None, None)  # of those that do not exist
    for path in inputs:
        clash = by_path.get(path.resolve()) or by_identity.get(_identity(path))
        if clash is None and path.is_dir():
            clash = next((file for known, file in by_path.items() if _shows(known, path)), None)
        if clash is not None:
            return clash
    return None


def files_read(session: Session) -> Iterator[Path]:
    """The files that a session makes the program read; folders of pictures as such."""
    sources: list[tuple[Source, Role]] = [(session.truth, "truth")]
    sources += [(system, "detections") for system in session.systems]
    for source, role in sources:
        with suppress(InputError):  # told when the files are read
            yield from (file.path for file in find_files(source, session.folder, role)[0])
    for frames in (session.frames, *(facts.frames for facts in session.recordings)):
        if frames is not None and not is_frame_range(frames):
            yield session.folder / frames
    for facts in session.recordings:
        if facts.pictures is not None:
            yield session.folder / facts.pictures


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


def _shows(path: Path, folder: Path) -> bool:
    """Whether the path is a picture in the folder."""
    return path.suffix.lower() in IMAGE_SUFFIXES and path.is_relative_to(folder.resolve())
