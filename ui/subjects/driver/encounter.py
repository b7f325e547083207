"""Additions of the driver to the Encounters page: a line, a filter, columns."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.driver.comparison.encounters import SIGHT_WORDS, describe_sight, driver_sights
from nvcore.subjects.driver.comparison.steps import driver_in
from ui.subject import EncounterFilter
from ui.widgets.text import plain


def draw_head(result: Result, encounter: int) -> None:
    """Draw a line on whether the driver sees the pedestrian, if this is known."""
    if sight := describe_sight(result, encounter):
        st.markdown(f":material/visibility: {plain(sight)}")


CHOICES: Final = {
    "sees": "sees, clearly",
    "unseen": "does not see, clearly",
    "open": "open, seen or not",
    "unknown": SIGHT_WORDS["unknown"],
}
"""Choices of the filter. Open encounters are excluded from the first two."""
HELP: Final = (
    f"*{CHOICES['sees']}*: the driver sees the {{one}} unaided.",
    f"*{CHOICES['unseen']}*: the driver does not see the {{one}} unaided.",
    f"*{CHOICES['open']}*: the value that decides is within one SD of the threshold.",
    f"*{CHOICES['unknown']}*: detectability is known in no frame up to the first that counts.",
    "Open ones are listed apart; the page Driver and encounters.csv count them as seen or not "
    "seen, by the side of the threshold on which the value is.",
)
FILTER: Final = EncounterFilter(
    "driver",
    "By the driver",
    "  \n".join(HELP),
    CHOICES,
    driver_sights,
    lambda result: driver_in(result).has_any,
)
COLUMNS: Final = ("driver_sees", "within_sd")
"""Main columns."""
