"""Plain CSV with a header that names its columns: ``frame,x,y,w,h`` and more."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import MissingFactError
from nvcore.common.findings import Finding, Remedy, Step
from nvcore.dataset.schema import names_as_categories
from nvcore.inputs.readers.base import (
    BOTH_ROLES,
    Format,
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    concat_boxes,
    conversion_text,
    recordings_table,
    select_boxes,
    warning,
)
from nvcore.inputs.readers.csv.columns import (
    ALERTED,
    EXCEL,
    MISSING,
    OTHER_SCORE,
    Header,
    csv_content,
    misspelt_columns,
    read_columns,
    read_header,
)
from nvcore.inputs.readers.meaning.classes import (
    CategoryChoice,
    ClassNames,
    choose_categories,
    codes_of,
    labels_of,
    names_of_numbers,
)
from nvcore.inputs.readers.meaning.frame_names import in_file, places_of_pictures, times_as_frames
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.values import (
    TEXT_IDS,
    attributes_of_boxes,
    checked_numbers,
    known_distances,
    levels_of_numbers,
    odd_distances,
    odd_levels,
    track_numbers,
)
from nvcore.inputs.readers.parse.rows import FilePart, joined_parts
from nvcore.inputs.readers.parse.text import whole_numbers

ParseColumns = Callable[[Sequence[str]], tuple[pd.DataFrame, np.ndarray, bool]]
"""Columns to read -> result of `nvcore.inputs.readers.csv.columns.read_columns`."""


@dataclass(frozen=True)
class NamedColumns:
    """Boxes in columns that a header names: a CSV file, or a table in memory."""

    file: SourceFile
    header: Header
    parse: ParseColumns
    read_later: tuple[str, ...] = ()
    """Columns that are read once the boxes are in their frames."""


EXPECTED = (
    "frame,x,y,w,h[,score,track,ignore,distance_m,occlusion,detectability,attributes,recording]"
)

_CORNER: Final = ("right", "bottom")
_LAYOUTS: Final = {"right": "corners", "xc": "centres"}
"""Layout of boxes by a column that only this layout has."""
MAX_SHARE: Final = 2.0
"""Largest coordinate of centres that are shares of the picture, not pixels."""
_OF_OTHERS: Final[dict[Role, tuple[str, ...]]] = {
    "truth": ("score", OTHER_SCORE),
    "detections": ("ignore", "attributes", "detectability"),
}
"""Columns that are skipped in files of a role."""


def recognise(_name: str, head: str, _role: Role) -> bool:
    """Whether the first line names the columns of a frame and a box."""
    lines = head.lstrip("\ufeff").splitlines()
    if lines and EXCEL.match(f"{lines[0]}\n".encode()):
        lines = lines[1:]
    if not lines or lines[0].lstrip().startswith(("<", "{", "[", "%", "#")):
        return False
    header = read_header(lines[0])
    return header.has_frame and header.has_box


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read plain CSV files. A file without a recording column is one recording.

    Frames and pixels are kept as they are, except that frames start at 0 if
    ``options.frame_base`` is given.
    """
    tables = []
    for file in files:
        content = csv_content(file, role=options.role)
        end = content.find(b"\n")
        header = read_header(content[: end if end >= 0 else None].decode())
        problem = missing_columns(header)
        if problem is not None:
            raise file.fault(f"expected a header line with {problem}", 1)
        parse = partial(read_columns, file, header, content)
        later = (ALERTED,) if options.role == "detections" else ()
        tables.append(NamedColumns(file, header, parse, read_later=later))
    return read_named_columns(tables, options)


