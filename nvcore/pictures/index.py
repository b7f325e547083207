"""Which picture shows which frame."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.pictures.base import Pictures, PictureTrait
from nvcore.pictures.timing import NOT_WHOLE

_BY_COUNT: Final = "picture i shows frame i, both counted from 0"
_BY_TIME: Final = "the time of each picture tells its frame, as pictures are missing in the video"
_BY_NAME: Final = "the number in a picture's name is the frame"
NO_FRAMES: Final = np.empty(0, np.int64)
USUAL: Final = tuple(f"{rule[0].upper()}{rule[1:]}." for rule in (_BY_COUNT, _BY_NAME))
"""Notes of `picture_index` that say nothing but what anybody expects."""
_SAME_SHAPE: Final = 0.02
"""By so much the scales across and down may differ: sides are whole numbers of pixels."""
_SAME_RATE: Final = 0.005
_ENOUGH: Final = 0.5
"""Share of the frames, or of the pictures, from which on numbers in names are believed."""


def picture_index(
    frames: NDArray[np.int64],
    pictures: Pictures,
    first_picture: int | None = None,
    *,
    others: NDArray[np.int64] = NO_FRAMES,
    fps: float | None = None,
) -> tuple[NDArray[np.int64], str]:
    """The picture of every listed frame, and in words by which rule.

    In this order: `first_picture`; a video's picture i shows frame i, or frame i + 1 where the last
    listed frame is the number of pictures, or, where frames go beyond that number and the times say
    that pictures are missing, the frame of its time; the number in a picture's name is the frame,
    or the frame + 1 (names that count from 1), if so every listed frame has a picture, or else at
    least half of the frames or pictures find each other; the pictures in their order show the
    listed frames if they are as many, or else frame 0, 1, 2, ...

    Parameters
    ----------
    frames
        Frame numbers of a recording, shape (n,).
    pictures
        Its pictures.
    first_picture
        Number of the frame that the first picture shows; None: by the rules above.
    others
        Further frames of the recording, which are not listed: a selection of frames changes no
        rule.
    fps
        Frame rate of the recording, 1/s; None: that of the video.

    Returns
    -------
    tuple
        Index of the picture, -1 none, int64, shape (n,); and a note for the user.
    """
    frames = np.asarray(frames, dtype=np.int64)
    if first_picture is not None:
        index = frames - first_picture
        rule = f"the first picture shows frame {first_picture}, as given"
        if pictures.is_video:
            by_time = _by_time(frames - first_picture, pictures, fps)
            index, rule = (index, rule) if by_time is None else (by_time, f"{rule}; {_BY_TIME}")
    else:
        every = np.union1d(frames, others)
        if pictures.is_video:
            index, rule = _of_video(every, pictures, fps)
        elif pictures.numbers is not None:
            index, rule = _by_number(every, pictures.numbers)
        else:
            index, rule = _by_order(every, pictures.n)
        index = index[np.searchsorted(every, frames)]
    index = np.where((index >= 0) & (index < pictures.n), index, -1)
    n_without = int(np.count_nonzero(index < 0))
    note = f"{rule[0].upper()}{rule[1:]}."
    if n_without:
        note += (
            f" {n_without} of {len(frames)} listed frames have no picture "
            f"({pictures.n} pictures in {pictures.name})."
        )
    if pictures.note:
        note += f" {pictures.name}: {pictures.note}."
    return index, note


def _of_video(
    frames: NDArray[np.int64], pictures: Pictures, fps: float | None
) -> tuple[NDArray[np.int64], str]:
    """Frames that count from 1 to the number of pictures are those of a video counted from 1."""
    if len(frames) and frames.min() >= 1 and frames.max() == pictures.n:
        return frames - 1, "picture i, counted from 0, shows frame i + 1: the frames count from 1"
    by_time = _by_time(frames, pictures, fps)
    return (frames.copy(), _BY_COUNT) if by_time is None else (by_time, _BY_TIME)


def _by_time(
    frames: NDArray[np.int64], pictures: Pictures, fps: float | None
) -> NDArray[np.int64] | None:
    """Picture of the time of each frame; None: the video misses none, or frames do not go so far.

    Frames that a video lacks are counted by whoever numbers frames by time, or as they were
    recorded; programs that count decoded pictures do not come to a number beyond these.
    """
    rate, times = pictures.fps, pictures.times_s
    if fps and not (rate and abs(fps / rate - 1) < _SAME_RATE):  # 30 is said of 29.97
        rate = fps
    has_gap = any(note.trait is PictureTrait.GAP for note in pictures.notes)
    if times is None or not rate or not has_gap or frames.max(initial=0) < pictures.n:
        return None
    recorded = np.rint(times * rate).astype(np.int64)
    is_whole = (np.abs(times * rate - recorded) <= NOT_WHOLE).all()
    if not is_whole or (np.diff(recorded) < 1).any():
        return None
    counts_from_one = frames.min() >= 1 and frames.max() == recorded[-1] + 1
    return _find(frames - counts_from_one, recorded)


def _by_number(
    frames: NDArray[np.int64], numbers: NDArray[np.int64]
) -> tuple[NDArray[np.int64], str]:
    """The number in a name is the frame, or the frame + 1; by order where too few match."""
    as_named, one_based = _find(frames, numbers), _find(frames, numbers - 1)
    n_as_named, n_one_based = np.count_nonzero(as_named >= 0), np.count_nonzero(one_based >= 0)
    enough = _ENOUGH * min(len(frames), len(numbers))
    n_best = max(n_as_named, n_one_based)
    if n_best and n_best >= enough:
        if n_as_named < n_one_based:
            return one_based, (
                "the number in a picture's name, less one, is the frame (names that count from 1)"
            )
        rule = _BY_NAME
        if n_as_named == n_one_based:
            rule += " (less one would do as well: if boxes lag behind, give the first frame)"
        return as_named, rule
    return _by_order(frames, len(numbers))


def _by_order(frames: NDArray[np.int64], n: int) -> tuple[NDArray[np.int64], str]:
    """As many pictures as listed frames show these; else they show 0, 1, 2 and so on."""
    if len(frames) == n:
        return np.arange(n), "the pictures in their order show the listed frames"
    return frames.copy(), "the pictures in their order show frame 0, 1, 2 and so on"


def _find(frames: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Position of each frame among the numbers, -1 none."""
    return np.asarray(pd.Index(numbers).get_indexer(pd.Index(frames)), dtype=np.int64)


def is_of_other_shape(pictures: Pictures, width: float, height: float) -> bool:
    """Whether width and height of the pictures are in another proportion than a recording's."""
    return abs(pictures.width / width / (pictures.height / height) - 1) > _SAME_SHAPE


def size_note(pictures: Pictures, width: float, height: float) -> str:
    """What to say of pictures of another size than their recording's; empty: the same size.

    Boxes are drawn scaled to the picture.
    """
    if (pictures.width, pictures.height) == (width, height):
        return ""
    note = (
        f"The pictures are {pictures.width} x {pictures.height} px, the recording is "
        f"{width:g} x {height:g} px: boxes are drawn scaled"
    )
    if is_of_other_shape(pictures, width, height):
        across, down = pictures.width / width, pictures.height / height
        note += f", by {across:.3g} across and {down:.3g} down; check that they belong together"
    return note + "."
