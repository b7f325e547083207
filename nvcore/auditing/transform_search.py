"""Search for the transform under which a system's boxes overlap the truth best.

Candidates come from the data: frame numbers, sizes of pictures and boxes, and distances between
boxes. The best single transforms are then combined. The search proposes the best fit, the simplest
of several equal ones, and none if the gain may be chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain
from typing import Final

import numpy as np

from nvcore.auditing.transforms import (
    Fit,
    Transform,
    Trial,
    above_threshold,
    recording_and_frame,
    rows_in_ranges,
    source_of,
)
from nvcore.common.errors import NvcoreError
from nvcore.dataset import Dataset
from nvcore.inputs.files.find import find_files
from nvcore.inputs.load import load
from nvcore.inputs.readers import formats_like
from nvcore.inputs.session import Session

MAX_SHIFT: Final = 5
"""Largest time offset tried in addition to another transform, in listed frames ..."""
FARTHEST_SHIFT: Final = 30
"""... and by itself if the boxes fit badly."""
RATES: Final = tuple(
    sorted(
        {Fraction(p, q) for p in range(1, 7) for q in range(1, 7)}
        | {Fraction(24, 25), Fraction(25, 24), Fraction(1000, 1001), Fraction(1001, 1000)}
        | {Fraction(n) for n in (10, 15, 20, 30)}
        | {Fraction(1, n) for n in (10, 15, 20, 30)},
        key=lambda ratio: ratio.numerator + ratio.denominator,
    )[1:]
)
"""Usual ratios of two frame rates, the simplest first; 1 is not among them."""
MAX_DRIFT: Final = 0.06
"""Largest difference of clocks, as a share."""
MOST_DRIFTS: Final = 60
"""Number of drifts tried in each direction, each of at least half a frame over the recording."""
SCALES: Final = tuple(
    Fraction(a, b)
    for a, b in ((1, 4), (1, 3), (2, 5), (1, 2), (3, 5), (5, 8), (2, 3), (3, 4), (4, 5), (5, 6))
)
"""Usual ratios of two picture sizes, the smaller one over the larger one."""
SIZES: Final = (
    (300, 300), (320, 320), (416, 416), (512, 512), (608, 608), (640, 640), (1024, 1024),
    (320, 240), (320, 256), (384, 288), (640, 480), (640, 512), (1024, 768), (1280, 720),
    (1280, 1024), (1920, 1080),
)  # fmt: skip
"""Usual input sizes of networks and picture sizes, px."""
INPUT_SIDES: Final = (300, 320, 416, 512, 608, 640, 768, 800, 960, 1024, 1280, 1536)
"""Model input sizes (longer side, px) that use letterboxing."""
STRIDE: Final = 32
"""Model inputs have sides that are multiples of this, px."""
SNAP: Final = 0.015
"""Largest relative distance at which a measured ratio of sizes is rounded to a usual one."""
MAX_ASPECT: Final = 0.1
"""Largest difference of measured ratios of widths and heights for the same objects."""
LOOSE: Final = (0.1, 0.3, 0.3)
"""Least IoU of a detection with its pedestrian when offsets are measured, by iteration; the first
estimate favours small offsets, so its limit is low."""
MIN_CLOSE: Final = 20
"""Fewer such detections are too few to measure an offset."""
MAX_SPREAD: Final = 1.5
"""Largest distance between the quartiles of a constant offset's differences, in offsets."""
MIN_OFFSET_PX: Final = 2.0
"""Smallest relevant pixel offset. Drawing, or counting pixels from 0 or 1, causes smaller ones ...
"""
MIN_OFFSET_SHARE: Final = 0.05
"""... as well as those below this share of the pedestrians' median width."""

