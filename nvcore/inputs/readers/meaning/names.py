"""Parse recording, and frame number or time, from names of files and pictures."""

from __future__ import annotations

import os
import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile
from pathlib import PurePosixPath
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.file_kinds import unpacked_name
from nvcore.common.findings import Remedy, Step
from nvcore.common.wording import listed

_PICTURE: Final = "jpe?g|png|bmp|tiff?|webp|avif|heic|ppm|pgm"
_VIDEO: Final = "mp4|avi|mov|mkv|webm|m4v|mpe?g|wmv|ts"
_ENDINGS = re.compile(
    rf"(?:\.(?:{_PICTURE}))?\.(?:txt|xml|json|csv|tsv|gz|{_PICTURE})$|\.[A-Za-z]{{2,4}}$",
    re.IGNORECASE,
)
_ROBOFLOW = re.compile(
    rf"(?:(?:[_\-.](?:{_PICTURE}))*\.rf\.[0-9A-Za-z_\-]{{6,}}|(?<=\d)[_\-](?:{_PICTURE}))$",
    re.IGNORECASE,
)
"""``drive_mp4-0031_jpg.rf.0123456789abcdef0123456789abcdef``, or with a shorter id."""
_COPY = re.compile(
    r"(?<=\d)(?: ?\(\d{1,2}\)| ?- ?(?:Copy|Kopie)(?: ?\(\d+\))?|[ _]copy)$", re.IGNORECASE
)
_KIND = re.compile(
    r"(?<=\d)"
    r"(?:[_\-.](?:leftImg8bit(?:_\w+)?|gt(?:Fine|Coarse|Bbox)\w*|lwir|visible|rgb|thermal))+$",
    re.IGNORECASE,
)
"""Words of Cityscapes and cameras that often only one side has."""
_SIZE = re.compile(r"(?<=\d)[_\-]\d{3,4}x\d{3,4}$")
"""Size in the name of a resized picture: ``frame_0012_640x480``."""
_OF_VIDEO = re.compile(rf"[_.](?:{_VIDEO})(?=[-_. ]?(?:frame|f)?[-_. ]?\d+$)", re.IGNORECASE)
_FLIR = re.compile(r"(?:^|.*/)video-(?P<video>[^/]+?)-frame-(?P<frame>\d+)(?:[-.][^/]*)?$")
_WORDS = re.compile(r"(?:[_\-. ][A-Za-z]+\d{0,2}[A-Za-z]*)+|[A-Za-z]+")
"""Possible common endings: ``_det``, ``.left_eye``, ``_cam2``, but not ``_I00019``."""
_LABEL_STUDIO = re.compile(r"^[0-9a-f]{8}-(?=.*\d)")
MIN_NAMES: Final = 4
"""Smallest number of names for a common ending that contains a number."""


@lru_cache(maxsize=1 << 15)  # lists of pictures are processed several times
def plain_name(name: str) -> str:
    """Return folders and stem of a picture's name, without additions by tools.

    Examples
    --------
    >>> plain_name("labels/drive_mp4-0031_jpg.rf.0123456789abcdef0123456789abcdef.txt")
    'labels/drive-0031'
    >>> plain_name("video-BzZs-frame-000123-Xk9.jpg"), plain_name("V000/I00019_lwir.png")
    ('BzZs/000123', 'V000/I00019')
    """
    name = unpacked_name(name.replace("\\", "/"))
    flir = _FLIR.match(name)
    if flir is not None:
        return f"{flir['video']}/{flir['frame']}"
    folders, slash, last = name.rpartition("/")
    stem, before = _ENDINGS.sub("", last), ""
    while stem != before:  # repeated exports add endings repeatedly
        before = stem
        for added in (_ROBOFLOW, _COPY, _KIND, _SIZE):
            stem = added.sub("", stem) or stem
    return folders + slash + _OF_VIDEO.sub("", stem)


