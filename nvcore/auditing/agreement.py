"""Findings on systems that agree with each other, or seem right, but not with the truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import scipy

from nvcore.auditing.boxes import repeated_rows
from nvcore.auditing.cases import BoxSource, place_of_frame, truth_source
from nvcore.auditing.transforms import rows_in_ranges
from nvcore.common.findings import TRUTH_NAME, Cases, Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.pairs import pair_frames
from nvcore.metrics.linking import link_boxes
from nvcore.metrics.matching import Matches, iou_of_pairs
from nvcore.settings.params import Params

MIN_BOXES: Final = 20
"""Fewer boxes than this may be the same by chance."""
LOOSE_IOU: Final = 0.25
"""Least overlap of a false alarm with a missed pedestrian that it may be meant for."""
LOOSE_SHARE: Final = 0.25
"""Least share of a system's false alarms on missed pedestrians that is worth a look."""
SAME_IOU: Final = 1 - 1e-9
"""Least IoU of equal boxes, allowing for rounding."""
SAME_SHARE: Final = 0.95
"""Least share of a system's boxes equal to the truth's that cannot be chance."""


def audit_same_as_truth(source: BoxSource) -> list[Finding]:
    """Report a system whose boxes are all or nearly all copies of the ground truth's."""
    boxes, truth = source.boxes, source.dataset.truth
    same = _paired(boxes, truth, SAME_IOU)
    n_same, n = len(same), len(boxes)
    if n_same < MIN_BOXES:
        return []
    # repeated boxes of the system do not count
    n_different = n - len(repeated_rows(boxes))
    if n_same < SAME_SHARE * n_different:
        return []
    if n_same == n_different and n_same >= np.count_nonzero(~truth.ignore):
        return source.findings(
            Severity.WARNING,
            "truth-as-system",
            same,
            f"All {n_same:,} boxes are those of the ground truth, and all of the ground truth's "
            "are here: the ground truth was given as a system.",
            "Give the detections of the system.",
        )
    return source.findings(
        Severity.WARNING,
        "boxes-of-truth",
        same,
        f"{n_same:,} of {n_different:,} boxes are exactly those of the ground truth.",
        "Check that neither was made from the other: no detector draws the very same boxes.",
        count=n_same,
    )


def audit_same_systems(
    x: BoxSource, y: BoxSource, counting: tuple[BoxColumns, ...]
) -> list[Finding]:
    """Report X and Y if they have identical boxes in the same frames.

    Parameters
    ----------
    counting
        Detections of X and of Y that pass their thresholds, since one file may be compared at two
        thresholds.
    """
    of_x, of_y = counting
    are_as_many = len(of_x) == len(of_y) >= MIN_BOXES
    if not are_as_many or len(_paired(of_x, of_y, SAME_IOU)) < len(of_x):
        return []
    return x.findings(
        Severity.WARNING,
        "same-boxes",
        np.arange(1),
        f"{x.name} and {y.name} have exactly the same {len(of_x):,} boxes.",
        "Check whether the same file was given twice: the comparison cannot tell the two apart.",
        count=len(of_x),
        is_of_all=True,
    )


AGREE_IOU: Final = 0.5
"""Smallest IoU of two detections that agree."""
REPEATED_SHARE: Final = 0.5
"""Least share of matched pedestrians with further boxes that suggests missing suppression."""
NEAR_IOU: Final = 0.1
"""Smallest IoU of an agreeing detection with the missed pedestrian that it may be meant for."""
MANY_SHARE: Final = 0.05
"""Least share of the pedestrians for which such cases are a warning instead of a note."""
NOT_OF_TRUTH: Final = "agreed-by-both-alone"
HARDLY: Final = 0.1
"""Share of the pedestrians below which systems match hardly anybody ..."""
LEAST_AGREED: Final = 5
"""... which is an error if they agree with each other on at least this number of boxes ..."""
MOST_AGREED: Final = 0.5
"""... on this share of the false alarms of the system with fewer ..."""
LEAST_OF_TRUTH: Final = 0.2
"""... and on this number of boxes per pedestrian."""
MANY_BOXES: Final = 20
"""Fewer boxes than this stay a note."""