WELL: Final = 0.7
"""Share of fitting boxes from which only small offsets are tried."""
GOOD_IOU: Final = 0.8
"""Mean IoU from which no combinations are tried, since two offsets may cancel each other."""
DECENT: Final = 0.4
"""Share of fitting boxes below which a small gain may be chance, and the truth misread."""
MOST_KEPT: Final = 4
"""Best fits on which combinations are built ..."""
ROUNDS: Final = 2
"""... and the number of rounds."""
TIME_GAIN: Final = 0.03
"""Required gain in mean IoU for another frame number ..."""
PART_GAIN: Final = 0.02
"""... and for any other part of a transform."""
MIN_BOXES: Final = 50
"""Fewest pedestrians or detections for judging by such gains ..."""
MIN_MOVED: Final = 30
"""... or by any gain, except for another layout or format."""
MIN_FITTING: Final = 10
"""Fewest fitting boxes; fewer may fit by chance."""
MIN_GAIN: Final = 0.1
"""Required gain in the share of fitting boxes, of pedestrians or boxes, whichever are fewer ..."""
CHANCE: Final = 0.3
"""... and as a share of the boxes that still do not fit, since a bad fit is more likely chance ...
"""
CHANCE_OF_FEW: Final = 0.7
"""... with this stricter share ..."""
MANY: Final = 100
"""... for fewer fitting boxes, except for another layout, since there are few layouts."""


@dataclass(frozen=True)
class Search:
    """Result of the search for one system.

    Attributes
    ----------
    as_is
        The fit without a transform.
    best
        The best fit; None if no transform is better than none.
    tried
        Most pedestrians that fit, by kind of transform.
    every
        Sampling step, see `Trial`.
    """

    as_is: Fit
    best: Fit | None
    tried: dict[str, int]
    every: int


def trial_of(dataset: Dataset, name: str, threshold: float | None = None) -> Trial:
    """Compare a system's detections that pass a threshold with the truth."""
    return Trial.of(dataset, name, above_threshold(dataset.system(name), threshold))


def search(dataset: Dataset, name: str, threshold: float | None = None) -> Search:
    """Find the transform under which a system's boxes fit best. Cached in the dataset."""
    return dataset.kept(
        ("transforms", name, threshold),
        lambda dataset: _search(trial_of(dataset, name, threshold), threshold),
    )


def _search(trial: Trial, threshold: float | None) -> Search:
    as_is = trial.fit(Transform())
    fits_well = as_is.share >= WELL
    if not fits_well:
        trial = trial.with_left_out()
        as_is = trial.fit(Transform())
    if min(as_is.n, len(trial.system.score)) < MIN_FITTING:
        return Search(as_is, None, {}, trial.every)
    most = MAX_SHIFT if fits_well else FARTHEST_SHIFT
    transforms = [*_beside(trial, Transform(), most), *_placed(trial, Transform(), not fits_well)]
    fits = [as_is, *_of_other_formats(trial, threshold)]
    if not fits_well:
        starts = [*_clip_starts(trial)]
        transforms += [Transform(boxes=layout) for layout in trial.other_layouts(trial.name)]
        transforms += chain(starts, *(_placed(trial, start, True) for start in starts))
        transforms += [*_scaled(trial), *_rates(trial)]
    fits += map(trial.fit, transforms)
    for _ in range(ROUNDS if as_is.mean < GOOD_IOU else 0):
        kept = sorted(fits, key=_worth, reverse=True)[:MOST_KEPT]
        known = {fit.transform for fit in fits}
        further = chain.from_iterable(
            [*_beside(trial, fit.transform), *_placed(trial, fit.transform, not fits_well)]
            for fit in kept
            if not fit.transform.format
        )
        fits += map(trial.fit, dict.fromkeys(of for of in further if of not in known))
    best = max(fits, key=_worth)
    tried: dict[str, int] = {}
    for fit in fits:
        for kind in fit.transform.kinds[:1]:
            tried[kind] = max(tried.get(kind, 0), fit.n_fitting)
    is_read = best.transform.boxes is not None or bool(best.transform.format)
    is_found = is_better(trial, best, as_is, is_of_layout=is_read)
    return Search(as_is, best if is_found else None, tried, trial.every)


