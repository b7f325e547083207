"""Plain CSV with a header that names its columns: ``frame,x,y,w,h`` and more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from nvcore.errors import FormatError
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    annotated_frames,
    concat_boxes,
    reading_boxes,
    recording_row,
    recordings_table,
)
from nvcore.inputs.readers.coco.images import place_of_picture
from nvcore.inputs.readers.csv_columns import Header, csv_content, read_columns, read_header
from nvcore.inputs.readers.meaning.categories import CategoryChoice, choose_categories, is_lookalike
from nvcore.inputs.readers.meaning.names import recordings_of
from nvcore.inputs.readers.meaning.occlusion import levels_of_numbers, odd_levels
from nvcore.inputs.readers.meaning.tracks import TEXT_IDS, track_numbers
from nvcore.inputs.readers.parse.text import whole_numbers

ParseColumns = Callable[[Sequence[str]], tuple[pd.DataFrame, np.ndarray, bool]]
"""Wanted columns -> what `nvcore.inputs.readers.csv_columns.read_columns` returns."""


@dataclass(frozen=True)
class NamedColumns:
    """Boxes in columns that a header names: a CSV file, or a table in memory."""

    file: SourceFile
    header: Header
    parse: ParseColumns


EXPECTED = "frame,x,y,w,h[,score,track,ignore,distance_m,occlusion,recording]"


def recognise(name: str, head: str, role: Role) -> bool:
    """Whether the first line names the columns of a frame and a box."""
    del name, role
    lines = head.lstrip("\ufeff").splitlines()
    if not lines or lines[0].lstrip().startswith(("<", "{", "[", "%", "#")):
        return False
    header = read_header(lines[0])
    return header.has_frame and header.has_box


def read(files: Sequence[SourceFile], options: ReadOptions) -> Reading:
    """Read plain CSV files; a file without a recording column is one recording.

    Frames and pixels are kept as they are, unless ``options.frame_base`` is given: then the first
    frame becomes 0.

    Raises
    ------
    FormatError
        With file and line of what is missing or is no number.
    """
    tables = []
    for file in files:
        content = csv_content(file, role=options.role)
        header = read_header(content.split(b"\n", 1)[0].decode())
        lack = lacking_columns(header)
        if lack is not None:
            raise FormatError(f"expected a header line with {lack}", file=file.name, line=1)
        tables.append(NamedColumns(file, header, partial(read_columns, file, header, content)))
    return read_named_columns(tables, options)


def read_named_columns(inputs: Sequence[NamedColumns], options: ReadOptions) -> Reading:
    """One reading from files or tables whose columns are named; see `read`.

    Raises
    ------
    FormatError
        With file and line of what is no number.
    """
    files = [each.file for each in inputs]
    whole = [
        number
        for number, each in enumerate(inputs)
        if "recording" not in each.header.place and "frame" in each.header.place
    ]
    names, facts = recordings_of([files[number].name for number in whole], options.recordings)
    recording_of_file = dict(zip(whole, names, strict=True))
    tables, kinds, rows = [], [], []
    findings: list[Finding] = []
    facts = ["pixels as they are (0-based)", *facts]
    for number, each in enumerate(inputs):
        own = recording_of_file.get(number)
        boxes, kind, what, oddities = _read_one(each, number, own, options)
        findings += oddities
        if options.role == "truth" and "score" in each.header.place:
            findings.append(_truth_with_scores(each.file, len(boxes)))
        tables.append(boxes)
        kinds.append(kind)
        facts += [fact for fact in what if fact not in facts]
    annotated = None
    choice = _classes(kinds, files, options)
    if choice is not None:
        every = concat_boxes(tables)
        annotated = annotated_frames(every["recording"].to_numpy(), every["frame"].to_numpy())
        facts.append(choice.conversion)
        tables = [
            boxes if kind is None else _sorted_by_class(boxes, kind, choice, options.role)
            for boxes, kind in zip(tables, kinds, strict=True)
        ]
    for number, boxes in enumerate(tables):
        own = recording_of_file.get(number)
        rows += [recording_row(name) for name in ([own] if own else boxes["recording"].unique())]
    return Reading(
        boxes=concat_boxes(tables),
        recordings=recordings_table(rows),
        conversion="; ".join(facts),
        annotated=annotated,
        findings=tuple(findings),
    )


def _truth_with_scores(file: SourceFile, n_rows: int) -> Finding:
    return Finding(
        severity=Severity.WARNING,
        code="truth-with-scores",
        subject="truth",
        count=n_rows,
        message="The ground truth has a score column, which is left unused.",
        advice="Check that the truth and a system's detections are not swapped.",
        file=file.name,
        example="line 1",
    )


def lacking_columns(header: Header) -> str | None:
    """Which columns are expected, found and missing, in words; None if none is missing."""
    if header.has_frame and header.has_box:
        return None
    missing = [] if header.has_frame else ["frame"]
    missing += [name for name in ("x", "y") if name not in header.place]
    if not header.has_box:
        missing += [name for name in ("w", "h") if name not in header.place]
    found = ", ".join(header.names)
    return f"the columns {EXPECTED}; found {found}; missing: {', '.join(missing)}"


def _read_one(
    source: NamedColumns, number: int, own: str | None, options: ReadOptions
) -> tuple[pd.DataFrame, pd.Series | None, list[str], list[Finding]]:
    """All boxes of a file, the class of each, the conversion in words, and what is odd."""
    file, header = source.file, source.header
    wanted = _wanted(header, options.role)
    columns, line, has_decimal_comma = source.parse(wanted)
    unused = [n for i, n in enumerate(header.names) if n and i not in _places(header, wanted)]
    facts = [f"columns left unused: {', '.join(unused)}"] if unused else []
    facts += ["decimal commas"] if has_decimal_comma else []
    if "frame" in columns:
        frame, what = _frames(columns["frame"].to_numpy(), file, line, options.frame_base)
        recording = _named(columns["recording"], file, line) if own is None else own
    else:
        recording, frame = _places_of_pictures(columns["picture"], file, line, options)
        what = "recordings and frame numbers from the pictures' names"
        if "recording" in columns:
            recording = _named(columns["recording"], file, line)
    facts.append(what)
    x, y = columns["x"].to_numpy(), columns["y"].to_numpy()
    values: dict[str, object] = {}
    findings: list[Finding] = []
    if "right" in columns:
        with np.errstate(invalid="ignore"):  # infinite corners: reported as rows that are no box
            w, h = columns["right"].to_numpy() - x, columns["bottom"].to_numpy() - y
        facts.append("corners to width and height (right edge = x + w)")
    else:
        w, h = columns["w"].to_numpy(), columns["h"].to_numpy()
    if "track" in columns:
        names = np.full(len(columns), own) if own is not None else np.asarray(recording)
        values["track"], has_text = track_numbers(columns["track"], names)
        facts += [TEXT_IDS] if has_text else []
    if "occlusion" in columns:
        level = columns["occlusion"].to_numpy()
        values["occlusion"] = levels_of_numbers(level)
        findings = odd_levels(level, file, line, options.role)
    ignore = columns["ignore"].to_numpy() if "ignore" in columns else np.zeros(len(line), bool)
    for name in ("score", "distance_m"):
        if name in columns:
            values[name] = columns[name].to_numpy()
    boxes = reading_boxes(
        len(line),
        recording=recording,
        frame=frame,
        x=x,
        y=y,
        w=w,
        h=h,
        ignore=ignore,
        file=number,
        line=line,
        **values,
    )
    return boxes, columns.get("class"), facts, findings


def _classes(
    kinds: Sequence[pd.Series | None], files: Sequence[SourceFile], options: ReadOptions
) -> CategoryChoice | None:
    """The choice of classes over all files; those of a single class are about that one."""
    given = [(file, kind) for file, kind in zip(files, kinds, strict=True) if kind is not None]
    if not given:
        return None
    names = {str(name): str(name) for _, kind in given for name in kind.unique()}
    if options.classes is None and len(names) <= 1 and not any(map(is_lookalike, names)):
        return CategoryChoice(tuple(names), (), (), f"class {''.join(names)} throughout: counted")
    return choose_categories(names, options.classes, file=given[0][0].name)


def _sorted_by_class(
    boxes: pd.DataFrame, kind: pd.Series, choice: CategoryChoice, role: Role
) -> pd.DataFrame:
    """Boxes without those of other classes; lookalikes are ignore regions of the truth."""
    keep = ~kind.isin(choice.left_out).to_numpy()
    is_neutral = kind.isin(choice.ignored).to_numpy()
    if role == "truth":
        boxes = boxes.assign(ignore=boxes["ignore"].to_numpy() | is_neutral)
    else:
        keep &= ~is_neutral
    return boxes if keep.all() else boxes[keep].reset_index(drop=True)


def _wanted(header: Header, role: Role) -> list[str]:
    """Columns that are read: of two ways to say one thing, the clearer."""
    left_aside = {"score"} if role == "truth" else {"ignore"}
    left_aside |= {"picture"} if "frame" in header.place else set()
    # beside corners, width and height are often those of the picture
    has_corners = {"right", "bottom"} <= header.place.keys()
    left_aside |= {"w", "h"} if has_corners else {"right", "bottom"}
    return [name for name in header.place if name not in left_aside]


def _named(recording: pd.Series, file: SourceFile, line: np.ndarray) -> np.ndarray:
    is_empty = recording.eq("").to_numpy()
    if is_empty.any():
        raise FormatError(
            "expected the name of a recording, found an empty field",
            file=file.name,
            line=int(line[int(np.argmax(is_empty))]),
        )
    return recording.to_numpy()


def _places(header: Header, wanted: Sequence[str]) -> set[int]:
    return {header.place[name] for name in wanted}


def _frames(
    values: np.ndarray, file: SourceFile, line: np.ndarray, base: int | None
) -> tuple[np.ndarray, str]:
    """Frame numbers, and in words what was done to them."""
    frame = whole_numbers(values, file, line, "frame")
    if base is None:
        return frame, "frame numbers as they are"
    if len(frame) and frame.min() < base:
        first = int(np.argmax(frame < base))
        raise FormatError(
            f"expected frame numbers from {base} on, as declared by the frame base; found "
            f"{frame[first]}",
            file=file.name,
            line=int(line[first]),
        )
    return frame - base, f"frame numbers from {base}-based to 0-based" if base else (
        "frame numbers as they are (0-based)"
    )


def _places_of_pictures(
    pictures: pd.Series, file: SourceFile, line: np.ndarray, options: ReadOptions
) -> tuple[np.ndarray, np.ndarray]:
    """Recording and frame of each row from the name of its picture."""
    codes, names = pd.factorize(pictures)
    places = [place_of_picture(str(name), options.recordings) for name in names]  # text: each once
    if None in places:
        wrong = places.index(None)
        raise FormatError(
            f"expected a frame number at the end of the picture's name, found {names[wrong]!r}; "
            "add a column frame",
            file=file.name,
            line=int(line[int(np.argmax(codes == wrong))]),
        )
    recording = np.array([place[0] for place in places if place], dtype=object)
    frame = np.array([place[1] for place in places if place], dtype=np.int64)
    return recording[codes], frame[codes]


FORMAT = Format(
    name="csv",
    title="plain CSV",
    roles=("truth", "detections"),
    suffixes=(".csv", ".tsv", ".txt"),
    recognise=recognise,
    read=read,
)
