"""Units of resampling: whole recordings, or blocks of time if there are too few recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
import scipy

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import EVIDENCE_KEYS, counted, inference_of, measure_of
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.dataset.copies import units_of

RECORDINGS: Final = "recordings"
UNITS: Final = "units"
"""Kind of units made of one or several recordings, such as parts of a drive, or copies."""
BLOCKS: Final = "blocks"
WHOLE: Final = frozenset({RECORDINGS, UNITS})
"""Kinds of units that represent other recordings."""
MIN_RECORDINGS: Final = 6
"""Fewest recordings that represent others. With 5, p is at least 2 / 2^5 = 0.0625."""
OTHER_RECORDINGS: Final = "other recordings"
THESE_RECORDINGS: Final = "these recordings"
STRETCH: Final = 2
"""Length of the blocks as a multiple of the length that minimises the variance's error. In
simulations, tests at 5 % rejected 8 to 10 % of equal traces with that length, and 6 to 8 % with
twice the length."""
INSIGNIFICANT: Final = 2.0
"""Autocorrelations below this many times sqrt(log10(n) / n) count as zero."""
MAX_BLOCKS: Final = 1000
"""Most blocks in all recordings. More do not improve an interval, and longer ones are safer."""


@dataclass(frozen=True)
class Units:
    """Parts of a comparison that are drawn as a whole.

    Attributes
    ----------
    kind
        ``"recordings"``, ``"units"`` of several recordings, or ``"blocks"`` of time.
    unit_of_frame
        Unit of every listed frame, -1 if it is in none; int64, shape (n_frames,). Units are
        numbered by the recordings' names, then by time, so that the order of the recordings changes
        no number.
    recording
        Recording of each unit (the first one of several), a row of the recordings table; int64,
        shape (n_units,).
    n_recordings
        Number of recordings with frames.
    n_independent
        Number of recordings with frames, counting each unit once.
    block_s
        Mean duration of a block in seconds; NaN for recordings.
    of_recording
        Unit of each recording (the first one of several), -1 if it is in none; int64, shape
        (n_all_recordings,).
    """

    kind: str
    unit_of_frame: np.ndarray
    recording: np.ndarray
    n_recordings: int
    n_independent: int
    block_s: float
    of_recording: np.ndarray

    def __len__(self) -> int:
        return len(self.recording)

    def total(self, unit: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
        """Sum the weights by unit, skipping unit -1, float64, shape (n_units,).

        Without weights, each row counts 1.
        """
        is_in = unit >= 0
        weights = None if weights is None else weights[is_in]
        sums: np.ndarray = np.bincount(unit[is_in], weights, minlength=len(self))
        return sums.astype(float)

    @property
    def noun(self) -> str:
        """Noun for one unit: ``recording``, ``unit`` or ``block``."""
        return self.kind.removesuffix("s")

    @property
    def text(self) -> str:
        """Number and kind of the units, such as ``16 recordings``."""
        n = len(self)
        if self.kind in WHOLE:
            return f"{n:,} {self.noun}{'' if n == 1 else 's'}"
        return f"{n:,} block{'' if n == 1 else 's'} of {self.block_s:.3g} s"

    @property
    def scope(self) -> str:
        """Scope of intervals over these units."""
        return OTHER_RECORDINGS if self.kind in WHOLE else THESE_RECORDINGS

    @property
    def note(self) -> str:
        """Consequences of the choice of units, empty for recordings."""
        if self.kind == RECORDINGS:
            return ""
        n = self.n_recordings
        if self.kind == UNITS:
            return f"{n:,} recordings are {len(self):,} units, each of which counts as one"
        few, needed = "one recording only" if n == 1 else f"{n} recordings only", "recordings"
        if self.n_independent < n:
            few = f"{n:,} recordings, {self.n_independent} of them independent"
            needed = "independent recordings"
        return (
            f"{few}: intervals over blocks of time hold within these recordings, say nothing of "
            f"others, and have no p ({MIN_RECORDINGS} {needed} are needed)"
        )


def find_whole(dataset: Dataset) -> Units:
    """Return recordings as units, however few.

    Recordings that belong together (`nvcore.dataset.copies.units_of`) form one unit.
    """
    frames, with_frames = dataset.frame_columns, _by_name(dataset)
    shared = units_of(dataset)[with_frames]
    own = np.array([unit or row for unit, row in zip(shared, with_frames, strict=True)], object)
    number, labels = pd.factorize(own)  # in the order of their first recordings
    of_recording = np.full(len(dataset.recordings), -1, np.int64)
    of_recording[with_frames] = number
    first = np.unique(number, return_index=True)[1]
    return Units(
        kind=RECORDINGS if len(labels) == len(with_frames) else UNITS,
        unit_of_frame=of_recording[frames.recording],
        recording=with_frames[first].astype(np.int64),
        n_recordings=len(with_frames),
        n_independent=len(labels),
        block_s=np.nan,
        of_recording=of_recording,
    )


def _by_name(dataset: Dataset) -> np.ndarray:
    """Return the recordings with frames, sorted by name."""
    with_frames = np.flatnonzero(np.diff(dataset.frame_columns.first))
    names = dataset.recordings["name"].to_numpy()[with_frames].astype(str)
    by_name: np.ndarray = with_frames[np.argsort(names, kind="stable")]
    return by_name


def find_units(result: Result) -> Units:
    """Return recordings if there are at least `MIN_RECORDINGS`, else blocks of time within them.

    All blocks have about the same number of listed frames: `STRETCH` times the longest length
    (`block_length`) needed for the differences X - Y of similarity, of low frames and of false
    alarms, but at most `MAX_BLOCKS` in all. Every recording has at least one block.
    """
    whole, frames = find_whole(result.dataset), result.dataset.frame_columns
    if len(whole) >= MIN_RECORDINGS or not len(whole):
        return whole
    n_of = np.diff(frames.first)
    with_frames = _by_name(result.dataset)
    lengths = (STRETCH * block_length(trace, frames.first) for trace in _differences(result))
    length = max(-(-len(frames) // MAX_BLOCKS), *lengths)
    n_blocks, start = np.zeros((2, len(n_of)), np.int64)
    n_blocks[with_frames] = np.maximum(n_of[with_frames] // length, 1)
    start[with_frames] = np.cumsum(n_blocks[with_frames]) - n_blocks[with_frames]
    row, recording = np.arange(len(frames)), frames.recording
    place = (row - frames.first[recording]) * n_blocks[recording] // np.maximum(n_of[recording], 1)
    return Units(
        kind=BLOCKS,
        unit_of_frame=(start[recording] + place).astype(np.int64),
        recording=np.repeat(with_frames, n_blocks[with_frames]).astype(np.int64),
        n_recordings=len(with_frames),
        n_independent=len(whole),
        block_s=result.duration_s / n_blocks.sum(),
        of_recording=np.where(n_blocks > 0, start, -1),
    )


def count_whole(dataset: Dataset) -> tuple[int, str]:
    """Count the recordings with frames, each unit once, and return the noun for them."""
    has_frames = np.diff(dataset.frame_columns.first) > 0
    n = _count_independent(dataset, has_frames)
    return n, "recording" if n == np.count_nonzero(has_frames) else "unit"


def _count_independent(dataset: Dataset, recordings: np.ndarray) -> int:
    """Count these recordings (bool), each unit once."""
    shared = units_of(dataset)[recordings]
    return int(np.count_nonzero(shared == "")) + len(set(shared[shared != ""]))


def _differences(result: Result) -> tuple[np.ndarray, ...]:
    x, y, low = result.x, result.y, result.params.low
    return (
        x.similarity - y.similarity,
        (x.similarity < low).astype(float) - (y.similarity < low),
        (x.false_alarms - y.false_alarms).astype(float),
    )


def sum_units(result: Result, units: Units) -> pd.DataFrame:
    """Sum every unit, as the basis for measures over all units.

    Returns
    -------
    One row per unit: recording (row of the recordings), n_frames, duration_s, share_of_recording
    (number of recordings, or a block's share of one), n_encounters (not distant), counts of
    subjects (`nvcore.comparison.measures.table.counted`), and the sums of the parts of each measure
    that is judged by units. Their columns are the measure's key with ``_x`` and ``_y`` (NaN if it
    cannot be split into blocks of time). Encounters, episodes and events belong to the unit in
    which they begin.
    """
    unit, total = units.unit_of_frame, units.total
    frames, encounters = result.dataset.frame_columns, result.encounters
    begin = unit[encounters.first_row]
    if units.kind == BLOCKS:
        share = 1 / np.bincount(units.recording)[units.recording]
    else:
        share = total(units.of_recording)
    columns: dict[str, Any] = {
        "recording": units.recording,
        "n_frames": total(unit),
        "duration_s": total(unit, frames.gap / frames.fps[frames.recording]),
        "share_of_recording": share,
        "n_encounters": total(begin[result.is_near]),
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
    """Sum the parts of a measure in every unit, NaN if it has none."""
    inference, by_recording = inference_of(key), measure_of(key).by_recording
    if inference.per == "share_of_recording" and units.kind in WHOLE:
        assert by_recording is not None, key
        return units.total(units.of_recording, np.asarray(by_recording(result, system), float))
    assert inference.parts is not None, key
    parts = inference.parts(result, system)
    if parts is None:
        return np.full(len(units), np.nan)
    return units.total(units.unit_of_frame[parts.frame], parts.value)


def units_within(result: Result, units: Units, recordings: np.ndarray) -> Units:
    """Return the units with some of these recordings (bool). Other frames are in unit -1."""
    frames = result.dataset.frame_columns
    is_within = has_any_of(units, recordings)
    number = np.where(is_within, np.cumsum(is_within) - 1, -1)
    has_unit = (units.of_recording >= 0) & recordings
    n_units, n_recordings = int(np.count_nonzero(is_within)), int(np.count_nonzero(has_unit))
    is_here = recordings[frames.recording]
    block_s = np.nan
    if units.kind == BLOCKS and n_units:
        block_s = float(frames.step_s[is_here].sum()) / n_units
    return Units(
        kind=RECORDINGS if units.kind == UNITS and n_units == n_recordings else units.kind,
        unit_of_frame=np.where(is_here, np.append(number, -1)[units.unit_of_frame], -1),
        recording=units.recording[is_within],
        n_recordings=n_recordings,
        n_independent=_count_independent(result.dataset, has_unit),
        block_s=block_s,
        of_recording=np.where(has_unit, np.append(number, -1)[units.of_recording], -1),
    )


def has_any_of(units: Units, recordings: np.ndarray) -> np.ndarray:
    """Return which units have any of these recordings (bool). The result is bool, (n_units,)."""
    if units.kind == BLOCKS:
        within: np.ndarray = recordings[units.recording]
        return within
    chosen = units.of_recording[recordings & (units.of_recording >= 0)]
    return np.bincount(chosen, minlength=len(units)) > 0


def block_length(trace: np.ndarray, first: np.ndarray) -> int:
    """Return the block length in frames for resampling a trace in non-overlapping blocks.

    This is the automatic choice of Politis and White: the length that minimises the error of the
    bootstrap's variance, from the trace's autocorrelations up to the lag at which they fade. Blocks
    that do not overlap have a variance of ``2 * g(0)^2 * b / n``.

    Parameters
    ----------
    trace
        Difference of the two systems in every frame; float64, shape (n_frames,).
    first
        First row of each recording, shape (n_recordings + 1,); lags never cross recordings.

    Returns
    -------
    At least 1, at most a third of the frames or ``3 * sqrt(n_frames)``.

    References
    ----------
    Politis and White (2004), Automatic block-length selection for the dependent bootstrap, with
    the correction by Patton, Politis and White (2009); Lahiri (1999), Theoretical comparisons of
    block bootstrap methods.
    """
    n = len(trace)
    if n < 2:
        return 1
    n_quiet = max(5, int(np.log10(n)))
    covariance = autocovariance(trace, first, n_lags=int(np.ceil(np.sqrt(n))) + n_quiet)
    # the autocorrelation of a constant trace is rounding
    if covariance[0] <= 1e-20 * max(1.0, float(np.abs(trace).max()) ** 2):
        return 1
    n_lags = len(covariance) - 1
    is_quiet = np.abs(covariance[1:] / covariance[0]) < INSIGNIFICANT * np.sqrt(np.log10(n) / n)
    # the last lag after which `n_quiet` lags in a row are quiet
    quiet_before = np.concatenate([[0], np.cumsum(is_quiet)])
    n_runs = max(len(quiet_before) - n_quiet, 0)
    runs = quiet_before[n_quiet:] - quiet_before[:n_runs] == n_quiet
    if runs.any():
        last = int(np.argmax(runs))
    else:
        loud = np.flatnonzero(~is_quiet)
        last = int(loud[-1]) + 1 if len(loud) else 0
    width = min(2 * max(last, 1), n_lags)
    if width < 1:
        return 1
    lag = np.arange(1, width + 1)
    window = np.minimum(1, 2 * (1 - lag / width))
    tapered = window * covariance[1 : width + 1]
    bias = 2 * float((lag * tapered).sum())
    long_run = float(covariance[0] + 2 * tapered.sum())
    most = max(1, int(min(3 * np.sqrt(n), n / 3)))
    if long_run <= 0:
        return most
    best = (bias**2 / long_run**2) ** (1 / 3) * n ** (1 / 3)
    return int(min(max(np.ceil(best), 1), most))


def autocovariance(trace: np.ndarray, first: np.ndarray, *, n_lags: int) -> np.ndarray:
    """Return the autocovariance at lags 0..n_lags within recordings, over the number of all frames.

    There are fewer lags if the longest recording has fewer frames.
    """
    deviation = trace - trace.mean()
    parts: Sequence[np.ndarray] = np.split(deviation, first[1:-1])
    n_lags = min(n_lags, max(len(part) for part in parts) - 1)
    total = np.zeros(n_lags + 1)
    for part in parts:  # a loop over recordings: few where blocks are used
        if len(part):
            products = scipy.signal.correlate(part, part, method="fft")[len(part) - 1 :][
                : n_lags + 1
            ]
            total[: len(products)] += products
    covariance: np.ndarray = total / len(trace)
    return covariance