def read_named_columns(inputs: Sequence[NamedColumns], options: ReadOptions) -> Reading:
    """Read files or tables with named columns, as `read` does.

    Raises
    ------
    FormatError
        If a field is not a number, with file and line.
    """
    files = [source.file for source in inputs]
    whole = [
        number
        for number, source in enumerate(inputs)
        if "recording" not in source.header.place and "frame" in source.header.place
    ]
    names, facts = recordings_of([files[number].name for number in whole], options.recordings)
    recording_of_file = dict(zip(whole, names, strict=True))
    contents = []
    for number, source in enumerate(inputs):
        with in_file(source.file):
            contents.append(_read_one(source, number, recording_of_file.get(number), options))
    joined = joined_parts(contents, ["pixels as they are (0-based)", *facts])
    tables, kinds = [part.reading.boxes for part in contents], [part.kind for part in contents]
    stated, choice, name_of = _classes(kinds, files, options)
    labels: tuple[str, ...] = ()
    if choice is not None:
        of_name = labels_of((name_of.get(key, key) for key in choice.counted), options.objects)
        label_of = {
            key: of_name[name]
            for key in choice.counted
            if (name := name_of.get(key, key)) in of_name
        }
        labels = tuple(dict.fromkeys(label_of.values()))
        joined = replace(
            joined,
            conversion=conversion_text([joined.conversion, choice.conversion]),
            annotated=annotated_frames(joined.boxes["recording"], joined.boxes["frame"].to_numpy()),
            findings=(*joined.findings, *choice.findings),
            classes=choice.classes,
            left_out=choice.left_out,
        )
        tables = [
            boxes if kind is None else _sorted_by_class(boxes, kind.key, choice, label_of)
            for boxes, kind in zip(tables, kinds, strict=True)
        ]
    of_boxes = {name for source in inputs for name in _columns_to_read(source.header, options.role)}
    recordings = [
        [recording_of_file[number]]
        if number in recording_of_file
        else boxes["recording"].unique().tolist()
        for number, boxes in enumerate(tables)
    ]
    return replace(
        joined,
        boxes=joined.boxes if choice is None else concat_boxes(tables),
        recordings=recordings_table(chain(*recordings)),
        labels=labels,
        categories=stated,
        numbering="list",
        layout=next((_LAYOUTS[name] for name in _LAYOUTS if name in of_boxes), "sizes"),
    )


def missing_columns(header: Header) -> str | None:
    """Describe expected, found and missing columns, or return None if none is missing."""
    if header.has_frame and header.has_box:
        return None
    missing = [] if header.has_frame else ["frame"]
    missing += [name for name in ("x", "y") if name not in header.place]
    if not header.has_box:
        missing += [name for name in ("w", "h") if name not in header.place]
    return f"the columns {EXPECTED}; found {', '.join(header.names)}; missing: {', '.join(missing)}"


def _read_one(source: NamedColumns, number: int, own: str | None, options: ReadOptions) -> FilePart:
    """Read all boxes of a file, with their `_Classes`."""
    header = source.header
    columns, line, has_decimal_comma = source.parse(_columns_to_read(header, options.role))
    lines = Lines.of(source.file, line)
    header, findings = _with_varying_score(columns, source, options.role)
    used = {header.place[str(name)] for name in columns}
    other = [name for i, name in enumerate(header.names) if name and i not in used]
    unused = [name for name in other if name.lower() not in source.read_later]
    facts = [f"columns left unused: {', '.join(unused)}"] if unused else []
    facts += [f"column {name}: a log of alerts" for name in other if name not in unused]
    facts += ["decimal commas"] if has_decimal_comma else []
    recording: Any
    if "frame" in columns:
        recording = _named(columns["recording"], lines) if own is None else own
        times = times_as_frames(columns["frame"].to_numpy(), recording, options, lines)
        if times is None:
            named = None
            frame, frame_fact = _frames(columns["frame"].to_numpy(), lines, options.frame_base)
        else:
            of_picture, frame, named = times
            recording = of_picture if named.is_joined else recording
            frame_fact = ""
    else:
        recording, frame, named = places_of_pictures(
            columns["picture"],
            options,
            lambda row, name: lines.fault(
                row,
                "expected a frame number at the end of the picture's name, found "
                f"{name!r}; add a column frame",
            ),
        )
        frame_fact = "recordings and frame numbers from the pictures' names"
        if "recording" in columns:
            recording = _named(columns["recording"], lines)
    facts.append(frame_fact)
    box, box_fact = _boxes(columns, source, options)
    facts.append(box_fact)
    values: dict[str, Any] = {
        name: columns[name].to_numpy()
        for name in ("score", "distance_m", "ignore", "detectability")
        if name in columns
    }
    if "detectability" in values:
        checked_numbers(values["detectability"], lines, "detectability", high=1)
    if "distance_m" in values:
        findings += odd_distances(values["distance_m"], lines, options.role)
        values["distance_m"] = known_distances(values["distance_m"])
    if "track" in columns:
        values["track"], has_text = track_numbers(columns["track"], recording)
        facts += [TEXT_IDS] if has_text else []
    if "occlusion" in columns:
        level = columns["occlusion"].to_numpy()
        values["occlusion"] = levels_of_numbers(level)
        findings += odd_levels(level, lines, options.role)
    if options.role == "truth" and "score" in header.place:
        findings.append(
            warning(
                "truth-with-scores",
                len(lines),
                "The ground truth has a score column, which is left unused.",
                "Check that the truth and a system's detections are not swapped.",
                role="truth",
                file=source.file.name,
                example="line 1",
            )
        )
    findings += _misspelt(source, options.role)
    boxes = lines.boxes(box, recording=recording, frame=frame, file=number, **values)
    attributes = None
    if "attributes" in columns:
        facts.append("attributes as classes of encounters")
        attributes = attributes_of_boxes(boxes, columns["attributes"], MISSING)
    reading = Reading(
        boxes,
        recordings_table(()),
        "",
        findings=tuple(findings),
        attributes=attributes,
        named=named,
    )
    return FilePart(reading, facts, _classes_of(columns))


