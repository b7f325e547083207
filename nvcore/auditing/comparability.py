"""Findings on the comparability of X and Y, such as unlike operating points without thresholds."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from nvcore.auditing.cases import BoxSource, spelled
from nvcore.common.findings import TRUTH_NAME, Cases, Finding, Remedy, Severity, Step
from nvcore.common.wording import capitalised, count_text, percent
from nvcore.dataset import Dataset
from nvcore.inputs.evaluated_frames import nth
from nvcore.metrics.detection.operating_point import are_unequal_alarms, threshold_for
from nvcore.metrics.encounters import encounters_of, mostly_one_frame
from nvcore.metrics.matching import Matches
from nvcore.metrics.proximity import weigh_proximity
from nvcore.metrics.proximity.borrowing import Borrowed, borrowed_distances, borrows, weighing_truth
from nvcore.settings.params import Params

MIN_ENCOUNTERS: Final = 10
"""Fewest near encounters for these findings."""
RELEVANT: Final = 0.5
"""Least proximity weight of a near pedestrian."""


def audit_encounter_lengths(dataset: Dataset, params: Params) -> list[Finding]:
    """Report that most near encounters are a single evaluated frame long.

    Notes
    -----
    Nothing is reported for proximity by an unknown horizon, which cannot be judged.
    """
    truth, frames = dataset.truth, dataset.frame_columns
    if params.proximity == "horizon" and params.horizon is None and np.isnan(frames.horizon).any():
        return []
    tracks, encounters = encounters_of(dataset)
    k = weigh_proximity(weighing_truth(dataset, params), ~truth.ignore, frames, params).k
    near = np.unique(encounters.encounter_of[~truth.ignore & (k >= RELEVANT)])
    n_frames = encounters.n_frames[near]
    if len(near) < MIN_ENCOUNTERS or not mostly_one_frame(n_frames):
        return []
    short = near[n_frames == 1]
    reasons, many, step = [], dataset.objects.plural, int(np.median(frames.gap))
    if step > 1:
        reasons.append(f"every {nth(step)} frame is evaluated")
    if len(tracks.linked_recordings):
        reasons.append(f"{many} without track ids were linked over the frames")
    why = f" ({'; '.join(reasons)})" if reasons else ""
    return [
        Finding(
            severity=Severity.WARNING,
            code="short-encounters",
            subject=TRUTH_NAME,
            count=len(short),
            message=(
                f"{len(short):,} of {len(near):,} encounters that count are one evaluated "
                f"frame long{why}."
            ),
            advice=(
                "Saliency, lag, gap, lead time, dropout and rates per hour mean little here, and "
                f"McNemar's test counts frames rather than {many}. Give ground truth with track "
                "ids in every frame, or read the measures per frame only."
            ),
            cases=Cases("boxes", np.flatnonzero(np.isin(encounters.encounter_of, short))),
        )
    ]


SHARE_APART: Final = 0.5
"""Least difference of the shares without distance for which two sources are weighted differently.
"""


def audit_weighting(
    truth: BoxSource, x: BoxSource, y: BoxSource, matches: tuple[Matches, Matches], params: Params
) -> list[Finding]:
    """Report X, Y and truth weighted by different rules because one of them lacks distances.

    This applies only to proximity by distance. A box without a distance is weighted by its height,
    so a false alarm of one system may weigh more than the same one of the other. As in the
    scorecard, ignore regions do not count, nor do detections on them or below the threshold.

    Parameters
    ----------
    matches
        Matches of X and Y, with their thresholds.
    """
    if params.proximity != "distance":
        return []
    weighed = replace(truth, boxes=weighing_truth(truth.dataset, params))
    counting = ~truth.boxes.ignore, *(match.is_counted for match in matches)
    sources = list(zip((weighed, x, y), counting, strict=True))
    rows = [
        np.flatnonzero(np.isnan(source.boxes.distance_m) & counts) for source, counts in sources
    ]
    counts = [int(np.count_nonzero(counts)) for _, counts in sources]
    shares = [len(own) / n if n else np.nan for own, n in zip(rows, counts, strict=True)]
    least = np.nanmin(shares, initial=1.0)
    of_each = ", ".join(
        f"{source.name} {percent(share)}"
        for (source, _), share in zip(sources, shares, strict=True)
        if not np.isnan(share)
    )
    return [
        finding
        for (source, _), own, n_boxes, share in zip(sources, rows, counts, shares, strict=True)
        if share - least >= SHARE_APART
        for finding in source.findings(
            Severity.WARNING,
            "mixed-weighting",
            own,
            f"{_how_many(len(own), n_boxes)} no distance and weigh by height"
            f"{', the others by metres' if len(own) < n_boxes else ''}: {_whose(source, own)}. "
            f"Boxes without a distance, by source: {of_each}.",
            "Weigh by height, which all boxes have, or give the distances"
            + (
                ", or borrow those of the systems."
                if source.is_truth and not borrows(params)
                else "."
            ),
            is_of_all=True,
            steps=(
                BY_HEIGHT,
                *[Step(Remedy.OPTION, "borrow", "missing_distance")]
                * (source.is_truth and not borrows(params)),
            ),
        )
    ]


def _how_many(n: int, n_boxes: int) -> str:
    """Return the beginning of a sentence about the share of boxes, ending in "have"."""
    if n == n_boxes:
        return "The only box that counts has" if n == 1 else f"All {n:,} boxes that count have"
    return f"{n:,} of {n_boxes:,} boxes that count ({percent(n / n_boxes)}) have"


def _whose(source: BoxSource, rows: np.ndarray) -> str:
    """Describe the recordings that boxes belong to."""
    recordings = source.dataset.recordings["name"]
    whose = np.unique(source.dataset.frame_columns.recording[source.boxes.frame_index[rows]])
    names = recordings.iloc[whose]
    if len(names) == len(recordings) > 1:
        return f"in all {len(names):,} recordings"
    return f"in {count_text(len(names), 'recording')}, {spelled(names)}"


BY_HEIGHT: Final = Step(Remedy.OPTION, "height", "proximity")
LARGE_SPREAD: Final = 0.25
"""Least relative difference of the distances that systems report of one pedestrian to be odd."""


LARGE_REST: Final = 0.1
"""Least share of pedestrians' boxes without any reported distance for a warning."""


