"""The search for the transform under which a system's boxes overlap the truth best.

Candidates are guessed from the data: from frame numbers, sizes of pictures and boxes, and from
where boxes stand to one another. Combinations are built on the best single ones. The best fit is
proposed, the simplest where several fit alike, and none if it may be chance.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain, product
from typing import Final

import numpy as np

from nvcore.auditing.transforms import (
    Fit,
    Transform,
    Trial,
    above_threshold,
    recording_and_frame,
    rows_in_ranges,
)
from nvcore.dataset import Dataset
from nvcore.errors import NvcoreError
from nvcore.inputs.files import find_files
from nvcore.inputs.load import load
from nvcore.inputs.readers import formats_like
from nvcore.inputs.session import Session

MAX_SHIFT: Final = 5
"""Largest time offset that is tried beside another transform, in listed frames ..."""
FARTHEST_SHIFT: Final = 30
"""... and alone where the boxes fit badly."""
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
MAX_OFFSET: Final = 3
"""Largest offset beside a frame rate, in listed frames."""
MAX_DRIFT: Final = 0.06
"""Largest difference of clocks, as a share."""
MOST_DRIFTS: Final = 60
"""Drifts that are tried to each side, of half a frame over the recording at least."""
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
"""By which the sides of inputs can be divided."""
SNAP: Final = 0.015
"""A measured ratio of sizes that is as near to a usual one as this is taken for it."""
MAX_ASPECT: Final = 0.1
"""Measured ratios of widths and heights that differ by more are of other objects."""
LOOSE: Final = (0.1, 0.3, 0.3)
"""Overlap from which on a detection is taken for the pedestrian's when offsets are measured; the
first look favours small offsets, and takes what it can get."""
MIN_CLOSE: Final = 20
"""Fewer such detections are too few to measure an offset."""
MAX_SPREAD: Final = 1.5
"""Largest distance between the quartiles of a constant offset's differences, in offsets."""
MIN_OFFSET_PX: Final = 2.0
"""Smaller pixel offsets are a matter of drawing, or of counting pixels from 0 or 1 ..."""
MIN_OFFSET_SHARE: Final = 0.05
"""... as are those of a smaller share of the pedestrians' median width."""

WELL: Final = 0.7
"""Share of boxes that fit from which on only small offsets are looked for."""
GOOD_IOU: Final = 0.8
"""Mean IoU from which on two offsets that cancel each other are not tried together."""
POOR: Final = 0.25
"""Share of boxes that fit below which a small gain may be chance."""
MOST_KEPT: Final = 4
"""Best fits on which combinations are built ..."""
ROUNDS: Final = 2
"""... and how often."""
TIME_GAIN: Final = 0.03
"""Gain in mean IoU that another frame number has to bring ..."""
PART_GAIN: Final = 0.02
"""... and any other part of a transform."""
ROUND: Final = 0.002
"""Loss of mean IoU up to which a rounder pixel offset is taken."""
MIN_BOXES: Final = 50
"""Fewer pedestrians or detections are too few to judge by such gains ..."""
MIN_MOVED: Final = 30
"""... or by any, but for that of another meaning of the numbers or another format."""
MIN_IOU: Final = 0.15
"""Mean IoU that they have to reach."""
MIN_FITTING: Final = 10
"""Fewer boxes that fit may do so by chance ..."""
MIN_SHARE: Final = 0.2
"""... or a smaller share of the pedestrians, or of the boxes where those are fewer."""
MIN_GAIN: Final = 0.1
"""Gain in the share of boxes that fit which a transform has to bring at least ..."""
CHANCE: Final = 0.5
"""... and as a share of those that still do not: the worse it fits, the likelier by chance ..."""
FEW: Final = 0.3
"""... of which another meaning of the numbers, or another format, has less."""


@dataclass(frozen=True)
class Search:
    """What was found of a system.

    Attributes
    ----------
    as_is
        The fit without a transform.
    best
        The best fit; None: the boxes are best left as they are.
    tried
        Most pedestrians that fit, by kind of transform.
    every
        1: judged by all frames with pedestrians; n: by every n-th.
    """

    as_is: Fit
    best: Fit | None
    tried: dict[str, int]
    every: int


def trial_of(dataset: Dataset, name: str, threshold: float | None = None) -> Trial:
    """A system's detections that pass a threshold, against the truth."""
    return Trial.of(dataset, name, above_threshold(dataset.system(name), threshold))


def search(dataset: Dataset, name: str, threshold: float | None = None) -> Search:
    """Look for the transform that makes a system's boxes fit best; kept with the dataset."""
    kept: dict[tuple[str, float | None], Search] = dataset.derived.setdefault("transforms", {})
    if (name, threshold) not in kept:
        kept[name, threshold] = _search(trial_of(dataset, name, threshold), threshold)
    return kept[name, threshold]


