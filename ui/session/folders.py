"""Private folders for uploads, removed when the process that made them has ended.

    BASE/PROCESS.lock       held as long as the process lives
    BASE/PROCESS/SESSION/   one folder for each browser session

BASE is a folder of its own, ``nvcore-uploads-USER``, in the system's temporary folder or in
`ENVIRONMENT`. What a killed process left behind is removed by the next one that starts: only
folders that have the names given here, and a lock that nobody holds.
"""

from __future__ import annotations

import atexit
import os
import re
import secrets
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from nvcore.output.private import make_private

ENVIRONMENT: Final = "NVCORE_UPLOAD_DIR"
"""Where uploads are kept while their session lasts; default: the system's temporary folder.

It may hold other things: they are left alone.
"""
_NAME: Final = re.compile(r"[0-9a-f]{16}")
"""Names of the folders made here."""

_held: list[FileLock] = []
"""Locks of this process; the system releases them when it ends, however it ends."""


def new_folder() -> Path:
    """An empty folder for one session, mode 0700."""
    folder = process_folder(base_folder()) / secrets.token_hex(8)
    folder.mkdir(mode=0o700)
    return folder


def base_folder() -> Path:
    """The folder that all server processes of this user share, and nothing else uses."""
    variable = os.environ.get(ENVIRONMENT)
    if variable:
        parent = Path(variable)
        parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        parent = parent.resolve()
    else:
        parent = Path(tempfile.gettempdir())
    if os.name == "nt":  # there the temporary folder is the user's own
        folder = parent / "nvcore-uploads"
        folder.mkdir(exist_ok=True)
        return folder
    folder = parent / f"nvcore-uploads-{os.getuid()}"
    if not make_private(folder):
        # made by someone else, who could read the files in it
        return Path(tempfile.mkdtemp(prefix="nvcore-uploads-", dir=parent))
    return folder


@cache
def process_folder(base: Path) -> Path:
    """Folder of the running process below `base`; folders of dead processes are removed."""
    remove_leftovers(base)
    name = secrets.token_hex(8)
    # the lock comes first, so that a folder without a held lock is always a leftover
    lock = FileLock(base / f"{name}.lock", timeout=0)
    lock.acquire()
    _held.append(lock)
    folder = base / name
    folder.mkdir(mode=0o700)
    atexit.register(_remove, folder)
    return folder


def remove_own() -> None:
    """Remove the folders of the running process."""
    for lock in _held:
        _remove(Path(lock.lock_file).with_suffix(""))


def remove_leftovers(base: Path) -> None:
    """Remove folders whose process has ended.

    Whatever was not made by `process_folder` stays: a new lock could be acquired for any
    folder, so a folder counts only with an existing lock.
    """
    for folder in base.iterdir():
        lock = folder.with_suffix(".lock")
        is_made_here = _NAME.fullmatch(folder.name) and lock.is_file()
        if not is_made_here or folder.is_symlink() or not folder.is_dir():
            continue
        try:
            with FileLock(lock, timeout=0):
                _remove(folder)
        except (OSError, Timeout):  # not ours, or alive
            continue


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.with_suffix(".lock").unlink(missing_ok=True)
