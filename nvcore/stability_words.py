"""What a stability map shows, in sentences that say no more than its cells.

The systems are called X and Y; no name from a file stands in these sentences.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.stability import StabilityMap, Stretch, Turn, Winner, winners
from nvcore.stability_axes import Axis
from nvcore.stability_scores import Criterion

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
    "similarity": "mean similarity, X less Y",
    "encounters": "encounters, X alone less Y alone",
    "saliency": "saliency, Y less X (s)",
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


def difference_text(criterion: Criterion, difference: float) -> str:
    """The size of a difference with its unit: "0.0123", "3 encounters", "0.50 s"."""
    size = abs(difference)
    if criterion == "encounters":
        return f"{size:.0f} encounter{'' if size == 1 else 's'}"
    figure = np.format_float_positional(size, precision=2, fractional=False, trim="-")
    return f"{figure} s" if criterion == "saliency" else figure


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

    What holds as analysed; in which share of the plausible range; how far each setting can be
    moved alone; and the nearest setting that overturns it. All of this is about these settings
    and these data: whether a difference is more than chance is another question.
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
    sentences += [
        f"The {axis.title} is each recording's own, {_range(axis, *axis.present)}: no one point of "
        "this map."
        for axis in found.axes
        if axis.present_index is None
    ]
    sentences += [_stretch(found, one) for one in found.stretches]
    sentences += _choices(found)
    sentences.append(_nearest(found))
    return tuple(sentences)


def _and(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _share(found: StabilityMap) -> str:
    ranges = _and([
        f"{axis.title} {_range(axis, *axis.plausible)}"
        for axis, moves in zip(found.axes, found.is_moved_by, strict=True) if moves
    ])  # fmt: skip
    share = found.share_held
    if np.isnan(share):
        return f"In the plausible range ({ranges}) it is undefined."
    how_much = "all" if share > 1 - 1e-9 else "none" if not share else _percent(share)
    partly = "" if found.share_defined > 1 - 1e-9 else ", where that is defined"
    return f"This holds in {how_much} of the plausible range ({ranges}){partly}."


def _percent(share: float) -> str:
    """In whole per cent; neither 0 nor 100 where there is something on either side."""
    return f"{min(max(round(100 * share), 1), 99)} %"


def _range(axis: Axis, low: float, high: float) -> str:
    if axis.labels:
        return " or ".join(axis.labels)
    return f"{low:.4g} to {axis.number_text(high)}"


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
    where = f"every {axis.title} from {_range(axis, stretch.low, stretch.high)}"
    if stretch.low == stretch.high:
        where = f"{axis.title} {axis.number_text(stretch.low)} only"
    said = f"All else as it is, it holds for {where}"
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
            sentences.append(f"With {axis.text(label)}, all else as it is, {said}.")
    return sentences


def settings_text(found: StabilityMap, cell: int) -> str:
    """A cell's settings in words, those that matter: "alpha 0.3 and midpoint 48 px"."""
    at = np.unravel_index(cell, found.difference.shape)
    return _and([
        axis.text(int(i))
        for axis, i, moves in zip(found.axes, at, found.is_moved_by, strict=True) if moves
    ])  # fmt: skip


def _nearest(found: StabilityMap) -> str:
    overturn, end = found.overturn, found.end
    if overturn is not None:
        what = "overturns this" if found.verdict != "even" else "ends the tie"
        return f"The nearest setting on this map that {what} is {_turn(found, overturn)}."
    other = "Y" if found.verdict == "x" else "X"
    if end is not None:
        return f"Nowhere on this map is {other} better; the nearest tie is {_turn(found, end)}."
    if found.verdict == "even":
        return "It is a tie all over this map."
    return f"Nowhere on this map does {other} come level."


def _turn(found: StabilityMap, turn: Turn) -> str:
    settings = settings_text(found, turn.cell)
    away = f"{turn.distance:.2g} of a plausible range away"
    if not turn.is_plausible:
        away += ", outside the plausible range"
    if turn.winner == "even":
        return f"at {settings}, {away}"
    ahead = difference_text(found.criterion, turn.difference)
    return f"{settings} ({turn.winner.upper()} ahead by {ahead}), {away}"
