"""Recording and frame of listed pictures, by a number or time in the name, or by order."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import FormatError, InputError
from nvcore.common.file_kinds import IMAGE_SUFFIXES
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.inputs.readers.base import (
    NO_FRAME,
    Lines,
    NamedPictures,
    ReadOptions,
    SourceFile,
    object_array,
)
from nvcore.inputs.readers.meaning.names import (
    DIGITS,
    LEAST_TIME,
    ONLY,
    NamedTimes,
    common_beginning,
    frame_last,
    frames_by_times,
    nearest_times,
    place_of_stem,
    plain_names,
    rate_of,
    recording_before,
    times_in,
    times_of_numbers,
)
from nvcore.inputs.readers.parse.text import read_text

NO_NAMES: Final = NamedPictures(
    pd.DataFrame({"recording": [], "frame": [], "name": []}).astype({"frame": np.int64}), strange=0
)
"""Pictures without names."""
MIN_JOINED: Final = 0.5
"""Share of a system's pictures from which on names of the truth are no coincidence."""
LONG_GAP: Final = 1000
"""Length of a gap between picture numbers that divides recordings, in numbers ..."""
LONG_GAP_STEPS: Final = 50
"""... and in usual steps, since a list may have only every hundredth picture."""
_HASH: Final = re.compile(r"[0-9a-f\-]{16,}$", re.IGNORECASE)
LATE_START: Final = 100
"""Largest first frame of a scene, if most scenes begin at 0 or 1."""


def listed_frames(files: Sequence[SourceFile], options: ReadOptions) -> NamedPictures:
    """Parse recording and frame from the names of files. Empty files are frames, too.

    Raises
    ------
    InputError
        If a file name has no frame number, two files are of one frame, or the names are
        ambiguous.
    """
    names = [file.name for file in files]
    empty = []
    if options.role == "truth":
        empty = pictures_without_file(files, options.picture_folders)
    named = named_pictures([*names, *empty], options)
    if named.strange >= len(files):
        named, empty = named_pictures(names, options), []
    if named.strange >= 0:
        are_hashes = all(_HASH.match(stem) for stem in _stems(names))
        raise InputError(
            "expected one file per frame with the frame number in its name, as in I00019.txt or "
            + (
                "000019.txt; found names such as checksums, which do not tell the order of the "
                "pictures"
                if are_hashes
                else "000019.txt; found no number: rename the file or leave it out"
            ),
            file=files[named.strange].name,
            steps=(Step(Remedy.TABLE) if are_hashes else Step(Remedy.FRAME_NAMES, "order"),),
        )
    table = named.table
    # one known recording and one read: the same one, regardless of folder names
    if len(options.recordings) == 1 and len(set(named.recording)) == 1:
        table = table.assign(recording=options.recordings[0])
        named = replace(named, table=table)
    double = (table.duplicated(["recording", "frame"]) & (table["frame"] != NO_FRAME)).to_numpy()
    if empty:  # one picture of several of a frame suffices
        is_file = np.arange(len(table)) < len(files)
        table, double = table[is_file | ~double], double[: len(files)]
        named = replace(named, table=table)
    if double.any():
        second = int(np.argmax(double))
        recording, frame = table[["recording", "frame"]].iloc[second]
        is_same = (table["recording"] == recording) & (table["frame"] == frame)
        raise InputError(
            f"is frame {frame} of recording {recording!r}, as is "
            f"{files[int(np.argmax(is_same))].name}; expected one file per frame: name the files "
            "or their folders by the recordings",
            file=files[second].name,
        )
    return with_empty_pictures(named, len(files)) if empty else named


def named_pictures(names: Sequence[str], options: ReadOptions) -> NamedPictures:
    """Parse recording and frame of each picture in a list from the names.

    Additions by tools are removed first. Names of the truth's pictures are frames of the truth.
    Other names end in the frame number, or in a time that determines it.

    Raises
    ------
    InputError
        If the names are ambiguous, and `ReadOptions.frame_names` does not decide.
    """
    named = _by_themselves(names, options)
    if options.named is None or options.role == "truth":
        _check_times(named, None, options)
        return named
    return _joined(named, names, options.named, options)


