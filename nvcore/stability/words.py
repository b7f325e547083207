"""What a stability map shows, in sentences that say no more than its cells.

The systems are called X and Y; no name from a file stands in these sentences.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import pandas as pd

from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.stability.axes import Plane
from nvcore.stability.map import StabilityMap
from nvcore.stability.scores import Criterion
from nvcore.stability.turns import Stretch, Turn, Winner, winners

PLANES: Final[dict[Plane, str]] = {
    "alpha-midpoint": "Alpha and what counts as near",
    "thresholds": "Both thresholds",
    "matching": "Matching rule",
    "edge-weight": "Traffic context",
    "edge-weight-alpha": "Traffic context and alpha",
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
SAME: Final[dict[Criterion, str]] = {
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
TESTED: Final[dict[Criterion, tuple[str, ...]]] = {
    "similarity": ("mean_similarity",),
    "encounters": ("encounters_detected", "encounters_detected_by_unit"),
    "saliency": ("saliency",),
}
"""Rows of the table of evidence that are about a criterion."""
ALL: Final = 1e-9
"""A share this near to all or none is that: shares are sums of rounded parts."""


def difference_text(criterion: Criterion, difference: float) -> str:
    """The size of a difference, digits as in the tables: "0.0123", "3 encounters", "0.50 s"."""
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
        return f"X and Y {SAME[criterion]}"
    size = difference_text(criterion, difference)
    return f"{winner.upper()} {BETTER[criterion]}, by {size}"


def describe_stability(found: StabilityMap) -> tuple[str, ...]:
    """Whether the verdict depends on the settings of the map, in sentences.

    What holds as analysed; in which share of the plausible range, what makes that plausible, and
    whether the settings in use lie in it; how far each setting can be moved alone; and the nearest
    setting that overturns it, in every separate part of the map. All of this is about these
    settings and these data: whether a difference is more than chance is another question, which
    `describe_chance` answers.
    """
    verdict, present = found.verdict, found.present_difference
    said = winner_text(found.criterion, verdict, present)
    if verdict == "undefined":
        return (f"As analysed the verdict is {said}.",)
    sentences = [f"As analysed, {said}."]
    still = [
        axis.title for axis, moves in zip(found.axes, found.is_moved_by, strict=True) if not moves
    ]
    if still:
        said = f"{_and(still)} {'do' if len(still) > 1 else 'does'} not enter into it."
        sentences.append(f"{said[0].upper()}{said[1:]}")
    if not any(found.is_moved_by):
        return tuple(sentences)
    sentences.append(_share(found))
    sentences += filter(None, [describe_equal_alarms(found)])
    sentences += _present(found)
    sentences += [_stretch(found, one) for one in found.stretches]
    sentences += _choices(found)
    sentences += _nearest(found)
    return tuple(sentences)


def _and(words: list[str]) -> str:
    return "".join(words) if len(words) < 2 else f"{', '.join(words[:-1])} and {words[-1]}"


def _share(found: StabilityMap) -> str:
    moved = [axis for axis, moves in zip(found.axes, found.is_moved_by, strict=True) if moves]
    said = [f"{_lower(axis.label)} {axis.range_text(*axis.plausible)}" for axis in moved]
    reasons = [f" ({axis.reason})" for axis in moved]
    if len(set(reasons)) == 1:
        reasons[:-1] = [""] * (len(reasons) - 1)
    ranges = _and([range_ + reason for range_, reason in zip(said, reasons, strict=True)])
    if np.isnan(found.share_held):
        return f"In the plausible range it is undefined: {ranges}."
    partly = "" if found.share_defined > 1 - ALL else ", where that is defined"
    pairs = (
        ", all pairs of a strict threshold with a lax one among them"
        if found.equal_alarms is not None else ""
    )  # fmt: skip
    return (
        f"The verdict holds in {share_text(found.share_held)} of the plausible range{partly}: "
        f"{ranges}{pairs}."
    )


def _lower(label: str) -> str:
    """A label within a sentence; abbreviations keep their capitals."""
    return label[0].lower() + label[1:]


def describe_equal_alarms(found: StabilityMap) -> str:
    """Who is better where both raise equally many false alarms; empty but over both thresholds."""
    criterion, line = found.criterion, found.equal_alarms
    if line is None:
        return ""
    present = (
        f"as analysed, X has {line.present_x:.2g} and Y {line.present_y:.2g} false alarms per frame"
    )
    if not len(line.difference):
        return f"No thresholds give X and Y equally many false alarms; {present}."
    least, most = line.alarms_per_frame[[0, -1]]
    who: dict[Winner, str] = {
        "x": f"X {BETTER[criterion]}", "y": f"Y {BETTER[criterion]}",
        "even": f"X and Y {SAME[criterion]}", "undefined": "it is undefined",
    }  # fmt: skip
    held = [f"{said} in {share_text(line.share(one))}" for one, said in who.items()
            if line.share(one)]  # fmt: skip
    return (
        f"With equally many false alarms, {least:.2g} to {most:.2g} per frame, {_and(held)} of "
        f"these pairs of thresholds; {present}."
    )


def describe_chance(found: StabilityMap, evidence: pd.DataFrame) -> str:
    """Whether the difference as analysed is more than chance; empty where there is none.

    Parameters
    ----------
    evidence
        `evidence_table` of the same result. Of several tests of the criterion the
        one with the largest p-value counts.
    """
    rows = evidence[evidence["figure"].isin(TESTED[found.criterion])]
    if found.verdict in ("even", "undefined") or rows.empty:
        return ""
    what = "this difference"
    if found.criterion == "saliency":
        what = "the difference in the mean saliency of the recordings"
        if rows["difference"].iloc[0] * found.present_difference > 0:  # less is better
            what += f", which speaks for {'Y' if found.verdict == 'x' else 'X'},"
    tested = rows[np.isfinite(rows["p_holm"])]
    no_evidence = "a verdict that holds at other settings is no evidence against chance"
    if tested.empty:
        why = rows["note"].iloc[-1].split("; ")[0]
        because = f" ({why})" if why else ""
        return f"Whether {what} is more than chance cannot be tested here{because}: {no_evidence}."
    worst = tested.loc[tested["p_holm"].idxmax()]
    by = f"by {int(worst['n']):,} {worst['unit']}"
    if worst["unit"] == "blocks":
        by += " of time, which say nothing of other recordings"
    p = f"p = {worst['p_holm']:.2g}, corrected for all figures tested; {by}"
    if worst["p_holm"] <= SIGNIFICANT:
        return f"{what[0].upper()}{what[1:]} is more than chance ({p})."
    return f"{what[0].upper()}{what[1:]} is not shown to be more than chance ({p}): {no_evidence}."


def share_text(share: float) -> str:
    """A share as "all", "none" or in whole per cent, neither 0 nor 100 of them."""
    if share > 1 - ALL:
        return "all"
    return "none" if share < ALL else f"{min(max(round(100 * share), 1), 99)} %"


def _present(found: StabilityMap) -> list[str]:
    """What the reader must know of the settings in use to read the rest."""
    moved = [axis for axis, moves in zip(found.axes, found.is_moved_by, strict=True) if moves]
    sentences = [
        f"\"{axis.label}\" is each recording's own here, {axis.range_text(*axis.present)}: the "
        "settings in use are no single point of this map."
        for axis in moved if axis.present_index is None
    ]  # fmt: skip
    outside = [
        f"{axis.title} {axis.range_text(*axis.present)}"
        for axis in moved if not axis.is_present_plausible
    ]  # fmt: skip
    if outside:
        said = "The settings in use lie outside the plausible range themselves"
        sentences.append(f"{said}: {_and(outside)}.")
    return sentences


def _stretch(found: StabilityMap, stretch: Stretch) -> str:
    """Where the verdict holds along one axis alone, and where it turns."""
    axis = found.axes[stretch.axis]
    turns = [
        f"at {axis.number_text(turn)} it {BECOMES[winner]}"
        for turn, winner in (
            (stretch.turns_below, stretch.below),
            (stretch.turns_above, stretch.above),
        )
        if not np.isnan(turn)
    ]
    where = f"every value tried from {axis.range_text(stretch.low, stretch.high)}"
    if stretch.low == stretch.high:
        where = f"{axis.number_text(stretch.low)} only"
    title = axis.title[0].upper() + axis.title[1:]
    said = f"{title}: all else as it is, it holds for {where}"
    return f"{said}; {_and(turns)}." if turns else f"{said}, the whole map."


def _choices(found: StabilityMap) -> list[str]:
    """Who is better with the other values of a choice, all else as it is."""
    at = [axis.present_index for axis in found.axes]
    if found.present_cell is None:
        return []
    sentences = []
    for i, axis in enumerate(found.axes):
        if not axis.labels or not found.is_moved_by[i]:
            continue
        for label in range(len(axis)):
            if label == at[i]:
                continue
            cell = tuple(label if j == i else place for j, place in enumerate(at))
            difference = float(found.difference[cell])
            winner = winners(np.array([difference]))[0]
            said = winner_text(found.criterion, winner, difference)
            sentences.append(f"With {axis.text(float(label))}, all else as it is, {said}.")
    return sentences


def settings_text(found: StabilityMap, at: Sequence[float]) -> str:
    """A place on the map in words, of the settings that matter: "alpha 0.3 and midpoint 48 px"."""
    return _and([
        axis.text(value)
        for axis, value, moves in zip(found.axes, at, found.is_moved_by, strict=True) if moves
    ])  # fmt: skip


def nearest_text(found: StabilityMap) -> str:
    """The nearest setting that overturns the verdict, or that none does, in a few words."""
    if found.verdict == "undefined":
        return "-"
    return _turn(found, found.overturn) if found.overturn is not None else "nowhere on the map"


def _nearest(found: StabilityMap) -> list[str]:
    """The nearest setting that overturns the verdict, overall and in each part of the map."""
    end, other = found.end, "Y" if found.verdict == "x" else "X"
    if not found.overturns:
        if end is not None:
            return [f"Nowhere on this map is {other} better; the nearest tie: {_turn(found, end)}."]
        if found.verdict == "even":
            return ["It is a tie all over this map."]
        return [f"Nowhere on this map does {other} come level."]
    first, *more = found.overturns
    what = "overturns this" if found.verdict != "even" else "ends the tie"
    sentences = [f"The nearest setting on this map that {what}: {_turn(found, first)}."]
    inside = found.plausible_overturn
    if inside is not None and inside != first:
        sentences.append(f"The nearest within the plausible range: {_turn(found, inside)}.")
    if more:
        who = other if found.verdict != "even" else "X or Y"
        where = "another part" if len(more) == 1 else f"{len(more)} other parts"
        sentences.append(
            f"{who} is also better in {where} of this map, nearest: {_turn(found, more[0])}."
        )
    return sentences


def _turn(found: StabilityMap, turn: Turn) -> str:
    """Where a turn is, what it turns to, and how far away."""
    said = settings_text(found, turn.at)
    if turn.winner != "even":
        ahead = (
            f"{turn.winner.upper()} ahead by {difference_text(found.criterion, turn.difference)}"
        )
        said += f" ({ahead})" if turn.difference else f", where it turns to {turn.winner.upper()}"
    side = "inside" if turn.is_plausible else "outside"
    away = f"{turn.distance:.2g} times its width away"
    if not turn.distance:
        away = "among the recordings' own values"
    return f"{said}, {side} the plausible range and {away}"
