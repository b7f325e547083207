"""Atomic writes: files are complete or absent, and a report folder holds a single run."""

from __future__ import annotations

import hashlib
import os
import secrets
import shutil
import signal
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from nvcore.common.errors import InputError
from nvcore.common.wording import one_line, shortened

MANIFEST: Final = "SHA256SUMS"
"""Hashes of a report's files in the format of `sha256sum --check`. It is written last."""
LOCK: Final = ".nvcore.lock"
PATIENCE_S: Final = 60.0
"""Time that a run waits for another one writing to the same folder."""
_LONGEST: Final = 80
"""Maximum length of the file names in a message, characters."""
_STAGE: Final = ".nvcore-writing-"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file atomically: if that fails, the previous file stays.

    Parent folders are created. A link keeps pointing to the same place. Special files (a pipe, a
    terminal) are written to directly.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file():
            path.write_bytes(content)
            return
        target = path.resolve()
        part = target.with_name(f".{secrets.token_hex(8)}.part")
        try:
            part.write_bytes(content)
            if target.exists():
                shutil.copymode(target, part)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", file=path) from error


def write_run(folder: Path, files: Iterable[tuple[str, bytes]], known: Iterable[str]) -> None:
    """Write the files of one run into a folder, replacing those of an older run.

    Files are written to a staging folder and moved into place at the end, one run at a time. A run
    that is stopped or fills the disk changes nothing. `MANIFEST` is missing while files are moved.

    Parameters
    ----------
    files
        Names and contents, which may be generated lazily.
    known
        Names that such runs may write. Those that this run does not write are removed.

    Raises
    ------
    InputError
        If the folder is not writable, or another run does not finish.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with FileLock(folder / LOCK, timeout=PATIENCE_S):
            for left in folder.glob(f"{_STAGE}*"):  # left by a run that was killed
                shutil.rmtree(left, ignore_errors=True)
            stage = folder / f"{_STAGE}{secrets.token_hex(8)}"
            stage.mkdir()
            try:
                names = _write_to(stage, files)
                with _uninterrupted():
                    _move(stage, folder, names, set(known) - set(names))
            finally:
                shutil.rmtree(stage, ignore_errors=True)
    except Timeout as error:
        raise InputError(
            f"another run of nvcore has been writing into it for {PATIENCE_S:.0f} s; wait for it, "
            f"or give another folder",
            file=folder,
        ) from error
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", file=folder) from error


def check_folder(folder: Path, known: Iterable[str]) -> None:
    """Check before a long run that its results can be written to a folder.

    Parameters
    ----------
    known
        Same as in `refuse_other_run`.

    Raises
    ------
    InputError
        If the folder is not writable, or holds the run of another command.
    """
    refuse_other_run(folder, known)
    if not _takes_files(folder):
        raise InputError("cannot be written to; give another folder", file=folder)


def check_file(path: Path, example: str) -> None:
    """Check before a long run that a file can be written.

    Parameters
    ----------
    example
        Valid example name for the message, such as ``model.npz``.

    Raises
    ------
    InputError
        If the path is a folder, or is not writable.
    """
    if path.is_dir():
        raise InputError(f"is a folder; give the name of a file, such as {example}", file=path)
    if not _takes_files(path.absolute().parent) or (path.exists() and not os.access(path, os.W_OK)):
        raise InputError("cannot be written to; give another file", file=path)


def _takes_files(folder: Path) -> bool:
    """Whether files can be written to a folder that exists or will be created."""
    place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    return place.is_dir() and os.access(place, os.W_OK | os.X_OK)


def refuse_other_run(folder: Path, known: Iterable[str]) -> None:
    """Reject a folder that holds another command's run, which would lose some of its files.

    Parameters
    ----------
    known
        Names that a run of this command may write. Others in `MANIFEST` belong to another command.

    Raises
    ------
    InputError
        If there is a file of another command, or the folder cannot be listed.
    """
    try:
        lines = (folder / MANIFEST).read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError):  # not written by nvcore
        return
    try:
        there = {path.name for path in folder.iterdir()}
    except OSError as error:
        raise InputError(
            f"cannot be listed ({error.strerror}); give another folder", file=folder
        ) from error
    others = sorted(there.intersection(line.partition("  ")[2] for line in lines) - {*known})
    if others:
        raise InputError(
            f"holds {one_line(shortened(', '.join(others), _LONGEST))} of another command (by its "
            f"{MANIFEST}); give another folder",
            file=folder,
        )


def manifest(files: Iterable[tuple[str, bytes]]) -> bytes:
    """Return the hashes of files by name in the format of `sha256sum`."""
    return "".join(
        f"{hashlib.sha256(content).hexdigest()}  {name}\n" for name, content in files
    ).encode()


def _write_to(stage: Path, files: Iterable[tuple[str, bytes]]) -> list[str]:
    """Write the files and return their names, `MANIFEST` last."""
    names, lines = [], []
    for name, content in files:
        (stage / name).write_bytes(content)
        names.append(name)
        lines.append(manifest([(name, content)]))
    (stage / MANIFEST).write_bytes(b"".join(lines))
    return [*names, MANIFEST]


def _move(stage: Path, folder: Path, names: Iterable[str], outdated: Iterable[str]) -> None:
    for name in (MANIFEST, *outdated):
        (folder / name).unlink(missing_ok=True)
    for name in names:
        (stage / name).replace(folder / name)


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Defer signals that stop the process while this context is open."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
