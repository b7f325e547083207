"""Constant errors of a system that ruin a comparison: in scale, in time, in position."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from nvcore.auditing.cases import BoxSource
from nvcore.auditing.overlaps import MAX_SHIFT, Correction, Overlaps, Sample, take_sample
from nvcore.auditing.rows import listed_ranges
from nvcore.auditing.scales import letterboxes, scale_candidates, scale_text
from nvcore.columns import BoxColumns
from nvcore.findings import Finding, Severity
from nvcore.inputs.evaluated_frames import nth

MIN_BOXES: Final = 50
"""Fewer pedestrians, or fewer overlapping detections, are too few to judge."""
TIME_GAIN: Final = 0.03
"""Gain in mean IoU from which on a time offset is reported."""
PIXEL_GAIN: Final = 0.02
"""Gain in mean IoU that a pixel offset has to bring, too."""
MIN_IOU: Final = 0.15
"""Mean IoU that a pixel offset has to reach: boxes that then still miss were not just moved."""
LOOSE_IOU: Final = 0.3
"""Overlap from which on a detection is taken for the pedestrian's when offsets are measured."""
LOOSEST_IOU: Final = 0.1
"""The same for the first look, when the boxes may still stand far off."""
MAX_SPREAD: Final = 1.5
"""Largest distance between the quartiles of a constant offset's differences, in offsets."""
MIN_OFFSET_PX: Final = 2.0
"""Smaller pixel offsets are a matter of drawing, or of counting pixels from 0 or 1."""
MIN_OFFSET_SHARE: Final = 0.05
"""Smallest pixel offset worth a warning, as a share of the pedestrians' median width."""
POOR_IOU: Final = 0.4
"""Mean IoU below which another scale is tried."""
WRONG_GAIN: Final = 2.0
"""Times the mean IoU, if it then reaches `POOR_IOU`, from which on what a correction mends is an
error: as they are, half of the overlap is lost and more."""
GOOD_IOU: Final = 0.8
"""Mean IoU above which two offsets that cancel each other are not tried together."""
SCALE_GAIN: Final = 0.1
"""Gain in mean IoU, beside twice the old value, that another scale has to bring."""


@dataclass(frozen=True)
class _Step:
    """A correction that helps: all corrections so far, and what this one brings.

    `needs_both` says that it brings it only together with the next one.
    """

    correction: Correction
    before: float
    after: float
    needs_both: bool = False

    @property
    def gain(self) -> float:
        return self.after - self.before


def find_offsets(source: BoxSource, detections: BoxColumns) -> list[Finding]:
    """Scale mismatch, time offset and constant pixel offset of a system against the truth.

    Each is looked for after what was found before has been corrected: first the scale (with the
    offset of bars that a network's input has at two sides), then offsets in time and pixels, the
    one that explains more first.

    Parameters
    ----------
    source
        The system.
    detections
        Those of its detections that count.

    Notes
    -----
    With fewer than 50 pedestrians or detections nothing is reported.
    """
    sample = take_sample(source.dataset, detections)
    if min(len(sample.rows), len(detections)) < MIN_BOXES:
        return []
    moved = _find_moves(sample, Correction())
    scaled = _find_scale(sample)
    findings = []
    # boxes of another resolution fit a bit better when moved, but best when scaled
    if scaled is not None and all(scaled.after > step.after for step in moved):
        findings.append(_scale_finding(source, sample, scaled))
        moved = _find_moves(sample, scaled.correction)
    is_moved_in_time = False
    for step in moved:
        if step.correction.offset_frames and not is_moved_in_time:
            findings.append(_time_finding(source, sample, step))
            is_moved_in_time = True
        else:
            findings.append(_pixel_finding(source, sample, step))
    if moved and _explains_rows(source, moved[0].correction.offset_frames):
        findings = [replace(finding, severity=Severity.ERROR) for finding in findings]
    if any(finding.severity is Severity.ERROR for finding in findings):
        # each builds on those before it: all of one severity stay in their order
        findings = [replace(finding, severity=Severity.ERROR) for finding in findings]
    return findings


def _explains_rows(source: BoxSource, offset_frames: int) -> bool:
    """Whether rows are left out beside the evaluated frames, and the time offset places them all.

    Then two things say that the file counts frames from another number; a system that lags behind
    has no such rows.
    """
    lost = source.dataset.left_out
    lost = lost[(lost["subject"] == source.name) & (lost["reason"] == "frame not listed")]
    if not offset_frames or lost.empty:
        return False
    first, last, _ = listed_ranges(source.dataset, lost["recording"])
    frame = lost["frame"].to_numpy()
    is_beside, moved = (frame < first) | (frame > last), frame + offset_frames
    return bool(np.all(is_beside & (first <= moved) & (moved <= last)))


