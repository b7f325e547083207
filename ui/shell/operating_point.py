"""Sidebar: give X and Y equal false alarms by moving thresholds, with a way to undo it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import streamlit as st

from nvcore.common.wording import number
from nvcore.comparison.compare import Result
from nvcore.metrics.detection.operating_point import (
    OperatingPoint,
    alarms_at_rate,
    point_of_matches,
    threshold_with_alarms,
)
from nvcore.settings.params import Params
from nvcore.settings.stages import MATCH, THRESHOLD
from ui.session import state, store
from ui.widgets.text import plain

RATE: Final = "point_rate"


@dataclass(frozen=True)
class Move:
    """Thresholds moved to equal false alarms, with the operating points before and after.

    Attributes
    ----------
    systems, matching
        X and Y, and the settings for matching detections.
    letters
        Letters of the systems whose threshold was moved.
    before, after
        Operating points of X and Y. `after` is None until they are in use.
    """

    systems: tuple[str, str | None]
    matching: Params
    letters: str
    before: tuple[OperatingPoint, OperatingPoint]
    after: tuple[OperatingPoint, OperatingPoint] | None = None


def points(result: Result) -> tuple[OperatingPoint, OperatingPoint]:
    """Return the operating points of X and Y at the thresholds in use."""

    def make() -> tuple[OperatingPoint, OperatingPoint]:
        x, y = (
            point_of_matches(result.dataset, system.matches, system.threshold)
            for _, system in result.sides
        )
        return x, y

    key = (result.params.only_for(MATCH, THRESHOLD), result.x.name, result.y.name)
    return state.cached("operating_points", key, make)


def why_fixed(letter: str) -> str:
    """Return why the threshold of X or Y cannot be moved, or "" if it can."""
    if state.systems()["xy".index(letter)] is None:
        return "There is no second system."
    if state.span_of(letter) is None:
        return f"{letter.upper()} has no scores that differ: there is no threshold to move."
    return ""


def move(letter: str) -> None:
    """Move the threshold of X or Y to as many false alarms as the other has. For callbacks."""
    result = state.result_as_set()
    if result is not None and not why_fixed(letter):
        target = points(result)["yx".index(letter)].n_false_alarms
        _move_to(result, letter, target)


def move_both(field: str) -> None:
    """Move both thresholds to the false alarm rate entered in a field. For callbacks."""
    result = state.result_as_set()
    rate: float | None = store.widget(field).get()
    if result is not None and rate is not None and not (why_fixed("x") or why_fixed("y")):
        _move_to(result, "xy", alarms_at_rate(result.dataset, rate))


def _move_to(result: Result, letters: str, n_alarms: int) -> None:
    before, params = points(result), state.params()
    for letter in letters:
        name = result.system(letter).name
        threshold = threshold_with_alarms(result.dataset, name, params, n_alarms)
        state.set_threshold(letter, threshold)
    store.THRESHOLD_MOVE.set(Move(state.systems(), params.only_for(MATCH), letters, before))


def undo() -> None:
    """Undo the last move. For callbacks."""
    moved = store.THRESHOLD_MOVE.pop()
    if moved is not None and moved.systems == state.systems():
        for letter in moved.letters:
            state.set_threshold(letter, moved.before["xy".index(letter)].threshold)


def draw() -> None:
    """Draw false alarms of X and Y, buttons that make them equal, and the last change."""
    result = state.result_as_set()
    if result is None:
        return
    now = points(result)
    x, y = (_rate(point) for point in now)
    as_set = "" if state.result() is result else ", as set"
    st.caption(
        f"False boxes per frame{as_set}: X\N{NO-BREAK SPACE}**{x}**, "
        f"Y\N{NO-BREAK SPACE}**{y}**. Make them equal:",
        help=state.say(
            "False alarms: detections that match {nobody}, counted in every frame. False-alert "
            "episodes are fewer: there a run of them counts once. A system that reports more of "
            "everything looks better unless both have equally many."
        ),
    )
    with st.container(horizontal=True, gap="xsmall", key="same_points"):
        for letter, other in (("x", "y"), ("y", "x")):
            why = why_fixed(letter)
            st.button(
                f"{letter.upper()} to {other.upper()}",
                key=f"point_{letter}",
                disabled=bool(why),
                help=why
                or f"Moves the threshold of {letter.upper()} so that it has as many false alarms "
                f"as {other.upper()} has now.",
                on_click=move,
                args=(letter,),
            )
        _draw_both(min(point.false_alarms_per_frame for point in now))
    _draw_change()


def _draw_both(lower: float) -> None:
    """Draw the field for a common rate of false alarms, initially the lower one of X and Y."""
    why = why_fixed("x") or why_fixed("y")
    if not why and math.isnan(lower):
        why = "There are no frames."
    with st.popover("Both to", disabled=bool(why), help=why or None, key="point_both"):
        if not why:
            start = round(lower, 3)
            key = f"{RATE}_{start}"  # another comparison resets the field
            st.number_input(
                "False boxes per frame, of X and of Y",
                min_value=0.0,
                value=start,
                step=0.01,
                format="%.3f",
                key=key,
            )
            st.button(
                "Set both thresholds",
                key="point_set",
                type="primary",
                on_click=move_both,
                args=(key,),
            )


def _draw_change() -> None:
    """Draw what the last move changed and an undo button, while its thresholds are in use."""
    result = state.result_as_set()
    moved = store.THRESHOLD_MOVE.get()
    if moved is None or result is None:
        return
    now = points(result)
    if moved.after is None:
        moved = replace(moved, after=now)
        store.THRESHOLD_MOVE.set(moved)
    if (moved.systems, moved.matching, moved.after) != (
        state.systems(),
        state.params().only_for(MATCH),
        now,
    ):
        store.THRESHOLD_MOVE.pop()
        return
    st.caption(plain(change_text(moved)))
    st.button(
        "Undo", key="point_undo_sidebar", type="tertiary", icon=":material/undo:", on_click=undo
    )


def change_text(moved: Move) -> str:
    """Describe threshold and false alarms of the moved systems, before and after."""
    assert moved.after is not None
    parts = []
    for letter in moved.letters:
        at = "xy".index(letter)
        old, new = moved.before[at], moved.after[at]
        if old == new:
            parts.append(
                f"{letter.upper()} stays at the threshold {_threshold(old)}, {_rate(old)} false "
                "boxes per frame: no other comes nearer"
            )
            continue
        parts.append(
            f"{letter.upper()}: threshold {_threshold(old)} → {_threshold(new)}, "
            f"{_rate(old)} → {_rate(new)} false boxes per frame"
        )
    if len(moved.letters) == 1:
        at = "yx".index(moved.letters)
        parts.append(f"{'XY'[at]} has {_rate(moved.after[at])}")
    return "; ".join(parts) + "."


def _threshold(point: OperatingPoint) -> str:
    return "none" if point.threshold is None else f"{point.threshold:.4g}"


def _rate(point: OperatingPoint) -> str:
    return number(point.false_alarms_per_frame, ".3g")
