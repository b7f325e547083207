"""Notes on a stability map, which claim no more than its cells show.

The systems are called X and Y; no note contains names from files.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.wording import listed
from nvcore.comparison.measures.table import evidence_form, inference_of, repeated_by
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.stability.axes import Axis, Plane
from nvcore.evidence.stability.map import Flip, FlipInterval, StabilityMap, Winner
from nvcore.evidence.stability.scores import MEASURE_OF, Criterion
from nvcore.notes import Note, phrase, say
from nvcore.settings.objects import PEDESTRIAN

PLANES: Final[dict[Plane, str]] = {
    "alpha-midpoint": "Alpha and what counts as near",
    "thresholds": "Both thresholds",
    "matching": "Matching rule",
    "edge-weight": "Traffic context",
    "edge-weight-alpha": "Traffic context and alpha",
    "pairing-alpha": "Strict pairing and alpha",
    "saliency-rule": "Rules of saliency",
}
CRITERIA: Final[dict[Criterion, str]] = {
    "similarity": "mean similarity",
    "encounters": "encounters detected",
    "saliency": "saliency",
}
QUANTITY: Final[dict[Criterion, str]] = {
    "similarity": "mean similarity: X better by (below 0: Y)",
    "encounters": "encounters detected: X better by (below 0: Y)",
    "saliency": "saliency (s): X better by (below 0: Y)",
}
UNDEFINED: Final[dict[Criterion, str]] = {
    "similarity": "there are no frames",
    "encounters": "no encounter is near enough to count",
    "saliency": "there are no frames",
}
ALL: Final = 1e-9
"""Shares this close to 1 or 0 count as all or none, since they are sums of rounded parts."""


def difference_text(criterion: Criterion, difference: float) -> str:
    """Format the size of a difference as in tables: "0.0123", "3 encounters", "0.50 s"."""
    size = abs(difference)
    if criterion == "encounters":
        return f"{size:.0f} encounter{'' if size == 1 else 's'}"
    form, unit = evidence_form(MEASURE_OF[criterion]), inference_of(MEASURE_OF[criterion]).noun_unit
    least = 10 ** -int(form[1])
    if 0 < size < least / 2:
        return f"less than {least:{form}}{unit}"
    return f"{size:{form}}{unit}"


def share_text(share: float) -> str:
    """Format a share as "all", "none" or a whole percentage from 1 to 99."""
    if share > 1 - ALL:
        return "all"
    return "none" if share < ALL else f"{min(max(round(100 * share), 1), 99)} %"


def winner_text(criterion: Criterion, winner: Winner, difference: float) -> str:
    """Return who is better and by how much: "X has the higher mean similarity, by 0.012"."""
    return phrase(_claim(criterion, winner, difference), PEDESTRIAN)


def settings_text(stability: StabilityMap, place: Sequence[float]) -> str:
    """Return the relevant settings at a point of the map: "alpha 0.3 and midpoint 48 px"."""
    return listed(_settings(stability, place))


def nearest_text(stability: StabilityMap) -> str:
    """Describe in a few words the nearest setting that overturns the verdict."""
    if stability.verdict == "undefined":
        return "-"
    if stability.overturn is None:
        return "nowhere on the map"
    return phrase(_flip(stability, stability.overturn), PEDESTRIAN)


def describe_stability(stability: StabilityMap) -> tuple[str, ...]:
    """Describe in sentences whether the verdict depends on the settings of the map.

    The sentences give the verdict as analysed, the share of the plausible range in which it holds,
    the reason for that range, and whether the settings in use lie in it. Then follow how far each
    setting can be moved alone, and the nearest setting that overturns the verdict in every separate
    part of the map. They are about these settings and data only; `describe_chance` says whether a
    difference is more than chance.
    """
    return tuple(say(note, PEDESTRIAN) for note in _notes(stability))


def describe_in_short(stability: StabilityMap) -> str:
    """Describe the verdict as analysed, and the share of the plausible range where it holds."""
    held = [
        note
        for note in _notes(stability)
        if note.key in ("stability.as_analysed", "stability.held")
    ]
    return " ".join(say(note, PEDESTRIAN, "short") for note in held)


def _notes(stability: StabilityMap) -> list[Note]:
    criterion, verdict = stability.criterion, stability.verdict
    claim = _claim(criterion, verdict, stability.present_difference)
    is_defined = verdict != "undefined"
    notes = [Note("stability.as_analysed", is_defined=is_defined, claim=claim)]
    axes = zip(stability.axes, stability.is_moved_by, strict=True)
    still = [axis.title for axis, moves in axes if not moves]
    if is_defined and still:
        notes.append(Note("stability.no_effect", settings=still))
    if not is_defined or not any(stability.is_moved_by):
        return notes
    equal_alarms = _equal_alarms(stability)
    notes += [_held(stability), *([equal_alarms] if equal_alarms else []), *_present(stability)]
    notes += [_interval(stability, interval) for interval in stability.intervals]
    return [*notes, *_choices(stability), *_nearest(stability)]


def _claim(criterion: Criterion, winner: Winner, difference: float | None = None) -> Note:
    size = None if difference is None else difference_text(criterion, difference)
    why = UNDEFINED[criterion] if winner == "undefined" else None
    return Note("stability.claim", criterion=criterion, winner=winner, size=size, why=why)


def _axes_that_matter(stability: StabilityMap) -> list[Axis]:
    axes = zip(stability.axes, stability.is_moved_by, strict=True)
    return [axis for axis, moves in axes if moves]


def _held(stability: StabilityMap) -> Note:
    axes = _axes_that_matter(stability)
    reasons: list[str | None] = [axis.reason for axis in axes]
    if len({*reasons}) == 1:
        reasons[:-1] = [None] * (len(reasons) - 1)
    ranges = [
        Note(
            "stability.range",
            setting=axis.label[0].lower() + axis.label[1:],
            range=axis.range_text(*axis.plausible),
            reason=reason,
        )
        for axis, reason in zip(axes, reasons, strict=True)
    ]
    share = stability.share_held
    return Note(
        "stability.held",
        share=None if np.isnan(share) else share_text(share),
        is_partly=stability.share_defined <= 1 - ALL,
        has_pairs=stability.equal_alarms is not None,
        ranges=ranges,
    )


def describe_equal_alarms(stability: StabilityMap) -> str:
    """Say who is better at equal false alarms, if both thresholds are varied."""
    note = _equal_alarms(stability)
    return say(note, PEDESTRIAN) if note else ""


def _equal_alarms(stability: StabilityMap) -> Note | None:
    line = stability.equal_alarms
    if line is None:
        return None
    values: dict[str, Any] = {"x": line.present_x, "y": line.present_y}
    if len(line.difference):
        order: tuple[Winner, ...] = ("x", "y", "even", "undefined")
        values["least"], values["most"] = line.alarms_per_frame[[0, -1]]
        values["parts"] = [
            Note(
                "stability.share_of_pairs",
                claim=None if winner == "undefined" else _claim(stability.criterion, winner),
                share=share_text(line.share(winner)),
            )
            for winner in order
            if line.share(winner)
        ]
    return Note("stability.equal_alarms", **values)


def describe_chance(stability: StabilityMap, evidence: pd.DataFrame) -> str:
    """Say whether the difference as analysed is more than chance, if there is a difference.

    The verdict decides whether the difference may be claimed, also at equal false alarms.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the same result.
    """
    key = MEASURE_OF[stability.criterion]
    rows = evidence[evidence["figure"] == (repeated_by(key) or key)].to_dict("records")
    if stability.verdict in ("even", "undefined") or not rows:
        return ""
    (row,) = rows
    p, p_corrected = row["p"], row["p_corrected"]
    if np.isnan(p_corrected):
        why = row["note"].split("; ")[0] or None
        return say(Note("stability.untestable", why=why), PEDESTRIAN)
    of_test = {"n": int(row["n"]), "p": p, "p_corrected": p_corrected}
    note = Note("stability.tested", is_shown=p_corrected <= SIGNIFICANT, **of_test)
    return say(note, PEDESTRIAN)


def _present(stability: StabilityMap) -> list[Note]:
    """Return remarks on the settings in use that readers need to understand the other notes."""
    axes = _axes_that_matter(stability)
    notes = [
        Note("stability.own_values", setting=axis.label, range=axis.range_text(*axis.present))
        for axis in axes
        if axis.present_index is None
    ]
    outside = [
        f"{axis.title} {axis.range_text(*axis.present)}"
        for axis in axes
        if not axis.is_plausible(np.array(axis.present)).all()
    ]
    return [*notes, Note("stability.outside", settings=outside)] if outside else notes


def _interval(stability: StabilityMap, interval: FlipInterval) -> Note:
    """Return a note on where the verdict holds, and where it flips, along one axis alone."""
    axis, low, high = stability.axes[interval.axis], interval.low, interval.high
    ends = ((interval.flips_below, interval.below), (interval.flips_above, interval.above))
    return Note(
        "stability.interval",
        setting=axis.title,
        value=axis.number_text(low) if low == high else None,
        range=axis.range_text(low, high),
        flips=[
            Note("stability.flip_at", value=axis.number_text(value), winner=winner)
            for value, winner in ends
            if not np.isnan(value)
        ],
    )


def _choices(stability: StabilityMap) -> list[Note]:
    """Return notes on who is better if one choice has another value and all else is unchanged."""
    present, notes = stability.present_indices, []
    if present is None:
        return []
    for i, axis in enumerate(stability.axes):
        others = [label for label in range(len(axis)) if label != present[i]]
        for label in others if axis.labels and stability.is_moved_by[i] else ():
            cell = tuple(label if j == i else index for j, index in enumerate(present))
            difference = float(stability.difference[cell])
            claim = _claim(stability.criterion, stability.winner[cell], difference)
            notes.append(Note("stability.choice", setting=axis.text(float(label)), claim=claim))
    return notes


def _settings(stability: StabilityMap, place: Sequence[float]) -> list[str]:
    axes = zip(stability.axes, place, stability.is_moved_by, strict=True)
    return [axis.text(value) for axis, value, moves in axes if moves]


def _nearest(stability: StabilityMap) -> list[Note]:
    """Return notes on the nearest settings that overturn the verdict, in every part of the map."""
    end, worse = stability.end, "Y" if stability.verdict == "x" else "X"
    is_tie = stability.verdict == "even"
    if not stability.overturns:
        if end is not None:
            return [Note("stability.nearest_tie", worse=worse, flip=_flip(stability, end))]
        return [Note("stability.all_tie") if is_tie else Note("stability.never_level", worse=worse)]
    first, *more = stability.overturns
    notes = [Note("stability.nearest", is_tie=is_tie, flip=_flip(stability, first))]
    inside = stability.plausible_overturn
    if inside is not None and inside != first:
        notes.append(Note("stability.nearest_plausible", flip=_flip(stability, inside)))
    if more:
        better, nearest = "X or Y" if is_tie else worse, _flip(stability, more[0])
        notes.append(Note("stability.other_parts", better=better, n=len(more), flip=nearest))
    return notes


def _flip(stability: StabilityMap, flip: Flip) -> Note:
    """Return a note on where a flip is, who is better there, and how far away it is."""
    lead = difference_text(stability.criterion, flip.difference) if flip.difference else None
    return Note(
        "stability.flip",
        place=_settings(stability, flip.place),
        winner=flip.winner,
        lead=lead,
        is_plausible=flip.is_plausible,
        distance=flip.distance,
    )
