"""Frame numbers of a system that run at another rate than those of the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np

from nvcore.auditing.cases import BoxSource
from nvcore.auditing.overlaps import MAX_SHIFT, rows_in_ranges
from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.session import Session
from nvcore.metrics.matching import iou_of_pairs

RATE_CODE: Final = "frame-rate"
MOST_FRAMES: Final = 150
"""Frames with detections that are compared."""
MIN_FRAMES: Final = 10
MIN_BOXES: Final = 30
"""Fewer frames or boxes are too few to judge."""
FITTING: Final = 0.8
"""Mean IoU from which on no other rate is looked for."""
STEADY: Final = (0.5, 0.7)
"""The same where it is as high in each third of the frames, up to this share of the best third: at
another rate boxes fit at one moment, and the less the farther from it."""
GAIN: Final = 0.1
"""Gain in mean IoU that another rate has to bring, if it fits well."""
MIN_IOU: Final = 0.4
"""Mean IoU that it has to reach."""
MOST_LOOKS: Final = 5
"""Rates, the best first, whose gain is measured on the frames that they leave."""
SURE: Final = 0.7
"""Mean IoU from which on another rate is no guess."""
CLOSE: Final = 0.1
"""IoU from which on a detection tells how far the boxes lie off."""
NEAR: Final = 0.02
"""Difference in mean IoU up to which the simpler rate is taken."""
RATIOS: Final = tuple(
    sorted(
        {Fraction(p, q) for p in range(1, 7) for q in range(1, 7)}
        | {Fraction(24, 25), Fraction(25, 24), Fraction(1000, 1001), Fraction(1001, 1000)},
        key=lambda ratio: ratio.numerator + ratio.denominator,
    )[1:]
)
"""Factors that are tried, the simplest first; 1 is not among them."""
MAX_OFFSET: Final = 3
"""Largest offset beside a factor, in listed frames."""
MAX_DRIFT: Final = 0.06
"""Largest difference of clocks, as a share."""
MOST_DRIFTS: Final = 60
"""Drifts that are tried to each side, of half a frame over the recording at least."""


@dataclass(frozen=True)
class _Rate:
    """Frame = factor x number + offset, the mean IoU that this gives, and how boxes lie off, px."""

    factor: float
    offset: int
    iou: float
    offset_px: tuple[float, float] = (0.0, 0.0)


def find_rate(source: BoxSource, detections: BoxColumns) -> list[Finding]:
    """Another frame rate of a system: frame = factor x number + offset makes its boxes fit.

    Half the rate, 25 against 30 frames a second, and clocks that drift apart are found; a mere
    offset is not looked for. Only where the boxes do not fit as they are.

    Parameters
    ----------
    source
        The system.
    detections
        Those of its detections that count.
    """
    trial = _Trial.of(source.dataset, detections)
    if trial is None or (now := trial.best_offset()).iou >= FITTING or trial.is_steady(now):
        return []
    step, taken = trial.step, _corrections(source)[1]
    offsets = sorted(range(-MAX_OFFSET, MAX_OFFSET + 1), key=abs)
    rates = [
        # an offset that was taken before is multiplied, too
        trial.rate(float(ratio), offset * step - round(float(ratio) * taken))
        for offset, ratio in product(offsets, RATIOS)
    ]
    by = max(0.5 * step / trial.span, MAX_DRIFT / MOST_DRIFTS)
    drifts = [drift for k in range(1, MOST_DRIFTS + 1) for drift in (k * by, -k * by)]
    drifting = [
        trial.rate(1 + drift, offset * step - taken)
        for drift, offset in product(drifts, (0, 1, -1))
        if abs(drift) <= MAX_DRIFT
    ]
    if drifting:  # else the frames are too few to tell a drift
        near = max(drifting, key=lambda rate: rate.iou)
        finer = [near.factor + k / 8 * by for k in range(-7, 8)]
        rates += [trial.rate(*at) for at in product(finer, (near.offset, near.offset + step))]
    for _ in range(MOST_LOOKS):
        most = max(rate.iou for rate in rates)
        if most < MIN_IOU:
            return []
        best = next(rate for rate in rates if rate.iou >= most - NEAR)  # the simplest of them
        if best.factor not in map(float, RATIOS):
            best = max(rates, key=lambda rate: rate.iou)
        # a rate that leaves but a part of the frames is held against an offset on that part
        part = replace(trial, rows=trial.targets(best.factor, best.offset)[0])
        now = part.best_offset()
        # the worse it fits, the likelier one of so many rates does by chance
        if best.iou - now.iou >= max(GAIN, 0.5 * (1 - best.iou)):
            return [_finding(source, now, best)]
        rates.remove(best)
    return []


def _corrections(source: BoxSource) -> tuple[float, int]:
    """Factor and offset of the frame numbers that the session gives the system already."""
    settings = source.dataset.settings
    if not isinstance(settings, Session):
        return 1.0, 0
    own = settings.systems[source.dataset.systems.index(source.name)]
    return own.frame_step, own.offset_frames


@dataclass(frozen=True)
class _Trial:
    """Some frames with detections, to be held against other frames of the truth."""

    dataset: Dataset
    detections: BoxColumns
    rows: np.ndarray
    """Rows of the frames table, int64, shape (n,)."""

    @classmethod
    def of(cls, dataset: Dataset, detections: BoxColumns) -> _Trial | None:
        rows = np.flatnonzero(np.diff(detections.offsets))
        if len(rows) < MIN_FRAMES or len(detections) < MIN_BOXES:
            return None
        return cls(dataset, detections, rows[:: -(-len(rows) // MOST_FRAMES)])

    @cached_property
    def keys(self) -> np.ndarray:
        """One number for recording and frame of each row of the frames table, sorted."""
        frames = self.dataset.frame_columns
        keys: np.ndarray = (frames.recording.astype(np.int64) << 40) + frames.frame
        return keys

    @cached_property
    def step(self) -> int:
        """Usual step between listed frames."""
        frames = self.dataset.frame_columns
        gaps = np.diff(frames.frame)[np.diff(frames.recording) == 0]
        return max(1, int(np.median(gaps))) if len(gaps) else 1

    @cached_property
    def span(self) -> int:
        """Largest frame number of those compared."""
        return max(1, int(np.abs(self.dataset.frame_columns.frame[self.rows]).max()))

    def best_offset(self) -> _Rate:
        """How well the boxes fit at the truth's rate, moved in time and in the picture."""
        shifts = [shift * self.step for shift in range(-MAX_SHIFT, MAX_SHIFT + 1)]
        rates = sorted((self.rate(1.0, shift) for shift in shifts), key=lambda rate: -rate.iou)
        det = self.detections
        for rate in rates[:MOST_LOOKS]:
            dx, dy = rate.offset_px
            moved = replace(self, detections=replace(det, x=det.x + dx, y=det.y + dy))
            rates.append(moved.rate(1.0, rate.offset))
        return max(rates, key=lambda rate: rate.iou)

    def is_steady(self, now: _Rate) -> bool:
        """Whether boxes fit as well from the first to the last frame number."""
        least, share = STEADY
        if now.iou < least:
            return False
        by_number = np.argsort(self.dataset.frame_columns.frame[self.rows], kind="stable")
        thirds = [
            replace(self, rows=np.sort(self.rows[part])).rate(1.0, now.offset).iou
            for part in np.array_split(by_number, 3)
        ]
        return min(thirds) >= share * max(thirds) > 0  # 0: too few to judge

    def targets(self, factor: float, offset: int) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the detections' frames and of those that they would be, where these are listed.

        Of several that come to one frame only the nearest stays.
        """
        frames = self.dataset.frame_columns
        exact = factor * frames.frame[self.rows] + offset
        target = np.floor(exact + 0.5).astype(np.int64)
        first = self.keys[self.rows] - frames.frame[self.rows]
        place = np.searchsorted(self.keys, first + target)
        place = np.minimum(place, len(frames.frame) - 1)
        is_listed = (frames.frame[place] == target) & (
            frames.recording[place] == frames.recording[self.rows]
        )
        ours, theirs = self.rows[is_listed], place[is_listed]
        if factor < 1:
            order = np.argsort(np.abs(exact - target)[is_listed], kind="stable")
            order = np.sort(order[np.unique(theirs[order], return_index=True)[1]])
            ours, theirs = ours[order], theirs[order]
        return ours, theirs

    def rate(self, factor: float, offset: int) -> _Rate:
        """How well the boxes fit at a rate; IoU 0 where too few frames are listed ones."""
        truth, det = self.dataset.truth, self.detections
        ours, theirs = self.targets(factor, offset)
        n_ours, n_theirs = np.diff(det.offsets)[ours], np.diff(truth.offsets)[theirs]
        has_both = n_theirs > 0
        if has_both.sum() < MIN_FRAMES:
            return _Rate(factor, offset, 0.0)
        # every detection of a frame with every pedestrian of the other
        number, d = rows_in_ranges(det.offsets[ours], n_ours)
        pair, g = rows_in_ranges(truth.offsets[theirs][number], n_theirs[number])
        iou = iou_of_pairs(
            *(tuple(side[rows] for side in of.xywh) for of, rows in ((det, d[pair]), (truth, g)))
        )
        used, pedestrian = np.unique(g, return_inverse=True)
        counts = ~truth.ignore[used]
        if min(len(d), counts.sum()) < MIN_BOXES:
            return _Rate(factor, offset, 0.0)
        of_detection, of_pedestrian = np.zeros(len(d)), np.zeros(len(used))
        np.maximum.at(of_detection, pair, iou)
        np.maximum.at(of_pedestrian, pedestrian, iou)
        # false alarms lower the one, misses the other
        mean = max(of_detection.mean(), of_pedestrian[counts].mean())
        close = (iou > CLOSE) & (iou == of_detection[pair])
        i, j = d[pair][close], g[close]
        moved = [
            float(np.median(t[j] + side[j] / 2 - p[i] - own[i] / 2)) if len(i) else 0.0
            for t, side, p, own in (
                (truth.x, truth.w, det.x, det.w),
                (truth.y, truth.h, det.y, det.h),
            )
        ]
        return _Rate(factor, offset, float(mean), (moved[0], moved[1]))


def _finding(source: BoxSource, now: _Rate, best: _Rate) -> Finding:
    """The finding, in the numbers that the files hold, whatever corrected them."""
    factor, offset = float(f"{best.factor:.6g}"), best.offset
    step, taken = _corrections(source)
    total, moved = factor * step, round(factor * taken) + offset
    behind = f" {'+' if moved > 0 else '-'} {abs(moved)}" if moved else ""
    [finding] = source.findings(
        Severity.ERROR if best.iou >= SURE else Severity.WARNING,
        RATE_CODE,
        np.arange(1),
        "The detections are numbered at another frame rate than the ground truth: as frame = "
        f"{total:g} x number{behind} they fit the {source.dataset.objects.plural} (mean IoU "
        f"{best.iou:.2f}, at best {now.iou:.2f} with an offset alone).",
        f"Multiply the frame numbers in this system's files by {total:g}, and move them by "
        f"{moved:+d} then. Frames that it did not see stay misses: evaluate both systems on those "
        "that it saw.".replace(", and move them by +0 then", ""),
        count=len(source.boxes),
        is_of_all=True,
    )
    suggestion = [("frame_step", factor)]
    suggestion += [("offset_frames", float(offset))] if offset else []
    return replace(
        finding,
        example="",
        suggestion=tuple(suggestion),
        steps=(Step(Remedy.FRAME_STEP, f"{total:g}", source.name),),
    )