def is_better(trial: Trial, best: Fit, as_is: Fit, *, is_of_layout: bool = False) -> bool:
    """Whether a fit is better than without a transform by more than chance.

    Set `is_of_layout` for another layout or format: these are few, so less gain is needed.
    """
    transform = best.transform
    if best.rank <= as_is.rank:
        return False
    n, is_numbered = min(best.n, len(trial.system.score)), transform.frame_step == 1
    is_offset = is_numbered and transform.scale == (1.0, 1.0) and not is_of_layout
    if is_offset and as_is.share >= DECENT:
        gain = TIME_GAIN if transform.offset_frames else PART_GAIN
        return n >= MIN_BOXES and best.mean >= as_is.mean + gain
    if is_of_layout and as_is.share >= DECENT:
        return n >= MIN_FITTING and best.rank >= as_is.rank + MIN_GAIN
    least = MIN_FITTING if is_of_layout else MIN_MOVED
    is_sure = is_of_layout or best.n_fitting >= MANY
    share = best.n_fitting / max(n, 1)
    gain = share - as_is.n_fitting / max(n, 1)
    return (
        gain >= max(MIN_GAIN, (CHANCE if is_sure else CHANCE_OF_FEW) * (1 - share))
        and best.n_fitting >= max((1 + MIN_GAIN) * as_is.n_fitting, MIN_FITTING)
        and n >= least
        and bool(transform.format or trial.is_spread(transform))
    )


def _worth(fit: Fit) -> float:
    """Rank of a fit minus a penalty for each part of its transform."""
    transform = fit.transform
    n_parts = sum(
        (
            transform.frame_step != 1,
            0 < abs(transform.frame_step - 1) <= MAX_DRIFT,
            transform.scale != (1.0, 1.0),
            any(transform.offset_px),
            transform.boxes is not None,
            bool(transform.format),
        )
    )
    return fit.rank - PART_GAIN * n_parts - TIME_GAIN * bool(transform.offset_frames)


def _of_other_formats(trial: Trial, threshold: float | None) -> list[Fit]:
    """Score other formats that the files' content may be in, at the same threshold."""
    derived, key = trial.dataset.derived, ("other formats", trial.name)
    if key not in derived:
        derived[key] = [*_in_other_formats(trial.dataset, trial.name)]
    return [
        replace(trial_of(read, system, threshold).fit(Transform()), transform=Transform(format=of))
        for of, read, system in derived[key]
    ]


def _in_other_formats(dataset: Dataset, name: str) -> Iterator[tuple[str, Dataset, str]]:
    """Yield other formats of a system's files, the inputs read that way, and the system's name."""
    settings = dataset.settings
    if not isinstance(settings, Session):
        return
    number, systems = dataset.systems.index(name), [*settings.systems]
    source = systems[number]
    with suppress(NvcoreError):  # a table in memory, or files that only look like that format
        files, taken = find_files(source, settings.folder, "detections")
        others = formats_like(files[0], "detections") if source.format is None else []
        for other in others:
            if other is not taken:
                systems[number] = replace(source, format=other.name)
                read = load(replace(settings, systems=tuple(systems)))
                yield other.name, read, read.systems[number]


def _gap(trial: Trial) -> int:
    """Return the smallest usual step between listed frames."""
    return max(1, round(float(trial.dataset.frame_columns.sampling_step.min())))


def _beside(trial: Trial, transform: Transform, most: int = MAX_SHIFT) -> Iterator[Transform]:
    """Vary a transform slightly: shift its frame numbers, refine its clock drift."""
    for k in sorted(range(-most, most + 1), key=abs)[1:]:
        yield replace(transform, offset_frames=transform.offset_frames + k * _gap(trial))
    if 0 < abs(transform.frame_step - 1) <= MAX_DRIFT:
        by = _drift_step(trial) / 8
        yield from (
            replace(transform, frame_step=transform.frame_step + k * by) for k in range(-7, 8)
        )


