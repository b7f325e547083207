"""Pictures of strangers, decoded in one process for each session."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from copy import copy
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from nvcore.errors import InputError, MediaError
from nvcore.pictures.base import Picture, Pictures, check_index
from nvcore.pictures.notes import PictureNote
from nvcore.pictures.open import open_pictures
from ui.confined.process import Allowance, SteadyProcess

T = TypeVar("T")

ALLOWANCE: Final = Allowance(memory_mb=1500, seconds=60.0)
"""For opening a video of an hour, and for its largest picture."""


class PictureProcess:
    """Opens pictures and reads them, one call after another; any thread may call.

    A process that a file has ended is started again by the next call, and opens what it needs.
    """

    def __init__(self, allowance: Allowance = ALLOWANCE) -> None:
        self._process = SteadyProcess(allowance)

    def open(self, path: Path) -> ConfinedPictures:
        """The pictures at that path.

        Raises
        ------
        MediaError
            As `open_pictures`, or if opening takes more than it may.
        """
        return ConfinedPictures(self, path, self.call(_open, path, what=f"opening {path.name}"))

    def call(self, function: Callable[..., T], *arguments: Any, what: str) -> T:
        """What a function returns in the process.

        Raises
        ------
        MediaError
            What it raises, or if it takes more than it may.
        """
        try:
            return self._process.call(function, *arguments, what=what)
        except MediaError:
            raise
        except InputError as error:
            raise MediaError(error.message) from error
        except OSError as error:
            raise MediaError(f"{what} failed ({error.strerror})") from error

    def close(self) -> None:
        """End the process; the next call starts another."""
        self._process.close()


class ConfinedPictures:
    """See `nvcore.pictures.base.Pictures`; what is read lies in the other process until then."""

    def __init__(self, process: PictureProcess, path: Path, facts: dict[str, Any]) -> None:
        """Pictures that the process has opened, with the facts that it told."""
        self._process, self._path = process, path
        self.name: str = facts["name"]
        self.n: int = facts["n"]
        self.width: int = facts["width"]
        self.height: int = facts["height"]
        self.is_video: bool = facts["is_video"]
        self.numbers: NDArray[np.int64] | None = facts["numbers"]
        self.fps: float | None = facts["fps"]
        self.times_s: NDArray[np.floating] | None = facts["times_s"]
        self.notes: tuple[PictureNote, ...] = facts["notes"]

    def read(self, index: int) -> Picture:
        """See `Pictures.read`."""
        check_index(index, self)
        picture = self._process.call(
            _read, self._path, index, what=f"decoding picture {index} of {self.name}"
        )
        picture.setflags(write=False)
        return picture

    def file_names(self, indices: Sequence[int]) -> list[str] | None:
        """See `Pictures.file_names`."""
        return self._process.call(
            _file_names, self._path, list(indices), what=f"reading the names in {self.name}"
        )

    def another(self) -> ConfinedPictures:
        """See `Pictures.another`."""
        return copy(self)

    def close(self) -> None:
        """See `Pictures.close`."""
        with contextlib.suppress(MediaError):
            self._process.call(_close, self._path, what="closing")


_FACTS: Final = ("name", "n", "width", "height", "is_video", "numbers", "fps", "times_s", "notes")
_opened: dict[Path, Pictures] = {}
"""In the other process: what it has open."""


def _open(path: Path) -> dict[str, Any]:
    _close(path)
    _opened[path] = pictures = open_pictures(path)
    return {name: getattr(pictures, name) for name in _FACTS}


def _read(path: Path, index: int) -> Picture:
    return _again(path).read(index)


def _file_names(path: Path, indices: list[int]) -> list[str] | None:
    return _again(path).file_names(indices)


def _again(path: Path) -> Pictures:
    """The pictures; opened again if the process that had opened them has ended."""
    if path not in _opened:
        _opened[path] = open_pictures(path)
    return _opened[path]


def _close(path: Path) -> None:
    pictures = _opened.pop(path, None)
    if pictures is not None:
        pictures.close()
