"""Check whether there is enough memory for a number of frames before loading them.

A machine that runs out of memory stalls for minutes, and then kills an arbitrary program.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from nvcore.common.errors import InputError

BYTES_OF_FRAME: Final = 500
"""Memory of a comparison for each evaluated frame, assuming few boxes."""
MANY_FRAMES: Final = 1_000_000
"""Largest number of frames that is not checked."""
SPARSE: Final = 1000
"""Frames for each frame with a box from which frame numbers are assumed to be wrong."""
_UNLIMITED: Final = 1 << 60


def check_room(n_frames: int, n_boxes: int) -> None:
    """Refuse more frames than there is memory for, or many without a box.

    Raises
    ------
    InputError
        If they need more memory than is free, or nearly all are empty and waste memory.
    """
    if n_frames <= MANY_FRAMES:
        return
    needed, free = n_frames * BYTES_OF_FRAME, free_bytes()
    if free is not None and needed > free:
        raise InputError(
            f"there are {n_frames:,} evaluated frames, which take about {needed / 1e9:.1f} GB of "
            f"memory; {max(free, 0) / 1e9:.1f} GB are free. Correct the frame numbers, compare "
            "fewer recordings at a time, or use a larger machine"
        )
    if n_frames > SPARSE * n_boxes:
        raise InputError(
            f"there are {n_frames:,} evaluated frames, but only {n_boxes:,} boxes; expected at "
            f"least one per {SPARSE:,} frames. Correct the frame numbers"
        )


def free_bytes(system: Path = Path("/")) -> int | None:
    """Return the memory still available to this process, or None if unknown, as outside Linux.

    This is the least of the machine's free memory, the limit of a container or service, and the
    rest of ``ulimit -v``.
    """
    try:
        lines = (system / "proc/meminfo").read_text(encoding="ascii").splitlines()
        values = dict(line.split(":", 1) for line in lines)
        page = os.sysconf("SC_PAGE_SIZE")
        statistics = (system / "proc/self/statm").read_text(encoding="ascii").split()
        size, held = (page * int(n_pages) for n_pages in statistics[:2])
        rooms = [1024 * sum(int(values[name].split()[0]) for name in ("MemAvailable", "SwapFree"))]
    except (OSError, ValueError, KeyError):
        return None
    import resource  # not available on Windows

    rooms += [limit - held for limit in _group_limits(system)]
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    rooms += [] if limit == resource.RLIM_INFINITY else [limit - size]
    return min(rooms)


def _group_limits(system: Path) -> list[int]:
    """Return the memory limits of the control group, version 1 or 2.

    A container sees its own group as the root.
    """
    groups = system / "sys/fs/cgroup"
    files = [groups / "memory.max", groups / "memory/memory.limit_in_bytes"]
    try:
        own = (system / "proc/self/cgroup").read_text(encoding="ascii").splitlines()
        files += [
            groups / line.removeprefix("0::").lstrip("/") / "memory.max"
            for line in own
            if line.startswith("0::")
        ]
    except (OSError, ValueError):
        pass
    limits = []
    for file in files:
        try:
            limits.append(int(file.read_text(encoding="ascii")))
        except (OSError, ValueError):  # not there, or "max"
            continue
    return [limit for limit in limits if limit < _UNLIMITED]