def plain_names(names: Sequence[str]) -> tuple[list[str], str]:
    """Return `plain_name` of each name, without their common ending, and the ending."""
    plain = [name if name.isdecimal() else plain_name(name) for name in names]
    parts = [name.rpartition("/") for name in plain]
    stems = [stem for *_, stem in parts]
    is_stamped = len(plain) > 1 and all(map(_LABEL_STUDIO.match, stems))
    if is_stamped and len({stem[:8] for stem in stems}) > len(plain) / 2:  # not a date
        stems = [stem[9:] for stem in stems]
        plain = [folders + slash + stem[9:] for folders, slash, stem in parts]
    taken = _common_ending({*stems})
    return ([name[: -len(taken)] for name in plain] if taken else plain), taken


_shared_start: Final = os.path.commonprefix
"""Function that returns the common beginning of texts, letter by letter."""


def _common_ending(stems: set[str]) -> str:
    """Return the last words of the names if all end in them, after a number."""
    if len(stems) < 2:
        return ""
    shared = _shared_start([stem[::-1] for stem in stems])[::-1]
    for start in range(len(shared)):  # the longest first
        words = shared[start:]
        if (
            _WORDS.fullmatch(words)
            and (len(stems) >= MIN_NAMES or not any(map(str.isdecimal, words)))
            and all(stem[: -len(words)][-1:].isdecimal() for stem in stems)
        ):
            return words
    return ""


def common_beginning(stems: Sequence[str]) -> str:
    """Return the common beginning of the stems, up to the first number that differs."""
    return _shared_start(stems).rstrip("0123456789")


NEUTRAL = {
    *("gt", "truth", "det", "dets", "detections", "results", "result", "res"),
    *("labels", "label", "label_2", "label_02", "annotations", "annotation"),
    *("data", "images", "image_2", "img1", "xml", "txt"),
    *("", "/", ".", ".."),
}
_FRAME = re.compile(
    r"^(?P<prefix>.*?)(?:(?<![A-Za-z])(?:I|img|image|im|frame|f)[_\-. ]?)?(?P<digits>[0-9]+)$",
    re.IGNORECASE,
)
ONLY: Final = "recording"
"""Name of a recording without a name."""
MAX_DIGITS: Final = 15
"""Most digits of a frame number, which every table stores exactly."""


def recording_of(name: str, known: tuple[str, ...] = ()) -> str:
    """Return the recording of a file that holds one whole recording.

    It is the known recording that parts of the path name, nearest to the file first. Otherwise it
    is the nearest part that is not a neutral word such as ``gt``.

    Examples
    --------
    >>> recording_of("mot15/TUD-Campus/gt/gt.txt")
    'TUD-Campus'
    >>> recording_of("mot15/TUD-Campus/det_frcnn/det.txt", known=("TUD-Campus",))
    'TUD-Campus'
    >>> recording_of("MBNet/set06/V000.txt", known=("set06/V000", "set07/V000"))
    'set06/V000'
    """
    path = PurePosixPath(unpacked_name(name))
    parts = (*path.parts[:-1], path.stem)
    recording = known_recording(parts, known)
    if recording is not None:
        return recording
    named = [part for part in parts if part.lower() not in NEUTRAL]
    return named[-1] if named else path.stem


@lru_cache(maxsize=4096)
def known_recording(parts: tuple[str, ...], known: tuple[str, ...]) -> str | None:
    """Find the known recording that one or more adjacent parts of a path name, or return None.

    Parts nearest to the end take precedence, then the longest run. The name ``set06_V000`` also
    matches a recording ``set06/V000``.
    """
    spellings = {name.replace("/", "_"): name for name in known} | {name: name for name in known}
    for end in range(len(parts), 0, -1):
        for start in range(end):
            recording = spellings.get("/".join(parts[start:end]))
            if recording is not None:
                return recording
    return None


