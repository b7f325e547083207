"""Estimates put to the truth's boxes that they are about."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.columns import offsets_of
from nvcore.dataset import Dataset
from nvcore.driver.inputs.reading import read_detectability
from nvcore.driver.inputs.record import EstimateRecord, estimate_json, read_estimate_record
from nvcore.driver.inputs.session import DETECTABILITY
from nvcore.findings import Finding
from nvcore.inputs.added import Input, with_files
from nvcore.inputs.assign_frames import REASONS, FramePlaces
from nvcore.inputs.files import digest
from nvcore.inputs.readers.base import SourceFile, warning
from nvcore.inputs.session import Session
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.joining import join_frames
from nvcore.schema import DETECTABILITY_COLUMNS, categories_of
from nvcore.wording import MOST_NAMED, listed, one_line, shortened

TOLERANCE_PX: Final = 1e-3 * (1 + 1e-6)
"""Largest difference of a coordinate of an estimate and of its box."""
MOST_SHOWN: Final = 160
"""Characters of a recording's name with its doubt."""
NO_SUCH_BOX: Final = "no such box"
"""Why a row of estimates is left out, beside `nvcore.inputs.assign_frames.REASONS`."""


@dataclass(frozen=True)
class _Estimates:
    """A file of estimates, read."""

    file: SourceFile
    digest: str
    table: pd.DataFrame
    record: EstimateRecord | None


def with_detectability(dataset: Dataset, session: Session) -> Dataset:
    """The dataset with the detectability that its session names a file of.

    Each row is joined to the truth's box of the same recording and frame whose four coordinates
    differ by no more than a thousandth of a pixel, and whose track is the same where both have one.
    Rows without such a box are left out, and reported. A value of the file goes before what the
    truth itself says of the same box; where the file has none, that stays.

    Raises
    ------
    InputError
        If the file, or the record of how it came to be, cannot be used; with file and line.
    """
    name: str = session.driver.detectability
    file = SourceFile(session.folder / name, name)
    provenance = session.driver.provenance
    record = None
    if provenance is not None:
        record = read_estimate_record(session.folder / provenance, provenance)
    estimates = _Estimates(file, digest([file])[0], read_detectability(file), record)
    titles = {entry.name: entry.title for entry in session.recordings if entry.title is not None}
    row_of, reason = _join(
        dataset, _called(estimates.table["recording"], dataset, titles), estimates
    )
    return _joined(dataset, session, estimates, row_of, reason)


def _called(recording: pd.Series[str], dataset: Dataset, titles: Mapping[str, str]) -> Any:
    """The recordings as the dataset calls them: by title, else by their names in the data."""
    known = set(dataset.recordings["name"])
    texts = [name if name in known else titles.get(name, name) for name in recording.cat.categories]
    unique = list(dict.fromkeys(texts))
    place = np.array([unique.index(text) for text in texts], dtype=np.int64)
    return categories_of(place[recording.cat.codes.to_numpy()], unique)


def _join(dataset: Dataset, recording: Any, estimates: _Estimates) -> tuple[np.ndarray, np.ndarray]:
    """Truth row of each estimate, -1 none, and why it has none; int64 and object, shape (n,)."""
    table = estimates.table.assign(recording=recording)
    frames, truth = dataset.frame_columns, dataset.truth
    listed = [frames.frame[start:stop] for start, stop in pairwise(frames.first)]
    frame_row, fault = FramePlaces(dataset.recordings["name"], listed).of(table)
    placed = np.flatnonzero(fault == 0)
    placed = placed[np.argsort(frame_row[placed], kind="stable")]
    row = np.full(len(placed), -1)
    sides = [np.ascontiguousarray(table[name].to_numpy()[placed]) for name in ("x", "y", "w", "h")]
    over_ranges(
        join_frames,
        len(frames),
        *(truth.offsets, *truth.xywh, truth.track),
        *(offsets_of(frame_row[placed], len(frames)), *sides, table["track"].to_numpy()[placed]),
        *(TOLERANCE_PX, row),
    )
    row_of = np.full(len(table), -1)
    row_of[placed] = row
    reason = np.array(REASONS, dtype=object)[fault]
    reason[placed[row < 0]] = NO_SUCH_BOX
    return row_of, reason


