"""Folders that nobody but this user can look into or change."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def make_private(folder: Path) -> bool:
    """Make a folder of mode 0700; whether it, or what was there before, is this user's alone.

    On systems with users only. In a place that others write to, such as the temporary folder,
    somebody may have made it first, or a link of that name.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except FileExistsError:  # a file, or a link that leads nowhere
        return False
    is_ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    return is_ours and not status.st_mode & 0o077