def recordings_of(
    names: Sequence[str], known: tuple[str, ...] = (), *, stated: Sequence[str | None] | None = None
) -> tuple[list[str], list[str]]:
    """Return the recordings of files that hold one whole recording each.

    A known recording in the path takes precedence over the name that the data state. A single file
    is the recording if only one is known and the data do not state another.

    Parameters
    ----------
    names
        File names as in `SourceFile.name`.
    known
        Recordings of the ground truth, if this is not the ground truth.
    stated
        Recording that the data state for each file, or None.

    Returns
    -------
    tuple of list of str
        Recordings, one per file, and assumptions, for the conversion text.

    Raises
    ------
    InputError
        If two files belong to one recording.
    """
    recordings, facts = [], []
    for name, own in zip(names, stated or [None] * len(names), strict=True):
        recording = recording_of(name, known)
        if recording not in known and own is not None:
            recording = own
        elif recording not in known and len(names) == len(known) == 1:
            recording = known[0]
            facts.append(f"the only file taken for the only recording, {recording!r}")
        recordings.append(recording)
    first: dict[str, str] = {}
    for name, recording in zip(names, recordings, strict=True):
        if recording in first:
            folders = _folders_apart(names, first[recording], name)
            advice = (
                f"the folders {listed(folders)} look like one system each: give a system only the "
                "files of its own folder (a pattern, or an archive of these alone)"
                if folders and known
                else "name the files or their folders by the recordings, or give one of the two"
            )
            raise InputError(
                f"holds recording {recording!r}, as {first[recording]} does; expected one file "
                f"per recording: {advice}",
                file=name,
            )
        first[recording] = name
    return recordings, facts


def _folders_apart(names: Sequence[str], one: str, other: str) -> list[str]:
    """Return the folders at the only position where two paths differ, for equally long paths.

    Examples
    --------
    >>> _folders_apart(["A/frcnn/det.txt", "A/sdp/det.txt"], "A/frcnn/det.txt", "A/sdp/det.txt")
    ['frcnn', 'sdp']
    """
    parts, others = one.split("/"), other.split("/")
    places = [at for at, pair in enumerate(zip(parts, others, strict=False)) if len({*pair}) > 1]
    if len(parts) != len(others) or len(places) != 1 or places[0] == len(parts) - 1:
        return []
    paths = [name.split("/") for name in names]
    return sorted({path[places[0]] for path in paths if len(path) == len(parts)})


def recording_and_frame_of(name: str, known: tuple[str, ...] = ()) -> tuple[str, int] | None:
    """Parse the recording and frame number of a file of one frame, or return None without one.

    The number at the end of the file's stem is the frame. The folders and the text before the
    number are the recording, or the known recording that they name. Neutral folders (``labels``,
    ``annotations``) do not count.

    Examples
    --------
    >>> recording_and_frame_of("set06/V000/I00019.txt")
    ('set06/V000', 19)
    >>> recording_and_frame_of("labels/0016_000007.png")
    ('0016', 7)
    >>> recording_and_frame_of("out/yolo/set06_V000_I00019.txt", known=("set06/V000",))
    ('set06/V000', 19)
    """
    path = PurePosixPath(unpacked_name(name))
    return place_of_stem(path.parts[:-1], path.stem, known)


def place_of_stem(
    folders: Sequence[str], stem: str, known: tuple[str, ...] = ()
) -> tuple[str, int] | None:
    """Do the same as `recording_and_frame_of`, given the folders and the stem."""
    match = _FRAME.match(stem)
    if match is None or len(match["digits"].lstrip("0")) > MAX_DIGITS:
        return None
    return recording_before(folders, match["prefix"], known), int(match["digits"])


def recording_before(folders: Sequence[str], prefix: str, known: tuple[str, ...] = ()) -> str:
    """Return the recording that folders and the text before a frame's number or time name."""
    own = [*filter(None, [prefix.rstrip("_-. ")])]
    parts = [*(part for part in folders if part.lower() not in NEUTRAL), *own]
    return known_recording((*folders, *own), known) or "/".join(parts) or ONLY


