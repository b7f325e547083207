"""Read a file of estimates, and join them to their truth boxes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding
from nvcore.common.wording import MOST_NAMED, listed, one_line, shortened
from nvcore.dataset import Dataset
from nvcore.dataset.columns import offsets_of
from nvcore.dataset.schema import (
    DETECTABILITY_COLUMNS,
    NO_TRACK,
    categories_of,
    names_as_categories,
)
from nvcore.inputs.assign_frames import REASONS, FramePlaces
from nvcore.inputs.files.find import digest
from nvcore.inputs.readers.base import Lines, SourceFile, warning
from nvcore.inputs.readers.csv.columns import Header, csv_content, read_columns, read_header
from nvcore.inputs.readers.meaning.values import checked_numbers
from nvcore.inputs.readers.parse.text import whole_numbers
from nvcore.inputs.session import Session
from nvcore.inputs.session.added import Input, with_files
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.joining import join_frames
from nvcore.subjects.driver.inputs.record import EstimateRecord, estimate_json, read_estimate_record
from nvcore.subjects.driver.inputs.session import DETECTABILITY

NEEDED: Final = ("recording", "frame", "x", "y", "w", "h", "detectability")
OPTIONAL: Final = ("track", "sd", "is_outside", "period_s")
_CALLED: Final = {"sd": "detectability_sd"}
"""Columns that have another name in a dataset."""


def read_detectability(file: SourceFile) -> pd.DataFrame:
    """Read a file of estimates: ``recording,frame,x,y,w,h,detectability`` and more.

    Columns may have any order. track, sd, is_outside and period_s are optional, and unknown columns
    are ignored. An empty detectability is unknown. An empty period_s means that no change of light
    is known.

    Returns
    -------
    Columns recording (category), frame, x, y, w, h (px), track (`NO_TRACK`: none), detectability,
    detectability_sd, is_outside, is_adapted, line (1-based); one row per row of the file.

    Raises
    ------
    FormatError
        If a column is missing, or a value is not a number or outside 0 to 1, with file and line.
    """
    content = csv_content(file, role="truth")
    header = _header(file, content)
    names = list(header.place)
    columns, line, _ = read_columns(file, header, content, names)
    lines = Lines.of(file, line)
    recording = names_as_categories(columns["recording"], len(lines))
    if "" in recording.categories:
        is_empty = np.asarray(recording == "")
        if is_empty.any():
            message = "expected the name of a recording, found an empty field"
            raise lines.fault(int(np.argmax(is_empty)), message)
    table: dict[str, object] = {
        "recording": recording,
        "frame": whole_numbers(columns["frame"].to_numpy(), lines, "frame"),
        **{name: columns[name].to_numpy() for name in "xywh"},
        "track": _tracks(columns, lines),
        "detectability": checked_numbers(
            columns["detectability"].to_numpy(), lines, "detectability", high=1
        ),
        "detectability_sd": np.full(len(lines), np.nan),
        "is_outside": np.zeros(len(lines), dtype=bool),
        "is_adapted": np.zeros(len(lines), dtype=bool),
        "line": line,
    }
    if "detectability_sd" in columns:
        sd = checked_numbers(columns["detectability_sd"].to_numpy(), lines, "sd")
        table["detectability_sd"] = sd
    if "is_outside" in columns:
        table["is_outside"] = columns["is_outside"].to_numpy(dtype=bool)
    if "period_s" in columns:
        period_s = checked_numbers(columns["period_s"].to_numpy(), lines, "period_s")
        table["is_adapted"] = np.isnan(period_s)
    return pd.DataFrame(table, copy=False)


def _header(file: SourceFile, content: bytes) -> Header:
    line = read_header(content[: content.find(b"\n")].decode())
    place = {name.lower(): number for number, name in reversed([*enumerate(line.names)])}
    missing = [name for name in NEEDED if name not in place]
    if missing:
        expected = f"{','.join(NEEDED)}[,{','.join(OPTIONAL)}]"
        raise file.fault(
            f"expected a header line with the columns {expected}; found {', '.join(line.names)}; "
            f"missing: {', '.join(missing)}",
            1,
        )
    known = {_CALLED.get(name, name): place[name] for name in (*NEEDED, *OPTIONAL) if name in place}
    return Header(line.names, line.delimiter, known)


def _tracks(columns: pd.DataFrame, lines: Lines) -> np.ndarray:
    """Return the track of each row, `NO_TRACK` for missing ids and for all text ids."""
    none = np.full(len(lines), NO_TRACK)
    if "track" not in columns or isinstance(columns["track"].dtype, pd.CategoricalDtype):
        return none
    track = columns["track"].to_numpy(dtype=float)
    is_known = ~np.isnan(track)
    none[is_known] = whole_numbers(track[is_known], lines[is_known], "track")
    return none


TOLERANCE_PX: Final = 1e-3 * (1 + 1e-6)
"""Maximum difference between a coordinate of an estimate and its box."""
MOST_SHOWN: Final = 160
"""Maximum length of a recording's name with its doubt, characters."""
NO_SUCH_BOX: Final = "no such box"
"""Reason for leaving out a row of estimates, beside `nvcore.inputs.assign_frames.REASONS`."""


