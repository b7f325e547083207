"""Datasets from tables in memory: sorted, checked, with a fingerprint."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.dataset.columns import frame_gaps
from nvcore.dataset.schema import (
    DATASET_BOX_DTYPES,
    DETECTABILITY_COLUMNS,
    FRAME_DTYPES,
    RECORDING_DTYPES,
    conform,
)
from nvcore.settings.defaults import MAX_FPS, MIN_FPS


def frames_table(
    frames_by_recording: Sequence[np.ndarray], fps: Sequence[float] | np.ndarray
) -> pd.DataFrame:
    """Create the frames table from each recording's listed frame numbers (sorted, unique)."""
    lengths = [len(frames) for frames in frames_by_recording]
    n_rows = sum(lengths)
    recording = np.repeat(np.arange(len(lengths)), lengths)
    frame = np.concatenate([*frames_by_recording, np.empty(0, np.int64)]).astype(np.int64)
    first = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    rate = np.repeat(np.asarray(fps, dtype=float), lengths)
    has_frames = np.array(lengths, dtype=int) > 0
    start = np.repeat(frame[first[:-1][has_frames]], [n for n in lengths if n])
    gap = frame_gaps(frame, first)
    columns: dict[str, object] = {
        "recording": recording,
        "frame": frame,
        "time_s": (frame - start) / rate,
        "step_s": gap / rate,
    }
    return conform(columns, FRAME_DTYPES, n_rows=n_rows)


def dataset_from_tables(
    recordings: pd.DataFrame,
    frames_by_recording: Sequence[np.ndarray],
    boxes: pd.DataFrame,
    systems: Sequence[str],
    *,
    fingerprint: str | None = None,
    **other_fields: object,
) -> Dataset:
    """Create a dataset from tables in memory.

    Parameters
    ----------
    recordings
        Columns name, width, height, fps, and optionally horizon, context, speed_kmh, tags and unit.
    frames_by_recording
        Listed frame numbers of each recording, sorted, unique.
    boxes
        frame_index, source and any of the other columns of `DATASET_BOX_DTYPES`, in any order;
        the order within a frame and source is kept.
    systems
        Names of the systems; source i + 1 is ``systems[i]``.
    fingerprint
        sha256 of the inputs; None: computed from the tables.
    other_fields
        Further fields of `Dataset`.

    Raises
    ------
    InputError
        If the size, the frame rate or the speed of a recording is not a positive number.
    """
    if "tags" not in recordings:
        recordings = recordings.assign(tags=pd.Series([()] * len(recordings), dtype=object).array)
    if "unit" not in recordings:
        recordings = recordings.assign(unit="")
    columns: dict[str, object] = {str(name): recordings[name].to_numpy() for name in recordings}
    recordings = conform(columns, RECORDING_DTYPES, n_rows=len(recordings))
    for name in ("width", "height", "fps", "speed_kmh"):
        values = recordings[name].to_numpy()
        bad = ~((values > 0) & np.isfinite(values))
        if name == "speed_kmh":
            bad &= ~np.isnan(values)
        if bad.any():
            first = int(np.argmax(bad))
            raise InputError(
                f"recording {recordings['name'][first]!r}: expected a positive {name}, found "
                f"{values[first]:g}; correct the size, the frame rate or the speed"
            )
    is_rate = recordings["fps"].between(MIN_FPS, MAX_FPS).to_numpy()
    if not is_rate.all():
        first = int(np.argmin(is_rate))
        raise InputError(
            f"recording {recordings['name'][first]!r}: expected a frame rate (fps) from "
            f"{MIN_FPS:g} to {MAX_FPS:g}, found {recordings['fps'][first]:g}; correct it"
        )
    frames = frames_table(frames_by_recording, recordings["fps"].to_numpy())
    columns_given: dict[str, object] = {str(name): boxes[name].to_numpy() for name in boxes}
    table = conform(columns_given, DATASET_BOX_DTYPES, n_rows=len(boxes))
    source, frame_index = table["source"].to_numpy(), table["frame_index"].to_numpy()
    is_before = (source[1:] < source[:-1]) | (
        (source[1:] == source[:-1]) & (frame_index[1:] < frame_index[:-1])
    )
    if is_before.any():
        key = source.astype(np.int64) * max(len(frames), 1) + frame_index
        table = table.iloc[np.argsort(key, kind="stable")].reset_index(drop=True)
    if fingerprint is None:
        tables = [what_is_stated(recordings), _frames_stated(frames), _boxes_stated(table)]
        fingerprint = tables_fingerprint(tables, systems)
    return Dataset(recordings, frames, table, tuple(systems), fingerprint, **other_fields)  # type: ignore[arg-type]


def what_is_stated(recordings: pd.DataFrame) -> pd.DataFrame:
    """Return the recordings for a fingerprint, without columns that are empty for all.

    Data without these columns thus keep the fingerprint from before the columns existed.
    """
    is_empty = {
        "tags": not any(recordings["tags"]),
        "context": recordings["context"].isna().all(),
        "speed_kmh": recordings["speed_kmh"].isna().all(),
        "unit": not any(recordings["unit"]),
    }
    return recordings.drop(columns=[name for name, empty in is_empty.items() if empty])


def _frames_stated(frames: pd.DataFrame) -> pd.DataFrame:
    """Return the frames for a fingerprint, without speeds if no series states any."""
    return frames.drop(columns="speed_kmh") if frames["speed_kmh"].isna().all() else frames


def _boxes_stated(boxes: pd.DataFrame) -> pd.DataFrame:
    """Return the boxes for a fingerprint, without labels and detectability if none has any.

    See `what_is_stated`.
    """
    unknown = [] if boxes["label"].ge(0).any() else ["label"]
    if boxes["detectability"].isna().all():
        unknown += DETECTABILITY_COLUMNS
    return boxes.drop(columns=unknown)


def tables_fingerprint(tables: Iterable[pd.DataFrame], systems: Sequence[str]) -> str:
    """Compute sha256 over the values of tables and the names of the systems."""
    digest = hashlib.sha256("\n".join(systems).encode())
    for table in tables:
        for name in table:
            values = table[name].to_numpy()
            if values.dtype == object:
                digest.update("\n".join(map(str, values)).encode())
            else:
                digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()