DIGITS: Final = re.compile(r"([0-9]+)")
TIME_DIGITS: Final = 10
"""Number of digits from which on a number is a time, if there is another number."""
MOST_CAMERAS: Final = 8
"""Largest number of cameras whose names follow the frame number."""
_SIGNS: Final = "_-. "
"""Signs between the parts of a name."""
_REGULAR_SHARE: Final = 0.5
"""Share of equal steps from which on numbers count frames, since times are less even."""
_ENDING: Final = re.compile(r"[_\-. ]+[0-9A-Za-z][0-9A-Za-z_\-. ]*")
"""Name of a camera after the frame number: ``_left``, ``_cam0``."""


def _before(words: str) -> re.Pattern[str]:
    return re.compile(rf"(?:^|[^A-Za-z])(?:{words})[_\-. ]?$", re.IGNORECASE)


_FRAME_WORD: Final = _before("I|img|image|im|frame")
_CAMERA_WORD: Final = _before("c|ch|cam|camera|channel|sensor|view")
_RECORDING_WORD: Final = _before("clip|drive|run|s|scene|seq|sequence|set|track|v|vid|video")
_STAMP: Final = re.compile(
    r"[_\-. ]?(?<![0-9A-Za-z])(?:"
    r"(?:19|20)\d\d[-_.]?[01]\d[-_.]?[0-3]\d"
    r"(?:[-_.T ]*[0-2]\d[-_.:h]?[0-5]\d[-_.:m]?[0-5]\d(?:[-_.,s]?\d{1,9})?Z?)?"
    r"|[0-2]\d[-.:h][0-5]\d[-.:m][0-5]\d(?:[-_.,s]\d{1,9})?"
    r"|[1-9]\d{9,18}"
    r"|(?=[0-9]*[a-f])(?=[a-f]*[0-9])[0-9a-f]{6,}"
    r")(?![0-9A-Za-z])"
)
"""A date, a time of day or both, a time in ticks, or a hash."""
_ONE_NUMBER: Final = re.compile(r"(?:.*/)?[^0-9/]*[0-9]{1,9}")
_HASH: Final = re.compile(r"(?=.*[a-f])(?=.*[0-9])[0-9a-f\-]{6,}", re.IGNORECASE)


def likeliest_column(stems: Sequence[Sequence[str]], columns: Iterable[int]) -> int:
    """Return the column with the most distinct values, preferring short numbers, then the last."""

    def usefulness(column: int) -> tuple[int, bool, int]:
        values = {parts[column].lstrip("0") for parts in stems}
        return len(values), max(map(len, values)) < TIME_DIGITS, column

    return max(columns, key=usefulness)


def frame_columns(stems: Sequence[Sequence[str]], places: Sequence[str] = ()) -> list[int]:
    """Return possible positions of the frame number in names, the most likely one first.

    The frame number increases from picture to picture. It is not a number that all names share,
    nor one of few values if another number has a value for every picture of a camera.

    Parameters
    ----------
    stems
        Alternating texts and numbers of each name, equally many: ``["", "0012", "_cam", "0", ""]``.
    places
        Folder of each name. Empty: all are in one folder.

    Returns
    -------
    list of int
        Indices of the parts, several if the names are ambiguous.
    """
    texts = [
        "/".join([place, *parts[::2]])
        for place, parts in zip(places or [""] * len(stems), stems, strict=True)
    ]
    columns = range(1, len(stems[0]), 2)
    values = {column: {parts[column].lstrip("0") for parts in stems} for column in columns}
    varying = [column for column in columns if len(values[column]) > 1]
    if not varying:
        return [columns[-1]]
    before = {column: stems[0][column - 1] for column in columns}
    called = [column for column in {*varying, columns[-1]} if _FRAME_WORD.search(before[column])]
    if len(called) == 1:
        return called
    likeliest, last = likeliest_column(stems, varying), varying[-1]
    # longer numbers are no frame numbers, and may be too large for arithmetic
    alone = [
        column
        for column in varying
        if len({(text, parts[column]) for text, parts in zip(texts, stems, strict=True)})
        == len(stems)
        and max(map(len, values[column])) <= MAX_DIGITS
    ]
    if likeliest != last and likeliest not in alone:
        n_last = len({parts[last] for parts in stems})
        if n_last == 2 or _CAMERA_WORD.search(before[last]):
            return [likeliest]
        is_last = n_last > MOST_CAMERAS or _RECORDING_WORD.search(before[likeliest]) is not None
        return [last] if is_last else [likeliest, last]
    if likeliest != last or not alone:
        return [likeliest]
    numbers = {column: np.array([int(parts[column]) for parts in stems]) for column in alone}
    even = []  # as frames: most steps are equal
    for column, number in numbers.items():
        steps = np.diff(np.unique(number))
        if np.unique(steps, return_counts=True)[1].max() >= _REGULAR_SHARE * len(steps):
            even.append(column)
    even = even or alone
    differ_alike = all(not np.ptp(numbers[column] - numbers[even[0]]) for column in even)
    return even[:1] if differ_alike else even[::-1]


