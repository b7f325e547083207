"""Find which picture files in one folder belong to a recording, and the number of each.

The names of a series differ in numbers alone: ``I00019_lwir.png``, ``I00039_lwir.png``. What does
not belong to it (``calib.png``, ``img_0120 (1).png``) is passed over. Two series of the same
numbers, such as those of two cameras, are for the user to choose from: never one picture of this
and one of that.
"""

from __future__ import annotations

import glob
import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import PurePosixPath
from posixpath import basename, splitext
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import MediaError
from nvcore.common.file_kinds import composed
from nvcore.common.findings import Remedy, Step
from nvcore.common.wording import listed, one_line
from nvcore.inputs.readers.meaning.names import DIGITS, MAX_DIGITS, frame_columns, times_in

_EXPORTED: Final = re.compile(r"(_(jpe?g|png|tiff?|bmp))?\.rf\.[0-9A-Za-z]{8,}$", re.IGNORECASE)
"""What Roboflow puts behind a name."""
_KINDS: Final = {".jpeg": ".jpg", ".tiff": ".tif"}
_FEW: Final = 3
"""So many files, or a tenth of the series, do not make another series."""
_MOST_SERIES: Final = 8
"""With more of them, the names tell nothing."""


@dataclass(frozen=True)
class Series:
    """Picture files of a recording.

    Attributes
    ----------
    names
        In natural order.
    numbers
        Frame number in each name, int64, shape (n,), all different; None: the names have none.
    passed_over
        Files of the folder that do not belong to it, in natural order.
    """

    names: list[str]
    numbers: NDArray[np.int64] | None
    passed_over: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Group:
    """Files whose names differ in numbers alone. `text` is the rest, `pattern` matches them."""

    names: list[str]
    numbers: list[int]
    kind: str
    text: str
    pattern: str


def series_of(names: Sequence[str], where: str) -> Series:
    """The series among the picture files of one folder.

    Parameters
    ----------
    names
        Paths in the folder.
    where
        Name of the folder, for the error.

    Raises
    ------
    MediaError
        If there are several series of the same numbers; its steps name them.
    """
    ordered = sorted(names, key=natural_order)
    groups = _groups(ordered)
    largest = max((len(group.names) for group in groups), default=0)
    rivals = [group for group in groups if not is_stray(len(group.names), largest)]
    main = max(rivals, key=lambda group: len(group.names), default=None)
    if main is None or 2 * sum(len(group.names) for group in rivals) < len(ordered):
        return Series(ordered, None)
    # a frame that was saved once more in another format fills a gap of the series
    rivals += [
        group
        for group in groups
        if group not in rivals
        and group.text == main.text
        and not {*group.numbers} & {*main.numbers}
    ]
    number_of = {
        name: number
        for group in rivals
        for name, number in zip(group.names, group.numbers, strict=True)
    }
    chosen = [name for name in ordered if name in number_of]
    numbers = np.array([number_of[name] for name in chosen], dtype=np.int64)
    if len(np.unique(numbers)) == len(numbers):
        passed_over = tuple(name for name in ordered if name not in number_of)
        return Series(chosen, numbers, passed_over)
    if _are_several(rivals):
        _ask(rivals, where)
    return Series(ordered, None)