def audit_borrowing(dataset: Dataset, params: Params) -> list[Finding]:
    """Report the lenders of pedestrians' missing distances, and how far the lenders differ.

    It is a warning in three cases. Many pedestrians find no lender. Only one of several systems
    lends: then misses before its first and after its last match weigh by height, its matches by
    metres. Or lenders differ.
    """
    if not borrows(params):
        return []
    borrowed = borrowed_distances(dataset)
    if not borrowed.n_borrowed + borrowed.n_unknown:
        return []
    n_boxes = borrowed.n_own + borrowed.n_borrowed + borrowed.n_unknown
    rest = borrowed.n_unknown / n_boxes
    advice, steps = _advice_on_borrowing(dataset, borrowed, rest)
    return [
        Finding(
            severity=Severity.WARNING if advice else Severity.NOTE,
            code="borrowed-distances",
            subject=TRUTH_NAME,
            count=borrowed.n_borrowed or borrowed.n_unknown,
            message=(
                f"{capitalised(borrowed.text)}. Of {n_boxes:,} truth boxes "
                f"{borrowed.n_unknown:,} ({percent(rest)}) have no distance and weigh by height."
            ),
            advice=advice or "Nothing to do: X and Y are judged by the same weights.",
            steps=steps,
        )
    ]


def _advice_on_borrowing(
    dataset: Dataset, borrowed: Borrowed, rest: float
) -> tuple[str, tuple[Step, ...]]:
    """Return advice on borrowed distances, or "" if nothing needs to be done."""
    n_lenders = sum(n > 0 for n in borrowed.lent.values())
    if not n_lenders:
        return (
            "Give the distances of the truth or of a system's detections (distance_m), or weigh by "
            "height, which all boxes have."
        ), (BY_HEIGHT,)
    advice, steps = [], []
    if rest >= LARGE_REST:
        advice.append(
            "Compare by height, too, which all boxes have: near and far are told by two rules here."
        )
        steps.append(BY_HEIGHT)
    if n_lenders == 1 < len(dataset.systems):
        advice.append(
            "Compare without borrowing, too: one system alone says here how near "
            f"{dataset.objects.plural} are, and only where it finds them."
        )
        steps.append(Step(Remedy.OPTION, "height", "missing_distance"))
    if borrowed.spread >= LARGE_SPREAD:
        advice.append("Check the unit of the distances, and what they are measured from.")
    return " ".join(advice), tuple(steps)


