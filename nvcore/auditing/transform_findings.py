"""Findings on boxes that overlap the truth only under a transform, or under none that was tried."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from nvcore.auditing.cases import BoxSource, all_sources, truth_source
from nvcore.auditing.coverage import PART_CODE, frames_with
from nvcore.auditing.rows import listed_ranges
from nvcore.auditing.transform_search import DECENT, Search, is_better, search, trial_of
from nvcore.auditing.transforms import FIT_IOU, LARGE, NOT_LISTED, Fit, Transform, source_of
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.sources import ReadAs, left_out_text
from nvcore.inputs.box_layouts import BoxLayout, parse_layout
from nvcore.inputs.evaluated_frames import nth
from nvcore.inputs.readers import format_named
from nvcore.metrics.matching import Matches

CODES: Final = {
    "another format": "box-layout",
    "another meaning of a box's numbers": "box-layout",
    "another frame rate": "frame-rate",
    "pictures of another size": "scale-mismatch",
    "another frame number": "time-offset",
    "another place in the picture": "pixel-offset",
}
"""Codes of findings by the first of `Transform.kinds`."""
ADVICE: Final = {
    "box-layout": "All numbers are wrong until the boxes are read as they were written.",
    "frame-rate": "Correct the frame numbers as they are read. Frames that the system did not see "
    "stay misses: evaluate both systems on those that it saw.",
    "scale-mismatch": "Scale them as they are read, or in the files.",
    "time-offset": "Check the frame numbers, or move them as they are read.",
    "pixel-offset": "Check the picture's origin and cropping, or move the boxes as they are read.",
}
EXPLAINED: Final = (PART_CODE, "frame-not-listed", "no-detections")
"""Codes of findings that add nothing to an error about a system's frame numbers."""
WRONG_GAIN: Final = 2
"""Factor in the number of fitting pedestrians by which a transform is an error ..."""
WRONG_SHARE: Final = 0.4
"""... if this share of the boxes then fits, so that half of the overlap or more is lost without it.
"""
UNCLEAR: Final = 0.05
"""Largest difference for which it is unclear whether truth or systems were misread."""
NO_MATCH: Final = "no-match"
MIN_MATCHABLE: Final = 5
"""Fewest pedestrians for this finding. Fewer may be missed by any system."""
MOST_FRAMES: Final = 0.5
"""Share of the frames with pedestrians in which a system without matches must have detections."""
MIN_CORNERS: Final = 20
"""Fewest boxes for this finding. Fewer may look like corners by chance ..."""
MANY_STICKING_OUT: Final = 0.2
"""... as may boxes of which a smaller share sticks out of the picture as read."""
NEARLY_ALL: Final = 0.9
"""Share of boxes wider than tall from which they are not of pedestrians."""


@dataclass(frozen=True)
class TruthLayout:
    """Box layout of the truth that makes all systems fit.

    `is_certain` is False if a system's boxes may be misread as well.
    """

    layout: BoxLayout
    best: Fit
    as_is: Fit
    is_certain: bool


def find_truth_layout(dataset: Dataset) -> TruthLayout | None:
    """Find out whether the truth was misread rather than the systems. Cached in the dataset.

    The better fit decides. If both fit equally well, the first rule that applies decides: systems
    whose files may be in another format were misread; the side whose boxes are less often upright
    and in the picture was misread; the truth was misread if several systems agree.
    """
    return dataset.kept("truth layout", _find_truth_layout)


def _find_truth_layout(dataset: Dataset) -> TruthLayout | None:
    names = [name for name in dataset.systems if len(dataset.system(name))]
    trials = [trial_of(dataset, name) for name in names]
    if not trials or any(trial.fit(Transform()).share > DECENT for trial in trials):
        return None
    trials = [trial.with_left_out() for trial in trials]
    if not all(len(trial.truth.score) for trial in trials):
        return None
    searches = [search(dataset, name) for name in names]
    as_they_are = [trial.fit(Transform()) for trial in trials]
    best, best_rank = None, 0.0
    for layout in trials[0].other_layouts(TRUTH_NAME):
        under = [trial.with_truth_as(layout) for trial in trials]
        fits = [trial.fit(Transform()) for trial in under]
        rank = float(np.mean([fit.rank for fit in fits]))
        if rank > best_rank and all(
            is_better(*of_one, is_of_layout=True)
            for of_one in zip(under, fits, as_they_are, strict=True)
        ):
            best_rank = rank
            best = TruthLayout(layout, fits[0], as_they_are[0], True)
    if best is None:
        return None
    of_systems = [found.best for found in searches]
    rank = float(np.mean([(found.best or found.as_is).rank for found in searches]))
    if best_rank > rank + UNCLEAR or None in of_systems:
        return best
    if best_rank < rank - UNCLEAR or any(fit.transform.format for fit in of_systems if fit):
        return None
    believable = [[of.believable(dataset) for of in (t.truth, t.system)] for t in trials]
    truth_share, system_share = np.mean(believable, axis=0)
    if system_share < truth_share - UNCLEAR:
        return None
    return replace(best, is_certain=len(trials) > 1 or system_share > truth_share + UNCLEAR)