def _search(trial: Trial, threshold: float | None) -> Search:
    as_is = trial.fit(Transform())
    fits_well = as_is.share >= WELL
    if not fits_well:
        trial = trial.with_left_out()
        as_is = trial.fit(Transform())
    if min(as_is.n, len(trial.system.score)) < MIN_FITTING:
        return Search(as_is, None, {}, trial.every)
    most = MAX_SHIFT if fits_well else FARTHEST_SHIFT
    transforms = [*_shifted(trial, Transform(), most), *_placed(trial, Transform(), not fits_well)]
    fits = [as_is]
    if not fits_well:
        fits += [] if as_is.share > POOR else _of_other_formats(trial, threshold)
        starts = [*_clip_starts(trial)]
        transforms += [Transform(boxes=layout) for layout in trial.other_layouts(trial.name)]
        transforms += chain(starts, *(_placed(trial, start, True) for start in starts))
        transforms += [*_scaled(trial), *_rates(trial)]
    fits += map(trial.fit, transforms)
    if not fits_well:
        fits += map(trial.fit, _finer_drifts(trial, fits))
    for _ in range(ROUNDS if as_is.mean < GOOD_IOU else 0):
        kept = sorted(fits, key=_worth, reverse=True)[:MOST_KEPT]
        known = {fit.transform for fit in fits}
        further = chain.from_iterable(
            [*_shifted(trial, fit.transform), *_placed(trial, fit.transform, not fits_well)]
            for fit in kept
            if not fit.transform.format
        )
        fits += map(trial.fit, dict.fromkeys(of for of in further if of not in known))
    best = _rounder(trial, max(fits, key=_worth))
    tried: dict[str, int] = {}
    for fit in fits:
        for kind in fit.transform.kinds[:1]:
            tried[kind] = max(tried.get(kind, 0), fit.n_fitting)
    is_read = best.transform.boxes is not None or bool(best.transform.format)
    return Search(
        as_is,
        best if is_better(trial, best, as_is, is_of_layout=is_read) else None,
        tried,
        trial.every,
    )


def is_better(trial: Trial, best: Fit, as_is: Fit, *, is_of_layout: bool = False) -> bool:
    """Whether a fit is so much better than without a transform that it is no chance.

    `is_of_layout`: it is by another meaning of the numbers, of which there are few.
    """
    transform = best.transform
    if best.rank <= as_is.rank:
        return False
    n, is_numbered = min(best.n, len(trial.system.score)), transform.frame_step == 1
    is_offset = is_numbered and transform.scale == (1.0, 1.0) and not is_of_layout
    if is_offset and as_is.share >= POOR:
        gain = TIME_GAIN if transform.offset_frames else PART_GAIN
        return n >= MIN_BOXES and best.mean >= max(as_is.mean + gain, MIN_IOU)
    chance, least = (FEW, MIN_FITTING) if is_of_layout else (CHANCE, MIN_MOVED)
    return (
        best.share - as_is.share >= max(MIN_GAIN, chance * (1 - best.share))
        and best.n_fitting >= max((1 + MIN_GAIN) * as_is.n_fitting, MIN_SHARE * n, MIN_FITTING)
        and n >= least
        and trial.is_spread(transform)
    )


def _worth(fit: Fit) -> float:
    """How well a transform fits, less what each of its parts has to bring."""
    transform = fit.transform
    parts = transform.frame_step != 1, transform.scale != (1.0, 1.0), any(transform.offset_px)
    n_parts = sum(parts) + (transform.boxes is not None) + bool(transform.format)
    n_parts += transform.frame_step not in (1, *map(float, RATES))
    return fit.rank - PART_GAIN * n_parts - TIME_GAIN * bool(transform.offset_frames)


def _rounder(trial: Trial, best: Fit) -> Fit:
    """The fit with a rounder pixel offset, if that is as good."""
    if not any(best.transform.offset_px) or best.transform.scale != (1.0, 1.0):
        return best
    for unit in (10.0, 1.0):
        x, y = (float(round(value / unit) * unit) for value in best.transform.offset_px)
        fit = trial.fit(replace(best.transform, offset_px=(x, y)))
        if fit.rank >= best.rank - ROUND:
            return fit
    return best


def _of_other_formats(trial: Trial, threshold: float | None) -> list[Fit]:
    """The fits if the files were in another format that their content may be in."""
    settings, fits = trial.dataset.settings, []
    number = trial.dataset.systems.index(trial.name)
    if not isinstance(settings, Session) or settings.systems[number].format is not None:
        return []
    source = settings.systems[number]
    try:
        files, taken = find_files(source, settings.folder, "detections")
        others = [found for found in formats_like(files[0], "detections") if found != taken]
    except NvcoreError:  # a table in memory
        return []
    for other in others:
        systems = list(settings.systems)
        systems[number] = replace(source, format=other.name)
        try:
            dataset = load(replace(settings, systems=tuple(systems)))
        except NvcoreError:  # it only looks like that format
            continue
        fit = trial_of(dataset, dataset.systems[number], threshold).fit(Transform())
        fits.append(replace(fit, transform=Transform(format=other.name)))
    return fits


def _gap(trial: Trial) -> int:
    """Smallest usual step between listed frames."""
    return max(1, round(float(trial.dataset.frame_columns.sampling_step.min())))