@contextmanager
def in_file(file: SourceFile) -> Iterator[None]:
    """Name the file in errors about names of pictures that it lists."""
    try:
        yield
    except InputError as error:
        if error.file == file.name:
            raise
        raise file.fault(error.message, steps=error.steps) from error


def places_of_pictures(
    pictures: pd.Series, options: ReadOptions, fault: Callable[[int, str], FormatError]
) -> tuple[np.ndarray, np.ndarray, NamedPictures]:
    """Parse recording and frame number of each row from the name of its picture.

    Parameters
    ----------
    pictures
        Names of the pictures, text, shape (n,).
    fault
        Function from the first row and name without a number to the error to raise.
    """
    codes, names = pd.factorize(pictures)
    named = named_pictures([*map(str, names)], options)
    if named.strange >= 0:
        raise fault(int(np.argmax(codes == named.strange)), names[named.strange])
    return named.recording[codes], named.frame[codes], named


def times_as_frames(
    values: np.ndarray, recording: object, options: ReadOptions, lines: Lines
) -> tuple[np.ndarray, np.ndarray, NamedPictures] | None:
    """Return recording and frame of rows whose frame numbers are times, or None.

    Parameters
    ----------
    values
        float64 or int64, shape (n,).
    recording
        One recording for all rows, or one for each.
    lines
        Lines of the rows, for errors.

    Raises
    ------
    InputError
        If values are too large for frame numbers and are no times of a camera, with the line.
    """
    least = 0 if options.frame_names == "times" else LEAST_TIME
    if options.frame_names == "numbers" or not len(values) or not values.min() >= least:
        return None
    rows = pd.DataFrame({"recording": recording, "value": values})
    codes = rows.groupby(["recording", "value"], sort=False, observed=True).ngroup().to_numpy()
    unique = rows.iloc[np.unique(codes, return_index=True)[1]]
    recordings = unique["recording"].astype(str).tolist()
    numbers = unique["value"].to_numpy()
    times = times_of_numbers(numbers, recordings)
    names = [f"{number:.6f}".rstrip("0").rstrip(".") for number in numbers.tolist()]
    if times is None and options.frame_names == "times":
        return None
    if times is None:
        unclear = _unclear(names[0], "in the column of frame numbers")
        raise lines.fault(0, unclear.message, unclear.steps)
    # a column lists only frames with boxes, so gaps are no pauses of the recording
    named = _by_times(recordings, names, times, options, divide=False)
    if options.named is not None and options.role == "detections":
        named = _joined(named, names, options.named, options, times=times)
    _check_times(named, options.named, options)
    return named.recording[codes], named.frame[codes], named


def _by_themselves(names: Sequence[str], options: ReadOptions) -> NamedPictures:
    """Parse pictures from the list alone, and set `strange` if a name has no number."""
    plain, ending = plain_names(names)
    facts: tuple[str, ...] = (
        (f"the common ending {ending} of the names taken off",) if ending else ()
    )
    how, known = options.frame_names, options.recordings
    which: tuple[str, ...] = ()
    if how != "order":
        theirs = options.named.table["name"].tolist() if options.named is not None else []
        plain, which = frame_last(plain, plain_names(theirs)[0], how)
    parts = [(name.split("/")[:-1], name.rpartition("/")[2]) for name in plain]
    stems = [stem for _, stem in parts]
    if how == "order":
        return replace(_by_order(names, parts, known), facts=facts)
    times = None
    if how in (None, "times") and stems:
        times = times_in(stems, is_stated=how == "times")
    if times is not None:
        recordings = [
            recording_before(tuple(folders), prefix, known)
            for (folders, _), prefix in zip(parts, times.prefix, strict=True)
        ]
        named = _by_times(recordings, names, times, options, divide=options.role == "truth")
        return replace(named, facts=(*facts, *named.facts))
    facts += which
    places = [place_of_stem(tuple(folders), stem, known) for folders, stem in parts]  # text
    if None in places:
        return replace(NO_NAMES, strange=places.index(None))
    placed = [place for place in places if place is not None]
    table = _table((recording for recording, _ in placed), [frame for _, frame in placed], names)
    named = NamedPictures(table, "numbers", facts)
    is_large = named.frame >= LEAST_TIME
    if how is None and is_large.sum() > len(is_large) / 2:
        raise _unclear(names[int(np.argmax(named.frame))], "in the names")
    return named if options.role == "detections" else _by_scenes(named, stems, how)