def _boxes(
    columns: pd.DataFrame, source: NamedColumns, options: ReadOptions
) -> tuple[tuple[np.ndarray, ...], str]:
    """Convert the columns of boxes to x, y, w, h in pixels, with conversion text."""
    if "right" in columns:
        left, top, right, bottom = (columns[name].to_numpy() for name in ("x", "y", *_CORNER))
        with np.errstate(invalid="ignore"):  # infinite corners: reported as rows that are no box
            return (left, top, right - left, bottom - top), (
                "corners to width and height (right edge = x + w)"
            )
    if "xc" not in columns:
        return tuple(columns[name].to_numpy() for name in "xywh"), ""
    numbers = columns[["xc", "yc", "w", "h"]].to_numpy()
    fact = "centres to left, top"
    if len(numbers) and np.nanmax(np.abs(numbers), initial=0) <= MAX_SHARE:
        if options.size is None:
            raise MissingFactError(
                "boxes are shares of the picture: its size is needed",
                file=source.file.name,
                facts=("size",),
            )
        numbers = numbers * [*options.size, *options.size]
        fact = f"shares of the picture to pixels of {options.size[0]} x {options.size[1]}; {fact}"
    middle, size = numbers[:, :2], numbers[:, 2:]
    with np.errstate(invalid="ignore"):
        return (*(middle - size / 2).T, *size.T), fact


def _with_varying_score(
    columns: pd.DataFrame, source: NamedColumns, role: Role
) -> tuple[Header, list[Finding]]:
    """Take the second column of scores if only that one varies, and drop it otherwise."""
    header = source.header
    if OTHER_SCORE not in columns:
        return header, []
    second = pd.to_numeric(columns.pop(OTHER_SCORE).astype(object), errors="coerce")
    score = columns["score"]
    if score.min() < score.max() or not second.min() < second.max():
        return header, []
    columns["score"] = second.astype(float)
    constant, varying = (header.names[header.place[name]] for name in ("score", OTHER_SCORE))
    finding = warning(
        "constant-score-column",
        len(columns),
        f"The column {constant} is the same throughout, while {varying} varies: {varying} is "
        "taken for the score.",
        f"If {constant} is meant, leave out the column {varying}.",
        role=role,
        file=source.file.name,
        example="line 1",
    )
    return replace(header, place={**header.place, "score": header.place[OTHER_SCORE]}), [finding]


def _misspelt(source: NamedColumns, role: Role) -> list[Finding]:
    """Report unused columns whose names are similar to those of known columns."""
    return [
        warning(
            "misspelt-column",
            1,
            f"The column {name} is left unused; {meant}, which it may be, is missing.",
            f"If it is meant, call it {meant}; else there is nothing to do.",
            role=role,
            file=source.file.name,
            example="line 1",
        )
        for name, meant in misspelt_columns(source.header, _OF_OTHERS[role])
    ]


@dataclass(frozen=True)
class _Classes:
    """Classes of the rows of a file.

    Attributes
    ----------
    key
        Name or number of each row's class.
    names
        Names of the numbers, if a column of the file gives them. Otherwise empty.
    """

    key: pd.Series
    names: Mapping[str, str]