def _find_scale(sample: Sample) -> _Step | None:
    before = sample.overlaps(Correction()).mean
    if not before < POOR_IOU:
        return None
    tried = [Correction(scale=scale) for scale in scale_candidates(sample)] + letterboxes(sample)
    steps = [
        _Step(correction, before, overlaps.mean)
        for correction in tried
        if _is_same_size(overlaps := sample.overlaps(correction))
    ]
    best = max(steps, key=lambda step: step.after, default=None)
    if best is None or best.after < max(2 * before, before + SCALE_GAIN):
        return None
    return best


def _is_same_size(overlaps: Overlaps) -> bool:
    """Whether pedestrians and detections that overlap are of about the same size."""
    close = overlaps.iou >= LOOSE_IOU
    if np.count_nonzero(close) < MIN_BOXES:
        return False
    ratios = np.median(overlaps.ratio_w[close]), np.median(overlaps.ratio_h[close])
    return all(0.5 < ratio < 2 for ratio in ratios)


def _find_moves(sample: Sample, correction: Correction) -> list[_Step]:
    """Offsets in time and in pixels that help, at most one of each, the greater gain first.

    Where both together explain much more than either alone, the time offset comes first: without
    the other, each would be found with a wrong value.
    """
    now = sample.overlaps(correction)
    shifts = [k * sample.frame_step() for k in range(-MAX_SHIFT, MAX_SHIFT + 1) if k]
    # small offsets first: they win ties
    tried = [
        step
        for shift in sorted(shifts, key=abs)
        if (step := _shifted(sample, now, replace(correction, offset_frames=shift))) is not None
    ]
    pixel = _find_pixel(sample, correction)
    time = max((step for step, _ in tried), key=lambda step: step.gain, default=None)
    both = max(tried, key=lambda pair: pair[1], default=None)
    alone = max(0.0 if time is None else time.gain, 0.0 if pixel is None else pixel.gain)
    if both is not None and now.mean < GOOD_IOU and both[1] >= alone + TIME_GAIN:
        joint = _find_pixel(sample, both[0].correction)
        if joint is not None:
            time = _Step(both[0].correction, both[0].before, joint.after, needs_both=True)
            return [time, joint]
    if time is not None and time.gain < TIME_GAIN:
        time = None
    if time is not None and (pixel is None or time.gain >= pixel.gain):
        pixel = _find_pixel(sample, time.correction)
        return [time] if pixel is None else [time, pixel]
    return [] if pixel is None else [pixel]


def _shifted(sample: Sample, now: Overlaps, moved: Correction) -> tuple[_Step, float] | None:
    """What a time offset brings alone, and its gain with the pixel offset that then fits."""
    overlaps = sample.overlaps(moved)
    both = overlaps.has_frame  # the same pedestrians before and after: ends do not count
    if np.count_nonzero(both) < MIN_BOXES:
        return None
    before = float(now.iou[both].mean())
    step = _Step(moved, before, float(overlaps.iou[both].mean()))
    close = overlaps.iou >= LOOSE_IOU
    if np.count_nonzero(close) < MIN_BOXES:
        return step, step.gain
    offset = float(np.median(overlaps.dx[close])), float(np.median(overlaps.dy[close]))
    placed = sample.overlaps(replace(moved, offset_px=offset))
    return step, float(placed.iou[both].mean()) - before


def _find_pixel(sample: Sample, correction: Correction) -> _Step | None:
    before = sample.overlaps(correction).mean
    width = float(np.median(sample.dataset.truth.w[sample.rows]))
    least = max(MIN_OFFSET_PX, MIN_OFFSET_SHARE * width)
    steps = []
    for start in ((0.0, 0.0), _offset_by_order(sample, correction)):
        offset = start
        # the first pairs favour small offsets, and take what they can get: look again after moving
        for loose in (LOOSEST_IOU, LOOSE_IOU, LOOSE_IOU):
            overlaps = sample.overlaps(replace(correction, offset_px=offset))
            close = overlaps.iou >= loose
            if np.count_nonzero(close) < MIN_BOXES:
                break
            dx, dy = overlaps.dx[close], overlaps.dy[close]
            offset = offset[0] + float(np.median(dx)), offset[1] + float(np.median(dy))
        else:
            is_clear = any(
                abs(value) > least and _spread(residual) <= MAX_SPREAD * abs(value)
                for value, residual in zip(offset, (dx, dy), strict=True)
            )
            moved = replace(correction, offset_px=(round(offset[0], 1), round(offset[1], 1)))
            step = _Step(moved, before, sample.overlaps(moved).mean)
            if is_clear and step.gain >= PIXEL_GAIN and step.after >= MIN_IOU:
                steps.append(step)
    return max(steps, key=lambda step: step.gain, default=None)


