"""Boxes whose four numbers mean another thing than they were taken for.

Corners where width and height belong, the vertical axis first, shares of the picture: whatever
was read so lies nowhere near a pedestrian. Every other meaning is tried on the boxes that are
there, of the systems and of the truth; one that makes them fit is an error, since all numbers
are wrong until it is corrected.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.auditing.cases import BoxSource, all_sources, system_source, truth_source
from nvcore.auditing.overlaps import Correction, rows_in_ranges, take_sample
from nvcore.dataset import Dataset
from nvcore.dataset.sources import ReadAs
from nvcore.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.inputs.layouts import KINDS, UNITS, Box, BoxLayout, parse_layout
from nvcore.inputs.placing import REASONS
from nvcore.metrics.matching import iou_of_pairs
from nvcore.objects import Objects
from nvcore.wording import count_text

FIT_IOU: Final = 0.5
"""Overlap from which on a box fits a pedestrian."""
POOR_SHARE: Final = 0.25
"""Share of pedestrians with a box that fits up to which other meanings are tried."""
MIN_FITTING: Final = 5
"""Fewer pedestrians that another meaning makes fit may do so by chance ..."""
MIN_SHARE: Final = 0.2
"""... or a smaller share of the pedestrians, or of the boxes where those are fewer ..."""
MIN_GAIN: Final = 4
"""... or not as many times those that fit as it is ..."""
GOOD_IOU: Final = 0.6
"""... or a smaller median IoU of those that fit or nearly do ..."""
NEAR_IOU: Final = 0.3
MIN_SPREAD: Final = 0.5
"""... or pedestrians who all stand in one place: less far apart than this many of their widths."""
UNCLEAR: Final = 0.05
"""Shares of believable boxes of truth and systems that differ by less tell not which is wrong."""
LARGEST: Final = 1.2
"""Numbers up to this many times the whole may be shares of it: boxes stick out of pictures."""
LARGE: Final = 0.1
"""How far a box of truth or system may stick out of the picture, as a share of it."""
MIN_CORNERS: Final = 20
"""Fewer boxes may look like corners by chance ..."""
NEARLY_ALL: Final = 0.9
"""Share of the pedestrians that are wider than tall from which on they are none."""
MANY_STICKING_OUT: Final = 0.2
"""... or if a smaller share of them sticks out of the picture as they were read."""
NO_AREA: Final = REASONS[-1]
_KEY: Final = "box layouts"


@dataclass(frozen=True)
class LayoutFit:
    """A meaning of the numbers of one source, and how well boxes then fit.

    Attributes
    ----------
    layout, was
        The meaning, and the one that was taken.
    n_fitting, n_before, n
        Pedestrians with a box that fits, of how many looked at; `n_before` as it is.
    iou
        Median IoU of those that fit or nearly do.
    of_truth
        What would make the boxes fit as well if those of the truth were meant so; None: nothing,
        or the truth's are beyond doubt.
    """

    layout: BoxLayout
    was: BoxLayout
    n_fitting: int
    n_before: int
    n: int
    iou: float
    of_truth: BoxLayout | None = None

    def text(self, objects: Objects) -> str:
        """What it is and what it gives, for a finding."""
        counted = count_text(self.n, objects.singular, objects.plural)
        return (
            f"{self.layout.text}: then {self.n_fitting:,} of {counted} overlap a box by an IoU of "
            f"{FIT_IOU:g} or more, not {self.n_before:,} (median {self.iou:.2f})"
        )


@dataclass(frozen=True)
class _Boxes:
    """Boxes as they were read, by frame, with score and size of the picture (px) of each."""

    frame: np.ndarray
    box: Box
    score: np.ndarray
    size: Box
    read_as: ReadAs

    @property
    def was(self) -> BoxLayout:
        return parse_layout(self.read_as.boxes)

    def laid_out(self, layout: BoxLayout) -> Box:
        """x, y, w, h (px) if the numbers have another meaning."""
        return layout.boxes(self.was.numbers(self.box, self.score, self.size), self.size)[0]

    def other_layouts(self) -> list[BoxLayout]:
        """Meanings that the numbers can have, but the one that was taken."""
        was = self.was
        numbers = was.numbers(self.box, self.score, self.size)[:4]
        largest = float(np.nanpercentile(np.abs(np.stack(numbers)), 99))
        orders = (False, True) if self.read_as.has_score_beside else (was.is_score_first,)
        layouts = [
            BoxLayout(kind, is_yx, unit, is_score_first)
            for unit, (whole, _) in UNITS.items()
            if unit == was.unit or (whole is not None and largest <= LARGEST * whole)
            for kind in KINDS
            for is_yx in (False, True)
            for is_score_first in orders
        ]
        return [layout for layout in layouts if layout != was]

    def believable(self, *, are_upright: bool) -> float:
        """Share of boxes that have an area and lie in the picture, and stand upright, 0..1."""
        x, y, w, h = self.box
        width, height, *_ = self.size
        is_so = (w > 0) & (h > 0) & (x > -LARGE * width) & (y > -LARGE * height)
        is_so &= (x + w < (1 + LARGE) * width) & (y + h < (1 + LARGE) * height)
        return float(np.mean(is_so & (h > w) if are_upright else is_so))


def audit_layouts(dataset: Dataset) -> list[Finding]:
    """Truth or systems whose boxes fit once their numbers mean another thing."""
    fits = find_layouts(dataset)
    findings = [] if fits else _corners_of_all(dataset) or _lying(dataset)
    for subject, fit in fits.items():
        files = dataset.inputs["file"][dataset.inputs["subject"] == subject]
        is_truth = subject == TRUTH_NAME
        n = len(dataset.truth if is_truth else dataset.system(subject))
        steps = [Step(Remedy.BOXES, str(fit.layout), subject)]
        if fit.of_truth is not None:
            steps.append(Step(Remedy.BOXES, str(fit.of_truth), TRUTH_NAME))
        findings.append(
            Finding(
                Severity.ERROR,
                "box-layout",
                subject,
                n,
                f"The numbers of each box were taken for {fit.was.text}. They seem to be "
                f"{fit.text(dataset.objects)}.",
                "All numbers are wrong until the boxes are read as they were written."
                + (" It is the ground truth that needs it: the systems agree." * is_truth),
                file=files.iloc[0] if len(files) else "",
                steps=tuple(steps),
            )
        )
    return findings


def _corners_of_all(dataset: Dataset) -> list[Finding]:
    """An error where the truth, and so perhaps every source, has corners where sizes belong.

    Then boxes fit one another, and only the picture tells: many stick out of it, though none of
    their corners does.
    """
    having = [source for source in all_sources(dataset) if _are_corners(source)]
    if not having or not having[0].is_truth:
        return []
    names = [""] if len(having) > len(dataset.systems) else [source.name for source in having]
    boxes = parse_layout(dataset.read_as.get(TRUTH_NAME, ReadAs()).boxes)
    value = str(replace(boxes, kind="corners"))
    files = dataset.inputs["file"][dataset.inputs["subject"] == TRUTH_NAME]
    return [
        Finding(
            Severity.ERROR,
            "box-layout",
            TRUTH_NAME,
            len(dataset.truth),
            f"The numbers of each box were taken for {boxes.text}, and many boxes then stick out "
            "of the picture. The third is always larger than the first and the fourth than the "
            "second, and all lie in the picture: they seem to be corners.",
            "All numbers are wrong until the boxes are read as they were written.",
            file=files.iloc[0] if len(files) else "",
            steps=tuple(Step(Remedy.BOXES, value, name) for name in names),
        )
    ]


def _lying(dataset: Dataset) -> list[Finding]:
    """An error where nearly all pedestrians are wider than tall: another class, or swapped axes.

    All sources may have that in common, so that their boxes fit one another.
    """
    truth = truth_source(dataset)
    rows = np.flatnonzero(~dataset.truth.ignore)
    are_wide = dataset.truth.w[rows] > dataset.truth.h[rows]
    if len(rows) < MIN_CORNERS or not dataset.objects.are_pedestrians:
        return []
    if np.mean(are_wide) < NEARLY_ALL:
        return []
    was = parse_layout(dataset.read_as.get(TRUTH_NAME, ReadAs()).boxes)
    n_wide = np.count_nonzero(are_wide)
    return truth.findings(
        Severity.ERROR,
        "lying-pedestrians",
        rows[are_wide],
        f"{n_wide:,} of {count_text(len(rows), 'pedestrian')} are wider than tall: they are "
        "objects of another class, or the vertical number of each pair comes first.",
        "Look at one of them in its picture.",
        steps=(
            Step(Remedy.CLASSES),
            Step(Remedy.BOXES, str(replace(was, is_yx=not was.is_yx))),
            Step(Remedy.ACCEPT, "lying-pedestrians"),
        ),
    )


def _are_corners(source: BoxSource) -> bool:
    read_as = source.dataset.read_as.get(source.name, ReadAs())
    layout = parse_layout(read_as.boxes)
    boxes, frames = source.boxes, source.dataset.frame_columns
    if layout.kind != "sizes" or len(boxes) < MIN_CORNERS:
        return False
    x, y, w, h = boxes.xywh
    if not ((w > x) & (h > y)).all():  # as nearly always: the rest takes long
        return False
    recording = frames.recording[boxes.frame_index]
    width, height = frames.width[recording], frames.height[recording]
    are_inside = (w <= width + 1) & (h <= height + 1)
    sticking_out = np.mean((x + w > width + 1) | (y + h > height + 1))
    spread = np.ptp(np.percentile(x / width, [5, 95]))
    return bool(are_inside.all() and sticking_out > MANY_STICKING_OUT and spread > LARGE)


def find_layouts(dataset: Dataset) -> dict[str, LayoutFit]:
    """The meaning that makes boxes fit, by ``truth`` or the system's name; only where it is found.

    Where the truth could be wrong as well as the systems, it is whose boxes are less often upright
    and in the picture; and the truth, if that tells nothing and there are several systems.
    """
    if _KEY not in dataset.derived:
        dataset.derived[_KEY] = _find_layouts(dataset)
    layouts: dict[str, LayoutFit] = dataset.derived[_KEY]
    return layouts


def _find_layouts(dataset: Dataset) -> dict[str, LayoutFit]:
    of_systems: dict[str, LayoutFit | None] = {}
    of_truth: list[LayoutFit | None] = []
    believable: list[tuple[float, float]] = []
    are_upright = dataset.objects.are_pedestrians
    for name in dataset.systems:
        sample = take_sample(dataset, dataset.system(name))
        frames = np.unique(dataset.truth.frame_index[sample.rows])
        if not len(frames) or np.mean(sample.overlaps(Correction()).iou >= FIT_IOU) > POOR_SHARE:
            of_truth.append(None)
            continue
        truth = _boxes(truth_source(dataset), frames)
        system = _boxes(system_source(dataset, name), frames)
        if not len(system.frame):
            continue
        of_systems[name] = _best_layout(truth, system, is_of_truth=False)
        of_truth.append(_best_layout(truth, system, is_of_truth=True))
        believable.append(
            (
                truth.believable(are_upright=are_upright),
                system.believable(are_upright=are_upright),
            )
        )
    fits = {name: fit for name, fit in of_systems.items() if fit is not None}
    whole = of_truth[0] if of_truth else None
    if whole is None or any(fit is None or fit.layout != whole.layout for fit in of_truth):
        return fits
    truth_share, system_share = np.mean(believable, axis=0)
    least = UNCLEAR if len(of_truth) == 1 else -UNCLEAR
    if len(fits) == len(of_systems) and system_share - truth_share <= least:
        if system_share < truth_share - UNCLEAR:
            return fits
        return {name: replace(fit, of_truth=whole.layout) for name, fit in fits.items()}
    return {TRUTH_NAME: whole}


def _boxes(source: BoxSource, frames: np.ndarray) -> _Boxes:
    """The boxes of a source in some frames, with those that have no area as they were read."""
    dataset, boxes = source.dataset, source.boxes
    start = boxes.offsets[frames]
    rows = rows_in_ranges(start, boxes.offsets[frames + 1] - start)[1]
    rows = rows[~boxes.ignore[rows]]
    columns = [boxes.frame_index, *boxes.xywh, boxes.score]
    frame, x, y, w, h, score = (column[rows] for column in columns)
    lost = dataset.left_out
    lost = lost[(lost["reason"] == NO_AREA) & (lost["subject"] == source.name)]
    if len(lost):
        codes = pd.Index(dataset.recordings["name"]).get_indexer(pd.Index(lost["recording"]))
        listed = pd.MultiIndex.from_frame(dataset.frames[["recording", "frame"]])
        of_lost = listed.get_indexer(pd.MultiIndex.from_arrays([codes, lost["frame"].to_numpy()]))
        lost, of_lost = lost[is_there := np.isin(of_lost, frames)], of_lost[is_there]
        frame = np.concatenate([frame, of_lost])
        x, y, w, h = (
            np.concatenate([column, lost[name].to_numpy()])
            for name, column in zip("xywh", (x, y, w, h), strict=True)
        )
        score = np.concatenate([score, np.full(len(lost), np.nan)])
        by_frame = np.argsort(frame, kind="stable")
        frame, x, y, w, h, score = (column[by_frame] for column in (frame, x, y, w, h, score))
    of_frames = dataset.frame_columns
    recording = of_frames.recording[frame]
    width, height = of_frames.width[recording], of_frames.height[recording]
    read_as = dataset.read_as.get(source.name, ReadAs())
    return _Boxes(frame, (x, y, w, h), score, (width, height, width, height), read_as)


def _best_layout(truth: _Boxes, system: _Boxes, *, is_of_truth: bool) -> LayoutFit | None:
    """The meaning of the numbers of truth or system that makes most boxes fit, if one does."""
    lo, hi = (np.searchsorted(system.frame, truth.frame, side) for side in ("left", "right"))
    g, d = rows_in_ranges(lo, hi - lo)
    if not len(g):
        return None
    first = np.flatnonzero(np.diff(g, prepend=-1))

    def best_iou(of_truth: Box, of_system: Box) -> np.ndarray:
        pairs = tuple(column[g] for column in of_truth), tuple(column[d] for column in of_system)
        best: np.ndarray = np.maximum.reduceat(iou_of_pairs(*pairs), first)
        return best

    n, changed = len(truth.frame), truth if is_of_truth else system
    n_before = int(np.count_nonzero(best_iou(truth.box, system.box) >= FIT_IOU))
    fits = []
    for layout in changed.other_layouts():
        box = changed.laid_out(layout)
        iou = best_iou(*((box, system.box) if is_of_truth else (truth.box, box)))
        near = iou >= NEAR_IOU
        fitting = np.count_nonzero(iou >= FIT_IOU)
        least = max(MIN_FITTING, MIN_SHARE * min(n, len(system.frame)), MIN_GAIN * n_before)
        if fitting < least or np.median(iou[near]) < GOOD_IOU:
            continue
        x, y, w, _ = (column[g[first]][near] for column in (box if is_of_truth else truth.box))
        spread = max(np.ptp(np.percentile(values, [10, 90])) for values in (x, y))
        if spread < MIN_SPREAD * np.median(w):
            continue
        median = float(np.median(iou[near]))
        fits.append(LayoutFit(layout, changed.was, int(fitting), n_before, n, median))
    return max(fits, key=lambda fit: (fit.n_fitting, fit.iou), default=None)
