"""Detection of recordings whose truth is nearly that of another one: rounded, mirrored, redrawn.

Time series of each recording that neither scale, shift nor mirroring changes are correlated, which
proposes pairs and the frames between them. A transform of boxes that gives most of them a partner
confirms a pair, unless it does so at other times, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from nvcore.dataset import Dataset

LEAST_BOXES: Final = 40
"""Fewest boxes with a partner."""
LEAST_SHARE: Final = 0.8
"""Least share of the smaller recording's boxes with a partner.

Recordings of different people reach 0.7, rarely 0.8 (short ones), redrawn ones 0.9 and more.
"""
TOLERANCE: Final = 0.12
"""Largest distance of partners' centres in heights, and difference of the logs of heights."""
LEAST_REDRAWN: Final = 0.02
LEAST_REDRAWN_PX: Final = 0.8
"""Median distances of partners, relative and in px, that rounding does not explain."""
LEAST_EVIDENCE: Final = 9.0
"""Least evidence: stretches of time and place with partners, times -log of their misfit.

The misfit is the median distance and a third of the share without a partner. It takes 3 stretches
that fit well, or 4: one person may walk alike in two recordings.
"""
LEAST_SCALED: Final = 0.02
"""Logs of a scale up to this are chance, and the scale is 1."""
LAGS: Final = (24, 12)
"""Frames before and after at which boxes must not agree as well, as in a scene at rest."""
LEAST_BESIDE: Final = 0.4
"""Least share of boxes in frames of both at such a lag; else the next one is taken."""
MOST_BESIDE: Final = 0.75
"""Largest share of boxes with partners at such a lag, relative to that at the shift."""
LEAST_SCORE: Final = 0.6
"""Least correlation of two recordings' time series for an alignment."""
MOST_FAILURES: Final = 4
"""Most alignments of a recording that fail."""
N_BINS: Final = 256
"""Bins of time of the longest recording in the search for pairs."""
MOST_BINS: Final = 1 << 17
"""Most bins in the alignment of a pair."""
N_NEIGHBOURS: Final = 150
"""Recordings with the next larger numbers of boxes to which each is compared."""
SAMPLE: Final = 300
"""Most boxes whose partners are looked for until a pair is confirmed."""
MOST_PAIRS: Final = 2_000_000
"""Most pairs of boxes compared when it is: of a crowd, only every n-th box is looked at."""


class Boxes(NamedTuple):
    """Boxes of a recording, sorted by frame: frame, centre, height, px, and the height's log."""

    frame: np.ndarray
    x: np.ndarray
    y: np.ndarray
    h: np.ndarray
    log_h: np.ndarray

    def take(self, rows: np.ndarray | slice) -> Boxes:
        """Return some of the boxes."""
        return Boxes(*(column[rows] for column in self))


class Match(NamedTuple):
    """Boxes with a partner in another recording, and how to get there.

    ``x_second = sign * scale * x_first + right``, ``y_second = scale * y_first + down``, and the
    frame number in the second recording is larger by `shift`. `error` is the median distance of
    partners (see `TOLERANCE`), also in px; `first` and `second` are rows of boxes.
    """

    shift: int
    sign: int = 1
    scale: float = 1.0
    right: float = 0.0
    down: float = 0.0
    error: float = np.inf
    error_px: float = np.inf
    first: np.ndarray = np.empty(0, np.int64)
    second: np.ndarray = np.empty(0, np.int64)

    @property
    def n(self) -> int:
        """Number of boxes with a partner."""
        return min(len(self.first), len(self.second))

    def relation(self, *, is_reversed: bool) -> str:
        """Describe what was done to the boxes of the first, or of the second if reversed."""
        scale = 1 / self.scale if is_reversed else self.scale
        way = -1 if is_reversed else 1
        is_redrawn = self.error > LEAST_REDRAWN and self.error_px > LEAST_REDRAWN_PX
        done = ["mirrored"] * (self.sign < 0)
        if abs(np.log(scale)) > (0.1 if is_redrawn else 0):
            done.append(f"scaled by {scale:.2g}")
        elif self.sign > 0 and max(abs(self.right), abs(self.down)) > 0.5 and not is_redrawn:
            right, down = (round(way * by, 1) + 0.0 for by in (self.right, self.down))
            done.append(f"moved by {right:.1f}, {down:.1f} px")
        if is_redrawn:
            done.append("annotated again")
        return " and ".join(done) or "the same but for rounding"


