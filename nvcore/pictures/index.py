"""Map from the frames of a recording to its pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.wording import capitalised, count_text
from nvcore.pictures.base import Pictures
from nvcore.pictures.notes import MAY_MISLEAD, PictureTrait
from nvcore.pictures.video_frames import NOT_WHOLE

NO_FRAMES: Final = np.empty(0, np.int64)
_SAME_SHAPE: Final = 0.02
"""Largest difference of the scales across and down, as sides are whole numbers of pixels."""
_ENOUGH: Final = 0.5
"""Least share of the frames with a number in names that cover all frames but have gaps."""
_NEARLY_ALL: Final = 0.95
_CLEARLY_MORE: Final = 1.5
"""Least ratio of pictures of every frame to listed frames, of which each is a second or fifth."""
_SAME_RATE: Final = 0.005
"""Largest difference of frame rates that are the same, as a share: 29.97 is called 30."""
_TIMES_FROM: Final = 10**9
"""Least number in a name that is rather a time, and times are not even."""


class NumberingRule(Enum):
    """Rule by which the picture of a frame is known, in words."""

    GIVEN = "the first picture shows frame {first_picture}, as given"
    COUNT = "picture i shows frame i, both counted from 0"
    COUNT_FROM_ONE = "picture i, counted from 0, shows frame i + 1: the frames count from 1"
    TIME = "the time of each picture tells its frame, as pictures are missing in the video"
    NUMBER = "the number in a picture's name is the frame"
    NUMBER_LESS_ONE = (
        "the number in a picture's name, minus one, is the frame (names that count from 1)"
    )
    ORDER = "the pictures in their order show the listed frames"
    ORDER_FROM_ZERO = "the pictures in their order show frame 0, 1, 2 and so on"
    UNCLEAR = "which picture shows which frame is not clear, so that none is shown"


USUAL: Final = tuple(
    f"{capitalised(rule.value)}." for rule in (NumberingRule.COUNT, NumberingRule.NUMBER)
)
"""Notes of `map_frames` that say only what anybody expects."""


@dataclass(frozen=True)
class FrameMap:
    """Pictures of the frames of a recording.

    Attributes
    ----------
    index
        Index of the picture of each frame, -1 none; int64, shape (n_frames,).
    is_either
        Whether the numbers in the names fit the frames as well minus one as they are.
    note
        The rule, and how many frames have no picture, for the user.
    """

    index: NDArray[np.int64]
    rule: NumberingRule
    is_either: bool = False
    note: str = ""


def map_frames(
    frames: NDArray[np.int64],
    pictures: Pictures,
    first_picture: int | None = None,
    *,
    others: NDArray[np.int64] = NO_FRAMES,
    fps: float | None = None,
) -> FrameMap:
    """Find the picture of every listed frame.

    The first rule that fits counts:

    1. `first_picture` is given.
    2. A video's picture i shows frame i, or frame i + 1 if the last listed frame is the number of
       pictures. If frames go beyond that number and the times say that pictures are missing, it
       shows the frame of its time.
    3. The number in a picture's name is the frame, or the frame + 1 (names that count from 1), if
       every frame has a picture, or every picture a frame, or pictures that cover the frames lack
       some.
    4. The pictures in their order show the frames, if they are as many.
    5. They show frame 0, 1, 2, ..., if no frame is beyond them, and either their names have no
       numbers or the frames reach to their end.

    Otherwise no frame has a picture.

    Parameters
    ----------
    frames
        Frame numbers of a recording, ascending, shape (n,).
    pictures
        Its pictures.
    first_picture
        Number of the frame that the first picture shows; None: by the rules above.
    others
        Further frames of the recording, so that a selection of frames changes no rule.
    fps
        Frame rate of the recording, 1/s; None: that of the video.
    """
    frames = np.asarray(frames, dtype=np.int64)
    if first_picture is not None:
        by_time = _by_time(frames - first_picture, pictures, fps)
        index = frames - first_picture if by_time is None else by_time
        return _with_note(FrameMap(index, NumberingRule.GIVEN), frames, pictures, first_picture)
    every = np.union1d(frames, others)
    mapped = _of_names(every, pictures.numbers)
    if mapped is None:
        mapped = _of_count(every, pictures)
        by_time = _by_time(every, pictures, fps) if mapped.rule is NumberingRule.COUNT else None
        is_whole = np.all((mapped.index >= 0) & (mapped.index < pictures.n))
        shown = every if len(every) == pictures.n else frames
        if by_time is not None:
            mapped = FrameMap(by_time, NumberingRule.TIME)
        elif not (pictures.is_video and is_whole) and _is_in_order(shown, pictures):
            is_shown = np.isin(every, shown)
            mapped = FrameMap(np.where(is_shown, np.cumsum(is_shown) - 1, -1), NumberingRule.ORDER)
    listed = replace(mapped, index=mapped.index[np.searchsorted(every, frames)])
    return _with_note(listed, frames, pictures)


def _with_note(
    mapped: FrameMap,
    frames: NDArray[np.int64],
    pictures: Pictures,
    first_picture: int | None = None,
) -> FrameMap:
    """Add the note, and drop what is beyond the pictures."""
    rule, index = mapped.rule.value.format(first_picture=first_picture), mapped.index
    if mapped.is_either:
        other = "minus one" if mapped.rule is NumberingRule.NUMBER else "the number itself"
        rule += f" ({other} would do as well: if boxes lag behind, give the first frame)"
    note = f"{capitalised(rule)}."
    index = np.where((index >= 0) & (index < pictures.n), index, -1)
    n_without = int(np.count_nonzero(index < 0))
    if mapped.rule is NumberingRule.UNCLEAR:
        note += f" {capitalised(why_unclear(frames, pictures))}."
    elif n_without:
        note += (
            f" {n_without} of {len(frames)} listed frames have no picture "
            f"({pictures.n} pictures in {pictures.name})."
        )
    for fact in pictures.notes:
        if fact.trait in MAY_MISLEAD:
            note += f" {pictures.name}: {fact.text}."
    return replace(mapped, index=index, note=note)


def why_unclear(frames: NDArray[np.int64], pictures: Pictures) -> str:
    """Say in a clause why pictures and frames do not fit together."""
    there = (
        f"there are {count_text(pictures.n, 'picture')} for {count_text(len(frames), 'frame')} "
        f"({frames[0]} to {frames[-1]})"
    )
    if pictures.numbers is None:
        return f"{there}, and the pictures' names have no numbers"
    numbers = pictures.numbers
    n_hits = np.count_nonzero(np.isin(frames, numbers))
    return (
        f"{there}, and the numbers in the pictures' names ({numbers.min()} to {numbers.max()}) "
        f"are those of {n_hits:,} of these frames"
    )


def _of_names(frames: NDArray[np.int64], numbers: NDArray[np.int64] | None) -> FrameMap | None:
    """Take the number in a name for the frame or the frame + 1, or return None if neither fits."""
    if numbers is None or not len(frames):
        return None
    as_named, less_one = _find(frames, numbers), _find(frames, numbers - 1)
    n_as_named, n_less_one = np.count_nonzero(as_named >= 0), np.count_nonzero(less_one >= 0)
    fits_as_named = _fits(frames, numbers, int(n_as_named))
    fits_less_one = _fits(frames, numbers - 1, int(n_less_one))
    # where both fit alike, frames from 0 and names from 1 are counted differently
    is_either = bool(n_as_named == n_less_one and numbers.min() == 1)
    is_counted = is_either and frames[0] == 0
    if fits_less_one and (n_less_one > n_as_named or is_counted or not fits_as_named):
        return FrameMap(less_one, NumberingRule.NUMBER_LESS_ONE, is_either)
    return FrameMap(as_named, NumberingRule.NUMBER, is_either) if fits_as_named else None


def _fits(frames: NDArray[np.int64], numbers: NDArray[np.int64], n_hits: int) -> bool:
    """Whether numbers of pictures are those of frames, with gaps at the most."""
    if n_hits in (len(frames), len(numbers)):
        return n_hits > 0
    first, last = numbers.min(), numbers.max()
    if first <= frames[0] and frames[-1] <= last:
        n_inside = np.count_nonzero((numbers >= frames[0]) & (numbers <= frames[-1]))
        return n_hits >= max(_ENOUGH * len(frames), _NEARLY_ALL * n_inside)
    step = int(np.median(np.diff(frames))) if len(frames) > 1 else 1
    if first < frames[0] - step or last > frames[-1] + step or len(numbers) <= len(frames):
        return False
    if step > 1 and len(numbers) <= _CLEARLY_MORE * len(frames):
        return False  # they may as well be the listed frames, numbered anew, and a few more
    n_inside = np.count_nonzero((frames >= first) & (frames <= last))
    return n_hits >= max(1, _NEARLY_ALL * n_inside)


def _is_in_order(frames: NDArray[np.int64], pictures: Pictures) -> bool:
    """Whether as many pictures show these frames, without gaps in their numbers that frames lack.

    A video shows every second frame, or fifth, and has no gaps.
    """
    numbers = pictures.numbers
    if len(frames) != pictures.n or not len(frames):
        return False
    if pictures.is_video:
        return _is_even(frames)
    if numbers is None or _is_even(numbers) or numbers.max() >= _TIMES_FROM:
        return True
    steps, wanted = np.diff(numbers), np.diff(frames)
    return bool(np.all(steps * wanted[0] == wanted * steps[0]))


def _of_count(frames: NDArray[np.int64], pictures: Pictures) -> FrameMap:
    """Let picture i show frame i, or i + 1 if the last frame is the number of pictures.

    Single pictures do so if every frame then has one. Where their names have other numbers, the
    frames have to reach to their end.
    """
    n = pictures.n
    if len(frames) and frames[0] >= 1 and frames[-1] == n:
        return FrameMap(frames - 1, NumberingRule.COUNT_FROM_ONE)
    if pictures.is_video:
        return FrameMap(frames.copy(), NumberingRule.COUNT)
    numbers = pictures.numbers
    is_whole = not len(frames) or (frames[0] >= 0 and frames[-1] < n)
    if numbers is not None and len(frames):
        is_other = not np.isin(frames, numbers).any() and _is_even(numbers)
        is_whole = is_whole and is_other and frames[-1] >= _NEARLY_ALL * (n - 1)
    if is_whole:
        return FrameMap(frames.copy(), NumberingRule.ORDER_FROM_ZERO)
    return FrameMap(np.full(len(frames), -1, dtype=np.int64), NumberingRule.UNCLEAR)


def _by_time(
    frames: NDArray[np.int64], pictures: Pictures, fps: float | None
) -> NDArray[np.int64] | None:
    """Find the picture of the time of each frame, or None if times do not count.

    They count if the video misses pictures and frames go beyond the number of pictures: programs
    that count decoded pictures do not come so far, but those that number frames by time do.
    """
    times = pictures.times_s
    if times is None or not any(note.trait is PictureTrait.GAP for note in pictures.notes):
        return None
    rate = pictures.fps
    if fps and not (rate and abs(fps / rate - 1) < _SAME_RATE):  # 30 is said of 29.97
        rate = fps
    if not rate or frames.max(initial=0) < pictures.n:
        return None
    recorded = np.rint(times * rate).astype(np.int64)
    is_whole = (np.abs(times * rate - recorded) <= NOT_WHOLE).all()
    if not is_whole or (np.diff(recorded) < 1).any():
        return None
    counts_from_one = frames.min() >= 1 and frames.max() == recorded[-1] + 1
    return _find(frames - counts_from_one, recorded)


def _is_even(numbers: NDArray[np.int64]) -> bool:
    steps = np.diff(numbers)
    return bool(np.all(steps == steps[:1]))


def _find(frames: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the position of each frame among the numbers, -1 none."""
    return np.asarray(pd.Index(numbers).get_indexer(pd.Index(frames)), dtype=np.int64)


def is_of_other_shape(pictures: Pictures, width: float, height: float) -> bool:
    """Whether the pictures have another aspect ratio than the recording."""
    return abs(pictures.width / width / (pictures.height / height) - 1) > _SAME_SHAPE


def size_note(pictures: Pictures, width: float, height: float) -> str:
    """Note that the pictures have another size than their recording, or return an empty text."""
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