def audit_truth_layout(dataset: Dataset) -> list[Finding]:
    """Report an error if the boxes of the truth, and perhaps of all sources, were misread."""
    found = find_truth_layout(dataset)
    if found is None or not found.is_certain:
        return _corners_of_all(dataset) or _lying(dataset)
    what = f"{found.layout.text} (taken for {_read_as(dataset).text})"
    return [
        _of_source(
            truth_source(dataset),
            "box-layout",
            _gain_text(dataset, what, found.best, found.as_is),
            f"{ADVICE['box-layout']} It is the ground truth that needs it: the systems agree.",
            [Step(Remedy.BOXES, str(found.layout), TRUTH_NAME)],
        )
    ]


def audit_transform(source: BoxSource, threshold: float | None) -> list[Finding]:
    """Report the transform under which a system's misfitting boxes fit the truth best."""
    dataset, name = source.dataset, source.name
    of_truth = find_truth_layout(dataset)
    found = search(dataset, name, threshold)
    if found.best is None or (of_truth is not None and of_truth.is_certain):
        return []
    best, as_is, transform = found.best, found.as_is, found.best.transform
    code = CODES[transform.kinds[0]]
    is_wrong = (
        code in ("box-layout", "frame-rate")
        or (best.n_fitting >= WRONG_GAIN * as_is.n_fitting and best.share >= WRONG_SHARE)
        or _explains_rows(source, transform)
    )
    steps = []
    if transform.format:
        steps.append(Step(Remedy.FORMAT, transform.format, name))
    if transform.boxes is not None:
        steps.append(Step(Remedy.BOXES, str(transform.boxes), name))
        if of_truth is not None:
            steps.append(Step(Remedy.BOXES, str(of_truth.layout), TRUTH_NAME))
    looked_at = "" if found.every == 1 else f", judged by every {nth(found.every)} frame"
    message = _gain_text(dataset, _in_words(dataset, name, transform), best, as_is, looked_at)
    return [
        replace(
            _of_source(source, code, message, ADVICE[code], steps),
            severity=Severity.ERROR if is_wrong else Severity.WARNING,
            suggestion=_suggestion(dataset, name, transform),
        )
    ]


def _gain_text(dataset: Dataset, what: str, best: Fit, as_is: Fit, looked_at: str = "") -> str:
    people = count_text(best.n, dataset.objects.singular, dataset.objects.plural)
    return (
        f"The boxes seem to be {what}: corrected, {best.n_fitting:,} of {people} overlap one by an "
        f"IoU of {FIT_IOU:g} or more, {as_is.n_fitting:,} as they are (mean IoU {best.mean:.2f} "
        f"instead of {as_is.mean:.2f}{looked_at})."
    )


def _of_source(
    source: BoxSource, code: str, message: str, advice: str, steps: Sequence[Step]
) -> Finding:
    """Return an error about a source as a whole."""
    inputs = source.dataset.inputs
    files = inputs["file"][inputs["subject"] == source.name]
    file, n = files.iloc[0] if len(files) else "", len(source.boxes)
    return Finding(
        *(Severity.ERROR, code, source.name, n, message, advice, file), steps=tuple(steps)
    )


def _explains_rows(source: BoxSource, transform: Transform) -> bool:
    """Whether a time offset explains all rows left out beside the evaluated frames.

    Two facts then show that the file counts frames from another number. A system that merely lags
    behind has no such rows.
    """
    lost = source.dataset.left_out
    lost = lost[(lost["subject"] == source.name) & (lost["reason"] == NOT_LISTED)]
    if not transform.offset_frames or lost.empty:
        return False
    first, last, _ = listed_ranges(source.dataset, lost["recording"])
    frame = lost["frame"].to_numpy()
    moved = transform.frame_step * frame + transform.offset_frames
    is_beside = (frame < first) | (frame > last)
    return bool(np.all(is_beside & (first <= moved) & (moved <= last)))


def _read_as(dataset: Dataset, name: str = TRUTH_NAME) -> BoxLayout:
    return parse_layout(dataset.read_as.get(name, ReadAs()).boxes)