def frame_last(
    names: Sequence[str], others: Sequence[str], how: str | None
) -> tuple[list[str], tuple[str, ...]]:
    """Return the names with the frame number at the end, and describe the number.

    The name of a camera after the number moves before it. Other numbers there are dropped.

    Parameters
    ----------
    names
        Plain names with folders (see `plain_names`).
    others
        Names of the ground truth, so that a system's files are interpreted alike.
    how
        See `ReadOptions.frame_names`.

    Raises
    ------
    InputError
        If two numbers may be the frame number, and `how` does not decide.
    """
    if all(map(_ONE_NUMBER.fullmatch, names)):
        return [*names], ()
    every = list(dict.fromkeys([*names, *others]))
    n_hashes = sum(_HASH.fullmatch(name.rpartition("/")[2]) is not None for name in every)
    if 2 * n_hashes >= len(every):  # names are mostly hashes, whose numbers count nothing
        return [*names], ()
    bare = every if how == "numbers" else _without_stamps(every)
    new = dict(zip(every, bare, strict=True))
    groups: dict[int, list[tuple[str, str, list[str]]]] = defaultdict(list)
    for name, stripped in new.items():
        folder, _, stem = stripped.rpartition("/")
        parts = DIGITS.split(stem)
        groups[len(parts)].append((name, folder, parts))
    for n_parts, group in groups.items():
        own_names, folders, split = zip(*group, strict=True)
        columns = [n_parts - 2]
        if n_parts > 3 and len(group) >= MIN_NAMES and how != "numbers":
            columns = frame_columns(split, folders)
            if how == "counter":
                column = min(columns)
                is_last = column == n_parts - 2
                columns = [likeliest_column(split, range(1, column, 2)) if is_last else column]
        if len(columns) > 1 and not {*names} <= {*others}:
            first, second = (split[0][column] for column in sorted(columns)[:2])
            raise InputError(
                f"the names of pictures do not tell which of their numbers is that of the frame: "
                f"in {''.join(split[0])} it may be {first} or {second}",
                steps=tuple(
                    Step(Remedy.FRAME_NAMES, way) for way in ("counter", "numbers", "order")
                ),
            )
        if n_parts > 1 and (columns[0] < n_parts - 2 or len(group) == len(every)):
            new |= dict(zip(own_names, _moved(split, folders, columns[0]), strict=True))
    found = [new[name] for name in names]
    for name, last in zip(names, found, strict=True):
        number = re.search("[0-9]*$", last)
        if number is not None and not name.endswith(number[0]):
            return found, (f"the frame number of {name.rpartition('/')[2]} is {number[0]}",)
    return found, ()


