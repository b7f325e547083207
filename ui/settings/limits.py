"""Limits on server resources, overall and per visitor, set by environment variables."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Final

from nvcore.common.errors import InputError
from nvcore.common.memory import free_bytes

MEBI: Final = 1 << 20
PREFIX: Final = "NVCORE_"
MOST_UPLOADS_MB: Final = 2048


@dataclass(frozen=True)
class Limits:
    """Limits of a server.

    Attributes
    ----------
    max_visitors
        Maximum number of simultaneous browser tabs.
    max_visitors_of_address
        Maximum number of tabs per network address.
    max_upload_mb
        Annotation files of one tab, MiB. They are held in memory until they are opened.
    max_uploads_mb
        Annotation files of all tabs, MiB. None: a third of the available memory, at most
        `MOST_UPLOADS_MB`.
    max_disk_mb
        Uploads of all tabs on disk, MiB.
    max_frames
        Evaluated frames open in a tab.
    max_frames_of_all
        Evaluated frames open in all tabs.
    reading_mb, reading_s
        Memory, MiB, and time for reading annotation files.
    """

    max_visitors: int = 50
    max_visitors_of_address: int = 20
    max_upload_mb: int = 512
    max_uploads_mb: int | None = None
    max_disk_mb: int = 65536
    max_frames: int = 2_000_000
    max_frames_of_all: int = 10_000_000
    reading_mb: int = 3000
    reading_s: int = 300

    def uploads_bytes(self, held: int, system: Path = Path("/")) -> int:
        """Return how many bytes of annotation files all tabs may hold, given `held` in memory.

        Parameters
        ----------
        system
            Root of the system whose memory counts (see `nvcore.common.memory.free_bytes`).
        """
        if self.max_uploads_mb is not None:
            return self.max_uploads_mb * MEBI
        free = free_bytes(system)
        return (
            MEBI * MOST_UPLOADS_MB
            if free is None
            else min(MEBI * MOST_UPLOADS_MB, (free + held) // 3)
        )


@cache
def limits_of_environment() -> Limits:
    """Return the limits, read once. Variables such as ``NVCORE_MAX_VISITORS`` replace defaults.

    Raises
    ------
    InputError
        If a variable is not a positive integer.
    """
    values = {}
    for field in fields(Limits):
        variable = f"{PREFIX}{field.name.upper()}"
        text = os.environ.get(variable, "").strip()
        if not text:
            continue
        if not (text.isascii() and text.isdigit() and 0 < int(text) < 10**9):
            raise InputError(f"{variable}: expected a whole number above 0, got {text!r}")
        values[field.name] = int(text)
    return Limits(**values)
