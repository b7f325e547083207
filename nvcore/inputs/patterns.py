"""Files that a pattern names, also where folders have links to themselves."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Final

from nvcore.errors import InputError

ANY_DEPTH: Final = "**"
MOST_FOLDERS: Final = 100_000
"""That ``**`` may stand for; links between folders can make any number of ways to them."""


def matching(pattern: str, folder: Path) -> list[str]:
    """What a pattern names, as `glob.glob` finds it from a folder on, each once, sorted.

    Links to folders are followed, except back to a folder that the path has come through.

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
    """The folder and all below it, by their names; hidden ones are passed over."""
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
        except OSError:  # as glob does: what may not be looked into holds nothing
            continue
        ways += ((join(folder, entry), join(name, entry), above | {real}) for entry in inner)
