"""Encounters page: details of one encounter beside the list, with picture and explanations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import pandas as pd
import streamlit as st

from nvcore.common.wording import capitalised, minus, percent
from nvcore.common.wording import listed as listed_words
from nvcore.comparison.compare import Result
from nvcore.dataset.schema import CATEGORY_TEXT, CLASS_SEPARATOR, Category
from nvcore.metrics.encounter_classes import shown_class
from nvcore.pictures import jpeg, picture_address
from nvcore.tables.moments import NEVER, encounter_box, encounter_time
from ui.session import state, store
from ui.shell.navigate import open_row
from ui.subject import subject_pages
from ui.views.encounters import selection, weightings
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.drawing import keep_look, look
from ui.widgets.table_columns import class_words
from ui.widgets.text import UNDEFINED, docs_link, number, plain, short_names

MEANINGS: Final = (
    "Peak cost: what the worst of its frames costs, 0 to 1. Lag: how long after coming near enough "
    "to count it was first matched. Longest gap: between two matches. Tail: after the last match, "
    "until it no longer counts. k: weight for how near it is, 0 to 1, at the tallest box. "
    "Position: mean, −1 left edge, 1 right edge. Pose: height by width, in standard deviations "
    "from the mean of all encounters."
)
OF_VISIBLE: Final = ("visible", "blended")
"""Picture modes in which the cut-out shows visible light."""


def draw(result: Result, listed: pd.DataFrame, encounter: int) -> None:
    """Draw one encounter, with buttons to the previous and next ones."""
    selection.draw_steps(listed, encounter)
    row = listed.iloc[selection.place_of(listed, encounter)]
    st.header(f"{state.say('{One}')} {row['track']} in {plain(row['recording'])}")
    names = {letter: plain(name) for letter, name in short_names(result).items()}
    kind = Category(row["category"])
    finder = {Category.X_ONLY: names["x"], Category.Y_ONLY: names["y"]}.get(kind, "")
    text = "Only {finder} detected the {one}." if finder else CATEGORY_TEXT[kind]
    st.markdown(f"{state.say(text, finder=finder)}  \n{_who_missed(result, row, names)}")
    for subject in subject_pages():
        subject.encounters().draw_head(result, encounter)
    moments = selection.moments_of(result).iloc[encounter]
    if classes := [
        shown_class(name) for name in str(row["classes"]).split(CLASS_SEPARATOR) if name
    ]:
        words = plain(listed_words(classes))
        st.caption(f"{docs_link('Classes', 'classes-of-encounters')}: {words}.")
    _draw_picture(result, encounter, row, moments)
    _draw_ways(result, row, moments, names)
    for subject in subject_pages():
        subject.encounters().draw_text(result, encounter)
    st.table(_both(row, names))
    text = (
        f"Up to {row['peak_height']:.0f} px tall, k {row['peak_k']:.2f}; position "
        f"{row['lateral_position']:+.2f}; pose {number(row['aspect_z'], '+.1f')}; frames "
        f"{row['first_frame']} to {row['last_frame']}."
    )
    st.caption(plain(minus(text)), help=MEANINGS)
    weightings.draw(result, encounter)


def _who_missed(result: Result, row: pd.Series[Any], names: Mapping[str, str]) -> str:
    """Return how long each system misses the relevant pedestrian, and the severity, as Markdown."""
    times = encounter_time(result, int(str(row.name)))
    if not times.relevant_s:
        return ""
    lines = []
    for letter, missed_s in (("x", times.missed_s_x), ("y", times.missed_s_y)):
        if missed_s:
            share = f"missed for {missed_s:.2f} of {times.relevant_s:.2f} s"
            weighs = f"severity **{row[f'severity_s_{letter}']:.2f} s**"
            lines.append(f"**{names[letter]}**: {share}, {weighs}")
        else:
            lines.append(f"**{names[letter]}**: never missed in {times.relevant_s:.2f} s")
    return "  \n".join(lines)


def _both(row: pd.Series[Any], names: Mapping[str, str]) -> pd.DataFrame:
    """Return a table of both systems' results for one encounter, as text."""
    columns = {}
    for letter in "xy":
        matched, coverage = row[f"matched_{letter}"], row[f"coverage_{letter}"]
        share = f"{matched} of {row['n_relevant']} frames"
        columns[names[letter]] = {
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


def _draw_ways(
    result: Result, row: pd.Series[Any], moments: pd.Series[Any], names: Mapping[str, str]
) -> None:
    """Draw buttons that open the most informative frames of the encounter."""
    frames = result.dataset.frames
    shown_row = int(moments["shown_row"])
    if button(
        "Show in timeline",
        key="encounters_show",
        type="primary",
        icon=":material/movie:",
        width="stretch",
    ):
        open_row(shown_row)
    with st.container(horizontal=True):
        for letter in "xy":
            place = int(moments[f"missed_row_{letter}"])
            if place not in (shown_row, NEVER) and button(
                f"First miss of {names[letter]}",
                key=f"encounters_show_{letter}",
                help=f"Frame {frames['frame'].iloc[place]}",
                width="stretch",
            ):
                open_row(place)
        for subject in subject_pages():
            subject.encounters().draw_ways(result, int(str(row.name)))


def _why(result: Result, row: pd.Series[Any], shown_row: int, is_missed: bool) -> str:
    """Return why the picture shows this frame of the encounter."""
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


def _draw_picture(
    result: Result, encounter: int, described: pd.Series[Any], moments: pd.Series[Any]
) -> None:
    """Draw the part of a frame around the pedestrian. Without pictures, draw boxes on a blank area.

    The picture is the recording's own or of visible light, as chosen here or in a viewer.
    """
    row = int(moments["shown_row"])
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
    frames = result.dataset.frames
    is_missed = any(int(moments[f"missed_row_{letter}"]) >= 0 for letter in "xy")
    with st.container(horizontal=True, horizontal_alignment="distribute"):
        st.caption(
            f"Frame {frames['frame'].iloc[row]} at {frames['time_s'].iloc[row]:.2f} s",
            width="content",
            help=f"{capitalised(_why(result, described, row, is_missed))}.",
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
