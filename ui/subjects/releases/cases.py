"""What changed page: number of cases of each kind, their list, and both versions' pictures."""

from __future__ import annotations

from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import capitalised
from nvcore.comparison.compare import Result
from nvcore.pictures import jpeg, picture_address
from nvcore.tables.encounters.changes import CHANGE_COLUMNS, Change, count_changes, located_changes
from nvcore.tables.moments import encounter_box
from ui.session import state, store
from ui.session.chosen import choose_encounter
from ui.shell.navigate import open_page, open_row
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.table import draw_table
from ui.widgets.table_columns import MOST_ROWS, as_shown, columns_of
from ui.widgets.text import plain

KINDS, CASE = store.widget("releases_kinds"), store.widget("releases_case", (None, 0))
ALL: Final = [kind.value for kind in Change]
COLUMNS: Final = (
    *("kind", "recording", "track", "severity_s_old", "severity_s_new"),
    *("duration_s", "first_frame"),
)
"""In a small window, the first five fit."""
UNITS: Final = ("encounters", "false alarms", "encounters", "false alarms", "of both")
"""Of the kinds, in their order."""


def draw_tiles(result: Result) -> None:
    """Draw the number of cases of each kind."""
    tiles = (
        f'<section class="nv-tile"><h2>{capitalised(kind)}</h2>'
        f'<div class="values"><span>{n:,}</span></div><p>{unit}</p></section>'
        for unit, (kind, n) in zip(UNITS, count_changes(result).items(), strict=True)
    )
    st.html(f'<div class="nv-tiles nv-counts">{"".join(tiles)}</div>')


@st.fragment
def draw(result: Result) -> None:
    """Draw the filter by kind, the list, and the selected case."""
    cases = located_changes(result)
    KINDS.setdefault(ALL[:-1])
    kinds = st.pills(
        "Kinds",
        ALL,
        selection_mode="multi",
        format_func=capitalised,
        key=KINDS.key,
        persist_state="session",
        label_visibility="collapsed",
    )
    listed = cases[cases["kind"].isin(kinds or ALL)]
    if listed.empty:
        st.info("There is no case of this kind.")
        return
    names, index = CASE.get()
    found = np.flatnonzero((listed.index == index) & (names == result.names))
    at = int(found[0]) if len(found) else 0
    left, right = st.columns([5, 4], gap="medium")
    with left:
        draw_table(
            as_shown(listed.head(MOST_ROWS)),
            columns_of(CHANGE_COLUMNS, *COLUMNS),
            key="releases_table",
            name="Cases",
            on_click=partial(_select, result.names, listed.index),
            selected=at if at < MOST_ROWS else None,
        )
        if len(listed) > MOST_ROWS:
            st.caption(f"The first {MOST_ROWS:,} of {len(listed):,}")
    with right:
        _draw_case(result, listed.iloc[at])


def _select(names: tuple[str, str], index: pd.Index, row: int, _column: str) -> None:
    CASE.set((names, int(index[row])))


def _draw_case(result: Result, case: pd.Series[Any]) -> None:
    encounter, row = int(case["encounter"]), int(case["row"])
    person = state.say("{one} {track}", track=str(case["track"]))
    who = person if encounter >= 0 else "false alarm"
    st.header(f"{capitalised(case['kind'])}: {who} in {plain(case['recording'])}", anchor=False)
    versions = zip(st.columns(2, gap="small"), ("Old", "New"), result.sides, strict=True)
    for place, version, (letter, system) in versions:
        place.markdown(f"**{version}**: {plain(system.name)}")
        picture = picture_address(_picture(result, case, letter))
        place.image(
            picture, width="stretch", alt=f"Boxes of truth and the {version.lower()} version"
        )
    st.caption(
        f"Frame {case['frame']}; frames {case['first_frame']} to {case['last_frame']}, "
        f"{case['duration_s']:.2f} s"
    )
    with st.container(horizontal=True):
        if button("Show in timeline", key="releases_show", type="primary", icon=":material/movie:"):
            choose_encounter(result, encounter)
            open_row(row)
        if encounter >= 0 and button("Show encounter", key="releases_encounter"):
            choose_encounter(result, encounter)
            open_page("encounters")


def _picture(result: Result, case: pd.Series[Any], letter: str) -> bytes:
    """Return the part of the case's frame with the boxes of truth and one version, as JPEG."""
    row, encounter, box = (int(case[name]) for name in ("row", "encounter", "box"))

    def draw() -> bytes:
        if encounter >= 0:
            xywh = encounter_box(result, encounter, row)
        else:
            system = result.x if case["kind"] == Change.GONE.value else result.y
            boxes = result.dataset.system(system.name)
            xywh = np.array([getattr(boxes, name)[box] for name in "xywh"])
        layers = ("truth", letter)
        return jpeg(
            drawing.part_of_frame(result, row, xywh, labels=True, layers=layers, aspect=1.0)
        )

    key = ("change", result.params, result.names, row, encounter, box, letter)
    return drawing.thumbnail(key, draw)
