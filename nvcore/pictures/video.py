"""Exact random access to the pictures of a video.

The sorted presentation times identify the pictures (`nvcore.pictures.video_frames`). A picture is
decoded from the key picture before it, and is taken only if its own time is the wanted one.
Where times cannot be trusted (H.264 in AVI), pictures are counted from the start of the video.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from pathlib import Path
from threading import Lock
from typing import Any, Final

import av
import numpy as np

from nvcore.common.errors import MediaError
from nvcore.common.wording import one_line
from nvcore.pictures.base import Picture, Pictures, RecentPictures, check_index
from nvcore.pictures.containers import DAMAGED, REORDERED, check_samples, open_container
from nvcore.pictures.header import check_size
from nvcore.pictures.video_frames import decoded, list_pictures

_NEAR: Final = 8
"""Number of pictures before the wanted one that are cached on the way, for steps backwards."""
_SAME_STEP: Final = 1.25
"""Multiple of the least step up to which a step is the same: containers round times."""


class Video(Pictures):
    """Pictures of a video in the order in which they are shown."""

    is_video = True

    def __init__(self, path: Path, container_format: str):
        """Open and list the pictures.

        Raises
        ------
        MediaError
            If it is damaged, holds no picture, or is too large.
        """
        self.name = one_line(path.name)
        self._path, self._format = path, container_format
        self._start()
        try:
            if self._format == "mov":
                check_samples(path, self.name)
            self._table = list_pictures(path, self._format, self.name)
            first = self._find(0)
            begins_late = first is None and self._format in ("mpegts", "mpeg")
            if begins_late or self._has_fields():
                self._table = list_pictures(path, self._format, self.name, must_decode=True)
                self._recent.clear()
                first = self._find(0)
        except (av.error.FFmpegError, OSError) as error:
            raise MediaError(DAMAGED, file=self.name) from error
        finally:
            self._let_go()
        if first is None:
            raise MediaError(f"its first picture cannot be decoded: it {DAMAGED}", file=self.name)
        self.height, self.width = first.shape[:2]
        self.n, self.fps = len(self._table.shown), self._table.fps
        self.times_s, self.notes = self._table.times_s, self._table.notes

    def _start(self) -> None:
        """Reset to the state before anything was read."""
        self._lock, self._recent = Lock(), RecentPictures()
        self._container: Any = None
        self._stream: Any = None
        self._frames: Iterator[Any] = iter(())
        self._at = -1
        self._lost: set[int] = set()
        # a frame's own reformatter would start threads of its own
        self._reformatter = av.video.reformatter.VideoReformatter()

    def read(self, index: int) -> Picture:
        """See `Pictures.read`."""
        check_index(index, self)
        position = int(self._table.shown[index])
        with self._lock:
            picture = self._recent.get(position)
            if picture is not None:
                return picture
            if position not in self._lost:
                try:
                    picture = self._find(position)
                except (av.error.FFmpegError, OSError):
                    self._let_go()
            if picture is None:
                self._lost.add(position)
                raise MediaError(
                    f"picture {index} cannot be decoded: the video is damaged there", file=self.name
                )
            return picture

    def another(self) -> Video:
        """See `Pictures.another`."""
        other = copy(self)
        other._start()
        return other

    def close(self) -> None:
        """See `Pictures.close`. Reading opens the file again."""
        with self._lock:
            self._recent.clear()
            self._let_go()

    # Reading the file. Everything below is called with the lock held, or while opening.

    def _let_go(self) -> None:
        self._frames, self._at = iter(()), -1
        if self._container is not None:
            self._container.close()
            self._container = None

    def _find(self, index: int) -> Picture | None:
        """Decode the picture, or return None if the decoder does not give it."""
        key = int(np.searchsorted(self._table.keys, index, side="right")) - 1
        key_at = int(self._table.keys[key]) if key >= 0 else 0
        if self._container is not None and (
            key_at <= self._at < index or (not self._table.is_sure and self._at < index)
        ):
            picture, _ = self._forward(index, self._at)
            if picture is not None:
                return picture
        # key pictures further and further back, where a seek lands too late; at last the start
        for number in [key - back for back in (0, 1, 3) if key - back > 0]:
            self._seek(int(self._table.key_seeks[number]))
            picture, was_reached = self._forward(index, int(self._table.keys[number]))
            if was_reached:
                return picture
        self._seek(None)
        return self._forward(index, len(self._table.times))[0]

    def _has_fields(self) -> bool:
        """Whether a decoder makes one picture of two packets, which are the fields of a frame.

        If there are such pairs, they are the packets nearest in time, and the decoder does not give
        the second of a pair. Two pairs are tried, as a picture may be damaged.
        """
        steps = np.diff(self._table.times.astype(np.float64))
        seconds = np.flatnonzero(steps <= _SAME_STEP * steps.min(initial=np.inf))[:4:2] + 1
        try:
            return len(seconds) > 0 and all(
                self._find(position - 1) is not None
                and self._forward(position, position - 1)[0] is None
                for position in map(int, seconds)
            )
        except (MediaError, av.error.FFmpegError, OSError):
            self._let_go()
            return False

    def _seek(self, time: int | None) -> None:
        """Go to a key picture, or with None to the start of the file, which is opened anew."""
        if time is None or self._container is None:
            self._let_go()
            self._container, self._stream = open_container(self._path, self._format, self.name)
        if time is not None:
            self._container.seek(time, stream=self._stream, backward=True)
        self._at, self._frames = -1, decoded(self._container, self._stream)

    def _forward(self, index: int, start: int) -> tuple[Picture | None, bool]:
        """Decode up to the picture.

        Returns the picture, or None, and whether decoding began at `start` or before: if so, the
        decoder does not give a picture that is None.
        """
        n_beyond, is_first = 0, self._at < 0
        for frame in self._frames:
            position = self._position(frame)
            if position is None:
                continue
            if is_first and (position > start or self._is_shifted(frame, position, start)):
                self._at = position
                return None, False
            is_first, self._at = False, max(self._at, position)
            if index - _NEAR < position <= index:
                picture = self._recent.put(position, self._to_array(frame))
                if position == index:
                    return picture, True
            n_beyond += position > index
            if n_beyond > REORDERED:  # a decoder may give a few pictures out of order
                return None, True
        self._let_go()
        return None, not is_first  # none of the times that are listed: a seek has shifted them

    def _is_shifted(self, frame: Any, position: int, start: int) -> bool:
        """Whether the first picture after a seek is another one than its time says.

        A program stream need not give each picture its time. A guess after a seek may differ from
        the guess from the start: then key pictures are where none are listed.
        """
        if self._format != "mpeg" or start == len(self._table.times):  # from the start
            return False
        return not frame.key_frame or position not in self._table.keys

    def _position(self, frame: Any) -> int | None:
        """Return which picture this is, or None if it is not listed."""
        times = self._table.times
        if not self._table.is_sure:
            return self._at + 1 if self._at + 1 < len(times) else None
        if frame.pts is None:
            return None
        position = int(np.searchsorted(times, frame.pts))
        return position if position < len(times) and times[position] == frame.pts else None

    def _to_array(self, frame: Any) -> Picture:
        name = frame.format.name
        pixel_format = "rgb24"
        if name.startswith("gray"):
            pixel_format = "gray" if name == "gray" else "gray16le"
        width, height = self._stream.width, self._stream.height
        check_size(width, height, self.name)  # it may change in the middle of a video
        scaled = self._reformatter.reformat(frame, width, height, pixel_format)
        picture: Picture = scaled.to_ndarray()
        quarters = round(frame.rotation / 90) % 4
        return np.ascontiguousarray(np.rot90(picture, quarters)) if quarters else picture
