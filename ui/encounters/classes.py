"""Encounters page: who detects the encounters of each class."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.codes import NO_CODE
from nvcore.comparison import Result
from nvcore.evidence.measures import Evidence
from nvcore.evidence.subgroup_table import judge_groups
from nvcore.evidence.subgroups import class_groups
from nvcore.measures.table import evidence_form
from nvcore.metrics.encounter_classes import (
    CHILD,
    CROSSING,
    GROUP,
    IN_ROAD,
    EncounterClasses,
    classes_of,
    shown_class,
)
from nvcore.report.words import interval_cell
from nvcore.tables.encounters.miss_classes import class_counts
from nvcore.wording import UNDEFINED, Footnotes, capitalised, difference, minus, number
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import docs_link, plain

HEAD: Final = (
    *("Both", "Only X", "Only Y", "Neither", "Distant", "Detected X − Y", "95 % interval"),
    *("Severity X (s)", "Severity Y (s)", "Shared misses", "phi"),
)
SHARE: Final = "encounters_detected_by_unit"
NO_INTERVAL: Final = (UNDEFINED, "")
MEANINGS: Final = {
    CROSSING: "Was on both sides of the picture's middle.",
    IN_ROAD: "At most 3.5 m beside the camera's axis in half of the frames, by height.",
    GROUP: "Another {one} alongside in half of the frames.",
    CHILD: "Small for {a_one} at that distance, which is known or follows from the horizon.",
    NO_CODE: "Overlaps no stretch with a code.",
}


def draw(result: Result) -> None:
    """Draw a row for each class."""
    table = class_counts(result)
    if table.empty:
        st.caption("No encounter has a class.")
        return
    classes = classes_of(result.dataset)
    evidence = state.cached("by_class", comparison_key(result), lambda: _judge(result), most=8)
    notes = Footnotes()
    intervals = {name: interval_cell(row, notes) for name, row in evidence.items()}
    rows = [
        MeasureRow(
            label=shown_class(str(name)),
            cells=(
                *(
                    f"{row[kind]:,.0f}"
                    for kind in ("both", "x_only", "y_only", "neither", "distant")
                ),
                _apart(evidence.get(str(name))),
                intervals.get(str(name), NO_INTERVAL)[0],
                *(number(row[f"severity_s_{letter}"], ".2f") for letter in "xy"),
                number(row["jaccard"], ".2f"),
                minus(number(row["phi"], ".2f")),
            ),
            marks=intervals.get(str(name), NO_INTERVAL)[1],
            hint=_hint(classes, str(name)),
        )
        for name, row in table.iterrows()
    ]
    from_boxes = ""
    if result.dataset.objects.are_pedestrians:
        from_boxes = (
            "; crossing, in road, group and child also from the boxes alone, by rules of ours "
            f"({docs_link('Metrics', 'classes-of-encounters')})"
        )
    st.html(measures_html(rows, key="by-class", head=HEAD, first="Class"))
    lines = [f"{mark}: {plain(capitalised(note))}." for note, mark in notes.marks.items()]
    lines.append(state.say("{A_one} may have several classes."))
    st.caption(
        "  \n".join(lines),
        help="Classes come from the truth's column *attributes*, from stretches with a code"
        f"{from_boxes}. Detected: as a share of those not distant. Shared misses: Jaccard index.",
    )


def _hint(classes: EncounterClasses, name: str) -> str:
    """Where a class comes from."""
    ways = ["Named by the truth."] if name in classes.named else []
    if name in classes.coded and name != NO_CODE:
        ways.append("Overlaps a stretch with this code.")
    return " ".join(ways) or state.say(MEANINGS.get(name, ""))


def _judge(result: Result) -> dict[str, Evidence]:
    """Evidence of the share detected, by class."""
    judged = judge_groups(result, class_groups(result, result.is_near), (SHARE,))
    return {name: of[SHARE] for name, of in judged.items()}


def _apart(of: Evidence | None) -> str:
    return UNDEFINED if of is None else minus(difference(of.x, of.y, evidence_form(of.figure)))