def find_disagreement(
    dataset: Dataset, x: BoxSource, y: BoxSource, matches: tuple[Matches, Matches]
) -> list[Finding]:
    """Report pedestrians that both systems place elsewhere, and false alarms that both share.

    A detection of X and one of Y agree if their IoU is at least 0.5. Only pairs count in which
    neither detection matches a pedestrian or lies on an ignore region. A pair that overlaps a
    pedestrian whom neither system matched indicates a badly drawn box. Any other pair indicates a
    pedestrian missing from the annotation, unless it overlaps one who is matched by another box. It
    is an error if both match hardly anybody but agree with each other, because the truth then
    belongs to other frames or pictures.
    """
    truth = dataset.truth
    agreed = _paired(x.boxes, y.boxes, AGREE_IOU, *(of_one.is_false_alarm for of_one in matches))
    if not len(agreed):
        return []
    n_truth = int(np.count_nonzero(~truth.ignore))
    n_matched = [int(np.count_nonzero(of_one.is_matched)) for of_one in matches]
    n_alarms = min(int(np.count_nonzero(of_one.is_false_alarm)) for of_one in matches)
    least = max(LEAST_AGREED, MOST_AGREED * n_alarms, LEAST_OF_TRUTH * n_truth)
    if max(n_matched) < HARDLY * n_truth and len(agreed) >= least:
        return [_elsewhere(x, y, agreed, n_matched, n_truth)]
    unmatched = ~truth.ignore & ~matches[0].is_matched & ~matches[1].is_matched
    missed_row = _overlapped(truth, unmatched, x.boxes, agreed)
    is_annotated = _overlapped(truth, ~truth.ignore, x.boxes, agreed, AGREE_IOU) >= 0
    return [
        *_drawn_elsewhere(dataset, np.unique(missed_row[missed_row >= 0]), n_truth),
        *_missing(dataset, x.boxes, agreed[(missed_row < 0) & ~is_annotated], x=x.name, y=y.name),
    ]


def find_repeated(source: BoxSource, matches: Matches) -> list[Finding]:
    """Report a system that has several boxes on most of the pedestrians that it matches."""
    truth, objects = source.dataset.truth, source.dataset.objects
    rows = np.flatnonzero(matches.is_false_alarm)
    people = matches.is_matched & ~truth.ignore
    on = _overlapped(truth, people, source.boxes, rows, AGREE_IOU)
    n_people, n_repeated = int(np.count_nonzero(people)), len(np.unique(on[on >= 0]))
    if n_repeated < max(MIN_BOXES, REPEATED_SHARE * n_people):
        return []
    return source.findings(
        Severity.WARNING,
        "several-boxes",
        rows[on >= 0],
        f"{n_repeated:,} of {count_text(n_people, objects.singular, objects.plural)} matched have "
        f"several boxes: {count_text(int(np.count_nonzero(on >= 0)), 'false alarm')} overlap them "
        f"by an IoU of {AGREE_IOU:g} or more.",
        "Check whether non-maximum suppression was left out, or boxes of several files joined.",
    )


def find_ignored(source: BoxSource, matches: Matches) -> list[Finding]:
    """Report a system that detects more ignored boxes of the truth than pedestrians."""
    truth, objects = source.dataset.truth, source.dataset.objects
    rows = _paired(truth, source.boxes, AGREE_IOU, truth.ignore)
    n_matched = int(np.count_nonzero(matches.is_matched & ~truth.ignore))
    if len(rows) < max(MIN_BOXES, n_matched + 1):
        return []
    return truth_source(source.dataset).findings(
        Severity.WARNING,
        "ignored-boxes-detected",
        rows,
        f"{source.name} has boxes on {len(rows):,} of {np.count_nonzero(truth.ignore):,} ignored "
        f"boxes (IoU {AGREE_IOU:g} or more), but matches only "
        f"{count_text(n_matched, objects.singular, objects.plural)}.",
        "Look at some: the numbers or names of the classes may mean others. Ignored boxes count "
        "neither as missed nor as detected.",
        steps=(Step(Remedy.CLASSES, "", TRUTH_NAME),),
    )


