"""How many threads a picture may take: all cores if it is alone, one where others are beside it."""

from __future__ import annotations

import os
import threading

_here = threading.local()


def one_for_a_picture() -> None:
    """From now on what this thread begins takes no further thread: others work beside it."""
    _here.is_shared = True


def threads_for_a_picture() -> int:
    """So many threads the work on a picture may take that is begun by this thread."""
    return 1 if getattr(_here, "is_shared", False) else os.cpu_count() or 1
