"""Data page: one table of the recordings to edit, filled from a CSV file, applied at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.errors import NvcoreError
from nvcore.inputs.recordings import no_such_recording
from nvcore.inputs.recordings_file import read_recordings_file
from nvcore.inputs.session import RecordingEntry
from nvcore.wording import count_text
from ui.data.opening import try_to_open
from ui.data.recordings.edited import NAMES_ALONE, NO_PICTURES, changes_in, editable, filled
from ui.data.recordings.names import n_changes, use_names
from ui.session import state
from ui.session.opening import with_recordings
from ui.session.uploads import SentFile, new_upload, store_annotations
from ui.shell.page_words import page_text
from ui.widgets.text import plain

CONFIG: Final = {
    "name": st.column_config.TextColumn("Recording", help="What it is called on every page."),
    "width": st.column_config.NumberColumn("Width (px)", min_value=1, format="%g"),
    "height": st.column_config.NumberColumn("Height (px)", min_value=1, format="%g"),
    "fps": st.column_config.NumberColumn("Frames per second", min_value=0.01, format="%g"),
    "context": st.column_config.TextColumn(
        "Traffic", help="urban, rural, or a number from 0 (urban) to 1 (rural); empty: not stated."
    ),
    "tags": st.column_config.TextColumn(
        "Tags", help="Words such as night; rain, separated by semicolons."
    ),
}


def draw(choices: Mapping[str, str | None], labels: Mapping[str, str]) -> None:
    """The table and the button that applies what was changed in it.

    Parameters
    ----------
    choices
        Pictures to choose from: their paths, by label.
    labels
        Label of the pictures of each recording that has some.
    """
    before = editable(state.opened().whole, labels)
    st.caption(
        "Names, sizes, frame rates, traffic, tags and pictures. Sizes and rates that the files "
        "state need no change. The names are used on every page, in links and in exports."
    )
    version = f"{state.workspace().n_opened}_{n_changes()}"
    file = st.file_uploader(
        "Fill the table from a CSV file",
        key=f"recordings_csv_{version}",  # what was applied is not filled in again
        type=["csv", "tsv", "txt"],
        help="Columns recording, width, height, fps, context, tags, title; all but the first may "
        "be missing. Nothing changes until the table is applied.",
    )
    shown = before if file is None else _filled(before, file)
    key = f"recordings_editor_{version}"
    with st.form(f"{key}_form", border=False):
        after = st.data_editor(
            shown,
            hide_index=True,
            num_rows="fixed",
            width="stretch",
            column_config={
                **CONFIG,
                "pictures": st.column_config.SelectboxColumn(
                    "Pictures", options=[NO_PICTURES, *choices], required=True
                ),
            },
            key=f"{key}_{'' if file is None else file.file_id}",
        )
        is_wanted = st.form_submit_button("Apply to the recordings", icon=":material/check:")
    if is_wanted:
        _apply(before, after, choices)


def _filled(table: pd.DataFrame, file: SentFile) -> pd.DataFrame:
    try:
        entries = _entries(file)
        names = table["name"].tolist()
        for name in entries:
            if name not in names:
                st.error(plain(no_such_recording(name, names)), icon=":material/error:")
                return table
    except NvcoreError as error:
        st.error(plain(page_text(error)), icon=":material/error:")
        return table
    what = count_text(len(entries), "recording")
    st.caption(f"{what} filled in below; apply the table to use it.")
    return filled(table, entries.values())


def _entries(file: SentFile) -> dict[str, RecordingEntry]:
    """The rows of a CSV file that was sent, by recording."""

    def read() -> dict[str, RecordingEntry]:
        space = state.workspace()
        folder = new_upload(space)
        (path,) = store_annotations(space, folder, "recordings", [file])
        rows = read_recordings_file(folder / path, PurePosixPath(path).name)
        return {name: entry for name, (_, entry) in rows.items()}

    entries: dict[str, RecordingEntry] = state.workspace().cached(
        "recordings_sent", getattr(file, "file_id", file.name), read
    )
    return entries


def _apply(before: pd.DataFrame, after: pd.DataFrame, choices: Mapping[str, str | None]) -> None:
    try:
        changes = changes_in(before, after, choices)
        if not changes:
            st.info("Nothing was changed in the table.", icon=":material/info:")
            return
        if {field for change in changes.values() for field in change} <= NAMES_ALONE:
            use_names({}, changes)
    except NvcoreError as error:
        st.error(plain(page_text(error)), icon=":material/error:")
        return
    opened = state.opened()
    session = with_recordings(opened.session, before["name"].tolist(), changes)
    try_to_open(replace(session, params=state.params()), label=opened.label)
