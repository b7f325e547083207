"""Folders for uploads on disk: private, and gone when the process that made them is.

    BASE/PROCESS.lock       held as long as the process lives
    BASE/PROCESS/SESSION/   one folder for each browser session

What a killed process left behind is removed by the next one that starts.
"""

from __future__ import annotations

import atexit
import os
import secrets
import shutil
import stat
import tempfile
from functools import cache
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

ENVIRONMENT: Final = "NVCORE_UPLOAD_DIR"
"""Where uploads are kept while their session lasts; default: the system's temporary folder."""

_held: list[FileLock] = []
"""Locks of this process; the system lets go of them when it ends, however it ends."""


def new_folder() -> Path:
    """An empty folder for one session, mode 0700."""
    folder = process_folder(base_folder()) / secrets.token_hex(8)
    folder.mkdir(mode=0o700)
    return folder


def base_folder() -> Path:
    """The folder that all processes of this user share."""
    given = os.environ.get(ENVIRONMENT)
    if given:
        folder = Path(given)
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return folder.resolve()
    if os.name == "nt":  # there the temporary folder is the user's own
        folder = Path(tempfile.gettempdir()) / "nvcore-uploads"
        folder.mkdir(exist_ok=True)
        return folder
    folder = Path(tempfile.gettempdir()) / f"nvcore-uploads-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    found = folder.lstat()
    is_ours = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    if not is_ours or found.st_mode & 0o077:
        # somebody else was here first: others might read what is put there
        return Path(tempfile.mkdtemp(prefix="nvcore-uploads-"))
    return folder


@cache
def process_folder(base: Path) -> Path:
    """Folder of the running process in `base`; what dead processes left there is removed."""
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


def remove_leftovers(base: Path) -> None:
    """Remove the folders of processes that no longer live."""
    for folder in base.iterdir():
        if not folder.is_dir() or folder.is_symlink():
            continue
        try:
            with FileLock(folder.with_suffix(".lock"), timeout=0):
                _remove(folder)
        except (OSError, Timeout):  # not ours, or alive
            continue


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    folder.with_suffix(".lock").unlink(missing_ok=True)