def _joined(
    dataset: Dataset,
    session: Session,
    estimates: _Estimates,
    row_of: np.ndarray,
    reason: np.ndarray,
) -> Dataset:
    table, name = estimates.table, estimates.file.name
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
    says = f"{DETECTABILITY} {estimates.digest}\n".encode()
    record = estimates.record
    conversion = f"{int(is_joined.sum()):,} of {len(table):,} rows joined to boxes of the truth"
    if record is not None:
        says += estimate_json(record)
        facts = (conversion, record.made_by, record.caution)
        conversion = "; ".join(filter(None, facts))
    rows = [part for part in (dataset.left_out, left_out) if len(part)] or [dataset.left_out]
    return with_files(
        dataset,
        session,
        DETECTABILITY,
        [name],
        [estimates.digest],
        says=says,
        conversion=conversion,
        boxes=dataset.boxes.assign(**columns),
        left_out=pd.concat(rows, ignore_index=True).reindex(columns=list(dataset.left_out)),
        findings=(
            *_twice(dataset, columns["detectability"], name),
            *_of_other_file(estimates),
            *_of_doubtful_light(estimates),
            *_of_doubtful_pictures(estimates),
        ),
        of_subjects={
            **dataset.of_subjects,
            "driver": _with_origins(
                record or EstimateRecord(), dataset, columns["detectability"], row_of[has_value]
            ),
        },
    )


def _with_origins(
    record: EstimateRecord, dataset: Dataset, detectability: np.ndarray, estimated: np.ndarray
) -> EstimateRecord:
    """The record with the recordings whose values it is about, and those of the truth's own.

    Parameters
    ----------
    detectability
        Of all boxes, those of the truth first, shape (n_boxes,).
    estimated
        Rows of the truth's boxes that the file has a value of.
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


def _of_other_file(estimates: _Estimates) -> list[Finding]:
    """A warning where the record is about another file."""
    record = estimates.record
    if record is None or not record.files or estimates.digest in record.files.values():
        return []
    return [
        warning(
            "detectability-other-record",
            1,
            "The record of how detectability was estimated is about another file.",
            "Correct the path, or estimate anew: until then nobody knows how these came to be.",
            role=DETECTABILITY,
            file=estimates.file.name,
        )
    ]


def _of_doubtful_light(estimates: _Estimates) -> list[Finding]:
    """A warning where a light meter looks like one of another unit or clock."""
    doubts = {} if estimates.record is None else estimates.record.light_doubts
    if not doubts:
        return []
    return [
        warning(
            "doubtful-light-meter",
            len(doubts),
            "The light meter may be of another unit or clock, and with it how long the eyes have "
            f"adapted: {_doubted(doubts)}.",
            "Give time_s in seconds of the recording and lux in lux, and estimate anew.",
            role=DETECTABILITY,
            file=estimates.file.name,
        )
    ]


def _of_doubtful_pictures(estimates: _Estimates) -> list[Finding]:
    """A warning where pictures or gaze look like those of something else."""
    doubts = {} if estimates.record is None else estimates.record.picture_doubts
    if not doubts:
        return []
    return [
        warning(
            "doubtful-visible-pictures",
            len(doubts),
            "Pictures or gaze from which detectability was estimated may be of another view: "
            f"{_doubted(doubts)}.",
            "Look at the boxes in these pictures (page Driver). Correct the pictures, visible_map "
            "or the gaze, and estimate anew.",
            role=DETECTABILITY,
            file=estimates.file.name,
        )
    ]


def _doubted(doubts: Mapping[str, str]) -> str:
    """The recordings with what is in doubt, which may be anything."""
    whose = [f"{one_line(name)} ({one_line(why)})" for name, why in doubts.items()]
    return listed([shortened(text, MOST_SHOWN) for text in whose], most=MOST_NAMED)


def _twice(dataset: Dataset, detectability: np.ndarray, name: str) -> list[Finding]:
    """A warning where the truth says something else of a box than the file."""
    stated = dataset.detectability.value
    differs = ~np.isnan(stated) & (stated != detectability[: len(stated)])
    if not differs.any():
        return []
    return [
        warning(
            "detectability-twice",
            int(differs.sum()),
            "The ground truth states another detectability of these boxes than the file of "
            "estimates; the file's is taken.",
            "Leave one of the two out.",
            role=DETECTABILITY,
            file=name,
        )
    ]


INPUT: Final = Input(
    name=DETECTABILITY,
    is_named=lambda session: session.driver.detectability is not None,
    join=with_detectability,
)
