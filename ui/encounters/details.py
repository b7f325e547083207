"""Encounters page: one encounter, beside the list: picture, who missed it how long, and why."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.metrics.encounter_classes import shown_class
from nvcore.pictures import jpeg, picture_address
from nvcore.schema import CATEGORY_TEXT, CLASS_SEPARATOR, Category
from nvcore.tables.moments import NEVER, encounter_box, encounter_time
from nvcore.wording import listed as listed_words
from nvcore.wording import minus, percent
from ui.encounters import selection, weightings
from ui.session import state, store
from ui.shell.navigate import open_row
from ui.subjects import contributed
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.drawing import keep_look, look
from ui.widgets.table_columns import class_words
from ui.widgets.text import UNDEFINED, docs_link, number, plain

MEANINGS: Final = (
    "Peak cost: what the worst of its frames costs, 0 to 1. Lag: how long after coming near enough "
    "to count it was first matched. Longest gap: between two matches. Tail: after the last match, "
    "until it no longer counts."
)
OF_VISIBLE: Final = ("visible", "blended")
"""Ways to see the pictures in which the cut-out is of visible light."""


def draw(result: Result, listed: pd.DataFrame, encounter: int) -> None:
    """The encounter, with the way to the one before and the next."""
    selection.draw_steps(listed, encounter)
    row = listed.iloc[selection.place_of(listed, encounter)]
    st.header(f"{state.say('{One}')} {row['track']} in {plain(row['recording'])}")
    category = state.say(CATEGORY_TEXT[Category(row["category"])])
    st.markdown(f"{category}  \n{_who_missed(result, row)}")
    for draw_head in contributed("ENCOUNTER_HEAD"):
        draw_head(result, encounter)
    moments = selection.moments_of(result).iloc[encounter]
    if names := [shown_class(name) for name in str(row["classes"]).split(CLASS_SEPARATOR) if name]:
        classes = plain(listed_words(names))
        st.caption(f"{docs_link('Classes', 'classes-of-encounters')}: {classes}.")
    _draw_picture(result, encounter, int(moments["shown_row"]))
    _draw_ways(result, row, moments)
    for draw_text in contributed("ENCOUNTER_TEXT"):
        draw_text(result, encounter)
    st.table(_both(row))
    st.caption(MEANINGS)
    pose = number(row["aspect_z"], "+.1f")
    text = (
        f"Up to {row['peak_height']:.0f} px tall, where the weight for how near it is (k, 0 to 1) "
        f"is {row['peak_k']:.2f}; mean position {row['lateral_position']:+.2f} (-1 left edge, 1 "
        f"right edge); height by width {pose} standard deviations from the mean of all "
        f"encounters; frames {row['first_frame']} to {row['last_frame']}."
    )
    st.caption(plain(minus(text)))
    weightings.draw(result, encounter)


def _who_missed(result: Result, row: pd.Series[Any]) -> str:
    """How long each system misses the pedestrian while it counts, and what that weighs."""
    times = encounter_time(result, int(str(row.name)))
    if not times.relevant_s:
        return ""
    lines = []
    for letter, missed_s in (("x", times.missed_s_x), ("y", times.missed_s_y)):
        if missed_s:
            does = f"misses it for {missed_s:.2f} of {times.relevant_s:.2f} s"
            weighs = f"severity **{row[f'severity_s_{letter}']:.2f} s**"
            lines.append(f"**{letter.upper()}** {does}: {weighs}")
        else:
            lines.append(f"**{letter.upper()}** never misses it in {times.relevant_s:.2f} s")
    return "  \n".join(lines)


def _both(row: pd.Series[Any]) -> pd.DataFrame:
    """How X and Y did with one encounter, side by side, as text."""
    columns = {}
    for letter in "xy":
        matched, coverage = row[f"matched_{letter}"], row[f"coverage_{letter}"]
        share = f"{matched} of {row['n_relevant']} frames"
        columns[letter.upper()] = {
            "Severity": _seconds(row[f"severity_s_{letter}"]),
            "Peak cost": number(row[f"peak_cost_{letter}"], ".2f"),
            "Miss class": class_words(row[f"miss_class_{letter}"]) or UNDEFINED,
            "Matched": f"{share} ({percent(coverage)})" if row["n_relevant"] else UNDEFINED,
            "Lag": _seconds(row[f"lag_s_{letter}"]),
            "Longest gap": _seconds(row[f"gap_s_{letter}"]),
            "Tail": _seconds(row[f"tail_s_{letter}"]),
        }
    return pd.DataFrame(columns).rename_axis("Measure")


def _seconds(value: float) -> str:
    text = number(value, ".2f")
    return text if text == UNDEFINED else f"{text} s"


def _draw_ways(result: Result, row: pd.Series[Any], moments: pd.Series[Any]) -> None:
    """Buttons to the frames that are worth seeing."""
    frames = result.dataset.frames
    shown_row = int(moments["shown_row"])
    missed = {letter: int(moments[f"missed_row_{letter}"]) for letter in "xy"}
    if button(
        "Show in timeline",
        key="encounters_show",
        type="primary",
        icon=":material/movie:",
        width="stretch",
    ):
        open_row(shown_row)
    st.caption(
        f"Frame {frames['frame'].iloc[shown_row]} at {frames['time_s'].iloc[shown_row]:.2f} s, "
        f"{_why(result, row, shown_row, any(place >= 0 for place in missed.values()))}."
    )
    for letter, place in missed.items():
        if place not in (shown_row, NEVER) and button(
            f"Show where {letter.upper()} first misses (frame {frames['frame'].iloc[place]})",
            key=f"encounters_show_{letter}",
            width="stretch",
        ):
            open_row(place)
    for draw_ways in contributed("ENCOUNTER_WAYS"):
        draw_ways(result, int(str(row.name)))


def _why(result: Result, row: pd.Series[Any], shown_row: int, is_missed: bool) -> str:
    """Why that frame is shown."""
    if not is_missed:
        return "where the encounter begins to count"
    x, y = row["severity_s_x"], row["severity_s_y"]
    heavier, other = ("y", "x") if y > x else ("x", "y")
    what = (
        state.say("missing the {one}") if x == y else f"{heavier.upper()}'s failure, the heavier,"
    )
    is_peak = shown_row == result.system(heavier).failures["peak_row"].iloc[int(str(row.name))]
    noun = result.objects.singular
    while_seen = "" if is_peak else f" while {other.upper()} detects the {noun}"
    return f"where {what} costs most{while_seen}"


def _draw_picture(result: Result, encounter: int, row: int) -> None:
    """The part of a frame around the pedestrian; without pictures, the boxes on a blank.

    Of the recording's own pictures or those of visible light, as chosen here or in a viewer.
    """
    has_visible = drawing.has_visible(row)
    is_visible = has_visible and look().picture in OF_VISIBLE
    key = (state.workspace().version, drawing.stretch(), row, encounter, is_visible)
    content = state.cached(
        "encounter_picture",
        key,
        lambda: _picture(result, encounter, row, is_visible=is_visible),
        most=drawing.MOST_THUMBNAILS,
    )
    st.image(
        picture_address(content),
        width="stretch",
        alt=state.say("The {one} with the boxes of truth, X and Y"),
    )
    if has_visible:
        store.ENCOUNTER_IS_VISIBLE.set(is_visible)
        st.toggle("Visible light", key=store.ENCOUNTER_IS_VISIBLE.key, on_change=_choose)


def _choose() -> None:
    is_visible = store.ENCOUNTER_IS_VISIBLE.get()
    keep_look(look()._replace(picture="visible" if is_visible else "own"))


def _picture(result: Result, encounter: int, row: int, *, is_visible: bool) -> bytes:
    xywh = encounter_box(result, encounter, row)
    return jpeg(drawing.part_of_frame(result, row, xywh, labels=True, is_visible=is_visible))
