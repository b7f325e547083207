"""Folders that only the current user can read or change."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def make_private(folder: Path) -> bool:
    """Make a folder of mode 0700, and return whether it belongs to this user alone.

    This works on POSIX systems only. In a shared place such as the temporary folder, another user
    may already have created a folder or link of that name.

    Raises
    ------
    OSError
        If the folder cannot be made.
    """
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except FileExistsError:  # a file, or a dangling link
        return False
    is_ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
    return is_ours and not status.st_mode & 0o077
