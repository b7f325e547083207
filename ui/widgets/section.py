"""Tables of report sections, drawn on pages."""

from __future__ import annotations

import streamlit as st

from nvcore.report.section import Table, true_minus, worded
from ui.session import state
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import plain


def draw_table_of(block: Table, *, key: str, explanation: str) -> None:
    """Draw a report section's table with its notes below.

    Parameters
    ----------
    key
        CSS class of the table.
    explanation
        Markdown behind "?".
    """
    (table,) = worded([block], state.opened().dataset.objects)
    assert isinstance(table, Table)
    first, *head = table.head
    rows = [
        MeasureRow(
            label,
            tuple(
                true_minus(cell) if i in table.right else cell for i, cell in enumerate(cells, 1)
            ),
            marks=table.marks[number] if table.marks else "",
            hint=table.hints[number] if table.hints else "",
        )
        for number, (label, *cells) in enumerate(table.rows)
    ]
    st.html(measures_html(rows, key=key, head=head, first=first))
    st.caption("  \n".join(plain(str(note)) for note in table.notes), help=explanation)