def find_near_copies(
    dataset: Dataset, n_boxes: np.ndarray, linked: Iterable[tuple[int, int]]
) -> Iterator[tuple[int, int, float, int, str]]:
    """Find recordings whose boxes are those of another one, up to a transform and small errors.

    Parameters
    ----------
    n_boxes
        Number of boxes of each recording, int64, shape (n_recordings,).
    linked
        Recordings that are known to be copies, and are not compared again.

    Yields
    ------
    first, second
        Rows of the recordings table, ``first < second``.
    share
        Boxes with a partner, as a share of those of the recording with fewer boxes.
    shift
        Frame number in the second recording minus that in the first.
    relation
        What was done to the boxes, in words.
    """
    truth, columns = dataset.truth, dataset.frame_columns
    if np.count_nonzero(n_boxes >= LEAST_BOXES) < 2:
        return
    log_h = np.log(np.maximum(truth.h, 1e-9))
    centre = truth.x + 0.5 * truth.w, truth.y + 0.5 * truth.h
    every = Boxes(columns.frame[truth.frame_index], *centre, truth.h, log_h)
    step = np.maximum(1, columns.sampling_step.astype(np.int64))
    rows = [slice(end - n, end) for end, n in zip(np.cumsum(n_boxes), n_boxes, strict=True)]
    group, n_failed = np.arange(len(n_boxes)), np.zeros(len(n_boxes), np.int64)
    for first, second in linked:
        group[group == group[second]] = group[first]
    for few, many, *shift in _candidates(every, n_boxes, int(step[n_boxes > 0].min())):
        if group[few] == group[many] or max(n_failed[[few, many]]) >= MOST_FAILURES:
            continue
        pair = every.take(rows[few]), every.take(rows[many])
        found = _confirmed(*pair, *shift, steps=step[[few, many]])
        if found is None:
            n_failed[[few, many]] += 1
            continue
        group[group == group[many]] = group[few]
        match, share = found
        relation = match.relation(is_reversed=few > many)
        by = match.shift if few < many else -match.shift
        yield min(few, many), max(few, many), share, by, relation