def _ends(trial: Trial) -> list[tuple[int, int, int, int]]:
    """Return first and last frame of the truth and of the system, for up to three recordings."""
    frames, ends = trial.dataset.frame_columns, []
    recording, number = recording_and_frame(trial.system.key[np.diff(trial.system.offsets) > 0])
    for one in np.unique(recording)[:3]:
        listed, own = frames.frame[frames.rows_of(int(one))], number[recording == one]
        if len(listed):
            ends.append((int(listed[0]), int(listed[-1]), int(own[0]), int(own[-1])))
    return ends


def _clip_starts(trial: Trial) -> list[Transform]:
    """Return offsets for a system that numbers a clip's frames from its own first one, 0 or 1."""
    offsets = [
        offset
        for first, last, own_first, own_last in _ends(trial)
        for offset in (first, first - 1, first - own_first, last - own_last)
    ]
    return [Transform(offset_frames=offset) for offset in dict.fromkeys(offsets) if offset]


def _rates(trial: Trial) -> Iterator[Transform]:
    """Yield other frame rates: usual ones, that of the evaluated frames, and drifting clocks.

    Numbers count from 0, from the first evaluated frame, or from an offset given before.
    """
    taken, gap = source_of(trial.dataset, trial.name).offset_frames, _gap(trial)
    for rate in dict.fromkeys([*map(float, RATES), float(gap), 1.0 / gap]):
        offsets = [0, -round(rate * taken)]
        for first, _, own_first, _ in _ends(trial):
            offsets += [first - round(rate * start) for start in (taken, taken + 1, own_first)]
        yield from (Transform(rate, offset) for offset in dict.fromkeys(offsets) if rate != 1)
    by = _drift_step(trial)
    for k in range(1, min(MOST_DRIFTS, int(MAX_DRIFT / by)) + 1):
        yield from (Transform(1 + k * by, -taken), Transform(1 - k * by, -taken))


def _drift_step(trial: Trial) -> float:
    """Return the step between tried drifts: half a frame over the recording, or more if long."""
    span = max((last for _, _, _, last in _ends(trial)), default=1)
    return max(0.5 * _gap(trial) / max(span, 1), MAX_DRIFT / MOST_DRIFTS)


def _scaled(trial: Trial) -> Iterator[Transform]:
    """Yield scales from usual, measured and network input sizes, undoing letterboxing."""
    for ratio in SCALES:
        for factor in (float(ratio), float(1 / ratio)):
            yield Transform(scale=(factor, factor))
    for factor in dict.fromkeys(_measured_scales(trial)):
        measured = Transform(scale=(factor, factor))
        yield from (measured, *_placed(trial, measured, True))
    frames = trial.dataset.frame_columns
    if np.ptp(frames.width) or np.ptp(frames.height):
        return
    W, H = float(frames.width[0]), float(frames.height[0])
    yield from (Transform(scale=(W / w, H / h)) for w, h in SIZES if (w, h) != (W, H))
    for side in INPUT_SIDES:
        factor = max(W, H) / side
        across, down = (side - W / factor) / 2, (side - H / factor) / 2
        # square inputs, and those whose shorter side is the next multiple of the stride
        for x, y in ((across, down), (across % (STRIDE / 2), down % (STRIDE / 2))):
            if max(x, y) >= 1:
                yield Transform(scale=(factor, factor), offset_px=(-factor * x, -factor * y))


