"""Find the real recordings, which are not part of the project."""

from __future__ import annotations

import os
from pathlib import Path


def realdata() -> Path:
    """Return the folder of the real recordings, `$NVCORE_REALDATA`.

    Raises
    ------
    SystemExit
        If the variable is not set, or the folder does not exist.
    """
    folder = os.environ.get("NVCORE_REALDATA", "")
    if not folder or not Path(folder).is_dir():
        raise SystemExit(f"no real recordings in {folder!r}: set NVCORE_REALDATA to their folder")
    return Path(folder).resolve()