def find_loose(source: BoxSource, matches: Matches, params: Params) -> list[Finding]:
    """Report a system if many of its false alarms overlap missed pedestrians by too low an IoU.

    This applies only to matching by IoU. Otherwise the shape of a box does not matter.
    """
    if params.match != "iou":
        return []
    truth, boxes = source.dataset.truth, source.boxes
    rows = np.flatnonzero(matches.is_false_alarm)
    missed = _overlapped(truth, ~truth.ignore & ~matches.is_matched, boxes, rows, LOOSE_IOU)
    g, d = missed[missed >= 0], rows[missed >= 0]
    iou = iou_of_pairs(
        (truth.x[g], truth.y[g], truth.w[g], truth.h[g]),
        (boxes.x[d], boxes.y[d], boxes.w[d], boxes.h[d]),
    )
    loose = d[iou < params.iou]  # otherwise their classes differ
    if len(loose) < max(MIN_BOXES, LOOSE_SHARE * len(rows)):
        return []
    say = source.dataset.objects.say
    return source.findings(
        Severity.WARNING,
        "loose-boxes",
        loose,
        f"{len(loose):,} of {count_text(len(rows), 'false alarm')} overlap {say('{a_one} {who}')} "
        f"counts as missed by an IoU of {LOOSE_IOU:g} or more, but less than the {params.iou:g} "
        "that is asked for.",
        say(
            "Look at some: where they show the {one}, the boxes are of another shape than the "
            "ground truth's. The {one} then counts as missed, the boxes as false alarms, and "
            'comparisons at equal false alarms rest on them. A lower iou, or match = "lateral", '
            "judges {what} a system detects."
        ),
    )


LIKE_MATCHED: Final = 0.25
"""Share of a system's matched runs that are shorter, lower or less sure than an unmatched run that
looks like them. A lower share lets in passing false alarms of systems whose matches are often
interrupted."""
LEAST_MORE: Final = 5
"""Least number of such runs that one system has more ..."""
LEAST_SHARE: Final = 0.01
"""... and their least share of its matched runs: fewer hardly move a verdict."""
LEVEL: Final = 0.05
"""Largest p that is beyond chance."""


class _Lookalikes(NamedTuple):
    """Unmatched runs of a system that look like its matched ones.

    `rows`: largest box of each, largest first. `by_recording`: their number, shape
    (n_recordings,). `n_others`: number of its other unmatched runs. `n_matched`: of its matched
    ones. `least`: frames, height (px) and score from which a run looks like them.
    """

    rows: np.ndarray
    by_recording: np.ndarray
    n_others: int
    n_matched: int
    least: np.ndarray


def find_unlisted(x: BoxSource, y: BoxSource, matches: tuple[Matches, Matches]) -> list[Finding]:
    """Report a system whose false alarms look like pedestrians missing from the ground truth.

    If the ground truth was drawn by looking at what X shows, it lacks people whom only Y detects.
    Y's right detections then count as false alarms. This compares the systems' `_lookalikes`: if
    both have as many, the truth is merely incomplete. Since more false alarms include more of them,
    the other's number is first raised by the ratio of their other unmatched runs. The rest is
    tested over recordings (two-sided sign test with mid-p, Lancaster 1961, which needs five that
    differ). Their share of unmatched runs has to be larger than the other's, too (binomial mid-p):
    where that has hardly any false alarms, few of them being alike says nothing.
    """
    found = [_lookalikes(system, matched) for system, matched in zip((x, y), matches, strict=True)]
    say = x.dataset.objects.say
    if min(runs.n_matched for runs in found) < MIN_BOXES:
        return []
    for system, other, many, few in ((x, y, found[0], found[1]), (y, x, found[1], found[0])):
        ratio = max(1.0, many.n_others / max(few.n_others, 1))
        more = many.by_recording - ratio * few.by_recording
        if more.sum() < max(LEAST_MORE, LEAST_SHARE * many.n_matched):
            continue
        n_fewer, n_apart = int(np.count_nonzero(more < 0)), int(np.count_nonzero(more))
        n_many, n_few = len(many.rows), len(few.rows)
        share = (n_many + n_few) / (n_many + many.n_others + n_few + few.n_others)
        p = 2 * _mid_p(n_fewer, n_apart, 0.5), _mid_p(n_few, n_few + few.n_others, share)
        if max(p) > LEVEL:
            continue
        frames, height, score = many.least
        sure = f" and sure (score {score:.3g})" if np.isfinite(score) else ""
        return system.findings(
            Severity.WARNING,
            "false-alarms-like-matches",
            many.rows,
            f"{system.name} has {count_text(n_many, 'run')} of false alarms as long "
            f"({count_text(int(np.ceil(frames)), 'frame')}), large ({height:.0f} px){sure} as the "
            f"upper three quarters of its matches, {other.name} has {n_few:,}: more than chance.",
            say(
                "Look at them. Where they show {people}, the ground truth lacks {people} {whom} "
                "{other} does not detect, and {name}'s right detections count as false alarms: add "
                "{them}. Where they show {nobody}, there is nothing to do.",
                other=other.name,
                name=system.name,
            ),
        )
    return []


