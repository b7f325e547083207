"""Which of the numbers in names of pictures is the frame number."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from nvcore.errors import InputError
from nvcore.findings import Remedy, Step

DIGITS: Final = re.compile(r"([0-9]+)")
MAX_DIGITS: Final = 15
"""Frame numbers are exact in every table up to here; a longer number is no frame number."""
TIME_DIGITS: Final = 10
"""A number of so many digits is a time rather than a frame, if there is another number."""
MIN_NAMES: Final = 4
"""Names from which on it is no chance that a number is the same in all, or differs in all."""
MOST_CAMERAS: Final = 8
"""Most cameras whose names stand behind the frame number."""
_SIGNS: Final = "_-. "
"""Signs between the parts of a name."""
_REGULAR_SHARE: Final = 0.5
"""Share of equal steps from which on numbers count frames; times are less even."""
_ENDING: Final = re.compile(r"[_\-. ]+[0-9A-Za-z][0-9A-Za-z_\-. ]*")
"""Name of a camera behind the frame number: ``_left``, ``_cam0``."""


def _before(words: str) -> re.Pattern[str]:
    return re.compile(rf"(?:^|[^A-Za-z])(?:{words})[_\-. ]?$", re.IGNORECASE)


_FRAME: Final = _before("I|img|image|im|frame")
_CAMERA: Final = _before("c|ch|cam|camera|channel|sensor|view")
_RECORDING: Final = _before("clip|drive|run|s|scene|seq|sequence|set|track|v|vid|video")
_STAMP: Final = re.compile(
    r"[_\-. ]?(?<![0-9A-Za-z])(?:"
    r"(?:19|20)\d\d[-_.]?[01]\d[-_.]?[0-3]\d"
    r"(?:[-_.T ]*[0-2]\d[-_.:h]?[0-5]\d[-_.:m]?[0-5]\d(?:[-_.,s]?\d{1,9})?Z?)?"
    r"|[0-2]\d[-.:h][0-5]\d[-.:m][0-5]\d(?:[-_.,s]\d{1,9})?"
    r"|[1-9]\d{9,18}"
    r"|(?=[0-9]*[a-f])(?=[a-f]*[0-9])[0-9a-f]{6,}"
    r")(?![0-9A-Za-z])"
)
"""A date, a time of day or both; a time in ticks; a hash."""
_HASH: Final = re.compile(r"(?=.*[a-f])(?=.*[0-9])[0-9a-f\-]{6,}", re.IGNORECASE)


def likeliest_column(stems: Sequence[Sequence[str]], columns: Iterable[int]) -> int:
    """Return the number with the most different values; of several a short one, the last."""

    def usefulness(column: int) -> tuple[int, bool, int]:
        values = {parts[column].lstrip("0") for parts in stems}
        return len(values), max(map(len, values)) < TIME_DIGITS, column

    return max(columns, key=usefulness)


def frame_columns(stems: Sequence[Sequence[str]], places: Sequence[str] = ()) -> list[int]:
    """Return where the frame number may stand in names, the likeliest place first.

    The frame number increases from picture to picture. A number that all names share is none,
    nor is one of few values beside another with a value for every picture of a camera.

    Parameters
    ----------
    stems
        Texts and numbers of each name in turn, equally many: ``["", "0012", "_cam", "0", ""]``.
    places
        Folder of each name; empty: one folder holds all.

    Returns
    -------
    list of int
        Indices of the parts; several if the names do not tell.
    """
    texts = [
        "/".join([place, *parts[::2]])
        for place, parts in zip(places or [""] * len(stems), stems, strict=True)
    ]
    columns = range(1, len(stems[0]), 2)
    varying = [
        column for column in columns if len({parts[column].lstrip("0") for parts in stems}) > 1
    ]
    if not varying:
        return [columns[-1]]
    before = {column: stems[0][column - 1] for column in columns}
    called = [column for column in {*varying, columns[-1]} if _FRAME.search(before[column])]
    if len(called) == 1:
        return called
    likeliest, last = likeliest_column(stems, varying), varying[-1]
    # longer numbers are no frame numbers, and may be too long to be computed with
    alone = [
        column
        for column in varying
        if len({(text, parts[column]) for text, parts in zip(texts, stems, strict=True)})
        == len(stems)
        and max(len(parts[column].lstrip("0")) for parts in stems) <= MAX_DIGITS
    ]
    if likeliest != last and likeliest not in alone:
        n_last = len({parts[last] for parts in stems})
        if n_last == 2 or _CAMERA.search(before[last]):
            return [likeliest]
        is_last = n_last > MOST_CAMERAS or _RECORDING.search(before[likeliest]) is not None
        return [last] if is_last else [likeliest, last]
    if likeliest != last or not alone:
        return [likeliest]
    even = [column for column in alone if _differ_evenly(stems, column)] or alone
    return even[:1] if _rise_alike(stems, even) else even[::-1]


def _differ_evenly(stems: Sequence[Sequence[str]], column: int) -> bool:
    """Whether most steps between the numbers are equal, as those of frames are."""
    steps = np.diff(sorted({int(parts[column]) for parts in stems})).tolist()
    return Counter(steps).most_common(1)[0][1] >= _REGULAR_SHARE * len(steps)


def _rise_alike(stems: Sequence[Sequence[str]], columns: Sequence[int]) -> bool:
    """Whether the numbers differ by the same amount in all names."""
    return all(
        len({int(parts[column]) - int(parts[columns[0]]) for parts in stems}) == 1
        for column in columns
    )


def frame_last(
    names: Sequence[str], others: Sequence[str], how: str | None
) -> tuple[list[str], tuple[str, ...]]:
    """Return the names with the frame number at the end, and in words which number that is.

    The name of a camera behind the number moves before it; other numbers there are dropped.

    Parameters
    ----------
    names
        Plain names with folders, see `plain_names`.
    others
        Those of the ground truth, so that the files of a system are understood alike.
    how
        See `ReadOptions.frame_names`.

    Raises
    ------
    InputError
        If two numbers may be the frame number, and `how` does not say which.
    """
    every = list(dict.fromkeys([*names, *others]))
    n_hashes = sum(_HASH.fullmatch(name.rpartition("/")[2]) is not None for name in every)
    if 2 * n_hashes >= len(every):  # no number of them counts anything
        return [*names], ()
    new = dict(zip(every, every if how == "numbers" else _without_stamps(every), strict=True))
    groups: dict[int, list[str]] = defaultdict(list)
    for name, bare in new.items():
        groups[len(DIGITS.split(bare.rpartition("/")[2]))].append(name)
    for n_parts, group in sorted(groups.items(), key=lambda item: -len(item[1])):
        folders, _, stems = zip(*(new[name].rpartition("/") for name in group), strict=True)
        split = [DIGITS.split(stem) for stem in stems]
        columns = [n_parts - 2]
        if n_parts > 3 and len(group) >= MIN_NAMES and how != "numbers":
            columns = frame_columns(split, folders)
            if how == "counter":
                columns = [
                    min(columns)
                    if len(columns) > 1
                    else likeliest_column(split, range(1, n_parts - 2, 2))
                ]
        if len(columns) > 1 and not {*names} <= {*others}:
            first, second = (split[0][column] for column in sorted(columns)[:2])
            raise InputError(
                f"the names of pictures do not tell which of their numbers is that of the frame: "
                f"in {stems[0]} it may be {first} or {second}",
                steps=tuple(
                    Step(Remedy.FRAME_NAMES, way) for way in ("counter", "numbers", "order")
                ),
            )
        if n_parts > 1 and (columns[0] < n_parts - 2 or len(group) == len(every)):
            moved = _moved(split, folders, columns[0])
            new |= dict(zip(group, moved, strict=True))
    found = [new[name] for name in names]
    for name, last in zip(names, found, strict=True):
        number = re.search("[0-9]*$", last)
        if number is not None and not name.endswith(number[0]):
            return found, (f"the frame number of {name.rpartition('/')[2]} is {number[0]}",)
    return found, ()


def _without_stamps(names: Sequence[str]) -> list[str]:
    """The names without dates, times of day and hashes, if a number still tells them apart."""
    folders, slashes, stems = zip(*(name.rpartition("/") for name in names), strict=True)
    stamps = [_STAMP.search(stem) for stem in stems]
    bare = [_STAMP.sub("", stem).strip(_SIGNS) for stem in stems]
    without = ["".join(parts) for parts in zip(folders, slashes, bare, strict=True)]
    texts = {stamp[0] for stamp in stamps if stamp is not None}
    are_last = all(
        stamp and stamp.end() == len(stem) for stamp, stem in zip(stamps, stems, strict=True)
    )
    is_told_apart = len(set(without)) == len(names) >= MIN_NAMES and all(map(DIGITS.search, bare))
    is_each = None not in stamps and (are_last or len(texts) > len(names) / 3)
    return without if is_told_apart and is_each else [*names]


def _moved(stems: Sequence[Sequence[str]], folders: Sequence[str], column: int) -> list[str]:
    """The names with what stands behind a number before it, or without it if it is no camera."""
    starts = ["".join(parts[:column]) for parts in stems]
    for earlier in range(1, column, 2):  # a time or a hash is no recording
        word = stems[0][earlier - 1]
        is_each = len({parts[earlier] for parts in stems}) == len(stems) >= MIN_NAMES
        if is_each and not _RECORDING.search(word) and not _CAMERA.search(word):
            starts = [parts[0] for parts in stems]
    numbers, tails = [parts[column] for parts in stems], ["".join(p[column + 1 :]) for p in stems]
    kinds = {*tails}
    is_double = len({*zip(folders, starts, numbers, strict=True)}) < len(stems)
    is_camera = is_double or _CAMERA.search(stems[0][column + 1]) or not _has_digit(tails)
    if kinds == {""} or not is_camera or (len(kinds) == 1 and _has_digit(tails)):
        moved = [f"{start}{number}" for start, number in zip(starts, numbers, strict=True)]
    elif len(kinds) > MOST_CAMERAS or not all(map(_ENDING.fullmatch, kinds)):
        moved = ["".join(parts) for parts in stems]
    else:
        moved = []
        for start, number, tail in zip(starts, numbers, tails, strict=True):
            stem = start + number
            stamp = _STAMP.search(stem)
            at = stamp.start() if stamp and stamp.end() == len(stem) else len(start)
            before, number = stem[:at].rstrip(_SIGNS), stem[at:].lstrip(_SIGNS)
            moved.append(f"{before}{tail}_{number}".lstrip(_SIGNS))
    return [
        f"{folder}/{stem}".removeprefix("/") for folder, stem in zip(folders, moved, strict=True)
    ]


def _has_digit(texts: Iterable[str]) -> bool:
    return any(map(DIGITS.search, texts))
