"""The interface of every source of pictures, and a cache of decoded pictures."""

from __future__ import annotations

from abc import abstractmethod
from collections import OrderedDict
from collections.abc import Sequence
from typing import Any, Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import MediaError
from nvcore.pictures.notes import PictureNote

Picture: TypeAlias = NDArray[Any]
"""Grey (h, w) or RGB (h, w, 3), uint8 or uint16, read-only."""

_CACHED_PICTURES: Final = 16
_CACHED_BYTES: Final = 1 << 26


class PictureReader(Protocol):
    """Reader of pictures by their index."""

    def read(self, index: int) -> Picture:
        """Return the picture `index` (0-based).

        Raises
        ------
        MediaError
            If there is no such picture, or it cannot be decoded.
        """
        ...


class Pictures(PictureReader):
    """Pictures of one recording, for readers in any thread.

    Attributes
    ----------
    name
        File or folder name, without the folders above.
    n
        Number of pictures that can be read.
    width, height
        Size of the first picture, px.
    is_video
        Whether one file holds them in their order: a video, or a TIFF of many pages.
    numbers
        Frame number in the name of each picture, int64, shape (n,), all different; None for a
        video and where names have none.
    fps
        Frame rate that a video states, 1/s; None for single pictures, and where it states none.
    times_s
        Time of each picture, s after the first, float64, shape (n,), ascending; None for single
        pictures, and for a video whose times cannot be relied on.
    notes
        Facts that the user should know.
    """

    name: str
    n: int
    width: int
    height: int
    is_video: bool
    numbers: NDArray[np.int64] | None = None
    fps: float | None = None
    times_s: NDArray[np.floating] | None = None
    notes: tuple[PictureNote, ...] = ()

    def file_names(self, indices: Sequence[int]) -> list[str] | None:  # noqa: ARG002
        """Return the file name of each picture, without folders, or None for a video."""
        return None

    @abstractmethod
    def another(self) -> Pictures:
        """Return the same pictures for another reader, without listing them again.

        This one has to stay open as long.
        """

    @abstractmethod
    def close(self) -> None:
        """Release files and memory."""


class RecentPictures:
    """Cache of the pictures read last, up to 16 of them and 64 MiB."""

    def __init__(self) -> None:
        self._pictures: OrderedDict[int, Picture] = OrderedDict()

    def get(self, index: int) -> Picture | None:
        """Return the picture if it is still cached."""
        if index not in self._pictures:
            return None
        self._pictures.move_to_end(index)
        return self._pictures[index]

    def put(self, index: int, picture: Picture) -> Picture:
        """Make a picture read-only, cache it and return it."""
        picture.setflags(write=False)
        self._pictures[index] = picture
        self._pictures.move_to_end(index)
        n_bytes = sum(cached.nbytes for cached in self._pictures.values())
        while len(self._pictures) > _CACHED_PICTURES or (
            n_bytes > _CACHED_BYTES and len(self._pictures) > 1
        ):
            n_bytes -= self._pictures.popitem(last=False)[1].nbytes
        return picture

    def clear(self) -> None:
        """Drop all pictures."""
        self._pictures.clear()


def check_index(index: int, pictures: Pictures) -> None:
    """Refuse an index without a picture.

    Raises
    ------
    MediaError
        If it is not within 0..n - 1.
    """
    if not 0 <= index < pictures.n:
        raise MediaError(
            f"there is no picture {index}; there are {pictures.n}, counted from 0",
            file=pictures.name,
        )