def is_stray(n: int, largest: int) -> bool:
    """Whether so few files beside a series of that many are no series of their own."""
    return 3 * n <= largest and n <= max(_FEW, largest // 10)


def _groups(names: Sequence[str]) -> list[_Group]:
    """Group files by kind and by the text beside the number. Names without a number are skipped."""
    alike: dict[tuple[str, str], list[tuple[str, list[str]]]] = defaultdict(list)
    for name in names:
        stem, suffix = splitext(basename(name))  # a path object for each would take as long as all
        kind, stem = suffix.lower(), composed(_EXPORTED.sub("", stem))
        parts = DIGITS.split(stem)
        if len(parts) > 1:
            text = "#".join(parts[::2]).casefold()
            alike[_KINDS.get(kind, kind), text].append((name, parts))
    groups = []
    for (kind, _), members in alike.items():
        column = frame_columns([parts for _, parts in members])[0]
        times_ns = _times([parts for _, parts in members], column)
        if times_ns is not None:
            groups.append(replace(_group(members, column, kind), numbers=times_ns))
            continue
        own: dict[tuple[str, ...], list[tuple[str, list[str]]]] = {(): members}
        if len({parts[column].lstrip("0") for _, parts in members}) < len(members):
            own = defaultdict(list)  # of several cameras, whose numbers stand in the names as well
            for name, parts in members:
                own[*parts[:column], *parts[column + 1 :]].append((name, parts))
        for several in own.values():
            if all(len(parts[column].lstrip("0")) <= MAX_DIGITS for _, parts in several):
                groups += [_group(part, column, kind) for part in _single(several, column)]
    return groups


def _times(stems: Sequence[Sequence[str]], column: int) -> list[int] | None:
    """Nanoseconds, if the names are times: seconds start again with each minute.

    None: they are none, or their numbers rise as those of frames do.
    """
    if max(len(parts[column]) for parts in stems) > MAX_DIGITS:
        return None
    steps = {int(after[column]) - int(before[column]) for before, after in pairwise(stems)}
    is_clock = [len(digits) for digits in stems[0][max(column - 2, 1) : column + 1 : 2]] == [8, 6]
    if len(steps) < 2 or (min(steps) > 0 and not is_clock):
        return None
    times = times_in(["".join(parts) for parts in stems])
    if times is None or len({*times.prefix}) > 1 or len({*times.ns.tolist()}) < len(stems):
        return None
    ns: list[int] = times.ns.tolist()
    return ns


def _single(members: list[tuple[str, list[str]]], column: int) -> list[list[tuple[str, list[str]]]]:
    """The files with each number once, and those that repeat it with more or fewer zeros."""
    usual = Counter(len(parts[column]) for _, parts in members).most_common(1)[0][0]
    first: dict[int, tuple[str, list[str]]] = {}
    for member in sorted(members, key=lambda member: len(member[1][column]) != usual):
        first.setdefault(int(member[1][column]), member)
    single = {name for name, _ in first.values()}
    parts = [
        [member for member in members if (member[0] in single) == is_single]
        for is_single in (True, False)
    ]
    return [part for part in parts if part]


def _group(members: Sequence[tuple[str, list[str]]], column: int, kind: str) -> _Group:
    names, stems = [name for name, _ in members], [parts for _, parts in members]
    text = "".join(
        glob.escape(stems[0][i]) if i != column and len({*parts}) == 1 else "*"
        for i, parts in enumerate(zip(*stems, strict=True))
    )
    path = PurePosixPath(names[0])
    rest = "*" if _EXPORTED.search(path.stem) else ""
    numbers = [int(parts[column]) for parts in stems]
    return _Group(names, numbers, kind, text, f"{text}{rest}{path.suffix}")


def _are_several(groups: Sequence[_Group]) -> bool:
    """Whether each of these is a series by itself, beside others of the same frames."""
    is_alone = all(len({*group.numbers}) == len(group.numbers) for group in groups)
    is_long = all(len(group.names) > 1 for group in groups)
    is_of_kinds = len({group.kind for group in groups}) == len(groups)
    return is_alone and 1 < len(groups) <= _MOST_SERIES and (is_long or is_of_kinds)


def _ask(groups: Sequence[_Group], where: str) -> None:
    patterns = [group.pattern for group in groups]
    if len({group.kind for group in groups}) == len(groups):  # the ending is shorter to type
        patterns = [f"*{PurePosixPath(group.names[0]).suffix}" for group in groups]
    texts = [
        f"{len(group.names):,} {one_line(pattern)}"
        for group, pattern in zip(groups, patterns, strict=True)
    ]
    raise MediaError(
        f"holds several pictures for the same frame numbers ({listed(texts)}), and which are meant "
        f"is not clear: give one kind, such as {one_line(where)}/{one_line(patterns[0])}",
        file=where,
        steps=tuple(Step(Remedy.PICTURES, pattern) for pattern in patterns),
    )


def natural_order(name: str) -> list[tuple[int, int, str]]:
    """Sort key by which ``p9`` comes before ``p10``.

    Examples
    --------
    >>> sorted(["p10.png", "p9.png", "p09.png"], key=natural_order)
    ['p09.png', 'p9.png', 'p10.png']
    """
    parts = DIGITS.split(name)
    keys = [
        (1, len(part.lstrip("0")), part.lstrip("0")) if i % 2 else (0, 0, part)
        for i, part in enumerate(parts)
    ]
    return [*keys, (0, 0, name)]