def _offset_by_order(sample: Sample, correction: Correction) -> tuple[float, float]:
    """Median difference of centres of pedestrians and detections in the same order; 0 if none."""
    g, d = sample.pairs_by_order
    if not len(g):
        return 0.0, 0.0
    truth, det = sample.dataset.truth, sample.detections
    sx, sy = correction.scale
    across = truth.x[g] + truth.w[g] / 2 - sx * (det.x[d] + det.w[d] / 2)
    down = truth.y[g] + truth.h[g] / 2 - sy * (det.y[d] + det.h[d] / 2)
    return float(np.median(across)), float(np.median(down))


def _spread(values: np.ndarray) -> float:
    """Distance between the quartiles."""
    low, high = np.percentile(values, [25, 75])
    return float(high - low)


def _scale_finding(source: BoxSource, sample: Sample, step: _Step) -> Finding:
    sx, sy = step.correction.scale
    x, y = step.correction.offset_px
    is_uniform, is_moved = sx == sy, bool(x or y)
    message = (
        "The detections seem to be made at another resolution: multiplied by "
        f"{scale_text(sx, sy)}{f' and moved by {x:g} and {y:g} px' * is_moved} they fit the "
        f"{source.dataset.objects.plural}"
    )
    advice = "Scale them as they are read, or in the files."
    factors = (("scale", sx),) if is_uniform else (("scale_x", sx), ("scale_y", sy))
    suggestion = (*factors, *((("offset_x_px", x), ("offset_y_px", y)) if is_moved else ()))
    return _finding(source, sample, step, "scale-mismatch", message, advice, suggestion)


def _time_finding(source: BoxSource, sample: Sample, step: _Step) -> Finding:
    frames = step.correction.offset_frames
    n = abs(frames)
    message = (
        f"The detections seem to be {n} frame{'s' if n > 1 else ''} too "
        f"{'late' if frames < 0 else 'early'}: moved by {frames:+d} they fit the "
        f"{source.dataset.objects.plural} better"
    )
    at_limit = n == MAX_SHIFT * sample.frame_step()
    advice = "Check the frame numbers, or move them as they are read."
    if at_limit:
        advice += " No larger offset was tried: the true one may be larger still."
    suggestion = (("offset_frames", float(frames)),)
    return _finding(source, sample, step, "time-offset", message, advice, suggestion)


def _pixel_finding(source: BoxSource, sample: Sample, step: _Step) -> Finding:
    x, y = step.correction.offset_px
    parts = [
        f"{abs(value):.1f} px too far {words[value < 0]}"
        for value, words in ((x, ("left", "right")), (y, ("up", "down")))
        if abs(value) >= 0.5
    ]
    message = f"The boxes stand {' and '.join(parts)}, all alike; moved back they fit better"
    advice = "Check the picture's origin and cropping, or move the boxes as they are read."
    suggestion = (("offset_x_px", x), ("offset_y_px", y))
    return _finding(source, sample, step, "pixel-offset", message, advice, suggestion)


def _finding(
    source: BoxSource,
    sample: Sample,
    step: _Step,
    code: str,
    message: str,
    advice: str,
    suggestion: tuple[tuple[str, float], ...],
) -> Finding:
    looked_at = "" if sample.step == 1 else f", judged by every {nth(sample.step)} frame"
    if step.needs_both:
        looked_at = f", together with the pixel offset{looked_at}"
    is_wrong = step.after >= max(POOR_IOU, WRONG_GAIN * step.before)
    [finding] = source.findings(
        Severity.ERROR if is_wrong else Severity.WARNING,
        code,
        np.arange(1),
        f"{message} (mean IoU {step.after:.2f} instead of {step.before:.2f}{looked_at}).",
        advice,
        count=len(source.boxes),
        is_of_all=True,
    )
    return replace(finding, example="", suggestion=suggestion)
