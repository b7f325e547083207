"""Ends sessions whose browser has gone, and manages the folders of their uploads.

A session ends, and its workspace is closed, some time after its browser has disconnected. Streamlit
itself ends such a session only when the next visitor comes. Until then the uploads would stay on
disk and in memory.

    BASE/PROCESS.lock       held as long as the process lives
    BASE/PROCESS/SESSION/   one folder for each browser session

BASE is the folder ``nvcore-uploads-USER`` in the system's temporary folder or in `UPLOAD_FOLDER`.
A starting process removes the leftovers of killed ones: only folders with names as above whose lock
nobody holds.
"""

from __future__ import annotations

import asyncio
import atexit
import logging
import os
import re
import secrets
import shutil
import tempfile
import threading
import time
import weakref
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from filelock import FileLock, Timeout

from nvcore.common.output.private import make_private
from ui.settings.limits import limits_of_environment
from ui.streamlit_inside.sessions import close_session, is_connected, running_session

if TYPE_CHECKING:
    from ui.session.workspace import Workspace

GRACE_S: Final = 150.0
"""Longest absence of a browser before its session ends.

`GRACE_S` and `INTERVAL_S` together must stay below ``server.disconnectedSessionTTL``, because a
session that Streamlit has given up can no longer be ended.
"""
INTERVAL_S: Final = 20.0
_LOG = logging.getLogger("nvcore.ui")
_lock = threading.Lock()
_threads: list[threading.Thread] = []
_loops: list[asyncio.AbstractEventLoop] = []
"""Event loop on which Streamlit's sessions can be ended. Empty until it is known."""
UPLOAD_FOLDER: Final = "NVCORE_UPLOAD_DIR"
"""Environment variable with the parent folder of uploads. Default: the system's temporary folder.

Other content of that folder is left alone.
"""
_NAME: Final = re.compile(r"[0-9a-f]{16}")
"""Names of the folders that this module makes."""
_held: list[FileLock] = []
"""Locks of this process. The system releases them however the process ends."""


@dataclass
class _Watched:
    """Workspace of a session, and the time when the session's browser was last connected."""

    space: weakref.ref[Workspace]
    is_alive: Callable[[], bool]
    session_id: str | None = None
    seen_s: float = field(default_factory=time.monotonic)


_watched: list[_Watched] = []


def close_sessions_on(loop: asyncio.AbstractEventLoop) -> None:
    """Use this event loop, Streamlit's own, to end sessions."""
    _loops[:] = [loop]


def end_with_session(space: Workspace) -> None:
    """Close a workspace when the browser of the running session has gone, if there is a session."""
    session_id = running_session()
    if session_id is None:
        return
    watch(space, partial(is_connected, session_id), session_id=session_id)
    with _lock:
        if not _threads or not _threads[-1].is_alive():
            _threads[:] = [threading.Thread(target=_run, name="session-end", daemon=True)]
            _threads[0].start()


def watch(space: Workspace, is_alive: Callable[[], bool], *, session_id: str | None = None) -> None:
    """Close a workspace and end its session once `is_alive` was false for `GRACE_S`."""
    with _lock:
        _watched.append(_Watched(weakref.ref(space), is_alive, session_id))


def workspace_of_session(session_id: str) -> Workspace | None:
    """Return the workspace of a Streamlit session, or None."""
    with _lock:
        spaces = [entry.space() for entry in _watched if entry.session_id == session_id]
    return next((space for space in spaces if space is not None), None)


def is_in_use(space: Workspace) -> bool:
    """Whether the browser of a session that uses this workspace is connected."""
    with _lock:
        watched = list(_watched)
    return any(entry.space() is space and entry.is_alive() for entry in watched)


def sweep(now_s: float) -> None:
    """Close workspaces whose browser has been gone too long.

    `now_s` is from ``time.monotonic``. If more sessions are away than the server accepts visitors,
    the longest absent ones end at once, so that opening and closing tabs cannot fill the memory.
    """
    with _lock:
        watched = list(_watched)
    away = []
    for entry in watched:
        if entry.space() is not None and entry.is_alive():
            entry.seen_s = now_s
        else:
            away.append(entry)
    away.sort(key=lambda entry: entry.seen_s)
    n_too_many = len(away) - limits_of_environment().max_visitors
    for number, entry in enumerate(away):
        space = entry.space()
        if space is None or number < n_too_many or now_s - entry.seen_s > GRACE_S:
            with _lock:
                _watched.remove(entry)  # first, so that a failing close is not retried
                is_last = not any(other.space() is space for other in _watched)
            if is_last and space is not None:  # another session may have taken it over
                try:
                    space.close()
                except Exception as error:  # noqa: BLE001  # the others must still be closed
                    _LOG.warning("what a session left could not be removed: %s", error)
            if _loops and entry.session_id is not None and not entry.is_alive():
                close_session(entry.session_id, _loops[0])


def _run() -> None:
    while True:
        time.sleep(INTERVAL_S)
        sweep(time.monotonic())


def new_folder() -> Path:
    """Create an empty folder for one session, mode 0700."""
    folder = process_folder(base_folder()) / secrets.token_hex(8)
    folder.mkdir(mode=0o700)
    return folder


def base_folder() -> Path:
    """Return the upload folder that all server processes of this user share."""
    variable = os.environ.get(UPLOAD_FOLDER)
    if variable:
        parent = Path(variable)
        parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        parent = parent.resolve()
    else:
        parent = Path(tempfile.gettempdir())
    if os.name == "nt":  # on Windows the temporary folder belongs to the user
        folder = parent / "nvcore-uploads"
        folder.mkdir(exist_ok=True)
        return folder
    folder = parent / f"nvcore-uploads-{os.getuid()}"
    if not make_private(folder):
        # another user made it, and could read the files in it
        return Path(tempfile.mkdtemp(prefix="nvcore-uploads-", dir=parent))
    return folder


@cache
def process_folder(base: Path) -> Path:
    """Create this process's folder below `base`, and remove the folders of dead processes."""
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

    Folders that `process_folder` did not make stay. A lock could be acquired for any folder, so
    only folders with an existing lock file count.
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
