"""What a stability map shows, in sentences that claim no more than its cells show.

The systems are called X and Y; these sentences contain no names from files.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import pandas as pd

from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.stability.axes import Axis, Plane
from nvcore.stability.flips import Flip, FlipInterval, Winner, winners
from nvcore.stability.map import StabilityMap
from nvcore.stability.scores import MEASURE_OF, Criterion
from nvcore.wording import capitalised, count_text, listed, p_text

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
BETTER: Final[dict[Criterion, str]] = {
    "similarity": "has the higher mean similarity",
    "encounters": "detects more encounters",
    "saliency": "has the lower saliency",
}
EQUAL: Final[dict[Criterion, str]] = {
    "similarity": "have the same mean similarity",
    "encounters": "detect equally many encounters",
    "saliency": "have the same saliency",
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
BECOMES: Final[dict[Winner, str]] = {
    "x": "turns to X",
    "y": "turns to Y",
    "even": "becomes a tie",
    "undefined": "becomes undefined",
}
ALL: Final = 1e-9
"""A share this close to 1 or 0 counts as all or none: shares are sums of rounded parts."""


def difference_text(criterion: Criterion, difference: float) -> str:
    """The size of a difference, rounded as in tables: "0.0123", "3 encounters", "0.50 s"."""
    size = abs(difference)
    if criterion == "encounters":
        return f"{size:.0f} encounter{'' if size == 1 else 's'}"
    digits, unit = (2, " s") if criterion == "saliency" else (4, "")
    least = 10**-digits
    if 0 < size < least / 2:
        return f"less than {least:.{digits}f}{unit}"
    return f"{size:.{digits}f}{unit}"


def winner_text(criterion: Criterion, winner: Winner, difference: float) -> str:
    """Who is better by how much: "X has the higher mean similarity, by 0.012"."""
    if winner == "undefined":
        return f"undefined: {UNDEFINED[criterion]}"
    if winner == "even":
        return f"X and Y {EQUAL[criterion]}"
    size = difference_text(criterion, difference)
    return f"{winner.upper()} {BETTER[criterion]}, by {size}"


def describe_stability(stability: StabilityMap) -> tuple[str, ...]:
    """Whether the verdict depends on the settings of the map, in sentences.

    The verdict as analysed; the share of the plausible range in which it holds, why that range, and
    whether the settings in use lie in it; how far each setting can be moved alone; and the nearest
    setting that overturns it, in every separate part of the map. All this concerns these settings
    and these data; `describe_chance` says whether a difference is more than chance.
    """
    verdict, present = stability.verdict, stability.present_difference
    text = winner_text(stability.criterion, verdict, present)
    if verdict == "undefined":
        return (f"As analysed the verdict is {text}.",)
    sentences = [f"As analysed, {text}."]
    still = [
        axis.title
        for axis, moves in zip(stability.axes, stability.is_moved_by, strict=True)
        if not moves
    ]
    if still:
        text = f"{listed(still)} {'do' if len(still) > 1 else 'does'} not enter into it."
        sentences.append(capitalised(text))
    if not any(stability.is_moved_by):
        return tuple(sentences)
    sentences.append(_share(stability))
    sentences += filter(None, [describe_equal_alarms(stability)])
    sentences += _present(stability)
    sentences += [_interval(stability, interval) for interval in stability.intervals]
    sentences += _choices(stability)
    sentences += _nearest(stability)
    return tuple(sentences)


def describe_in_short(stability: StabilityMap) -> str:
    """The verdict as analysed, and in which share of the plausible range it holds."""
    first = describe_stability(stability)[0]
    if stability.verdict == "undefined" or not any(stability.is_moved_by):
        return first
    return f"{first} {_share(stability).partition(':')[0]}."


def _axes_that_matter(stability: StabilityMap) -> list[Axis]:
    axes = zip(stability.axes, stability.is_moved_by, strict=True)
    return [axis for axis, moves in axes if moves]


def _share(stability: StabilityMap) -> str:
    axes = _axes_that_matter(stability)
    settings = [f"{_lower(axis.label)} {axis.range_text(*axis.plausible)}" for axis in axes]
    reasons = [f" ({axis.reason})" for axis in axes]
    if len(set(reasons)) == 1:
        reasons[:-1] = [""] * (len(reasons) - 1)
    ranges = listed([range_ + reason for range_, reason in zip(settings, reasons, strict=True)])
    if np.isnan(stability.share_held):
        return f"In the plausible range it is undefined: {ranges}."
    partly = "" if stability.share_defined > 1 - ALL else ", where that is defined"
    pairs = (
        ", all pairs of a strict threshold with a lax one among them"
        if stability.equal_alarms is not None
        else ""
    )
    return (
        f"The verdict holds in {share_text(stability.share_held)} of the plausible range{partly}: "
        f"{ranges}{pairs}."
    )


def _lower(label: str) -> str:
    """A label within a sentence; abbreviations keep their capitals."""
    return label[0].lower() + label[1:]


def describe_equal_alarms(stability: StabilityMap) -> str:
    """Who is better at equally many false alarms; empty unless the map is over both thresholds."""
    criterion, line = stability.criterion, stability.equal_alarms
    if line is None:
        return ""
    present = (
        f"as analysed, X has {line.present_x:.2g} and Y {line.present_y:.2g} false alarms per frame"
    )
    if not len(line.difference):
        return f"No thresholds give X and Y equally many false alarms; {present}."
    least, most = line.alarms_per_frame[[0, -1]]
    claims: dict[Winner, str] = {
        "x": f"X {BETTER[criterion]}",
        "y": f"Y {BETTER[criterion]}",
        "even": f"X and Y {EQUAL[criterion]}",
        "undefined": "it is undefined",
    }
    parts = [
        f"{claim} in {share_text(line.share(winner))}"
        for winner, claim in claims.items()
        if line.share(winner)
    ]
    return (
        f"With equally many false alarms, {least:.2g} to {most:.2g} per frame, {listed(parts)} of "
        f"these pairs of thresholds; {present}."
    )


def describe_chance(stability: StabilityMap, evidence: pd.DataFrame) -> str:
    """What p says of the difference as analysed; empty if there is no difference.

    Whether the difference may be claimed, at equal false alarms as well, is up to the verdict.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the same result.
    """
    rows = evidence[evidence["figure"] == MEASURE_OF[stability.criterion]].to_dict("records")
    if stability.verdict in ("even", "undefined") or not rows:
        return ""
    (row,) = rows
    no_evidence = "a verdict that holds at other settings is no evidence against chance"
    if np.isnan(row["p_corrected"]):
        why = row["note"].split("; ")[0]
        because = f" ({why})" if why else ""
        return (
            "Whether this difference is more than chance cannot be tested here"
            f"{because}: {no_evidence}."
        )
    by = count_text(int(row["n"]), "recording")
    family = " for all measures" if row["p"] != row["p_corrected"] else ""
    p = f"by {by}, {p_text(row['p'], row['p_corrected'])}{family}"
    if row["p_corrected"] <= SIGNIFICANT:
        return (
            f"This difference is unlikely to be chance ({p}); whether it may be claimed is up to "
            "the verdict."
        )
    return f"This difference is not shown to be more than chance ({p}): {no_evidence}."


def share_text(share: float) -> str:
    """A share as "all", "none" or a whole percentage from 1 to 99."""
    if share > 1 - ALL:
        return "all"
    return "none" if share < ALL else f"{min(max(round(100 * share), 1), 99)} %"


def _present(stability: StabilityMap) -> list[str]:
    """What the reader must know about the settings in use to understand the rest."""
    axes = _axes_that_matter(stability)
    sentences = [
        f'"{axis.label}" is each recording\'s own here, {axis.range_text(*axis.present)}: the '
        "settings in use are no single point of this map."
        for axis in axes
        if axis.present_index is None
    ]
    outside = [
        f"{axis.title} {axis.range_text(*axis.present)}"
        for axis in axes
        if not axis.is_present_plausible
    ]
    if outside:
        sentences.append(
            f"The settings in use lie outside the plausible range themselves: {listed(outside)}."
        )
    return sentences


def _interval(stability: StabilityMap, interval: FlipInterval) -> str:
    """Where the verdict holds along one axis alone, and where it flips."""
    axis = stability.axes[interval.axis]
    flips = [
        f"at {axis.number_text(value)} it {BECOMES[winner]}"
        for value, winner in (
            (interval.flips_below, interval.below),
            (interval.flips_above, interval.above),
        )
        if not np.isnan(value)
    ]
    where = f"every value tried from {axis.range_text(interval.low, interval.high)}"
    if interval.low == interval.high:
        where = f"{axis.number_text(interval.low)} only"
    title = capitalised(axis.title)
    text = f"{title}: all else as it is, it holds for {where}"
    return f"{text}; {listed(flips)}." if flips else f"{text}, the whole map."


def _choices(stability: StabilityMap) -> list[str]:
    """Who is better with the other values of a choice, all else unchanged."""
    present_indices = [axis.present_index for axis in stability.axes]
    if stability.present_cell is None:
        return []
    sentences = []
    for i, axis in enumerate(stability.axes):
        if not axis.labels or not stability.is_moved_by[i]:
            continue
        for label in range(len(axis)):
            if label == present_indices[i]:
                continue
            cell = tuple(label if j == i else index for j, index in enumerate(present_indices))
            difference = float(stability.difference[cell])
            winner = winners(np.array([difference]))[0]
            text = winner_text(stability.criterion, winner, difference)
            sentences.append(f"With {axis.text(float(label))}, all else as it is, {text}.")
    return sentences


def settings_text(stability: StabilityMap, place: Sequence[float]) -> str:
    """A place on the map in words, without irrelevant settings: "alpha 0.3 and midpoint 48 px"."""
    axes = zip(stability.axes, place, stability.is_moved_by, strict=True)
    return listed([axis.text(value) for axis, value, moves in axes if moves])


def nearest_text(stability: StabilityMap) -> str:
    """The nearest setting that overturns the verdict, if any, in a few words."""
    if stability.verdict == "undefined":
        return "-"
    if stability.overturn is None:
        return "nowhere on the map"
    return _flip(stability, stability.overturn)


def _nearest(stability: StabilityMap) -> list[str]:
    """The nearest setting that overturns the verdict, overall and in each part of the map."""
    end, worse = stability.end, "Y" if stability.verdict == "x" else "X"
    if not stability.overturns:
        if end is not None:
            tie = _flip(stability, end)
            return [f"Nowhere on this map is {worse} better; the nearest tie: {tie}."]
        if stability.verdict == "even":
            return ["It is a tie all over this map."]
        return [f"Nowhere on this map does {worse} come level."]
    first, *more = stability.overturns
    effect = "overturns this" if stability.verdict != "even" else "ends the tie"
    sentences = [f"The nearest setting on this map that {effect}: {_flip(stability, first)}."]
    inside = stability.plausible_overturn
    if inside is not None and inside != first:
        sentences.append(f"The nearest within the plausible range: {_flip(stability, inside)}.")
    if more:
        better_system = worse if stability.verdict != "even" else "X or Y"
        where = "another part" if len(more) == 1 else f"{len(more)} other parts"
        nearest = _flip(stability, more[0])
        sentences.append(
            f"{better_system} is also better in {where} of this map, nearest: {nearest}."
        )
    return sentences


def _flip(stability: StabilityMap, flip: Flip) -> str:
    """Where a flip is, who is better there, and how far away it is."""
    text = settings_text(stability, flip.place)
    if flip.winner != "even":
        lead = difference_text(stability.criterion, flip.difference)
        ahead = f"{flip.winner.upper()} ahead by {lead}"
        text += f" ({ahead})" if flip.difference else f", where it turns to {flip.winner.upper()}"
    side = "inside" if flip.is_plausible else "outside"
    away = f"{flip.distance:.2g} times its width away"
    if not flip.distance:
        away = "among the recordings' own values"
    return f"{text}, {side} the plausible range and {away}"
