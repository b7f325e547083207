"""Data page: the full list of a finding's cases, with a click from each entry to its frame."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.findings import Cases, Finding
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.dataset import Dataset
from nvcore.pictures.recordings import picture_names
from nvcore.tables.inputs import entries_as_cvat, entry_frames
from ui.session import state, store
from ui.session.workspace import Workspace
from ui.shell import review
from ui.shell.messages import path_remover
from ui.shell.navigate import ask_for_page
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.table_columns import MOST_ROWS, rows_told

NOUNS: Final = {
    "boxes": ("box", "boxes"),
    "frames": ("frame", "frames"),
    "recordings": ("recording", "recordings"),
    "left_out": ("row", "rows"),
}
"""Nouns for the cases of a finding, by table. Frames are recordings if each has only one."""
COLUMNS: Final = {
    "seen": TableColumn("Seen", "Looked at in this tab."),
    "recording": TableColumn("Recording", is_head=True),
    "frame": TableColumn("Frame"),
    "x": TableColumn("x (px)", form=".1f"),
    "y": TableColumn("y (px)", form=".1f"),
    "w": TableColumn("Width (px)", form=".1f"),
    "h": TableColumn("Height (px)", form=".1f"),
    "score": TableColumn("Score", form=".4g"),
    "track": TableColumn("Track id"),
    "line": TableColumn("Line of the file"),
}


def is_open(finding: Finding) -> bool:
    """Whether the list of this finding is shown."""
    return store.OPEN_ENTRIES.get() == review.finding_key(finding)


def draw(finding: Finding, number: int) -> None:
    """Draw the button that opens or closes the list, and the open list."""
    cases = finding.cases
    if cases is None or not len(cases):
        return
    shown = is_open(finding)
    n, nouns = len(cases), NOUNS[cases.table]
    if cases.table == "frames":
        recordings = state.opened().dataset.frame_columns.recording[cases.rows]
        nouns = NOUNS["recordings" if len(np.unique(recordings)) == n else "frames"]
    what = f"Show the {nouns[0]}" if n == 1 else f"Show all {n:,} {nouns[1]}"
    st.button(
        "Hide the list" if shown else what,
        key=f"entries_{number}",
        icon=":material/list:",
        on_click=_toggle,
        args=(review.finding_key(finding),),
    )
    if shown:
        _draw_list(finding, cases)


def _toggle(name: tuple[str, str, str]) -> None:
    store.OPEN_ENTRIES.set(None if store.OPEN_ENTRIES.get() == name else name)


def _draw_list(finding: Finding, cases: Cases) -> None:
    name = review.list_key(finding)
    table = review.entries_of(finding, name)
    seen = review.seen_of(name)
    shown = table.head(MOST_ROWS)
    shown = shown.assign(seen=["✓" if row in seen else "" for row in range(len(shown))])
    st.caption(
        "Click a row to see its frame on the Timeline, with the way to the next and the previous "
        "one; the browser's Back returns here."
    )
    if store.NO_FRAME.pop():
        st.info("That frame is not evaluated: there is nothing to show.", icon=":material/info:")
    draw_table(
        shown,
        {of: c for of, c in COLUMNS.items() if of == "seen" or shown[of].notna().any()},
        key=f"entries_table_{finding.code}_{finding.subject}_{name[-1]}",
        name="Entries",
        on_click=partial(_go, finding),
    )
    if note := rows_told(len(table), "first"):
        st.caption(note)
    _draw_downloads(finding, cases, table)


def _go(finding: Finding, row: int, _column: str) -> None:
    """View the list on the Timeline, starting with the clicked row."""
    if review.begin(finding, row):
        ask_for_page("timeline")
    else:
        review.end()
        store.NO_FRAME.set(True)


def _draw_downloads(finding: Finding, cases: Cases, table: pd.DataFrame) -> None:
    dataset = state.opened().dataset
    stem = re.sub(r"[^\w.-]+", "_", f"{finding.code}-{finding.subject}")
    with st.container(horizontal=True):
        st.download_button(
            "List (CSV)",
            partial(_list_csv, table, path_remover()),
            f"{stem}.csv",
            "text/csv",
            on_click="ignore",
            icon=":material/download:",
            key="entries_csv",
        )
        if cases.table != "left_out":
            st.download_button(
                "For annotators (CVAT)",
                partial(_cvat, state.workspace(), dataset, finding, cases),
                f"{stem}.xml",
                "application/xml",
                on_click="ignore",
                icon=":material/download:",
                key="entries_cvat",
                help="CVAT for images XML 1.1: these frames, with the boxes to look at under the "
                f"label {finding.code}. CVAT knows pictures by their names: those of the files "
                "where the pictures are files, else recording/000012.png by the frame's number.",
            )


def _cvat(space: Workspace, dataset: Dataset, finding: Finding, cases: Cases) -> bytes:
    rows = entry_frames(dataset, cases)
    names = picture_names(dataset.frame_columns, rows, space.pictures)
    return entries_as_cvat(dataset, [finding], file_names=names)


def _list_csv(table: pd.DataFrame, remove_paths: Callable[[object], str]) -> bytes:
    names = {file: remove_paths(file) for file in table["file"].dropna().unique()}
    return to_csv_bytes(table.assign(file=table["file"].map(names)))
