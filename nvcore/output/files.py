"""Files that the program writes: each is there whole or not at all, and a report is one run's."""

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

from nvcore.errors import InputError
from nvcore.wording import one_line, shortened

MANIFEST: Final = "SHA256SUMS"
"""The hashes of a report's files, as `sha256sum --check` reads them; written last."""
LOCK: Final = ".nvcore.lock"
PATIENCE_S: Final = 60.0
"""How long a run waits for another that writes into the same folder."""
_LONGEST: Final = 80
"""Characters of a message that name files."""
_STAGE: Final = ".nvcore-writing-"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file, which is replaced at once or, if that fails, stays as it was.

    Folders on the way are created. A link goes on pointing to the same place. What is no plain
    file (a pipe, a terminal) is written to.

    Raises
    ------
    InputError
        If it cannot be written.
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
    """Write the files of one run into a folder, which then holds all of them and no older ones.

    They are written beside and moved into place at the end, one run after another; a run that is
    stopped, or that finds the disk full, leaves what was there. `MANIFEST` is missing as long as
    files are being moved.

    Parameters
    ----------
    files
        Names and contents, made one after another.
    known
        Names that a run may write: of these, what this one does not is removed.

    Raises
    ------
    InputError
        If the folder cannot be written to, or another run does not end.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with FileLock(folder / LOCK, timeout=PATIENCE_S):
            for left in folder.glob(f"{_STAGE}*"):  # by a run that was killed
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
    """Refuse a folder that a run could not be written to, before a long run.

    Parameters
    ----------
    known
        As of `refuse_other_run`.

    Raises
    ------
    InputError
        If it cannot be written to, or holds the run of another command.
    """
    refuse_other_run(folder, known)
    if not _takes_files(folder):
        raise InputError("cannot be written to; give another folder", file=folder)


def check_file(path: Path, example: str) -> None:
    """Refuse a file that could not be written, before a long run.

    Parameters
    ----------
    example
        A name that would do, such as ``model.npz``.

    Raises
    ------
    InputError
        If it is a folder, or cannot be written to.
    """
    if path.is_dir():
        raise InputError(f"is a folder; give the name of a file, such as {example}", file=path)
    if not _takes_files(path.absolute().parent) or (path.exists() and not os.access(path, os.W_OK)):
        raise InputError("cannot be written to; give another file", file=path)


def _takes_files(folder: Path) -> bool:
    """Whether files can be written to a folder that is there or is yet to be made."""
    place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    return place.is_dir() and os.access(place, os.W_OK | os.X_OK)


def refuse_other_run(folder: Path, known: Iterable[str]) -> None:
    """Refuse a folder that holds the run of another command, which would lose some of its files.

    Parameters
    ----------
    known
        Names that a run of this command may write; others in the folder's `MANIFEST` are another's.

    Raises
    ------
    InputError
        If there is such a file, or the folder cannot be listed.
    """
    try:
        lines = (folder / MANIFEST).read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError):  # no run of ours
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
    """The hashes of files by their names, as `sha256sum` writes them."""
    return "".join(
        f"{hashlib.sha256(content).hexdigest()}  {name}\n" for name, content in files
    ).encode()


def _write_to(stage: Path, files: Iterable[tuple[str, bytes]]) -> list[str]:
    """The names of the files, `MANIFEST` last."""
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
    """Within it, a wish to stop waits."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
