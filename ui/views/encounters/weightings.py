"""Encounters page: the selected one under height, horizon and distance weighting, side by side."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text
from nvcore.comparison.compare import Result
from nvcore.dataset.schema import MissClass
from nvcore.figures.encounters import weightings_plot
from nvcore.tables.encounters.weightings import KINDS, Weightings, compare_weightings
from ui.session import state
from ui.widgets.charts import draw_chart
from ui.widgets.table_columns import class_words
from ui.widgets.text import UNDEFINED, docs_link, number

HEADINGS: Final = {"height": "Height", "horizon": "Horizon", "distance": "Distance"}

WHERE_FROM: Final = {
    "horizon": "The row of the horizon is not known: the page Data estimates it from the boxes, or "
    "takes it typed, under \u201cRecordings\u201d.",
    "distance": "No distance of this {one} is known: give the truth's or the systems' "
    "distances as distance_m; by distance, the truth can borrow those of its matches.",
}
"""Suggested fix for a weighting that cannot be drawn."""


def draw(result: Result, encounter: int) -> None:
    """Draw the weight by each weighting, and its effect. Folded, nothing is computed."""
    place = st.expander(
        "Weighted by height, horizon and distance", key="encounters_weightings", on_change="rerun"
    )
    if not place.open:
        return
    weightings = compare_weightings(result, encounter)
    with place:
        draw_chart(
            weightings_plot(result, encounter, weightings, theme=state.theme()),
            "encounters_weights",
            help=_words(weightings),
        )
        st.table(_table(weightings))


def _table(weightings: Weightings) -> pd.DataFrame:
    """Return a table of the frames that count, what X and Y miss of them, and the severity."""
    columns = {}
    for kind, facts in _facts(weightings).items():
        heading = f"{HEADINGS[kind]} (in use)" if kind == weightings.in_use else HEADINGS[kind]
        columns[heading] = {
            "Frames that count": str(int(facts["n_relevant"])) if facts["is_known"] else UNDEFINED,
            "From – to": _span(facts),
            **{
                label: text
                for letter in "xy"
                for label, text in (
                    (f"{letter.upper()} misses", _missed(facts, letter)),
                    (f"Severity of {letter.upper()}", _severity(facts, letter)),
                )
            },
        }
    return pd.DataFrame(columns).rename_axis("Measure")


def _facts(weightings: Weightings) -> dict[str, dict[str, Any]]:
    """Return the row of each kind by its name."""
    rows = weightings.table.to_dict("index")
    return {kind: {str(name): value for name, value in rows[kind].items()} for kind in KINDS}


def _span(facts: dict[str, Any]) -> str:
    if not facts["is_known"] or not facts["n_relevant"]:
        return UNDEFINED
    return f"{int(facts['first_frame'])} – {int(facts['last_frame'])}"


def _missed(facts: dict[str, Any], letter: str) -> str:
    """Return the number of relevant frames that the system misses, and its miss class."""
    if not facts["is_known"] or not facts["n_relevant"]:
        return UNDEFINED
    kind = facts[f"miss_class_{letter}"]
    how = "" if kind == MissClass.NONE.value else f", {class_words(kind)}"
    return f"{int(facts[f'missed_{letter}'])}{how}"


def _severity(facts: dict[str, Any], letter: str) -> str:
    text = number(facts[f"severity_s_{letter}"], ".2f")
    return text if text == UNDEFINED else f"{text} s"


def _words(weightings: Weightings) -> str:
    facts = _facts(weightings)
    text = state.say(
        "What {link} {a_one} is decides which frames count: a child is small, and by height comes "
        "near late.",
        link=docs_link("tells how near", "proximity-weight-k"),
    )
    unknown = [kind for kind in KINDS if not facts[kind]["is_known"]]
    for kind in unknown:
        text += f" {state.say(WHERE_FROM[kind])}"
    n_by_height = 0 if "distance" in unknown else int(facts["distance"]["n_by_height"])
    if n_by_height:
        text += f" By distance, {count_text(n_by_height, 'box', 'boxes')} without one count by "
        text += "height."
    return text