def _without_stamps(names: Sequence[str]) -> list[str]:
    """Remove dates, times of day and hashes, if a number still distinguishes the names."""
    folders, slashes, stems = zip(*(name.rpartition("/") for name in names), strict=True)
    if len(names) < MIN_NAMES or _STAMP.search(stems[0]) is None:
        return [*names]
    stamps = [match[0] for stem in stems if (match := _STAMP.search(stem)) is not None]
    if len(stamps) < len(names):
        return [*names]
    bare = [_STAMP.sub("", stem).strip(_SIGNS) for stem in stems]
    without = ["".join(parts) for parts in zip(folders, slashes, bare, strict=True)]
    are_last = all(map(str.endswith, stems, stamps))
    is_of_each = are_last or len({*stamps}) > len(names) / 3
    is_told_apart = len({*without}) == len(names) and all(map(DIGITS.search, bare))
    return without if is_of_each and is_told_apart else [*names]


def _moved(stems: Sequence[Sequence[str]], folders: Sequence[str], column: int) -> list[str]:
    """Move a camera after the frame number to its front, and drop other text after the number."""
    starts = ["".join(parts[:column]) for parts in stems]
    for earlier in range(1, column, 2):  # a time or a hash is no recording
        word = stems[0][earlier - 1]
        is_each = len({parts[earlier] for parts in stems}) == len(stems) >= MIN_NAMES
        if is_each and not _RECORDING_WORD.search(word) and not _CAMERA_WORD.search(word):
            starts = [parts[0] for parts in stems]
    numbers, tails = [parts[column] for parts in stems], ["".join(p[column + 1 :]) for p in stems]
    kinds = {*tails}
    is_double = len({*zip(folders, starts, numbers, strict=True)}) < len(stems)
    is_camera = is_double or _CAMERA_WORD.search(stems[0][column + 1]) or not _has_digit(tails)
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


LEAST_TIME: Final = 10**9
"""Smallest whole number that is a time rather than a frame (ten digits)."""
LEAST_STEP: Final = 4
"""Smallest usual step of shorter numbers that can be times: milliseconds at 250 Hz."""
_SECONDS = re.compile(
    r"(?P<prefix>.*?)(?<!\d)(?P<whole>[1-9]\d{9})(?P<sign>[._\-])(?P<part>\d{3,9})$"
)
_TICKS = re.compile(r"(?P<prefix>.*?)(?<!\d)0*(?P<whole>[1-9]\d{9,18})$")
_SHORT_TICKS = re.compile(r"(?P<prefix>.*?)(?P<whole>\d{1,18})$")
_DATE = re.compile(
    r"(?P<prefix>.*?)(?<!\d)(?P<year>(?:19|20)\d\d)[-_.]?(?P<month>\d\d)[-_.]?(?P<day>\d\d)"
    r"[-_.T ]*(?P<hour>\d\d)[-_.:h]?(?P<minute>\d\d)[-_.:m]?(?P<second>\d\d)"
    r"(?:[-_.,s]?(?P<part>\d{1,9}))?Z?$"
)
_UNITS: Final = {"seconds": 10**9, "milliseconds": 10**6, "microseconds": 10**3, "nanoseconds": 1}
"""Nanoseconds per unit."""
_EPOCH: Final = (10**9, 22 * 10**8)
"""Range of seconds since 1970 for the years 2001 to 2039."""
RATES: Final = (0.05, 300.0)
"""Range of plausible frame rates of a camera, 1/s."""
_USUAL_RATES: Final = np.array([*range(1, 301), 7.5, 12.5, 23.976, 29.97, 59.94, 119.88])
_SNAP: Final = 0.005
_JITTER: Final = 0.3
"""Largest deviation of steps between pictures from whole periods, in periods ..."""
_EVEN_SHARE: Final = 0.9
"""... for this share of the steps."""
_NEAR_STEPS: Final = 3
"""Longest step, in periods, that is compared with the period, whose error adds up."""