def _unclear(name: str, where: str) -> InputError:
    return InputError(
        f"the number {where} is too large for a frame number, and a camera's times, nearly even, "
        f"would be between 0.05 and 300 a second: found {name}",
        steps=(Step(Remedy.FRAME_NAMES, "order"), Step(Remedy.FRAME_NAMES, "numbers")),
    )


def _by_order(
    names: Sequence[str], parts: Sequence[tuple[list[str], str]], known: tuple[str, ...]
) -> NamedPictures:
    """Number pictures 0, 1, 2, ... in the natural order of the names of each folder."""
    recordings = [recording_before(tuple(folders), "", known) for folders, _ in parts]
    order = sorted(range(len(names)), key=lambda row: (recordings[row], _natural(names[row])))
    table = _table(recordings, np.zeros(len(names)), names)
    frame = table.iloc[order].groupby("recording").cumcount()
    return NamedPictures(table.assign(frame=frame), "order")


def _natural(name: str) -> list[tuple[int, str]]:
    return [
        (int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name)
    ]


def _by_times(
    recordings: Sequence[str],
    names: Sequence[str],
    times: NamedTimes,
    options: ReadOptions,
    *,
    divide: bool,
) -> NamedPictures:
    """Number pictures by their times, recording by recording.

    Raises
    ------
    InputError
        If the times are not nearly even.
    """
    table = _table(recordings, np.zeros(len(names), np.int64), names)
    # a system's times need not be even if the truth has times
    is_of_truth = options.named is not None and options.named.how == "times"
    frame, own = np.zeros(len(names), np.int64), object_array(recordings)
    rates: dict[str, float] = {}
    n_missing = 0
    for recording, rows in _rows_of(table).items():
        unique, codes = np.unique(times.ns[rows], return_inverse=True)
        numbers, period, is_even = frames_by_times(unique)
        if not is_even and options.frame_names is None and not is_of_truth:
            raise InputError(
                f"the numbers of recording {recording!r} are too large for frame numbers, but "
                f"times ({times.unit}) that are not nearly even: found {names[rows[0]]}",
                steps=(Step(Remedy.FRAME_NAMES, "times"), Step(Remedy.FRAME_NAMES, "order")),
            )
        # a long pause separates recordings
        part = np.concatenate([[0], np.cumsum(np.diff(numbers) > LONG_GAP)])
        if divide and part[-1]:
            numbers = numbers - numbers[np.searchsorted(part, part)]
            own[rows] = object_array(_scene(recording, f"scene_{k + 1}") for k in part)[codes]
        frame[rows] = numbers[codes]
        is_next = np.diff(part) == 0
        n_missing += int((np.diff(numbers)[is_next] - 1).sum())
        if not np.isnan(period):
            rates |= dict.fromkeys(own[rows], rate_of(period))
    fact = f"numbers taken as times ({times.unit}), frames numbered by them from 0"
    if rates:
        low, high = min(rates.values()), max(rates.values())
        fact += f", at {low:g} a second" if low == high else f", at {low:g} to {high:g} a second"
    if n_missing:
        fact += f", gaps in the times kept as {count_text(n_missing, 'missing frame')}"
    if len(set(own)) > table["recording"].nunique():
        fact += f", {len(set(own))} recordings told apart by long pauses"
    return NamedPictures(table.assign(recording=own, frame=frame), "times", (fact,), rates)