def with_detectability(dataset: Dataset, session: Session) -> Dataset:
    """Return the dataset with the detectability from its session's file.

    Each row is joined to the truth box of the same recording and frame whose four coordinates
    differ by at most a thousandth of a pixel, and whose track is the same if both have one. Rows
    without such a box are left out and reported. Values in the file take precedence over the ground
    truth's own values, which stay for boxes without a value in the file.

    Raises
    ------
    InputError
        If the file or its record cannot be used, with file and line.
    """
    name: str = session.driver.detectability
    file, provenance = SourceFile(session.folder / name, name), session.driver.provenance
    record, told = EstimateRecord(), b""
    if provenance is not None:
        record = read_estimate_record(session.folder / provenance, provenance)
        told = estimate_json(record)
    sha256, table = digest([file])[0], read_detectability(file)
    titles = {entry.name: entry.title for entry in session.recordings if entry.title is not None}
    recording = _called(table["recording"], dataset, titles)
    row_of, reason = _join(dataset, table.assign(recording=recording))
    is_joined = row_of >= 0
    has_value = is_joined & table["detectability"].notna().to_numpy()
    columns: dict[str, Any] = {}
    for column in DETECTABILITY_COLUMNS:
        columns[column] = dataset.boxes[column].to_numpy(copy=True)
        columns[column][row_of[has_value]] = table[column].to_numpy()[has_value]
    lost = table[~is_joined]
    left_out = pd.DataFrame(
        {
            "subject": DETECTABILITY,
            "recording": lost["recording"].astype(object),
            "frame": lost["frame"],
            "file": np.int32(len(dataset.inputs)),
            "line": lost["line"].astype(np.int32),
            "reason": reason[~is_joined],
        }
    )
    joined = f"{int(is_joined.sum()):,} of {len(table):,} rows joined to boxes of the truth"
    rows = [part for part in (dataset.left_out, left_out) if len(part)] or [dataset.left_out]
    value = columns["detectability"]
    own = _with_origins(record, dataset, value, row_of[has_value])
    return with_files(
        dataset,
        session,
        DETECTABILITY,
        [name],
        [sha256],
        says=f"{DETECTABILITY} {sha256}\n".encode() + told,
        conversion="; ".join(filter(None, (joined, record.made_by, record.caution))),
        boxes=dataset.boxes.assign(**columns),
        left_out=pd.concat(rows, ignore_index=True).reindex(columns=list(dataset.left_out)),
        findings=_findings(dataset, record, sha256, value, name),
        of_subjects={**dataset.of_subjects, "driver": own},
    )


def _called(recording: pd.Series[str], dataset: Dataset, titles: Mapping[str, str]) -> Any:
    """Translate recording names of the file to the dataset's, by title or name in the data."""
    known = set(dataset.recordings["name"])
    texts = [name if name in known else titles.get(name, name) for name in recording.cat.categories]
    unique = list(dict.fromkeys(texts))
    place = np.array([unique.index(text) for text in texts], dtype=np.int64)
    return categories_of(place[recording.cat.codes.to_numpy()], unique)


