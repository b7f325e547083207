"""A file to download that is written in the background: a video, a report."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from ui.background_job import BackgroundJob, Progress
from ui.workspace import Workspace

FOLDER: Final = "exports"


def new_path(space: Workspace, suffix: str) -> Path:
    """Where the workspace has room for such a file; it is there no longer than the workspace."""
    folder = space.folder / FOLDER
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder / f"{secrets.token_hex(8)}{suffix}"


class FileJob(BackgroundJob):
    """One file.

    Attributes
    ----------
    path
        Where it is written; there is a file only once the job is done.
    name
        File name for the download.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        write: Callable[[Progress], bool],
        is_wanted: Callable[[], bool],
        *,
        key: Any = None,
    ):
        """Start to write; see `BackgroundJob`."""
        self.path, self.name = path, name
        super().__init__(write, is_wanted, key=key)

    def _remove(self) -> None:
        self.path.unlink(missing_ok=True)