def _by_scenes(named: NamedPictures, stems: Sequence[str], how: str | None) -> NamedPictures:
    """Divide recordings at long gaps between numbers of pictures.

    Raises
    ------
    InputError
        If this was not requested, and the first digits do not number the scenes.
    """
    if how == "numbers":
        return named
    table, digits = named.table, [re.search(r"\d*$", stem)[0] for stem in stems]  # type: ignore[index]
    names, frame = named.recording.copy(), named.frame.copy()
    for recording, rows in _rows_of(table).items():
        order = rows[np.argsort(named.frame[rows], kind="stable")]
        steps = np.diff(named.frame[order])
        if not len(steps):
            continue
        is_gap = steps > max(LONG_GAP, LONG_GAP_STEPS * float(np.median(steps)))
        if not is_gap.any():
            continue
        part = np.concatenate([[0], np.cumsum(is_gap)])
        width = _scene_digits([digits[row] for row in order], part)
        if width:
            scenes = [digits[row][:width] for row in order]
            frame[order] = [int(digits[row][width:]) for row in order]
        elif how == "scenes":
            scenes = [f"scene_{number + 1}" for number in part]
        else:
            at = int(np.argmax(is_gap))
            before, after = (table["name"].iloc[order[row]] for row in (at, at + 1))
            raise InputError(
                f"recording {recording!r} has a gap of {steps[at]:,} numbers, between the pictures "
                f"{before} and {after}: it cannot be told whether these are several recordings or "
                "parts of one",
                steps=(Step(Remedy.FRAME_NAMES, "scenes"), Step(Remedy.FRAME_NAMES, "numbers")),
            )
        names[order] = [_scene(recording, scene) for scene in scenes]
    is_part = names != named.recording
    if not is_part.any():
        return named
    n_parts = len(set(names[is_part]))
    return replace(
        named,
        table=table.assign(recording=names, frame=frame),
        how="scenes",
        facts=(
            *named.facts,
            f"{n_parts} recordings told apart by gaps in the numbers of the pictures",
        ),
    )


def _scene(recording: str, scene: str) -> str:
    return f"{recording}_{scene}".removeprefix(f"{ONLY}_")


def _scene_digits(digits: Sequence[str], part: np.ndarray) -> int:
    """Return the number of leading digits that identify the scene, 0 if none do.

    Parameters
    ----------
    digits
        Digits at the end of the names, sorted as numbers.
    part
        Index of each name's part, from 0. Long gaps separate the parts.
    """
    n_digits = {len(text) for text in digits}
    if len(n_digits) != 1:
        return 0
    for width in range(1, min(4, n_digits.pop() - 2)):
        heads = pd.Series([text[:width] for text in digits])
        first = pd.Series([int(text[width:]) for text in digits]).groupby(heads).min()
        same = pd.DataFrame({"head": heads, "part": part}).drop_duplicates()
        # pictures from 0 and from 5000 on may also be parts of one recording
        begins = (first <= 1).mean() > 0.5 and first.max() <= LATE_START
        if len(same) == heads.nunique() == part[-1] + 1 and begins and int(heads[0]):
            return width
    return 0


def _joined(
    named: NamedPictures,
    names: Sequence[str],
    truth: NamedPictures,
    options: ReadOptions,
    *,
    times: NamedTimes | None = None,
) -> NamedPictures:
    """Match a system's pictures to frames of the truth by names or times, if they agree."""
    theirs = truth.table
    row, way = rows_by_name(names, theirs["name"].tolist())
    is_joined = row >= 0
    if is_joined.mean() < MIN_JOINED:
        is_joined[:] = False
    recording = np.full(len(names), "", dtype=object)
    frame = np.full(len(names), NO_FRAME, np.int64)
    recording[is_joined] = theirs["recording"].to_numpy(dtype=object)[row[is_joined]]
    frame[is_joined] = truth.frame[row[is_joined]]
    facts = [*named.facts] if not is_joined.all() else [way]
    rest, is_by_time = ~is_joined, False
    if rest.any() and named.strange >= 0 and not is_joined.any():
        return named
    if rest.any() and named.strange < 0:
        if named.how == "times" and truth.how == "times":
            frame_by_time = _by_their_times(named, names, truth, times)
            recording[rest], frame[rest] = frame_by_time[0][rest], frame_by_time[1][rest]
            is_by_time = True
            facts.append("times held against those of the truth, up to half a period apart")
        elif named.how == truth.how or not is_joined.any():
            _check_times(named, truth, options)
            recording[rest], frame[rest] = named.recording[rest], named.frame[rest]
    unknown = rest & (recording == "")
    if unknown.any():
        recording[unknown] = theirs["recording"].iloc[0]
        facts.append(f"{int(unknown.sum())} of {len(names)} pictures are none of the truth's")
    joined = NamedPictures(_table(recording, frame, names), truth.how, tuple(facts))
    is_same = named.strange < 0 and not named.rates and joined.table.equals(named.table)
    return replace(named if is_same else joined, is_joined=is_by_time or bool(is_joined.any()))


