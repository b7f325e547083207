"""Compilation of the loops, and the location of their cached machine code.

numba caches it next to the source, in the user's cache folder, or in ``$NUMBA_CACHE_DIR``. If none
of these is writable (read-only packages and no home), we use a temporary folder that only this user
can change, because whoever can write the machine code decides what it does. Without such a folder,
each process compiles again, which takes about ten seconds.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config, njit

from nvcore.common.output.private import make_private


def compiler() -> Callable[[Callable[..., Any]], Any]:
    """Return the decorator for compiled loops, which finds a place for their machine code."""
    with_cache, without = (
        njit(cache=is_kept, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
        for is_kept in (True, False)
    )

    def compiled(loop: Callable[..., Any]) -> Any:
        try:
            return with_cache(loop)
        except RuntimeError:  # "no locator available": nowhere to write
            folder = private_folder()
        if folder is None:
            return without(loop)
        config.CACHE_DIR = str(folder)
        return with_cache(loop)

    return compiled


def private_folder() -> Path | None:
    """Return a temporary folder that belongs to this user, or None if there cannot be one."""
    try:
        folder = Path(tempfile.gettempdir()) / f"nvcore-kernels-{os.getuid()}"
        is_usable = make_private(folder) and os.access(folder, os.W_OK)
    except (OSError, AttributeError):  # AttributeError: Windows, where the home always exists
        return None
    return folder if is_usable else None