def _shifted(trial: Trial, transform: Transform, most: int = MAX_SHIFT) -> Iterator[Transform]:
    """Offsets in time beside a transform, the smallest first."""
    for k in sorted(range(-most, most + 1), key=abs)[1:]:
        yield replace(transform, offset_frames=transform.offset_frames + k * _gap(trial))


def _ends(trial: Trial) -> list[tuple[int, int, int, int]]:
    """First and last listed frame, first and last number of the system, of some recordings."""
    frames, ends = trial.dataset.frame_columns, []
    has_box = trial.system.key[np.diff(trial.system.offsets) > 0]
    recording, number = recording_and_frame(has_box)
    for one in np.unique(recording)[:3]:
        listed, own = frames.frame[frames.rows_of(int(one))], number[recording == one]
        if len(listed):
            ends.append((int(listed[0]), int(listed[-1]), int(own[0]), int(own[-1])))
    return ends


def _clip_starts(trial: Trial) -> list[Transform]:
    """Offsets of a system that counts the frames of a clip from its own first, or from 0 or 1."""
    offsets = [
        offset
        for first, last, own_first, own_last in _ends(trial)
        for offset in (first, first - 1, first - own_first, last - own_last)
    ]
    return [Transform(offset_frames=offset) for offset in dict.fromkeys(offsets) if offset]


def _taken(trial: Trial) -> tuple[float, int]:
    """Factor and offset of the frame numbers that the session gives the system already."""
    settings = trial.dataset.settings
    if not isinstance(settings, Session):
        return 1.0, 0
    own = settings.systems[trial.dataset.systems.index(trial.name)]
    return own.frame_step, own.offset_frames


def _rates(trial: Trial) -> Iterator[Transform]:
    """Other frame rates: usual ones, that of the evaluated frames, and clocks that drift apart.

    With an offset of a few frames, or that of numbers counted from the first evaluated frame.
    """
    gap, taken = _gap(trial), _taken(trial)[1]
    ends = _ends(trial)
    rates = dict.fromkeys([*map(float, RATES), float(gap), 1.0 / gap])
    near = sorted(range(-MAX_OFFSET, MAX_OFFSET + 1), key=abs)
    for rate in rates:
        if rate == 1:
            continue
        # an offset that was taken before is multiplied, too
        offsets = [k * gap - round(rate * taken) for k in near]
        offsets += [
            first - round(rate * (start + taken))
            for first, _, own_first, _ in ends
            for start in (0, 1, own_first - taken)
        ]
        yield from (Transform(rate, offset) for offset in dict.fromkeys(offsets))
    by = _drift_step(trial, gap)
    for k, offset in product(range(1, MOST_DRIFTS + 1), (0, 1, -1)):
        for drift in (k * by, -k * by):
            if abs(drift) <= MAX_DRIFT:
                yield Transform(1 + drift, offset * gap - taken)


def _drift_step(trial: Trial, gap: int) -> float:
    span = max((last for _, _, _, last in _ends(trial)), default=1)
    return max(0.5 * gap / max(span, 1), MAX_DRIFT / MOST_DRIFTS)


def _finer_drifts(trial: Trial, fits: Iterable[Fit]) -> list[Transform]:
    """Frame rates between the best drift and its neighbours."""
    drifts = [fit for fit in fits if 0 < abs(fit.transform.frame_step - 1) <= MAX_DRIFT]
    if not drifts:
        return []
    best, gap = max(drifts, key=lambda fit: fit.rank).transform, _gap(trial)
    finer = [best.frame_step + k / 8 * _drift_step(trial, gap) for k in range(-7, 8)]
    offsets = best.offset_frames, best.offset_frames + gap
    return [Transform(step, offset) for step, offset in product(finer, offsets)]


def _scaled(trial: Trial) -> Iterator[Transform]:
    """Factors that bring boxes to the picture's size, with the bars of letterboxing undone."""
    for ratio in SCALES:
        for factor in (float(ratio), float(1 / ratio)):
            yield Transform(scale=(factor, factor))
    factor = _measured_scale(trial)
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


def _measured_scale(trial: Trial) -> float:
    """Ratio of the median sizes of the boxes of truth and system; 1 where sides differ in it."""
    sizes = [np.median(side) for boxes in (trial.truth, trial.system) for side in boxes.box[2:]]
    across, down = sizes[0] / max(sizes[2], 1e-9), sizes[1] / max(sizes[3], 1e-9)
    if abs(across / down - 1) > MAX_ASPECT:
        return 1.0
    factor = float(np.sqrt(across * down))
    usual = [float(of) for ratio in SCALES for of in (ratio, 1 / ratio)]
    return next((of for of in usual if abs(factor / of - 1) < SNAP), round(factor, 3))


def _placed(trial: Trial, transform: Transform, is_far: bool) -> Iterator[Transform]:
    """A transform with the constant offsets in the picture that the boxes point to."""
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
                yield replace(transform, offset_px=(round(offset[0], 1), round(offset[1], 1)))


def _voted(trial: Trial, transform: Transform) -> list[tuple[float, float]]:
    """Offsets that most pairs of a pedestrian and a detection have, also where none overlaps."""
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
    """Centres of pedestrians minus those of detections under a transform, px; shape (2, n)."""
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