def _in_words(dataset: Dataset, name: str, transform: Transform) -> str:
    """Describe what the boxes seem to be, for the message."""
    parts, frames, (sx, sy) = [], transform.offset_frames, transform.scale
    if transform.format:
        title, taken = format_named(transform.format).title, dataset.read_as[name].format
        parts.append(f"{title} (read as {taken})")
    if transform.boxes is not None:
        parts.append(f"{transform.boxes.text} (taken for {_read_as(dataset, name).text})")
    if transform.frame_step != 1:
        step, offset = _frame_numbers(dataset, name, transform)
        behind = f" {'+' if offset > 0 else '-'} {abs(offset)}" if offset else ""
        parts.append(f"numbered at another frame rate (frame = {step:g} x number{behind})")
    elif frames:
        when = "late" if frames < 0 else "early"
        parts.append(f"{count_text(abs(frames), 'frame')} too {when}")
    if transform.scale != (1.0, 1.0):
        factors = f"{sx:.4g}" if sx == sy else f"{sx:.4g} across and {sy:.4g} down"
        parts.append(f"made at another resolution (to be multiplied by {factors})")
    sides = zip(transform.offset_px, (("left", "right"), ("up", "down")), strict=True)
    parts += [f"{abs(px):.1f} px too far {words[px < 0]}" for px, words in sides if abs(px) >= 0.5]
    return " and ".join(parts)


def _frame_numbers(dataset: Dataset, name: str, transform: Transform) -> tuple[float, int]:
    """Return factor and offset of the numbers in a system's files, including those already set."""
    own, step = source_of(dataset, name), transform.frame_step
    offset = round(own.offset_frames * step) + transform.offset_frames
    return float(f"{step * own.frame_step:.6g}"), offset


def _suggestion(dataset: Dataset, name: str, transform: Transform) -> tuple[tuple[str, float], ...]:
    """Return settings of the system that apply the transform, combined with existing ones."""
    own, values = source_of(dataset, name), {}
    step, offset = _frame_numbers(dataset, name, transform)
    if step != own.frame_step:
        values["frame_step"] = step
    if offset != own.offset_frames:
        values["offset_frames"] = float(offset)
    (sx, sy), (dx, dy) = transform.scale, transform.offset_px
    across, down = sx * own.scale[0], sy * own.scale[1]
    if transform.scale != (1.0, 1.0):
        values |= {"scale": across} if across == down else {"scale_x": across, "scale_y": down}
    moved = round(sx * own.offset_px[0] + dx, 3), round(sy * own.offset_px[1] + dy, 3)
    if moved != own.offset_px:
        values |= {"offset_x_px": moved[0], "offset_y_px": moved[1]}
    return tuple(values.items())


def audit_no_match(
    dataset: Dataset,
    systems: Sequence[BoxSource],
    counting: Sequence[BoxColumns],
    matches: Sequence[Matches],
    thresholds: Sequence[float | None],
) -> list[Finding]:
    """Report an error if no system matches anybody for an unknown reason, a warning for one of two.

    Parameters
    ----------
    systems
        Compared systems, perhaps only one.
    counting, thresholds
        Detections of the systems that pass the thresholds, and the thresholds.

    Notes
    -----
    This is limited to systems that detect something in half of the frames with pedestrians, because
    silent ones have other findings. A single system that matches nobody is an error, too, since
    nothing else shows that the files were read correctly. It is a warning if boxes overlap as read
    but less than the matching setting requires.
    """
    of_truth = frames_with(dataset.truth, ~dataset.truth.ignore)
    n = int(np.count_nonzero(~dataset.truth.ignore))
    if n < MIN_MATCHABLE or find_truth_layout(dataset) is not None:
        return []
    blind: dict[str, Search] = {}
    for system, boxes, matched, threshold in zip(
        systems, counting, matches, thresholds, strict=True
    ):
        if not matched.is_matched.any() and np.mean(frames_with(boxes)[of_truth]) >= MOST_FRAMES:
            found = search(dataset, system.name, threshold)
            if found.best is None:
                blind[system.name] = found
    if not blind:
        return []
    names, are_all, objects = [*blind], len(blind) == len(systems), dataset.objects
    is_pair = are_all and len(systems) == 2
    who = "Neither system matches a single" if is_pair else f"{names[0]} matches not a single"
    message = (
        f"{who} {objects.singular}, although {'both detect' if is_pair else 'it detects'} "
        "something in most frames."
    )
    left_out = _classes_left_out(dataset, [TRUTH_NAME, *names])
    if left_out:
        message += f" Left out as other classes: {'; '.join(left_out.values())}."
    are_read = any(found.as_is.n_fitting for found in blind.values())
    advice = (
        "The setting of matching asks for more: see match, iou and the classes."
        if are_read
        else f"Look at a frame with {objects.plural}: are these the classes, frames and boxes that "
        "were meant, and the same recording?"
    )
    tried = {"as they are": [found.as_is.n_fitting for found in blind.values()]}
    for kind in () if are_read else CODES:
        if any(kind in found.tried for found in blind.values()):
            tried[kind] = [found.tried.get(kind, 0) for found in blind.values()]
    seen = [f"{found.as_is.n:,}" for found in blind.values()]  # frames are sampled for each
    message += (
        f" Tried, with how many of {' and '.join(dict.fromkeys(seen))} {objects.plural} then "
        f"overlap a box of {' and '.join(names)} by an IoU of {FIT_IOU:g} or more: "
        + "; ".join(f"{what} {' and '.join(map(str, values))}" for what, values in tried.items())
        + "."
    )
    is_error = are_all and not are_read
    steps = [] if are_read else [Step(Remedy.CLASSES, "", name) for name in left_out]
    steps += [Step(Remedy.ACCEPT, NO_MATCH)] if is_error else []
    return [
        Finding(
            severity=Severity.ERROR if is_error else Severity.WARNING,
            code=NO_MATCH,
            subject=TRUTH_NAME if is_pair else names[0],
            count=n,
            message=message,
            advice=advice,
            steps=tuple(steps),
        )
    ]


