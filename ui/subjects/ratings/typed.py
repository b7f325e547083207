"""Ratings page: ratings typed into a table with a row for each clip of a participant."""

from __future__ import annotations

from typing import Final

import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text, fold_name
from nvcore.comparison.compare import Result
from nvcore.inputs.readers.parse.table import TextTable
from nvcore.subjects.people.participants import MOST_NAME
from nvcore.subjects.ratings.reading import check_ratings
from ui.session import state, store
from ui.widgets.buttons import submit_button
from ui.widgets.text import plain

COLUMNS: Final = ("participant", "clip", "system", "rating")
LAST: Final = "ratings_typed_last"
MOST_TOLD: Final = 5


def typed(result: Result) -> pd.DataFrame | None:
    """Return the ratings in the table, or None while it is empty.

    Raises
    ------
    InputError
        If a participant rates a clip twice.
    """
    _ask_for_rows(result)
    token = state.workspace().token
    if store.RATINGS_EDITOR_OF.setdefault(token) != token:  # restored after a reload
        store.RATINGS_EDITOR_OF.set(token)
        _draw_anew()
    editor = store.RATINGS_EDITOR.of(store.N_RATINGS_EDITORS.get())
    if not editor.is_set:  # drawn again, with the previous entries
        store.RATINGS_START.set(_before())
    table = st.data_editor(
        store.RATINGS_START.get(),
        num_rows="dynamic",
        hide_index=True,
        key=editor.key,
        height=280,
        column_config={
            "participant": st.column_config.TextColumn("Participant", max_chars=MOST_NAME),
            "clip": st.column_config.SelectboxColumn("Clip", options=state.recording_names()),
            "system": st.column_config.SelectboxColumn("Boxes of", options=[*result.names]),
            "rating": st.column_config.NumberColumn("Rating (higher = more annoying)"),
        },
    )
    state.workspace().notes[LAST] = table.reset_index(drop=True)
    if table.dropna(how="all").empty:
        return None
    return _complete(table)


def _before() -> pd.DataFrame:
    empty = pd.DataFrame({name: pd.Series(dtype=object) for name in COLUMNS})
    before: pd.DataFrame = state.workspace().notes.get(LAST, empty.astype({"rating": float}))
    return before


def _draw_anew() -> None:
    """Start a new, empty table."""
    store.N_RATINGS_EDITORS.set(store.N_RATINGS_EDITORS.get() + 1)


def _ask_for_rows(result: Result) -> None:
    """Draw a field for a name, and a button that adds a row per clip for that participant."""
    with st.form("ratings_add", border=False):
        name_at, button_at = st.columns([2, 3], vertical_alignment="bottom")
        name = name_at.text_input(
            "Participant",
            value="A01",
            max_chars=MOST_NAME,
            key="ratings_typed_name",
            autocomplete="off",
        )
        n = 2 * len(state.recording_names())
        is_sent = submit_button(
            f"Add a row for each of the {n:,} clips",
            icon=":material/playlist_add:",
            key="rating_add_rows",
            at=button_at,
        )
    if not is_sent:
        return
    before = _before()
    known = {
        fold_name(str(person)): str(person) for person in reversed(before["participant"].dropna())
    }
    person = known.get(fold_name(name or ""), (name or "").strip())
    if not person:
        st.info("A participant needs a name or a code.")
        return
    rows = _missing_rows(before, person, result)
    if rows.empty:
        st.info(f"{plain(person)} has a row for each clip already.")
        return
    both = pd.concat([before, rows], ignore_index=True) if len(before) else rows
    state.workspace().notes[LAST] = both
    _draw_anew()


def _missing_rows(before: pd.DataFrame, person: str, result: Result) -> pd.DataFrame:
    """Return rows of the participant for the clips that have none yet."""
    mine = before[before["participant"] == person]
    has_row = set(zip(mine["clip"], mine["system"], strict=True))
    unrated = [
        (person, clip, system, float("nan"))
        for system in result.names
        for clip in state.recording_names()
        if (clip, system) not in has_row
    ]
    return pd.DataFrame(unrated, columns=list(COLUMNS))


def _complete(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows with participant, clip and system as text, and draw a note about others."""
    numbered = table.reset_index(drop=True)
    numbered = numbered.set_axis(numbered.index + 1).dropna(how="all")
    needed = ["participant", "clip"]
    if numbered["system"].notna().any():  # otherwise the page asks whose boxes they were
        needed.append("system")
    cells = numbered[needed]
    blank = cells.isna() | cells.map(lambda cell: not str(cell).strip())
    is_short = blank.any(axis=1)
    if is_short.any():
        words = {"participant": "no participant", "clip": "no clip", "system": "whose boxes?"}
        row_texts = [
            f"row {number} ({', '.join(words[name] for name in needed if row[name])})"
            for number, row in blank[is_short].head(MOST_TOLD).iterrows()
        ]
        more = ", ..." if is_short.sum() > MOST_TOLD else ""
        st.warning(
            f"{count_text(int(is_short.sum()), 'incomplete row')} left out: "
            f"{plain(', '.join(row_texts))}{more}.",
            icon=":material/edit:",
        )
    complete = numbered[~is_short]
    n_unrated = int(complete["rating"].isna().sum())
    if 0 < n_unrated < len(complete):
        st.caption(f"{count_text(n_unrated, 'row')} without a rating yet.")
    if n_unrated < len(complete):
        st.caption(
            'It lasts as long as this browser tab: before you close that, download it under "Files"'
            " at the end of this page."
        )
    rating = complete["rating"].map(lambda value: "" if pd.isna(value) else f"{value:.15g}")
    text = complete.astype(object).where(complete.notna(), "").astype(str).assign(rating=rating)
    fields = {name: text[name].str.strip().to_numpy(dtype=object) for name in COLUMNS}
    lines = complete.index.to_numpy()
    return check_ratings(TextTable("the table above", fields, lines, has_decimal_comma=False))
