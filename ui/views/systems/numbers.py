"""Systems page: results of each system, and both measures for every pair."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.palette import Shade, SystemStyle, scheme_for
from nvcore.common.wording import capitalised, minus
from nvcore.evidence.pairwise import systems_of
from nvcore.report.matrix import (
    PAIR_MEASURES,
    SYSTEM_HEAD,
    PairMeasure,
    pair_cells,
    pair_name,
    pair_notes,
    system_cells,
    winner_of,
)
from ui.views.systems.pairs import BETWEEN
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import plain

HEAD: Final = ("First", "Second", "First − second", "95 % interval", "p", "p (Holm)")
SETTING: Final = "thresholds"
"""Heading of the mark for pairs at unequal operating points."""
AS_SET_TEXT: Final = (
    " *as set*: at unequal operating points. Nothing is claimed from these values; p, and the "
    "sentence above, are about the pair at equal false alarms, as the Overview shows it."
)


def draw(table: pd.DataFrame, systems: Sequence[str], shade: Shade) -> None:
    """Draw the table of systems, then each measure of the pairs, and the download."""
    st.header("The numbers")
    head = [capitalised(title) for title in SYSTEM_HEAD]
    st.html(
        measures_html(_systems(table, systems, shade), key="systems", head=head, first="System")
    )
    has_unequal = bool(table["is_unequal"].any())
    pairs_head = (*HEAD, SETTING) if has_unequal else HEAD
    for measure in PAIR_MEASURES:
        rows, notes = _pairs(table, measure, systems, shade)
        st.html(
            measures_html(
                rows,
                key=f"pairs-{measure.value}",
                head=pairs_head,
                first=capitalised(measure.title),
            )
        )
        if notes:
            lines = (f"{mark}: {plain(capitalised(note))}." for note, mark in notes.items())
            st.caption("  \n".join(lines))
    st.caption(
        "A dot marks the better system of a pair where the difference is claimed from the values "
        "in its row. The intervals, and p, are of the differences between recordings (between "
        "stretches of time, where these are too few)." + (AS_SET_TEXT if has_unequal else "")
    )
    st.download_button(
        "matrix.csv",
        to_csv_bytes(table.replace([float("inf"), -float("inf")], float("nan"))),
        "matrix.csv",
        "text/csv",
        on_click="ignore",
        icon=":material/download:",
        key="matrix_download",
    )


def _systems(table: pd.DataFrame, systems: Sequence[str], shade: Shade) -> list[MeasureRow]:
    rows = []
    for system in systems_of(table).to_dict("records"):
        style = scheme_for(shade, systems, system["system"], None).style("x")
        lines = (_line(style, shade),)
        rows.append(MeasureRow(system["system"], system_cells(system), lines=lines))
    return rows


def _pairs(
    table: pd.DataFrame, measure: PairMeasure, systems: Sequence[str], shade: Shade
) -> tuple[list[MeasureRow], dict[str, str]]:
    marks, notes = pair_notes(table, measure)
    rows = []
    for pair, mark in zip(table.to_dict("records"), marks, strict=True):
        scheme = scheme_for(shade, systems, pair["x"], pair["y"])
        cells = [minus(cell) for cell in pair_cells(pair, measure)]
        if table["is_unequal"].any():
            cells.append("as set" if pair["is_unequal"] else "alike")
        styles = {letter: scheme.style(letter) for letter in "xy"}
        rows.append(
            MeasureRow(
                label=pair_name(pair, between=BETWEEN),
                cells=tuple(cells),
                better="" if pair["is_unequal"] else winner_of(pair, measure),
                marks=mark,
                lines=tuple(_line(style, shade) for style in styles.values()),
                colours=tuple(style.colour(shade) for style in styles.values()),
            )
        )
    return rows, notes


def _line(style: SystemStyle, shade: Shade) -> str:
    return f"3px {style.css} {style.colour(shade)}"
