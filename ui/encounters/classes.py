"""Encounters page: who detects the encounters of each class."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.metrics.encounter_classes import CHILD, CROSSING, GROUP, IN_ROAD, classes_of
from nvcore.tables.encounters.miss_classes import class_counts
from nvcore.wording import minus, number
from ui.encounters.filters import class_name
from ui.session import state
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import docs_link

HEAD: Final = (
    *("Both", "Only X", "Only Y", "Neither", "Distant"),
    *("Severity X (s)", "Severity Y (s)", "Shared misses", "phi"),
)
MEANINGS: Final = {
    CROSSING: "Was on both sides of the picture's middle.",
    IN_ROAD: "At most 3.5 m beside the camera's axis in half of the frames, by {his} own height.",
    GROUP: "Another {one} beside {him} in half of the frames.",
    CHILD: "Small for where {he} stands, by {his} distance or the horizon.",
}


def draw(result: Result) -> None:
    """A row for each class; nothing where no encounter has any."""
    table = class_counts(result)
    if table.empty:
        return
    st.subheader(state.say("By class of {one}"))
    named = classes_of(result.dataset).named
    rows = [
        MeasureRow(
            label=class_name(str(name)),
            cells=(
                *(
                    f"{row[kind]:,.0f}"
                    for kind in ("both", "x_only", "y_only", "neither", "distant")
                ),
                *(number(row[f"severity_s_{letter}"], ".2f") for letter in "xy"),
                number(row["jaccard"], ".2f"),
                minus(number(row["phi"], ".2f")),
            ),
            hint="Named by the truth." if name in named else MEANINGS.get(str(name), ""),
        )
        for name, row in table.iterrows()
    ]
    st.html(measures_html(rows, key="by-class", head=HEAD, first="Class"))
    from_boxes = ""
    if result.dataset.objects.are_pedestrians:
        from_boxes = (
            "; crossing, in road, group and child also from the boxes alone, by rules of ours "
            f"({docs_link('Metrics', 'classes-of-encounters')})"
        )
    st.caption(
        state.say("{A_one} may have several classes. They come from the truth's column ")
        + f"*attributes*{from_boxes}. Shared misses: Jaccard index."
    )
