"""Overview page: significance of the differences, overall and by group of encounters."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import capitalised, difference, interval_text, minus, number
from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import EVIDENCE_KEYS, as_shown, evidence_form, inference_of
from nvcore.evidence.bootstrap import INTERVAL_RULE
from nvcore.evidence.operating_points import AS_SET, are_unequal, is_undecided
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.evidence.units import BLOCKS
from nvcore.figures.dots import forest_in_words, subgroup_forest
from nvcore.report.words import effect_text
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.charts import draw_chart, kept_figure
from ui.widgets.html import MeasureRow, measures_html, with_arrow
from ui.widgets.text import UNDEFINED, docs_link, plain

SETTING: Final = "thresholds"
HEAD: Final = ("X", "Y", "X − Y", "95 % interval", "p", "p (corrected)", "effect")


def draw(result: Result, evidence: pd.DataFrame) -> None:
    """Draw a table of the evidence for each measure."""
    evidence = as_shown(result, evidence)
    rows, notes = shown_evidence(result, evidence)
    head = (*HEAD, SETTING) if are_unequal(result) else HEAD
    st.html(measures_html(rows, key="evidence", head=head))
    has_blocks = (evidence["unit"] == BLOCKS).any()
    units = "stretches of these recordings" if has_blocks else "recordings"
    if notes:
        st.caption(
            "  \n".join(f"{mark}: {plain(capitalised(note))}." for note, mark in notes.items())
        )
    st.caption(
        state.say(
            "Both systems saw the same {many}, so differences are judged in pairs: how far "
            "they would vary with other {units} (interval), and how often they would be as large "
            "if X and Y could be exchanged (p, from six recordings on). p (corrected): the primary "
            "measure is tested by itself, the others are corrected for one another and follow it. "
            "The verdict claims no difference with more than "
            "{significant}, nor one that does not hold at equal false alarms. Within these "
            "recordings: McNemar's test, which says nothing of others. effect: size of the "
            "difference, Cohen's d_z or the odds ratio (∞: in all encounters that only one "
            "system detects it is the same one) ({link}).",
            units=units,
            significant=SIGNIFICANT,
            link=docs_link("Significance", "significance", doc="significance"),
        )
    )
    with st.expander("How it was computed"):
        for label, method in zip(evidence["label"], evidence["method"], strict=True):
            if method:
                st.markdown(f"- {plain(label)}: {plain(method)}")
        if np.isfinite(evidence["low"]).any():
            st.caption(INTERVAL_RULE)


@st.fragment
def draw_subgroups(result: Result, evidence: pd.DataFrame) -> None:
    """Draw the choice of a measure, and its difference in each group of encounters."""
    evidence = as_shown(result, evidence)
    labels = dict(zip(evidence["figure"], evidence["label"], strict=True))
    keys = [key for key in EVIDENCE_KEYS if key in labels]
    # where encounters are single frames, a test of single encounters says nothing
    is_fit = [not result.is_short or inference_of(key).test != "encounters" for key in keys]
    measure = st.selectbox(
        "Measure by group",
        keys,
        index=is_fit.index(True),
        format_func=labels.__getitem__,
        key="subgroup_figure",
        width=420,
        persist_state="session",
    )
    protocol = state.protocol()

    def make() -> pd.DataFrame:
        with st.spinner("Comparing the groups"):
            return subgroup_table(result, [measure], protocol=protocol)

    key = (*comparison_key(result), measure)
    table = state.cached("subgroups", key, make, most=len(EVIDENCE_KEYS))
    if nothing := forest_in_words(table):
        st.markdown(plain(nothing))
    else:
        theme = state.theme()
        figure = kept_figure(
            "subgroups_figure", (*key, theme), lambda: subgroup_forest(table, theme=theme)
        )
        draw_chart(figure, "subgroups")
    if why := inference_of(measure).not_of_pedestrians:
        st.caption(
            f"{UNDEFINED} Near, far, centre, edge, occlusion, pose: {state.say(why)}. "
            "Only groups of recordings have this measure, by the tags that a session file gives."
        )
    st.caption(
        "Groups are made by the ground truth alone. Near: the largest box is at least twice as "
        "high as one that counts half. Centre: the middle half of the picture. Occluded: in half "
        "of the frames or more. Wide, narrow: height by width is a standard deviation or more "
        "from the mean. Distant encounters, which do not count, are in none. Many groups give "
        "some large differences by chance: p is corrected for all groups of this measure "
        f"({docs_link('Groups', 'groups', doc='significance')})."
    )


def shown_evidence(
    result: Result, evidence: pd.DataFrame
) -> tuple[list[MeasureRow], dict[str, str]]:
    """Return the rows of the evidence table, and the mark of each footnote.

    Missing values are dashes.
    """
    rows: list[MeasureRow] = []
    footnotes = Footnotes()
    for row in evidence.to_dict("records"):
        form = evidence_form(row["figure"])
        notes = [note for note in row["note"].split("; ") if note and note != AS_SET]
        cells: tuple[str, ...] = (
            number(row["x"], form),
            number(row["y"], form),
            difference(row["x"], row["y"], form),
            interval_text(row["low"], row["high"], form),
            number(row["p"], ".2g"),
            number(row["p_corrected"], ".2g"),
            effect_text(row),
        )
        if are_unequal(result):
            cells = (*cells, "as set" if is_undecided(result, row["figure"]) else "all")
        rows.append(
            MeasureRow(
                label=with_arrow(row["label"], row["better"]),
                cells=tuple(minus(cell) for cell in cells),
                marks=footnotes.of_row(notes),
            )
        )
    return rows, footnotes.marks
