"""Glob patterns, safe for folders that contain links to themselves."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Final

from nvcore.common.errors import InputError

ANY_DEPTH: Final = "**"
MOST_FOLDERS: Final = 100_000
"""Limit of folders that match ``**``, as links can create any number of paths to them."""


def matching(pattern: str, folder: Path) -> list[str]:
    """Return the sorted paths that match a glob pattern below a folder, each once.

    Symbolic links to folders are followed unless they lead back to a folder above on the path.

    Raises
    ------
    InputError
        If ``**`` stands for more than `MOST_FOLDERS` folders.
    """
    parts = Path(pattern).parts
    if ANY_DEPTH not in parts:
        return sorted(glob.glob(pattern, root_dir=folder))  # noqa: PTH207  # may be absolute
    if parts[-1] == ANY_DEPTH:
        parts = (*parts, "*")
    anchor = Path(pattern).anchor
    places = [anchor]
    for part in parts[1:] if anchor else parts:
        below: dict[str, None] = {}
        for place in places:
            start = os.path.join(folder, place)  # noqa: PTH118  # names, thousands of them
            if part == ANY_DEPTH:
                ways = _folders_below(start, place)
                below |= dict.fromkeys(islice(ways, MOST_FOLDERS + 1 - len(below)))
            else:
                names = glob.glob(part, root_dir=start)  # noqa: PTH207  # Path.glob takes no ..
                below |= dict.fromkeys(os.path.join(place, name) for name in names)  # noqa: PTH118
            if part == ANY_DEPTH and len(below) > MOST_FOLDERS:
                raise InputError(
                    f"** stands for more than {MOST_FOLDERS:,} folders here; expected a pattern "
                    "that names the files more closely",
                    file=pattern,
                )
        places = list(below)
    return sorted(places)


def _folders_below(folder: str, name: str) -> Iterator[str]:
    """Yield the names of a folder and of all folders below it, except hidden ones."""
    join = os.path.join
    ways: list[tuple[str, str, frozenset[str]]] = [(folder, name, frozenset())]
    while ways:
        folder, name, above = ways.pop()
        real = os.path.realpath(folder)
        if real in above:
            continue
        yield name
        try:
            with os.scandir(folder) as entries:
                inner = [e.name for e in entries if not e.name.startswith(".") and e.is_dir()]
        except OSError:  # like glob, treat an unreadable folder as empty
            continue
        ways += ((join(folder, entry), join(name, entry), above | {real}) for entry in inner)