@dataclass(frozen=True)
class NamedTimes:
    """Times of pictures by their names.

    Attributes
    ----------
    prefix
        Text before the time in each name.
    ns
        Nanoseconds since 1970 or any other moment, int64, shape (n,).
    unit
        Name of the unit: "milliseconds".
    """

    prefix: list[str]
    ns: np.ndarray
    unit: str


def times_in(stems: Sequence[str], *, is_stated: bool = False) -> NamedTimes | None:
    """Parse the times at the end of all names, or return None if they are not plausible.

    Numbers of fewer than ten digits are times only if the user says so (`is_stated`).

    Examples
    --------
    >>> times = times_in(["a_1598000000123", "a_1598000000223", "a_1598000000323"])
    >>> times.prefix[0], np.diff(times.ns).tolist(), times.unit
    ('a_', [100000000, 100000000], 'milliseconds')
    """
    ways = ((_SECONDS, _of_seconds), (_TICKS, _of_ticks), (_DATE, _of_dates))
    for pattern, read in (*ways, *[(_SHORT_TICKS, _of_ticks)] * is_stated):
        matches = [match for match in takewhile(bool, map(pattern.match, stems)) if match]
        if len(matches) == len(stems) > 0:
            times = read(matches, [match["prefix"] for match in matches])
            if times is not None:
                return times
    return None


def _of_seconds(matches: Sequence[re.Match[str]], prefix: list[str]) -> NamedTimes | None:
    # digits after a point are a fraction, but other nanoseconds may lack leading zeros
    is_fraction = matches[0]["sign"] == "." or len({len(match["part"]) for match in matches}) == 1
    parts = [match["part"].ljust(9, "0") if is_fraction else match["part"] for match in matches]
    whole = np.array([int(match["whole"]) for match in matches], np.int64)
    ns = whole * 10**9 + np.array([*map(int, parts)], np.int64)
    is_time = whole.max() < _EPOCH[1] and _is_plausible(ns, prefix)
    return NamedTimes(prefix, ns, "seconds and their fractions") if is_time else None


def _of_ticks(matches: Sequence[re.Match[str]], prefix: list[str]) -> NamedTimes | None:
    ticks = [int(match["whole"]) for match in matches]
    return times_of_numbers(np.array(ticks, np.int64), prefix) if max(ticks) < 2**63 else None


def times_of_numbers(numbers: np.ndarray, prefix: list[str]) -> NamedTimes | None:
    """Convert large numbers to times, in the unit that gives a plausible frame rate.

    Parameters
    ----------
    numbers
        int64 or float64, shape (n,).
    prefix
        Text before each number. Different prefixes are different recordings.
    """
    low, high = numbers.min(), numbers.max()
    for unit, ns in _UNITS.items():
        per_second = 10**9 // ns
        if low >= _EPOCH[0] * per_second and high < _EPOCH[1] * per_second:
            since_1970 = _in_ns(numbers, ns)
            if _is_plausible(since_1970, prefix):
                return NamedTimes(prefix, since_1970, unit)
    step = _usual_step(numbers, prefix)
    if step is None or (high < LEAST_TIME and step < LEAST_STEP):
        return None
    # counted from some start: use the unit with a plausible rate that is nearest to 10 Hz
    rate = {unit: 1e9 / (step * ns) for unit, ns in _UNITS.items()}
    unit = min(rate, key=lambda name: abs(np.log10(rate[name] / 10)))
    if not RATES[0] <= rate[unit] <= RATES[1] or float(high) * _UNITS[unit] >= 2**63:
        return None
    return NamedTimes(prefix, _in_ns(numbers, _UNITS[unit]), unit)


def _in_ns(numbers: np.ndarray, ns: int) -> np.ndarray:
    if numbers.dtype.kind == "f":
        numbers, ns = np.rint(numbers * ns), 1
    whole: np.ndarray = numbers.astype(np.int64)
    return whole * ns