def _mid_p(k: int, n: int, share: float) -> float:
    """Return the probability of less than k of n, and half of that of k of n."""
    p: float = scipy.special.bdtr(k, n, share)
    return (p + scipy.special.bdtr(k - 1, n, share)) / 2 if k else p / 2


def _lookalikes(source: BoxSource, matches: Matches) -> _Lookalikes:
    """Return runs of false alarms, linked over frames, that look like the system's matched runs.

    A run looks like them if it has as many boxes as the shortest quarter, is as high and has as
    high a mean score, all at once, and none of its boxes overlaps the truth or its ignore regions.
    """
    boxes, truth = source.boxes, source.dataset.truth
    n_recordings = len(source.dataset.recordings)
    rows = np.flatnonzero(matches.is_false_alarm)
    run, unmatched = _runs(source, rows)
    _, matched = _runs(source, np.flatnonzero(matches.det_truth >= 0))
    if not len(rows) or not matched.size:
        nothing = np.zeros(n_recordings, np.int64), unmatched.shape[1], matched.shape[1]
        return _Lookalikes(rows[:0], *nothing, np.full(3, np.nan))
    least = np.quantile(matched, LIKE_MATCHED, axis=1)
    is_alike = np.all((unmatched >= least[:, None]) | np.isnan(least)[:, None], axis=0)
    rows, run = rows[is_alike[run]], run[is_alike[run]]
    is_near = _overlapped(truth, np.ones(len(truth), bool), boxes, rows) >= 0
    is_alike[run[is_near]] = False
    rows, run = rows[is_alike[run]], run[is_alike[run]]
    largest_first = np.argsort(-boxes.h[rows], kind="stable")
    rows = rows[largest_first][np.sort(np.unique(run[largest_first], return_index=True)[1])]
    recording = source.dataset.frame_columns.recording[boxes.frame_index[rows]]
    by_recording = np.bincount(recording, minlength=n_recordings)
    n_others = unmatched.shape[1] - len(rows)
    return _Lookalikes(rows, by_recording, n_others, matched.shape[1], least)