def _classes_of(columns: pd.DataFrame) -> _Classes | None:
    """Return the classes of a file, with numbers normalized ("0.0" is 0)."""
    if "class" not in columns:
        return None
    key = pd.Series(names_as_categories(columns["class"], len(columns)))
    texts = [str(text) for text in key.cat.categories]
    plain = [text.removesuffix(".0") for text in texts]
    if not all(map(str.isdecimal, plain)):
        return _Classes(key, {})
    if len({*plain}) == len(plain):
        key = key.cat.rename_categories(dict(zip(texts, plain, strict=True)))
    names: dict[str, str] = {}
    if "class_name" in columns:
        pairs = pd.DataFrame({"key": key, "name": columns["class_name"]}).drop_duplicates()
        if pairs["key"].is_unique:  # otherwise the column is no name of the number
            names = dict(zip(pairs["key"].astype(str), pairs["name"].astype(str), strict=True))
    return _Classes(key, names)


def _classes(
    kinds: Sequence[_Classes | None], files: Sequence[SourceFile], options: ReadOptions
) -> tuple[Mapping[str, str], CategoryChoice | None, Mapping[str, str]]:
    """Return the names stated in files, the choice of classes over all files, and names by key.

    Without classes there is no choice. Files with a single class are about that class.
    """
    counts: Counter[Any] = Counter()
    stated: dict[str, str] = {}
    for kind in kinds:
        if kind is not None:
            counts.update(kind.key.value_counts().to_dict())
            stated |= kind.names
    first = next((file for file, kind in zip(files, kinds, strict=True) if kind is not None), None)
    if first is None:
        return {}, None, {}
    if all(map(str.isdecimal, counts)):
        named = names_of_numbers(counts, ClassNames(stated), options, "list")
    else:
        named = ClassNames({key: key for key in counts})
        only = next(iter(counts))
        concerned = options.objects.is_lookalike(only) and not options.objects.is_kind(only)
        if options.classes is None and len(counts) == 1 and not concerned:
            findings = [
                warning(
                    "single-class",
                    counts[only],
                    f"All boxes are of the class {only}, and all count.",
                    options.objects.say("Check that they are {many}."),
                    role=options.role,
                    file=first.name,
                    steps=(Step(Remedy.CLASSES, only),),
                )
            ]
            is_odd = not options.objects.concerns(only)
            choice = CategoryChoice(
                (only,),
                conversion=f"class {only} throughout: counted",
                findings=tuple(findings) if is_odd else (),
            )
            return {}, choice, named.names
    return stated, choose_categories(counts, named, options, file=first.name), named.names


def _sorted_by_class(
    boxes: pd.DataFrame, key: pd.Series, choice: CategoryChoice, label_of: Mapping[str, str]
) -> pd.DataFrame:
    """Drop boxes of other classes, add labels, and turn lookalikes into ignore regions."""
    ignore = boxes["ignore"].to_numpy() | key.isin(choice.ignored).to_numpy()
    boxes = boxes.assign(ignore=ignore, label=codes_of(key, label_of))
    return select_boxes(boxes, ~key.isin(choice.others).to_numpy())


def _columns_to_read(header: Header, role: Role) -> list[str]:
    """List the columns to read, preferring the clearer of two equivalent ones."""
    left_aside = {*_OF_OTHERS[role]}
    left_aside |= {"picture"} if "frame" in header.place else set()
    # next to corners, width and height are often those of the picture
    has_corners = {"right", "bottom"} <= header.place.keys() and not header.has_centres
    left_aside |= {"w", "h"} if has_corners else {"right", "bottom"}
    left_aside |= {"x", "y"} if header.has_centres else {"xc", "yc"}
    return [name for name in header.place if name not in left_aside]


def _named(recording: pd.Series, lines: Lines) -> pd.Categorical:
    """Return the recording of each row, or raise FormatError for an empty field."""
    names = names_as_categories(recording, len(recording))
    if "" in names.categories:
        lines.refuse(
            names.codes == names.categories.get_loc(""),
            lambda _row: "expected the name of a recording, found an empty field",
        )
    return names


def _frames(values: np.ndarray, lines: Lines, base: int | None) -> tuple[np.ndarray, str]:
    """Convert frame numbers, and describe the conversion."""
    frame = whole_numbers(values, lines, "frame")
    if base is None:
        return frame, "frame numbers as they are"
    lines.refuse(
        frame < base,
        lambda row: (
            f"expected frame numbers from {base} on, as declared by the frame base; found "
            f"{frame[row]}"
        ),
    )
    if base == 0:
        return frame, "frame numbers as they are (0-based)"
    return frame - base, f"frame numbers from {base}-based to 0-based"


FORMAT = Format("csv", "plain CSV", BOTH_ROLES, (".csv", ".tsv", ".txt"), recognise, read)