def _of_dates(matches: Sequence[re.Match[str]], prefix: list[str]) -> NamedTimes | None:
    names = ("year", "month", "day", "hour", "minute", "second")
    columns = {name: [int(match[name]) for match in matches] for name in names}
    moments = pd.to_datetime(pd.DataFrame(columns), errors="coerce")
    if moments.isna().any():
        return None
    parts = np.array([int((match["part"] or "").ljust(9, "0")) for match in matches], np.int64)
    ns = moments.to_numpy().astype("datetime64[ns]").astype(np.int64) + parts
    return NamedTimes(prefix, ns, "date and time") if _is_plausible(ns, prefix) else None


def _usual_step(numbers: np.ndarray, prefix: list[str]) -> float | None:
    """Return the usual step between neighbours of one prefix, or None without neighbours."""
    table = pd.DataFrame({"prefix": prefix, "number": numbers}).drop_duplicates()
    steps = table.sort_values("number").groupby("prefix")["number"].diff().dropna()
    return None if steps.empty else float(steps.quantile(0.25))


def _is_plausible(ns: np.ndarray, prefix: list[str]) -> bool:
    """Whether the frame rate of times is plausible. True if there is no step to judge it by."""
    step = _usual_step(ns, prefix)
    return step is None or RATES[0] <= 1e9 / step <= RATES[1]


def frames_by_times(ns: np.ndarray) -> tuple[np.ndarray, float, bool]:
    """Return the frame number of each time, from 0, with gaps for missing pictures.

    Parameters
    ----------
    ns
        Sorted, unique, int64, shape (n,).

    Returns
    -------
    tuple
        Frames, int64, shape (n,), the period in ns (NaN for a single time), and whether the times
        are nearly even.
    """
    steps = np.diff(ns).astype(float)
    if not len(steps):
        return np.zeros(len(ns), np.int64), np.nan, True
    period = float(np.quantile(steps, 0.25))
    period = float(steps[steps < 1.5 * period].mean())
    n_periods = np.maximum(np.rint(steps / period), 1)
    is_near = n_periods <= _NEAR_STEPS
    period = float(steps[is_near].sum() / n_periods[is_near].sum())
    n_periods = np.maximum(np.rint(steps / period), 1)
    is_even = np.abs(steps / period - n_periods)[is_near] <= _JITTER
    frames = np.concatenate([[0], np.cumsum(n_periods)]).astype(np.int64)
    return frames, period, bool(is_even.mean() >= _EVEN_SHARE and is_near.mean() > 0.5)


def rate_of(period_ns: float) -> float:
    """Convert a period to pictures per second, rounded to a usual rate within 0.5 %."""
    rate = 1e9 / period_ns
    usual = float(_USUAL_RATES[np.argmin(np.abs(_USUAL_RATES - rate))])
    return usual if abs(rate / usual - 1) <= _SNAP else float(f"{rate:.5g}")


def nearest_times(
    ns: np.ndarray, their_ns: np.ndarray, period_ns: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the nearest known time of each time, or -1 if another is nearer to the same frame.

    A time belongs to a known frame if it is within half a period of it.

    Parameters
    ----------
    ns
        Unique, int64, shape (n,).
    their_ns
        Sorted, unique, int64, shape (m,), m > 0.

    Returns
    -------
    tuple
        Index of the known time, and the number of periods from it to the time, int64, shape (n,).
    """
    middles = their_ns[:-1] + np.diff(their_ns) // 2
    nearest = np.searchsorted(middles, ns)
    away = (ns - their_ns[nearest]).astype(float)
    period = 2.0**65 if np.isnan(period_ns) else period_ns  # single known time: one frame
    n_periods = np.rint(away / period).astype(np.int64)
    error = np.abs(away - n_periods * period)
    table = pd.DataFrame({"nearest": nearest, "n_periods": n_periods, "error": error})
    best = table.sort_values("error", kind="stable").drop_duplicates(["nearest", "n_periods"])
    is_best = np.isin(np.arange(len(ns)), best.index)
    return np.where(is_best, nearest, -1), n_periods