def _candidates(
    boxes: Boxes, n_boxes: np.ndarray, step: int, *, n_bins: int = N_BINS
) -> Iterator[tuple[int, int, int, int]]:
    """Yield pairs of recordings, the shift between them, and its error, by falling correlation.

    The shift is a frame number in the second recording minus that in the first. Its error is the
    length of a bin.
    """
    from scipy.fft import irfft, next_fast_len, rfft

    is_long = n_boxes >= LEAST_BOXES
    rows = np.flatnonzero(is_long)
    rows = rows[np.argsort(n_boxes[rows], kind="stable")]
    if len(rows) < 2:
        return
    ends = np.cumsum(n_boxes)
    start = boxes.frame[np.minimum(ends - n_boxes, len(boxes.frame) - 1)]
    span = np.where(is_long, boxes.frame[ends - 1] - start, 0)
    width = step * -(-(int(span.max()) + 1) // (n_bins * step))
    series = _series(boxes, n_boxes, start, span // width, width)[:, rows]
    n_varying = np.count_nonzero(series.any(axis=2), axis=0)
    size = next_fast_len(2 * series.shape[2], real=True)
    spectrum = rfft(series, size)
    found: list[np.ndarray] = []
    for k in range(1, min(len(rows), N_NEIGHBOURS + 1)):  # a loop over neighbours: hundreds
        product = (spectrum[:, :-k].conj() * spectrum[:, k:]).sum(axis=0)
        correlation = irfft(product, size)
        lag = correlation.argmax(axis=1)
        score = correlation[np.arange(len(lag)), lag] / np.maximum(
            1, np.minimum(n_varying[:-k], n_varying[k:])
        )
        at = np.flatnonzero(score >= LEAST_SCORE)
        lag = np.where(lag > size // 2, lag - size, lag)[at]
        first, second = rows[at], rows[at + k]
        shift = lag * width + start[second] - start[first]
        found.append(np.column_stack([-score[at], first, second, shift]))
    pairs = np.concatenate(found)
    for _, first, second, shift in pairs[np.lexsort(pairs.T[::-1])].tolist():
        yield int(first), int(second), int(shift), width


def _series(
    boxes: Boxes, n_boxes: np.ndarray, start: np.ndarray, last_bin: np.ndarray, width: int
) -> np.ndarray:
    """Return time series that no shift, scale or mirroring changes, float32, (3, n, n_bins).

    Each is a sum over the boxes of a bin: their number, logs of heights, and distances from the
    mean column in mean heights. Mean 0 and length 1 over a recording; 0 if constant.
    """
    n, n_bins = len(n_boxes), int(last_bin.max()) + 1
    recording = np.repeat(np.arange(n), n_boxes)
    at = (boxes.frame - start[recording]) // width
    at = recording * n_bins + np.minimum(at, last_bin[recording])
    of_all = np.maximum(n_boxes, 1)
    mean_x, mean_h, mean_log = (
        np.bincount(recording, values, n) / of_all for values in (boxes.x, boxes.h, boxes.log_h)
    )
    aside = np.abs(boxes.x - mean_x[recording]) / mean_h[recording]
    series = np.stack(
        [
            np.bincount(at, weights, n * n_bins).reshape(n, n_bins)
            for weights in (None, boxes.log_h - mean_log[recording], aside)
        ]
    ).astype(np.float32)
    is_within = np.arange(n_bins) <= last_bin[:, None]
    series -= (series.sum(axis=2) / (last_bin + 1))[:, :, None]
    series *= is_within
    length = np.sqrt((series**2).sum(axis=2, keepdims=True))
    scaled: np.ndarray = np.divide(series, length, out=np.zeros_like(series), where=length > 1e-3)
    return scaled


def _confirmed(
    a: Boxes, b: Boxes, shift: int, error: int, *, steps: np.ndarray
) -> tuple[Match, float] | None:
    """Return how the boxes of `a`, the smaller recording, agree with those of `b`, and their share.

    None if too few agree, or as many at other times. `steps` are the sampling steps of both.
    """
    step, long_step = int(steps.min()), int(steps.max())
    if error != step:
        both = Boxes(*(np.concatenate(pair) for pair in zip(a, b, strict=True)))
        n_boxes = np.array([len(a.frame), len(b.frame)])
        *_, shift, _ = next(_candidates(both, n_boxes, step, n_bins=MOST_BINS), (shift, error))
    few = _every(a, 1 + len(a.frame) // SAMPLE)
    enough = LEAST_SHARE * len(few.frame)
    match = _align(few, b, shift)
    if match.n < 0.6 * enough:
        return None
    near = [match, *(_align(few, b, shift + lag * step) for lag in (-1, 1, -2, 2))]
    match = max(near, key=lambda match: match.n * (1 - 2 * min(match.error, 0.5)))
    if match.n < enough or _share_beside(few, b, match, long_step) > MOST_BESIDE:
        return None
    n_pairs = len(a.frame) * len(b.frame) / (1 + (b.frame[-1] - b.frame[0]) // step)
    many = _every(a, 1 + int(n_pairs / MOST_PAIRS))
    match = _align(many, b, match.shift)
    share = match.n / len(many.frame)
    if share < LEAST_SHARE or match.n < LEAST_BOXES:
        return None
    n_pieces = _n_pieces(many.take(match.first), long_step)
    misfit = max(match.error, LEAST_REDRAWN) + (1 - share) / 3
    is_sure = -n_pieces * np.log(misfit) >= LEAST_EVIDENCE
    return (match, share) if is_sure else None


def _every(boxes: Boxes, n: int) -> Boxes:
    """Return the boxes of every n-th frame that has any."""
    is_next = np.diff(boxes.frame, prepend=boxes.frame[0]) != 0
    return boxes.take(np.cumsum(is_next) % n == 0) if n > 1 else boxes


def _share_beside(a: Boxes, b: Boxes, match: Match, step: int) -> float:
    """Return the mean share of partners some time before and after, relative to that of a match.

    1 if the recordings are too short to tell.
    """
    for lag in LAGS:
        shares = []
        for shift in (match.shift - lag * step, match.shift + lag * step):
            at = a.frame + shift
            n = np.count_nonzero((at >= b.frame[0]) & (at <= b.frame[-1]))
            if n >= LEAST_BESIDE * len(at):
                shares.append(_align(a, b, shift).n / n)
        if shares:
            return sum(shares) / len(shares) * len(a.frame) / match.n
    return 1.0


def _n_pieces(boxes: Boxes, step: int) -> int:
    """Return the number of boxes that continue none of the frames before."""
    continues = np.zeros(len(boxes.frame), bool)
    for lag in range(1, 6):
        i, j = _same_frame(boxes, boxes, -lag * step)
        off = np.hypot(boxes.x[j] - boxes.x[i], boxes.y[j] - boxes.y[i]) / boxes.h[i]
        is_near = (off < 0.5) & (np.abs(boxes.log_h[j] - boxes.log_h[i]) < 0.3)
        continues[i[is_near]] = True
    return int(np.count_nonzero(~continues))


def _align(a: Boxes, b: Boxes, shift: int) -> Match:
    """Find the transform that gives most boxes of `a` a partner in `b`, `shift` frames later."""
    i, j = _same_frame(a, b, shift)
    ratio = b.log_h[j] - a.log_h[i]
    if len(i):  # most pairs are of different people; the typical heights are of all
        is_usual = np.abs(ratio - np.median(b.log_h[j]) + np.median(a.log_h[i])) <= 2 * TOLERANCE
        near = np.abs(ratio - _densest(ratio[is_usual], TOLERANCE)) <= 2 * TOLERANCE
        i, j = i[near], j[near]
    return max((_fitted(a, b, shift, i, j, sign) for sign in (1, -1)), key=lambda match: match.n)


def _fitted(a: Boxes, b: Boxes, shift: int, i: np.ndarray, j: np.ndarray, sign: int) -> Match:
    """Fit the transform to pairs of boxes, most of which have the same ratio of heights."""
    match = Match(shift)
    if not len(i):
        return match
    width, ratio = TOLERANCE * b.h[j].mean(), b.log_h[j] - a.log_h[i]
    log_scale = float(np.median(ratio))
    scale = np.exp(log_scale)
    right = _densest(b.x[j] - sign * scale * a.x[i], width)
    near = np.abs(b.x[j] - sign * scale * a.x[i] - right) <= 2 * width
    down = _densest((b.y[j] - scale * a.y[i])[near], width)
    for tolerance in (2 * TOLERANCE, TOLERANCE, TOLERANCE):  # again, by the boxes that agree
        off_x, off_y = b.x[j] - sign * scale * a.x[i], b.y[j] - scale * a.y[i]
        away = np.maximum(np.abs(off_x - right), np.abs(off_y - down)) / b.h[j]
        away = np.maximum(away, np.abs(ratio - log_scale))
        fits = away <= tolerance
        if not fits.any():
            return Match(shift)
        found = np.unique(i[fits]), np.unique(j[fits])
        error, error_px = (float(np.median(of[fits])) for of in (away, away * b.h[j]))
        match = Match(shift, sign, float(scale), right, down, error, error_px, *found)
        log_scale = float(np.median(ratio[fits]))
        scale = np.exp(log_scale) if abs(log_scale) > LEAST_SCALED else 1.0
        right = float(np.median((b.x[j] - sign * scale * a.x[i])[fits]))
        down = float(np.median((b.y[j] - scale * a.y[i])[fits]))
    return match


def _same_frame(a: Boxes, b: Boxes, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rows of all pairs of boxes of both, `b` being `shift` frames later."""
    start = np.searchsorted(b.frame, a.frame + shift)
    n = np.searchsorted(b.frame, a.frame + shift, side="right") - start
    i = np.repeat(np.arange(len(n)), n)
    return i, np.arange(len(i)) + np.repeat(start - np.cumsum(n) + n, n)


def _densest(values: np.ndarray, width: float) -> float:
    """Return the middle value of the fullest window, NaN without values."""
    if not len(values):
        return np.nan
    ordered = np.sort(values)
    n = np.searchsorted(ordered, ordered + width, side="right") - np.arange(len(ordered))
    at = int(n.argmax())
    return float(ordered[at + n[at] // 2])
