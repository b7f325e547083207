"""What is resampled: whole recordings, or blocks of time where recordings are too few."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.block_length import block_length
from nvcore.measures.table import EVIDENCE_KEYS, counted, inference_of, measure_of
from nvcore.schema import Category
from nvcore.scoring import SystemResult

RECORDINGS: Final = "recordings"
BLOCKS: Final = "blocks"
MIN_RECORDINGS: Final = 6
"""Fewest recordings that say anything of others: with 5, p is at least 2 / 2^5 = 0.0625."""
OTHER_RECORDINGS: Final = "other recordings"
THESE_RECORDINGS: Final = "these recordings"
STRETCH: Final = 2
"""Length of the blocks in lengths that minimise the variance's error: in simulations, tests at 5 %
rejected 8 to 10 % of equal traces with that length, 6 to 8 % with twice the length."""
MAX_BLOCKS: Final = 1000
"""Most blocks of all recordings: more do not improve an interval, and longer ones are safer."""


@dataclass(frozen=True)
class Units:
    """Parts of a comparison that are drawn as a whole.

    Attributes
    ----------
    kind
        ``"recordings"`` or ``"blocks"`` of time.
    unit_of_frame
        Unit of every listed frame; int64, shape (n_frames,). Numbered by the recordings' names,
        then by time, so that the order of the recordings changes no number.
    recording
        Recording of each unit, a row of the recordings table; int64, shape (n_units,).
    n_recordings
        Recordings with frames.
    block_s
        Mean duration of a block in seconds; NaN for recordings.
    """

    kind: str
    unit_of_frame: np.ndarray
    recording: np.ndarray
    n_recordings: int
    block_s: float

    def __len__(self) -> int:
        return len(self.recording)

    @property
    def text(self) -> str:
        """What the units are, such as ``16 recordings``."""
        n = len(self)
        if self.kind == RECORDINGS:
            return f"{n:,} recording{'' if n == 1 else 's'}"
        return f"{n:,} block{'' if n == 1 else 's'} of {self.block_s:.3g} s"

    @property
    def scope(self) -> str:
        """What intervals over these units are about."""
        return OTHER_RECORDINGS if self.kind == RECORDINGS else THESE_RECORDINGS

    @property
    def note(self) -> str:
        """What the choice of units means; empty for recordings."""
        if self.kind == RECORDINGS:
            return ""
        n = self.n_recordings
        few = "one recording only" if n == 1 else f"{n} recordings only"
        return (
            f"{few}: intervals over blocks of time hold within these recordings, say nothing of "
            f"others, and have no p ({MIN_RECORDINGS} recordings are needed)"
        )


def find_units(result: Result) -> Units:
    """Recordings where there are at least `MIN_RECORDINGS`, else blocks of time within them.

    All blocks have about the same number of listed frames: `STRETCH` times the longest length that
    the differences X - Y need (`block_length`), of similarity, of low frames and of false
    alarms; at most `MAX_BLOCKS` in all. Every recording has at least one block.
    """
    frames = result.dataset.frame_columns
    n_of = np.diff(frames.first)
    with_frames = np.flatnonzero(n_of)
    names = result.dataset.recordings["name"].to_numpy()[with_frames].astype(str)
    with_frames = with_frames[np.argsort(names, kind="stable")]
    n_blocks = np.zeros(len(n_of), np.int64)
    if len(with_frames) >= MIN_RECORDINGS or not len(with_frames):
        kind = RECORDINGS
        n_blocks[with_frames] = 1
    else:
        kind = BLOCKS
        lengths = (STRETCH * block_length(trace, frames.first) for trace in _differences(result))
        length = max(-(-len(frames) // MAX_BLOCKS), *lengths)
        n_blocks[with_frames] = np.maximum(n_of[with_frames] // length, 1)
    start = np.zeros(len(n_of), np.int64)
    start[with_frames] = np.cumsum(n_blocks[with_frames]) - n_blocks[with_frames]
    row, recording = np.arange(len(frames)), frames.recording
    place = (row - frames.first[recording]) * n_blocks[recording] // np.maximum(n_of[recording], 1)
    n_units = int(n_blocks.sum())
    return Units(
        kind=kind,
        unit_of_frame=(start[recording] + place).astype(np.int64),
        recording=np.repeat(with_frames, n_blocks[with_frames]).astype(np.int64),
        n_recordings=len(with_frames),
        block_s=result.duration_s / n_units if kind == BLOCKS else np.nan,
    )


def _differences(result: Result) -> tuple[np.ndarray, ...]:
    x, y, low = result.x, result.y, result.params.low
    return (
        x.similarity - y.similarity,
        (x.similarity < low).astype(float) - (y.similarity < low),
        (x.false_alarms - y.false_alarms).astype(float),
    )


def sum_units(result: Result, units: Units) -> pd.DataFrame:
    """Sums of every unit, from which measures over all units are computed.

    Returns
    -------
    One row per unit: recording (row of the recordings), n_frames, duration_s, share_of_recording
    (1, or a block's part of it), n_encounters (not distant), those that subjects count
    (`nvcore.measures.table.counted`); and, for each measure that is judged by units, the sums of
    its parts: its key with ``_x`` and ``_y`` (NaN where it cannot be shared out to blocks of time).
    Encounters, episodes and events belong to the unit in which they begin.
    """
    n, unit = len(units), units.unit_of_frame
    frames, encounters = result.dataset.frame_columns, result.encounters
    is_near = result.category != Category.DISTANT.value

    def total(unit_of: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
        sums: np.ndarray = np.bincount(unit_of, weights=weights, minlength=n).astype(float)
        return sums

    begin = unit[encounters.first_row]
    n_frames, per_recording = total(unit), np.bincount(units.recording)
    columns: dict[str, Any] = {
        "recording": units.recording,
        "n_frames": n_frames,
        "duration_s": total(unit, frames.gap) / frames.fps[units.recording],
        "share_of_recording": 1 / per_recording[units.recording],
        "n_encounters": total(begin[is_near]),
        **{name: total(begin[members(result)]) for name, members in counted().items()},
    }
    for letter, system in result.sides:
        columns |= {
            f"{key}_{letter}": _sum_of(key, result, system, units)
            for key in EVIDENCE_KEYS
            if inference_of(key).test == "units"
        }
    return pd.DataFrame(columns)


def _sum_of(key: str, result: Result, system: SystemResult, units: Units) -> np.ndarray:
    """Sum of the parts of a measure in every unit; NaN where it has none."""
    inference, by_recording = inference_of(key), measure_of(key).by_recording
    if inference.per == "share_of_recording" and units.kind == RECORDINGS:
        assert by_recording is not None, key
        of_units: np.ndarray = by_recording(result, system)[units.recording]
        return of_units
    assert inference.parts is not None, key
    parts = inference.parts(result, system)
    if parts is None:
        return np.full(len(units), np.nan)
    unit = units.unit_of_frame[parts.frame]
    return np.bincount(unit, weights=parts.value, minlength=len(units)).astype(float)


def units_within(result: Result, units: Units, recordings: np.ndarray) -> Units:
    """The units of some recordings; frames of the others are in unit -1."""
    frames = result.dataset.frame_columns
    is_within = recordings[units.recording]
    number = np.where(is_within, np.cumsum(is_within) - 1, -1)
    recording = units.recording[is_within]
    block_s = np.nan
    if units.kind == BLOCKS and len(recording):
        is_here = recordings[frames.recording]
        block_s = float(frames.step_s[is_here].sum()) / len(recording)
    return Units(
        units.kind, number[units.unit_of_frame], recording, len(np.unique(recording)), block_s
    )