def _check_times(named: NamedPictures, truth: NamedPictures | None, options: ReadOptions) -> None:
    """Refuse a system's times if the truth has none, since the time of frame 0 is unknown."""
    is_system = options.role == "detections" and bool(options.recordings)
    if not is_system or named.how != "times" or options.frame_names is not None:
        return
    if truth is None or truth.how != "times":
        raise InputError(
            "the pictures are numbered by times, and those of the truth are not: which picture is "
            f"which cannot be told; found {named.table['name'].iloc[0]}",
            steps=(Step(Remedy.FRAME_NAMES, "times"), Step(Remedy.FRAME_NAMES, "order")),
        )


def _by_their_times(
    named: NamedPictures, names: Sequence[str], truth: NamedPictures, times: NamedTimes | None
) -> tuple[np.ndarray, np.ndarray]:
    """Find recording and frame of each picture by the truth's times."""
    theirs = truth.table
    their_times = times_in(_stems(theirs["name"].tolist()), is_stated=True)
    own_times = times or times_in(_stems(names), is_stated=True)
    if their_times is None or own_times is None:
        return named.recording, named.frame
    recording, frame = named.recording.copy(), np.full(len(names), NO_FRAME, np.int64)
    of_truth, of_system = _rows_of(theirs), _rows_of(named.table)
    for name, rows in of_system.items():  # a loop over recordings
        # a recording that the truth lacks is identified by its times alone
        there = of_truth.get(name, np.arange(len(theirs)))
        their_ns, first = np.unique(their_times.ns[there], return_index=True)
        there = there[first]
        unique, codes = np.unique(own_times.ns[rows], return_inverse=True)
        nearest, n_periods = nearest_times(unique, their_ns, frames_by_times(their_ns)[1])
        of_nearest = there[np.maximum(nearest, 0)]
        own_frame = np.where(nearest < 0, NO_FRAME, truth.frame[of_nearest] + n_periods)
        recording[rows] = theirs["recording"].to_numpy(dtype=object)[of_nearest][codes]
        frame[rows] = own_frame[codes]
    return recording, frame


def _stems(names: Sequence[str]) -> list[str]:
    return [name.rpartition("/")[2] for name in plain_names(names)[0]]


def rows_by_name(names: Sequence[str], listed: Sequence[str]) -> tuple[np.ndarray, str]:
    """Match names to listed pictures (row, or -1), and describe the comparison."""
    ours, theirs = plain_names(names)[0], plain_names(listed)[0]
    best, way = rows_by_text(ours, theirs), "pictures found in the truth by their names"
    stems = [[name.rpartition("/")[2] for name in plain] for plain in (ours, theirs)]
    begins = [common_beginning(of_side) for of_side in stems]
    without = [
        [stem.removeprefix(begin) for stem in of_side]
        for of_side, begin in zip(stems, begins, strict=True)
    ]
    begun = ", ".join(repr(begin) for begin in begins if begin)
    cut = f"pictures found in the truth by their names without the common beginnings {begun}"
    for sides, how in ((stems, way), ((without[0], stems[1]), cut), (without, cut)):
        if (best >= 0).all():
            break
        row = rows_by_text(*sides)
        row = np.where(best >= 0, best, row) if sides is stems else row
        if (row >= 0).sum() > (best >= 0).sum():
            best, way = row, how
    return best, way


