"""Data page: the full list of what a finding concerns, each entry one click from its frame."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.findings import Cases, Finding
from nvcore.output.csv_text import to_csv_bytes
from nvcore.tables.inputs import NO_ROW, entries_as_cvat, entry_frames, finding_entries
from ui.session import state
from ui.shell.messages import path_remover
from ui.shell.navigate import ask_for_page
from ui.widgets.clicks import clicked_row
from ui.widgets.table_columns import MOST_ROWS, rows_told, table_height
from ui.widgets.text import UNDEFINED

_OPEN: Final = "entries_open"
"""The finding whose list is open."""
_SEEN: Final = "entries_seen"
"""Which entries were looked at, by finding and its cases."""
_NO_FRAME: Final = "entries_no_frame"
NOUNS: Final = {
    "boxes": ("box", "boxes"),
    "frames": ("recording", "recordings"),
    "left_out": ("row", "rows"),
}
"""What the cases of a finding are, by their table."""
COLUMNS: Final = ("seen", "recording", "frame", "x", "y", "w", "h", "score", "track", "line")
CONFIG: Final = {
    "seen": st.column_config.TextColumn("Seen", width=50, help="Looked at in this tab."),
    "recording": st.column_config.TextColumn("Recording"),
    "frame": st.column_config.NumberColumn("Frame", format="%d"),
    "x": st.column_config.NumberColumn("x (px)", format="%.1f"),
    "y": st.column_config.NumberColumn("y (px)", format="%.1f"),
    "w": st.column_config.NumberColumn("Width (px)", format="%.1f"),
    "h": st.column_config.NumberColumn("Height (px)", format="%.1f"),
    "score": st.column_config.NumberColumn("Score", format="%.4g"),
    "track": st.column_config.NumberColumn("Track id", format="%d"),
    "line": st.column_config.NumberColumn("Line of the file", format="%d"),
}


def is_open(finding: Finding) -> bool:
    """Whether the list of this finding is on the page."""
    return st.session_state.get(_OPEN) == _name(finding)


def draw(finding: Finding, number: int) -> None:
    """The button that opens the list, and the list."""
    cases = finding.cases
    if cases is None or not len(cases):
        return
    shown = is_open(finding)
    n, nouns = len(cases), NOUNS[cases.table]
    what = f"Show the {nouns[0]}" if n == 1 else f"Show all {n:,} {nouns[1]}"
    st.button(
        "Hide the list" if shown else what,
        key=f"entries_{number}",
        icon=":material/list:",
        on_click=_toggle,
        args=(_name(finding),),
    )
    if shown:
        _draw_list(finding, cases)


def _name(finding: Finding) -> tuple[str, str, str]:
    """Says which finding it is, for as long as the same data are open."""
    return state.opened().dataset.fingerprint, finding.code, finding.subject


def _key(finding: Finding, cases: Cases) -> tuple[str, ...]:
    """Says which cases they are as well: thresholds, matching, X and Y change them."""
    rows = np.asarray(cases.rows, dtype=np.int64).tobytes()
    return *_name(finding), sha256(rows).hexdigest()[:12]


def _toggle(name: tuple[str, str, str]) -> None:
    if st.session_state.get(_OPEN) == name:
        del st.session_state[_OPEN]
    else:
        st.session_state[_OPEN] = name


def _draw_list(finding: Finding, cases: Cases) -> None:
    name = _key(finding, cases)
    table = _table(finding, name)
    seen = st.session_state.get(_SEEN, {}).get(name, frozenset())
    shown = table.head(MOST_ROWS)
    shown = shown.assign(seen=["✓" if row in seen else "" for row in range(len(shown))])
    st.caption("Click a row to see its frame on the Timeline; the browser's Back returns here.")
    if st.session_state.pop(_NO_FRAME, False):
        st.info("That frame is not evaluated: there is nothing to show.", icon=":material/info:")
    key = f"entries_table_{finding.code}_{finding.subject}_{name[-1]}"
    st.dataframe(
        shown,
        hide_index=True,
        column_config=CONFIG,
        column_order=[name for name in COLUMNS if name == "seen" or shown[name].notna().any()],
        height=table_height(len(shown)),
        placeholder=UNDEFINED,
        key=key,
        selection_mode=("single-row", "single-cell"),
        on_select=partial(_go, key, finding, cases),
    )
    if note := rows_told(len(table), "first"):
        st.caption(note)
    _draw_downloads(finding, cases, table)


def _table(finding: Finding, name: tuple[str, ...]) -> pd.DataFrame:
    dataset = state.opened().dataset
    table: pd.DataFrame = state.workspace().cached(
        "finding_entries", name, lambda: finding_entries(dataset, [finding])
    )
    return table


def _go(key: str, finding: Finding, cases: Cases) -> None:
    """Show the frame of the row that was clicked."""
    row = clicked_row(key)
    if row is None:
        return
    seen = st.session_state.setdefault(_SEEN, {})
    name = _key(finding, cases)
    seen[name] = seen.get(name, frozenset()) | {row}
    one = Cases(cases.table, np.asarray(cases.rows)[row : row + 1])
    frame_row = int(entry_frames(state.opened().dataset, one)[0])
    if frame_row == NO_ROW:
        st.session_state[_NO_FRAME] = True
        return
    state.go_to(*state.place_of(frame_row))
    ask_for_page("timeline")


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
                lambda: entries_as_cvat(dataset, [finding]),
                f"{stem}.xml",
                "application/xml",
                on_click="ignore",
                icon=":material/download:",
                key="entries_cvat",
                help="CVAT for images XML 1.1: these frames, with the boxes to look at under the "
                f"label {finding.code}. Pictures are called recording/000012.png.",
            )


def _list_csv(table: pd.DataFrame, remove_paths: Callable[[object], str]) -> bytes:
    names = {file: remove_paths(file) for file in table["file"].dropna().unique()}
    return to_csv_bytes(table.assign(file=table["file"].map(names)))