def _runs(source: BoxSource, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Link boxes into runs: run of each box, and number of boxes, mean height and score of runs."""
    run = link_boxes(source.boxes, source.dataset.frame_columns, rows)
    n = np.bincount(run)
    sums = [np.bincount(run, values[rows]) for values in (source.boxes.h, source.boxes.score)]
    return run, np.stack([n, *(total / n for total in sums)])


def _paired(
    x: BoxColumns,
    y: BoxColumns,
    least_iou: float,
    in_x: np.ndarray | None = None,
    in_y: np.ndarray | None = None,
) -> np.ndarray:
    """Return the rows of X that pair with a box of Y in the same frame.

    Pairs are formed by descending IoU, each box once.

    Parameters
    ----------
    in_x, in_y
        Boxes that take part, bool; None: all.
    """
    partner = np.full(len(x), -1, np.int64)
    in_x = np.ones(len(x), bool) if in_x is None else in_x
    in_y = np.ones(len(y), bool) if in_y is None else in_y
    pairs = x.arrays, in_x, y.arrays, in_y
    over_ranges(pair_frames, len(x.offsets) - 1, *pairs, least_iou, partner)
    return np.flatnonzero(partner >= 0)


def _overlapped(
    truth: BoxColumns,
    unmatched: np.ndarray,
    x: BoxColumns,
    agreed: np.ndarray,
    least_iou: float = NEAR_IOU,
) -> np.ndarray:
    """Return the unmatched pedestrian that each detection overlaps most, or -1 if none is near."""
    frame = x.frame_index[agreed]
    start = truth.offsets[frame]
    n = truth.offsets[frame + 1] - start
    pair, g = rows_in_ranges(start, n)
    is_open = unmatched[g]
    pair, g = pair[is_open], g[is_open]
    d = agreed[pair]
    iou = iou_of_pairs(
        (truth.x[g], truth.y[g], truth.w[g], truth.h[g]), (x.x[d], x.y[d], x.w[d], x.h[d])
    )
    best = np.zeros(len(agreed))
    np.maximum.at(best, pair, iou)
    row = np.full(len(agreed), -1, np.int64)
    is_best = (iou >= least_iou) & (iou == best[pair])
    row[pair[is_best]] = g[is_best]
    return row


def _elsewhere(
    x: BoxSource, y: BoxSource, agreed: np.ndarray, n_matched: Sequence[int], n_truth: int
) -> Finding:
    objects = x.dataset.objects
    return Finding(
        Severity.ERROR,
        NOT_OF_TRUTH,
        TRUTH_NAME,
        len(agreed),
        f"{x.name} and {y.name} match {n_matched[0]} and {n_matched[1]} of "
        f"{count_text(n_truth, objects.singular, objects.plural)}, but agree with one another on "
        f"{count_text(len(agreed), 'box', 'boxes')} where the ground truth has "
        f"{objects.say('{nobody}')}.",
        f"Look at a frame with {objects.plural}: is it the same recording, are its frames numbered "
        "alike (every n-th of them by 0, 1, 2, ...?), the pictures the same way round, and the "
        "classes those that were meant?",
        cases=Cases("boxes", x.boxes.first_row + agreed),
        steps=(
            Step(Remedy.FRAME_STEP, "", x.name),
            Step(Remedy.FRAME_STEP, "", y.name),
            Step(Remedy.ACCEPT, NOT_OF_TRUTH),
        ),
    )


def _drawn_elsewhere(dataset: Dataset, rows: np.ndarray, n_truth: int) -> list[Finding]:
    n_frames, objects = len(np.unique(dataset.truth.frame_index[rows])), dataset.objects
    are_many = len(rows) >= max(MANY_BOXES, MANY_SHARE * n_truth)
    return truth_source(dataset).findings(
        Severity.WARNING if are_many else Severity.NOTE,
        "box-disputed-by-both",
        rows,
        f"Neither system matches {count_text(len(rows), objects.singular, objects.plural)} in "
        f"{count_text(n_frames, 'frame')}, while both agree on a box close by.",
        "Look at them: the ground truth's box may be drawn badly, or be of another frame.",
    )


def _missing(
    dataset: Dataset, boxes: BoxColumns, rows: np.ndarray, *, x: str, y: str
) -> list[Finding]:
    if not len(rows):
        return []
    frames, say = np.unique(boxes.frame_index[rows]), dataset.objects.say
    return [
        Finding(
            severity=Severity.NOTE,
            code="agreed-by-both-not-in-truth",
            subject="truth",
            count=len(rows),
            message=f"In {count_text(len(frames), 'frame')} {x} and {y} agree on "
            f"{count_text(len(rows), 'box', 'boxes')} where the ground truth has "
            f"{say('{nobody}')}.",
            advice=say(
                "Look at them: {a_one} may be missing from the annotation, and each counts as a "
                "false alarm of both. If many are weak detections, give thresholds."
            ),
            example=place_of_frame(dataset, int(frames[0])),
            cases=Cases("boxes", boxes.first_row + rows),
        )
    ]