def rows_by_text(names: Sequence[str], listed: Sequence[str]) -> np.ndarray:
    """Return the row of each text in a list, or -1 if no row or several rows have it."""
    index = pd.Index(list(listed))
    rows = np.flatnonzero(~index.duplicated(keep=False))
    place = index[rows].get_indexer(pd.Index(list(names)))
    return np.append(rows, -1)[place]


def _rows_of(table: pd.DataFrame) -> dict[str, np.ndarray]:
    """Return the rows of each recording, in order."""
    groups = table.groupby("recording", sort=False).indices
    return {str(name): np.asarray(rows) for name, rows in groups.items()}


def _table(
    recordings: Iterable[str], frames: Sequence[int] | np.ndarray, names: Iterable[str]
) -> pd.DataFrame:
    return pd.DataFrame(
        {
            "recording": object_array(recordings),
            "frame": np.array(frames, dtype=np.int64),
            "name": object_array(names),
        }
    )


def joined_named(parts: Sequence[NamedPictures]) -> NamedPictures | None:
    """Concatenate lists of pictures, or return None if there are none."""
    if not parts:
        return None
    rates: Mapping[str, float] = {name: rate for part in parts for name, rate in part.rates.items()}
    table = pd.concat([part.table for part in parts], ignore_index=True)
    ways = {part.how for part in parts}
    facts = tuple(dict.fromkeys(fact for part in parts for fact in part.facts))
    return NamedPictures(table, ways.pop() if len(ways) == 1 else "", facts, rates)


LABEL_FOLDERS: Final = ("labels", "annotations", "annotation", "label_2", "label_02", "xml", "txt")
IMAGE_FOLDERS: Final = (
    *("images", "image", "imgs", "img", "img1", "JPEGImages", "image_2", "image_02"),
    *("frames", "pictures"),
)
"""Folders of pictures beside those of label files."""
LISTS: Final = ("train", "val", "valid", "validation", "trainval", "test", "images")
"""Names of lists of pictures, such as ``train.txt``."""
MAX_LIST_BYTES: Final = 64 << 20
MAX_YAML_BYTES: Final = 1 << 20
_SPLIT: Final = re.compile(r"^(?:train|val|test):[ \t]*['\"]?([^\s'\"#\[]+)", re.MULTILINE)
"""Pictures of a data set in its YAML file: ``train: images/train``."""
MIN_FOUND: Final = 0.9
"""Smallest share of label files whose pictures a folder or list has to contain."""
MIN_REGULAR: Final = 4
"""Number of pictures from which on equal steps are no coincidence."""


def pictures_without_file(files: Sequence[SourceFile], folders: Sequence[Path] = ()) -> list[str]:
    """Return the names of listed pictures that have no label file, with the folders of the files.

    Parameters
    ----------
    files
        Label files, one per picture.
    folders
        Further folders that may hold the pictures.
    """
    stems_in: dict[tuple[Path, str], set[str]] = defaultdict(set)
    for file in files:
        shown, _, name = file.name.rpartition("/")
        stems_in[file.path.absolute().parent, shown].add(PurePosixPath(name).stem)
    every = set().union(*stems_in.values())
    texts = {DIGITS.sub("", stem) for stem in every}
    found = []
    for (folder, shown), own in stems_in.items():
        enough = MIN_FOUND * len(own)
        places = (listed for listed in _listed(folder, folders) if len(own & listed) >= enough)
        for stem in sorted(next(places, set()) - every):
            if DIGITS.sub("", stem) in texts and stem not in texts:
                found.append(f"{shown}/{stem}".removeprefix("/"))
    return found