def _join(dataset: Dataset, table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return the truth row of each estimate, -1 for none, and why it has none, shape (n,)."""
    frames, truth = dataset.frame_columns, dataset.truth
    listed = [frames.frame[start:stop] for start, stop in pairwise(frames.first)]
    frame_row, fault = FramePlaces(dataset.recordings["name"], listed).of(table)
    placed = np.flatnonzero(fault == 0)
    placed = placed[np.argsort(frame_row[placed], kind="stable")]
    row = np.full(len(placed), -1)
    sides = tuple(np.ascontiguousarray(table[name].to_numpy()[placed]) for name in "xywh")
    over_ranges(
        join_frames,
        len(frames),
        truth.arrays,
        offsets_of(frame_row[placed], len(frames)),
        sides,
        table["track"].to_numpy()[placed],
        TOLERANCE_PX,
        row,
    )
    row_of = np.full(len(table), -1)
    row_of[placed] = row
    reason = np.array(REASONS, dtype=object)[fault]
    reason[placed[row < 0]] = NO_SUCH_BOX
    return row_of, reason


def _with_origins(
    record: EstimateRecord, dataset: Dataset, detectability: np.ndarray, estimated: np.ndarray
) -> EstimateRecord:
    """Add the names of recordings with estimates and with ground-truth values to the record.

    Parameters
    ----------
    detectability
        Values for all boxes, those of the truth first, shape (n_boxes,).
    estimated
        Rows of the truth boxes with a value in the file.
    """
    is_known = ~np.isnan(detectability[: len(dataset.truth)])
    is_estimated = np.zeros_like(is_known)
    is_estimated[estimated] = True
    recording = dataset.frame_columns.recording[dataset.truth.frame_index]
    names = dataset.recordings["name"].to_numpy()
    return replace(
        record,
        estimated_in=frozenset(names[np.unique(recording[is_estimated])]),
        stated_in=frozenset(names[np.unique(recording[is_known & ~is_estimated])]),
    )


def _findings(
    dataset: Dataset, record: EstimateRecord, sha256: str, detectability: np.ndarray, name: str
) -> Iterator[Finding]:
    """Yield warnings about the file of estimates and its record.

    Parameters
    ----------
    detectability
        Values for all boxes including those of the file, truth boxes first, shape (n_boxes,).
    """
    stated = dataset.detectability.value
    differs = ~np.isnan(stated) & (stated != detectability[: len(stated)])
    is_other = bool(record.files) and sha256 not in record.files.values()
    for code, n, message, advice in (
        (
            "detectability-twice",
            int(differs.sum()),
            "The ground truth states another detectability of these boxes than the file of "
            "estimates; the file's is taken.",
            "Leave one of the two out.",
        ),
        (
            "detectability-other-record",
            int(is_other),
            "The record of how detectability was estimated is about another file.",
            "Correct the path, or estimate anew: until then nobody knows how these came to be.",
        ),
        (
            "doubtful-light-meter",
            len(record.light_doubts),
            "The light meter may be of another unit or clock, and with it how long the eyes have "
            f"adapted: {_doubted(record.light_doubts)}.",
            "Give time_s in seconds of the recording and lux in lux, and estimate anew.",
        ),
        (
            "doubtful-visible-pictures",
            len(record.picture_doubts),
            "Pictures or gaze from which detectability was estimated may be of another view: "
            f"{_doubted(record.picture_doubts)}.",
            "Look at the boxes in these pictures (page Driver). Correct the pictures, visible_map "
            "or the gaze, and estimate anew.",
        ),
    ):
        if n:
            yield warning(code, n, message, advice, role=DETECTABILITY, file=name)


def _doubted(doubts: Mapping[str, str]) -> str:
    """Return the recordings with their doubts as text of limited length."""
    whose = [f"{one_line(name)} ({one_line(why)})" for name, why in doubts.items()]
    return listed([shortened(text, MOST_SHOWN) for text in whose], most=MOST_NAMED)


INPUT: Final = Input(
    name=DETECTABILITY,
    is_named=lambda session: session.driver.detectability is not None,
    join=with_detectability,
)
