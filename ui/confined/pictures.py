"""Untrusted pictures, decoded in one process for each session."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from copy import copy
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.common.errors import InputError, MediaError
from nvcore.pictures.base import Picture, Pictures, check_index
from nvcore.pictures.open import open_pictures
from ui.confined.process import Allowance, Process

T = TypeVar("T")

ALLOWANCE: Final = Allowance(memory_mb=1500, seconds=60.0)
"""Limits for opening a video of an hour without decoding all of it, or for reading a picture."""
FACTS: Final = tuple(Pictures.__annotations__)


class PictureProcess(Process):
    """Process that opens and reads pictures, and raises MediaError.

    If a file has ended the process, the next call restarts it and reopens the pictures it needs.
    """

    def __init__(self, allowance: Allowance = ALLOWANCE) -> None:
        super().__init__(allowance)

    def open(self, path: Path) -> ConfinedPictures:
        """Open the pictures at that path.

        Raises
        ------
        MediaError
            As in `open_pictures`, or if opening exceeds the allowance.
        """
        return ConfinedPictures(self, path, self.call(_open, path, what=f"opening {path.name}"))

    def call(self, function: Callable[..., T], *arguments: Any, **options: Any) -> T:
        """Call a function in the process, as `Process.call`."""
        try:
            return super().call(function, *arguments, **options)
        except MediaError:
            raise
        except InputError as error:
            raise MediaError(error.message) from error


class ConfinedPictures(Pictures):
    """Pictures that another process decodes when asked."""

    def __init__(self, process: PictureProcess, path: Path, facts: dict[str, Any]) -> None:
        """Represent pictures that the process has opened, with their `FACTS`."""
        self._process, self._path = process, path
        vars(self).update(facts)

    def read(self, index: int) -> Picture:
        """See `Pictures.read`."""
        check_index(index, self)
        what = f"decoding picture {index} of {self.name}"
        picture: Picture = self._process.call(_ask, self._path, "read", index, what=what)
        picture.setflags(write=False)
        return picture

    def file_names(self, indices: Sequence[int]) -> list[str] | None:
        """See `Pictures.file_names`."""
        what = f"reading the names in {self.name}"
        names: list[str] | None = self._process.call(
            _ask, self._path, "file_names", list(indices), what=what
        )
        return names

    def another(self) -> ConfinedPictures:
        """See `Pictures.another`."""
        return copy(self)

    def close(self) -> None:
        """See `Pictures.close`."""
        with contextlib.suppress(MediaError):
            self._process.call(_close, self._path, what="closing")


# The rest is called in the other process.

_opened: dict[Path, Pictures] = {}


def _open(path: Path) -> dict[str, Any]:
    _close(path)
    _opened[path] = pictures = open_pictures(path)
    return {name: getattr(pictures, name) for name in FACTS}


def _ask(path: Path, method: str, argument: Any) -> Any:
    if path not in _opened:  # the process that had opened them has ended
        _opened[path] = open_pictures(path)
    return getattr(_opened[path], method)(argument)


def _close(path: Path) -> None:
    pictures = _opened.pop(path, None)
    if pictures is not None:
        pictures.close()