def _listed(folder: Path, folders: Sequence[Path]) -> Iterator[set[str]]:
    """Yield the stems of pictures in each place that may have those of a folder's label files."""
    places = [folder, *(folder.parent / name for name in IMAGE_FOLDERS)]
    for at, part in enumerate(folder.parts):
        if part.casefold() in LABEL_FOLDERS:
            start, rest = Path(*folder.parts[:at]), folder.parts[at + 1 :]
            places += [start.joinpath(name, *rest) for name in IMAGE_FOLDERS]
    above = (folder, *folder.parents[:3])
    named = [place / value for place in above for value in _named_in_yaml(place)]
    for place in dict.fromkeys([*places, *folders, *named]):
        with suppress(OSError):
            names = [PurePosixPath(entry.name) for entry in place.iterdir()]
            yield {name.stem for name in names if name.suffix.casefold() in IMAGE_SUFFIXES}
    for place in (*above[:3], above[1] / "ImageSets" / "Main"):
        paths = [*(place / f"{name}.txt" for name in LISTS), *named]
        lists = [_stems_in(path, folder.name) for path in paths]
        yield from [*filter(None, lists), set().union(*lists)]


def _named_in_yaml(place: Path) -> list[str]:
    """Return the folders and lists of pictures that YAML files of data sets in a folder name."""
    texts = []
    with suppress(InputError, OSError):
        files = [SourceFile(path, path.name) for path in sorted(place.glob("*.y*ml"))]
        texts = [read_text(file) for file in files if not file.is_larger_than(MAX_YAML_BYTES)]
    return [value for text in texts for value in _SPLIT.findall(text)]


def _stems_in(path: Path, folder: str) -> set[str]:
    """Return the stems of listed pictures: those in a folder of this name, if there are any."""
    file = SourceFile(path, path.name)
    try:
        if not path.is_file() or file.is_larger_than(MAX_LIST_BYTES):
            return set()
        names = [PurePosixPath(line.strip()) for line in read_text(file).splitlines()]
    except (InputError, OSError):
        return set()
    names = [name for name in names if name.suffix.casefold() in {"", *IMAGE_SUFFIXES}]
    inside = [name for name in names if name.parent.name == folder]
    return {name.stem for name in inside or names}


def with_empty_pictures(named: NamedPictures, n_files: int) -> NamedPictures:
    """Separate the pictures without a label file, which stand last, as `NamedPictures.empty`.

    If most have none, or pictures with or without one follow each other in equal steps, only some
    pictures may have been annotated. Then `empty` is None, and a warning asks the user.
    """
    of_files, empty = named.table.iloc[:n_files], named.table.iloc[n_files:]
    parts = named.table.assign(is_empty=np.arange(len(named.table)) >= n_files)
    parts = parts.sort_values(["recording", "frame"])
    in_steps = any(
        _is_regular(np.flatnonzero(part["is_empty"] == is_empty))
        for _, part in parts.groupby("recording")
        for is_empty in (False, True)
    )
    is_part = in_steps or 2 * len(empty) >= len(parts)
    steps = [Step(Remedy.FRAMES)] * is_part
    if is_part and len({*parts["recording"]}) == 1:
        first, last = parts["frame"].iloc[[0, -1]]
        steps = [Step(Remedy.FRAMES, f"{first}:{last}")]
        frames = np.unique(of_files["frame"])
        if len({*np.diff(frames)}) == 1:
            steps.append(Step(Remedy.FRAMES, f"{frames[0]}:{frames[-1]}:{frames[1] - frames[0]}"))
    have = count_text(len(empty), "picture has", "pictures have")
    finding = Finding(
        Severity.WARNING if is_part else Severity.NOTE,
        "pictures-not-annotated" if is_part else "pictures-without-label-file",
        TRUTH_NAME,
        len(empty),
        f"{have} no label file"
        + (", as if only some were annotated: they are not evaluated." if is_part else "."),
        "If nobody is there, evaluate them, too; nothing to do if only some were annotated."
        if is_part
        else "Nobody is there then: every detection in them is a false alarm.",
        example=f"picture {empty['name'].iloc[0]}",
        steps=tuple(steps),
    )
    return replace(named, table=of_files, empty=None if is_part else empty, findings=(finding,))


def _is_regular(rows: np.ndarray) -> bool:
    steps = {*np.diff(rows).tolist()}
    return len(rows) >= MIN_REGULAR and len(steps) == 1 and steps != {1}