def _classes_left_out(dataset: Dataset, subjects: Sequence[str]) -> dict[str, str]:
    """Describe the boxes of other classes, by source, without sources that have none."""
    left_out = {
        subject: [part for part in dataset.read_as[subject].left_out if part.kind == "class"]
        for subject in subjects
        if subject in dataset.read_as
    }
    return {
        subject: f"{subject} {left_out_text(classes)}"
        for subject, classes in left_out.items()
        if classes
    }


def _corners_of_all(dataset: Dataset) -> list[Finding]:
    """Report an error if the truth, and so perhaps every source, has corners instead of sizes.

    Boxes then fit one another, and only the picture reveals it: many stick out of the picture,
    though none of their corners does.
    """
    having = [source for source in all_sources(dataset) if _are_corners(source)]
    if not having or not having[0].is_truth:
        return []
    names = [""] if len(having) > len(dataset.systems) else [source.name for source in having]
    boxes = _read_as(dataset)
    message = (
        f"The numbers of each box were taken for {boxes.text}, and many boxes then stick out of "
        "the picture. The third is always larger than the first and the fourth than the second, "
        "and all lie in the picture: they seem to be corners."
    )
    steps = [Step(Remedy.BOXES, str(replace(boxes, kind="corners")), name) for name in names]
    return [_of_source(having[0], "box-layout", message, ADVICE["box-layout"], steps)]


def _are_corners(source: BoxSource) -> bool:
    boxes, frames = source.boxes, source.dataset.frame_columns
    if _read_as(source.dataset, source.name).kind != "sizes" or len(boxes) < MIN_CORNERS:
        return False
    x, y, w, h = boxes.xywh
    if not ((w > x) & (h > y)).all():  # almost always: the rest is slow
        return False
    recording = frames.recording[boxes.frame_index]
    width, height = frames.width[recording], frames.height[recording]
    are_inside = (w <= width + 1) & (h <= height + 1)
    sticking_out = np.mean((x + w > width + 1) | (y + h > height + 1))
    spread = np.ptp(np.percentile(x / width, [5, 95]))
    return bool(are_inside.all() and sticking_out > MANY_STICKING_OUT and spread > LARGE)


def _lying(dataset: Dataset) -> list[Finding]:
    """Report an error if nearly all pedestrians are wider than tall (another class, swapped axes).

    All sources may have this in common, so that their boxes fit one another.
    """
    rows = np.flatnonzero(~dataset.truth.ignore)
    wide = rows[dataset.truth.w[rows] > dataset.truth.h[rows]]
    are_enough = len(rows) >= MIN_CORNERS and len(wide) >= NEARLY_ALL * len(rows)
    if not are_enough or not dataset.objects.are_pedestrians:
        return []
    was = _read_as(dataset)
    return truth_source(dataset).findings(
        Severity.ERROR,
        "lying-pedestrians",
        wide,
        f"{len(wide):,} of {count_text(len(rows), 'pedestrian')} are wider than tall: they are "
        "objects of another class, or the vertical number of each pair comes first.",
        "Look at one of them in its picture.",
        steps=(
            Step(Remedy.CLASSES),
            Step(Remedy.BOXES, str(replace(was, is_yx=not was.is_yx))),
            Step(Remedy.ACCEPT, "lying-pedestrians"),
        ),
    )
