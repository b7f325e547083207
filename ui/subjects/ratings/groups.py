"""Ratings page: comparison of persons or drives under several conditions, without ratings."""

from __future__ import annotations

from functools import partial
from typing import Any, Final, get_args

import pandas as pd
import streamlit as st

from nvcore.common.arguments.groups import GroupArguments, Scale
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.wording import minus
from nvcore.evidence.groups import GroupComparison, compare_groups
from nvcore.evidence.groups.reading import LABELS, SUMMARY
from nvcore.evidence.groups.text import cells_of
from nvcore.inputs.readers.parse.table import TextTable, parse_table
from nvcore.subjects.people.participants import MOST_NAME
from ui.session import state
from ui.shell.messages import errors_shown
from ui.widgets.choices import ask_for_file, choose_side_by_side, download_csv
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import docs_link, plain

FILE: Final = "CSV file"
VALUES: Final = "Values, typed in"
MEANS: Final = "Means and SD, typed in"
MOST_KEPT: Final = 4
COLUMNS: Final[dict[str, dict[str, Any]]] = {
    VALUES: {
        "participant": st.column_config.TextColumn("Participant, if known", max_chars=MOST_NAME),
        "condition": st.column_config.TextColumn("Condition"),
        "value": st.column_config.NumberColumn("Value"),
    },
    MEANS: {
        "condition": st.column_config.TextColumn("Condition"),
        "n": st.column_config.NumberColumn("n"),
        "mean": st.column_config.NumberColumn("Mean"),
        "sd": st.column_config.NumberColumn("SD, with n - 1"),
    },
}
"""Tables that can be typed in."""
HEADINGS: Final = {
    "groups": "Groups",
    "tests": "All conditions",
    "pairs": "Pairs of conditions",
    "assumptions": "Assumptions",
    "sizes": "A further study",
}


@errors_shown()
def draw() -> None:
    """Draw the table, the choice of comparison, and its results."""
    st.header("Compare groups")
    st.caption(
        "Persons or drives under several conditions: reaction times to alerts, violations with "
        "and without feedback. All tests that the table allows are made, and the one that fits is "
        f"named ({docs_link('which, and why', 'which-test-fits', doc='groups')}). Needs neither "
        "ratings nor a comparison of systems."
    )
    way = choose_side_by_side("Table from", [FILE, VALUES, MEANS], "groups_source", default=FILE)
    text = _from_file() if way == FILE else _typed(way)
    if text is None:
        return
    asked = _ask(text)
    content = tuple((name, tuple(fields)) for name, fields in text.fields.items())
    comparison = state.workspace().cached(
        "groups",
        (content, text.has_decimal_comma, repr(asked)),
        lambda: compare_groups(asked, text),
        most=MOST_KEPT,
    )
    _draw(comparison)


def _from_file() -> TextTable | None:
    sent = ask_for_file(
        "Groups (CSV with the columns condition and value, participant if known; or condition, n, "
        "mean, sd)",
        "groups_file",
    )
    return None if sent is None else _parsed(*sent)


def _typed(way: str) -> TextTable | None:
    config = COLUMNS[way]
    empty = pd.DataFrame({name: pd.Series(dtype=object) for name in config})
    st.caption("Rows can be pasted from a spreadsheet. The table lasts while this part is shown.")
    table: pd.DataFrame = st.data_editor(
        empty.astype({name: float for name in config if name in ("value", *SUMMARY)}),
        num_rows="dynamic",
        hide_index=True,
        key=f"groups_table_{len(config)}",
        column_config=config,
    )
    table = table.dropna(how="all")
    table = table.drop(
        columns=[name for name in LABELS[:1] if name in table and table[name].isna().all()]
    )
    return _parsed(to_csv_bytes(table, digits=15), "the table above") if len(table) else None


def _parsed(content: bytes, name: str) -> TextTable:
    return parse_table(content, name=name, what="groups", required=["condition"])


def _ask(text: TextTable) -> GroupArguments:
    """Ask how to compare the table."""
    is_means = all(name in text for name in SUMMARY)
    first, second, third = st.columns(3)
    chosen: dict[str, Any] = {}
    if is_means:
        chosen["correlation"] = first.number_input(
            "Correlation, if the persons were the same",
            *(-1.0, 1.0, None),
            key="groups_correlation",
            help="What paired comparisons would show: no result, as the values are not known.",
        )
    else:
        columns = [name for name in text.fields if name not in LABELS]
        chosen["measure"] = first.selectbox(
            "Compare", columns, None, key="groups_measure", placeholder="the first with numbers"
        )
        chosen["scale"] = second.selectbox(
            "Its numbers are",
            get_args(Scale),
            None,
            key="groups_scale",
            placeholder="found by name and value",
        )
    chosen["difference"] = (
        third.number_input(
            "Smallest difference that would matter",
            *(0.0, None, None),
            key="groups_difference",
            help="For the size of a further study. Empty: the largest difference found.",
        )
        or None
    )
    return GroupArguments(text.name, **chosen)


def _draw(comparison: GroupComparison) -> None:
    for sentence in comparison.sentences:
        st.markdown(f"- {plain(sentence)}")
    cells = cells_of(comparison)
    if comparison.fits:
        st.caption("★ fits; what stands beside it does not, and shows what it would have said.")
    for name, (heads, *rows) in cells.items():
        st.subheader(HEADINGS[name])
        table = pd.DataFrame(rows, columns=[f"c{i}" for i in range(len(heads))])
        table["c0"] = table["c0"].str.replace("* ", "★ ", regex=False).str.strip()
        columns = {
            f"c{i}": TableColumn(
                head.strip(), is_head=not i, is_number=i > 0 and head not in ("by", "it is", "note")
            )
            for i, head in enumerate(heads)
            if not i or (table[f"c{i}"] != "").any()
        }
        numbers = [key for key, column in columns.items() if column.is_number]
        table[numbers] = table[numbers].map(minus)
        draw_table(table, columns, key=f"groups_{name}", name=HEADINGS[name], is_sortable=False)
    with st.container(horizontal=True):
        for name in cells:
            download_csv(
                f"{HEADINGS[name]} (CSV)",
                partial(getattr, comparison, name),
                f"{name}.csv",
                f"groups_{name}_csv",
            )
