"""Driver page: list of encounters with what is known of the driver."""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np
import streamlit as st

from nvcore.common.wording import count_text
from nvcore.comparison.compare import Result
from nvcore.dataset.schema import Category
from nvcore.subjects.driver.comparison.encounters import REGION_NAMES, detectability_course
from nvcore.subjects.driver.comparison.judging import DriverRegion
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.tables.result import encounters_table
from ui.session import state
from ui.session.chosen import choose_encounter, chosen_encounter, name_of
from ui.subjects.driver.course import first_shown
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.table_columns import MOST_ROWS, as_shown, columns_of, rows_told
from ui.widgets.text import plain

COLUMNS: Final = (
    *("recording", "track", "driver_region", "detectability", "detectability_sd", "within_sd"),
    *("driver_seen_frames", "driver_in_time", "severity_s_x", "severity_s_y"),
)
DETECTED_BY: Final = {
    Category.BOTH: "X and Y detect",
    Category.X_ONLY: "X detects",
    Category.Y_ONLY: "Y detects",
    Category.NEITHER: "neither detects",
    Category.DISTANT: "distant",
}
"""Words for the encounters for which it is unknown whether the driver sees them."""


def draw(result: Result, region: DriverRegion | None) -> int | None:
    """Draw the list, least detectable first. Return the selected or first encounter, or None."""
    table = encounters_table(result)
    is_shown = table["driver_region"] != DriverRegion.DISTANT
    if region is not None:
        is_shown = table["driver_region"] == region
    listed = table[is_shown].sort_values("detectability", kind="stable", na_position="last")
    st.header("One by one")
    if listed.empty:
        st.info(state.say("No {one} is seen so."))
        return None
    shown = listed.head(MOST_ROWS)
    rows = shown.index.to_numpy(np.int64).tolist()
    chosen = chosen_encounter(result)
    who = shown["driver_region"].map(REGION_NAMES.__getitem__)
    is_unknown = shown["driver_region"] == DriverRegion.UNKNOWN
    who = who.mask(is_unknown, "unknown; " + shown["category"].map(DETECTED_BY))
    draw_table(
        as_shown(shown).assign(driver_region=who),
        columns_of("encounters.csv", *COLUMNS) | {"driver_region": TableColumn("Seen by")},
        key="driver_list",
        name="Encounters, the least detectable first",
        on_click=partial(_choose, result, rows),
        selected=None if chosen not in rows else rows.index(chosen),
    )
    n = count_text(len(listed), "encounter")
    told = rows_told(len(listed), "least detectable")
    st.caption(f"{n}. Click a row to see its course. {told}")
    if chosen is None or chosen in rows:
        return rows[0] if chosen is None else chosen
    st.caption(plain(_why_not_listed(result, chosen, region)))
    return rows[0]


def _why_not_listed(result: Result, encounter: int, region: DriverRegion | None) -> str:
    """Explain why the list lacks the selected encounter."""
    recording, _, track = name_of(result, encounter).rpartition(":")
    own = DriverRegion(driver_in(result).region[encounter])
    if own == DriverRegion.DISTANT:
        why = "the encounter stays distant"
    elif region is not None and own != region:
        why = f"the encounter is among those of {REGION_NAMES[own]}"
    else:
        why = "others are less detectable"
    return f"{state.say('{One}')} {track} of {recording} is chosen, but is not in this list: {why}."


def _choose(result: Result, rows: list[int], row: int, _column: str) -> None:
    choose_encounter(result, rows[row])
    shown = first_shown(detectability_course(result, rows[row]))
    state.go_to(*state.place_of(shown), writes=False)
