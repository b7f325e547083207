"""Protect inputs: no output may replace a file that it is made from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from nvcore.common.errors import InputError
from nvcore.common.file_kinds import IMAGE_SUFFIXES
from nvcore.inputs.files.find import find_files
from nvcore.inputs.session import Session


def refuse_to_replace(
    outputs: Iterable[Path], inputs: Iterable[Path], *, instead: str = "file to write"
) -> None:
    """Refuse to overwrite an input, under whatever name or link.

    Parameters
    ----------
    inputs
        Files. A folder means the pictures in it.
    instead
        Name of the argument to change.

    Raises
    ------
    InputError
        If one of the outputs is an input.
    """
    clash = _replaced(outputs, inputs)
    if clash is not None:
        raise InputError(f"is an input, and would be replaced; give another {instead}", file=clash)


def refuse_outputs(
    folder: Path, names: Iterable[str], inputs: Iterable[object], session: Session
) -> None:
    """Refuse to write files into a folder of inputs, or over what a run reads.

    Parameters
    ----------
    inputs
        Inputs besides those of the session. Only paths are checked.

    Raises
    ------
    InputError
        See `refuse_to_replace` and `refuse_among_inputs`.
    """
    files = [Path(path) for path in inputs if isinstance(path, str | Path)]
    outputs = [folder / name for name in names]
    refuse_to_replace(outputs, [*files, *files_read(session)], instead="folder")
    refuse_among_inputs(folder, session)


def refuse_among_inputs(folder: Path, session: Session) -> None:
    """Refuse to write into a folder of inputs, whose files are all read.

    Raises
    ------
    InputError
        If the folder lies in one, or is one.
    """
    around = _input_folder_around(folder, session)
    if around is not None:
        raise InputError(f"lies in the folder of inputs {around}; give another folder", file=folder)


def _replaced(outputs: Iterable[Path], inputs: Iterable[Path]) -> Path | None:
    """Return the first output that is also an input, or None."""
    by_path = {file.resolve(): file for file in outputs}
    if not by_path:  # spares reading the inputs
        return None
    by_identity = {_identity(path): file for path, file in by_path.items()}
    by_identity.pop(None, None)  # outputs that do not exist yet
    for path in inputs:
        clash = by_path.get(path.resolve()) or by_identity.get(_identity(path))
        if clash is None and path.is_dir():
            clash = next(
                (file for output, file in by_path.items() if _is_picture_in(output, path)), None
            )
        if clash is not None:
            return clash
    return None


def files_read(session: Session) -> Iterator[Path]:
    """Yield the files that the program reads for a session. A folder of pictures is one entry."""
    for source, role in session.sources:
        with suppress(InputError):  # reported when the files are read
            yield from (file.path for file in find_files(source, session.folder, role)[0])
    found = {path for source, _ in session.sources for path in source.path}
    table = session.recordings_file
    others = [*([] if table is None else [table.path]), *session.paths()]
    yield from (session.folder / path for path in others if path not in found)


def _input_folder_around(folder: Path, session: Session) -> Path | None:
    """Return the folder of inputs that is or contains the folder, or None.

    The next run would read files that are written there.
    """
    place = folder.resolve()
    for source, _ in session.sources:
        for text in source.path:
            path = session.folder / text
            if path.is_dir() and place.is_relative_to(path.resolve()):
                return path
    return None


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


def _is_picture_in(path: Path, folder: Path) -> bool:
    """Whether the path is a picture in the folder."""
    return path.suffix.lower() in IMAGE_SUFFIXES and path.is_relative_to(folder.resolve())