MIN_DETECTIONS: Final = 50
"""Fewest detections whose lowest score is meaningful."""
FLOOR_DIFFERENCE: Final = 0.05
"""Least difference of the lowest scores, both on a scale from 0 to 1, for a warning."""
MAX_RATIO: Final = 3.0
"""Ratio of the detections per frame for a warning on any scale."""


def audit_operating_points(
    x: BoxSource, y: BoxSource, matches: tuple[Matches, Matches], params: Params
) -> list[Finding]:
    """Report scores that reach down to different values, or far more detections of one system.

    This applies only if both systems have scores, neither has a threshold, and the verdict
    considers their numbers of false alarms unequal (`are_unequal_alarms`). Otherwise they are at
    similar operating points, wherever the scores end.

    Parameters
    ----------
    matches
        Matches of X and Y, without thresholds.
    """
    scores = x.boxes.score, y.boxes.score
    if params.threshold_x is not None or params.threshold_y is not None:
        return []
    if min(map(len, scores)) < MIN_DETECTIONS or not all(
        score.min() < score.max()
        for score in scores  # NaN is not less
    ):
        return []
    floors = [float(score.min()) for score in scores]
    per_frame = [len(score) / len(x.dataset.frames) for score in scores]
    is_unit = all(score.min() >= 0 and score.max() <= 1 for score in scores)
    is_apart = is_unit and abs(floors[0] - floors[1]) >= FLOOR_DIFFERENCE
    if not is_apart and max(per_frame) <= MAX_RATIO * min(per_frame):
        return []
    alarms = [
        np.sort(score[match.is_false_alarm])[::-1]
        for score, match in zip(scores, matches, strict=True)
    ]
    if not are_unequal_alarms(*map(len, alarms)):
        return []
    more = 0 if len(alarms[0]) >= len(alarms[1]) else 1
    threshold = threshold_for(alarms[more], len(alarms[1 - more]))
    systems = (x, y)
    advice = "Set thresholds for both."
    if threshold is not None:
        n_left, n_wanted = np.count_nonzero(alarms[more] >= threshold), len(alarms[1 - more])
        advice += (
            f" For example, {threshold:g} for {systems[more].name} alone leaves it "
            f"{n_left / len(x.dataset.frames):.2g} false alarms per frame; "
            f"{systems[1 - more].name} has {n_wanted / len(x.dataset.frames):.2g} "
            f"({count_text(n_wanted, 'false alarm')} in all)."
        )
    what = ", ".join(
        f"{score.name} {'has scores ' if i == 0 else ''}down to {floors[i]:.3f} "
        f"({per_frame[i]:.1f} detections per frame)"
        for i, score in enumerate(systems)
    )
    return [
        Finding(
            severity=Severity.WARNING,
            code="score-floors",
            subject=systems[more].name,
            count=len(systems[more].boxes),
            message=(
                f"{what}: without thresholds the comparison is at two different operating points."
            ),
            advice=advice,
            suggestion=() if threshold is None else (("threshold", threshold),),
            steps=tuple(
                Step(Remedy.THRESHOLD, "", system.name) for system in systems if threshold is None
            ),
        )
    ]