def _measured_scales(trial: Trial) -> Iterator[float]:
    """Yield ratios of sizes, truth to system: of median boxes, and of distances between centres.

    A system that detects only near pedestrians has larger boxes than the truth. The centres of the
    pairs that overlap after an offset are as far apart as in the truth, times the ratio.
    """
    sizes = [np.median(side) for boxes in (trial.truth, trial.system) for side in boxes.box[2:]]
    across, down = sizes[0] / max(sizes[2], 1e-9), sizes[1] / max(sizes[3], 1e-9)
    if abs(across / down - 1) <= MAX_ASPECT:
        yield _usual(float(np.sqrt(across * down)))
    for offset in [(0.0, 0.0), *_voted(trial, Transform())]:
        factor = 1.0
        for loose in LOOSE:
            iou, best, *_ = trial.overlaps(Transform(scale=(factor, factor), offset_px=offset))
            close = iou >= loose
            if np.count_nonzero(close) < MIN_CLOSE:
                break
            ours, theirs = (
                np.stack([boxes.box[k][rows] + boxes.box[k + 2][rows] / 2 for k in (0, 1)])
                for boxes, rows in ((trial.truth, close), (trial.system, best[close]))
            )
            away = theirs - theirs.mean(axis=1, keepdims=True)
            factor = float((ours * away).sum() / max((away**2).sum(), 1e-9))
            x, y = np.median(ours - factor * theirs, axis=1)
            offset = float(x), float(y)
        else:  # chance pairs, as of mirrored pictures, do not scale width and height alike
            pairs = ((trial.truth.box[k][close], trial.system.box[k][best[close]]) for k in (2, 3))
            larger = np.median(np.concatenate([ours / theirs for ours, theirs in pairs]))
            if abs(larger / factor - 1) <= MAX_ASPECT:
                yield _usual(factor)


def _usual(factor: float) -> float:
    """Round a measured ratio of sizes to a usual one close by, else to a thousandth."""
    usual = [float(of) for ratio in SCALES for of in (ratio, 1 / ratio)]
    return next((of for of in usual if abs(factor / of - 1) < SNAP), round(factor, 3))


def _placed(trial: Trial, transform: Transform, is_far: bool) -> Iterator[Transform]:
    """Extend a transform by pixel offsets measured from the boxes."""
    least = max(MIN_OFFSET_PX, MIN_OFFSET_SHARE * float(np.median(trial.truth.box[2])))
    for start in [transform.offset_px, *(_voted(trial, transform) if is_far else [])]:
        offset = start
        for loose in LOOSE:
            iou, best, *_ = trial.overlaps(replace(transform, offset_px=offset))
            close = iou >= loose
            if np.count_nonzero(close) < MIN_CLOSE:
                break
            away = _centres_apart(trial, replace(transform, offset_px=offset), close, best[close])
            offset = offset[0] + float(np.median(away[0])), offset[1] + float(np.median(away[1]))
        else:
            spread = np.ptp(np.percentile(away, [25, 75], axis=1), axis=0)
            pairs = zip(offset, spread, strict=True)
            if any(abs(one) > least and by <= MAX_SPREAD * abs(one) for one, by in pairs):
                yield replace(
                    transform, offset_px=(float(round(offset[0])), float(round(offset[1])))
                )


def _voted(trial: Trial, transform: Transform) -> list[tuple[float, float]]:
    """Return the most frequent offsets between pedestrians and detections, which may be apart."""
    _, _, lo, hi = trial.overlaps(transform)
    frame = np.repeat(np.arange(len(trial.truth.key)), np.diff(trial.truth.offsets))
    g, d = rows_in_ranges(lo[frame], (hi - lo)[frame])
    if not len(g):
        return []
    away = _centres_apart(trial, replace(transform, offset_px=(0.0, 0.0)), g, d)
    bin_px = max(MIN_OFFSET_PX, float(np.median(trial.truth.box[2])) / 2)
    bins = np.rint(away / bin_px)
    places, count = np.unique(bins, axis=1, return_counts=True)
    voted = []
    for place in places.T[np.argsort(-count, kind="stable")[:3]]:
        is_near = np.all(np.abs(away - bin_px * place[:, None]) <= bin_px, axis=0)
        x, y = np.median(away[:, is_near], axis=1)
        voted.append((float(x), float(y)))
    return voted


def _centres_apart(trial: Trial, transform: Transform, g: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return centres of pedestrians minus those of detections under a transform, px, (2, n)."""
    truth, system = trial.truth.box, trial.boxes_under(transform).box
    return np.stack(
        [
            truth[k][g]
            + truth[k + 2][g] / 2
            - transform.scale[k] * (system[k][d] + system[k + 2][d] / 2)
            - transform.offset_px[k]
            for k in (0, 1)
        ]
    )
