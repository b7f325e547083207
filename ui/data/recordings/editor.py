"""Data page: the one table of the recordings, to be edited, filled from CSV and saved as CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import PurePosixPath
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st
from streamlit.typing import UploadedFile

from nvcore.dataset import Dataset
from nvcore.errors import NvcoreError
from nvcore.inputs.recordings import no_such_recording
from nvcore.inputs.recordings_file import read_recordings_file
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.params.traffic import count_contexts
from nvcore.settings import MAX_FPS, MIN_FPS
from nvcore.wording import MOST_NAMED, count_text, listed
from ui.data.opening import WAYS, try_to_open
from ui.data.recordings.edited import (
    COLUMNS,
    NAMES_ALONE,
    NO_PICTURES,
    changes_in,
    editable,
    filled,
    saved,
)
from ui.data.recordings.names import use_names
from ui.session import state, store
from ui.session.opening import with_recordings
from ui.session.uploads import new_upload, store_annotations
from ui.shell.messages import shown_error
from ui.widgets.buttons import submit_button
from ui.widgets.text import UNDEFINED, docs_link, plain

FRAMES: Final = "frames"
NOTE: Final = "note"
READ_ONLY: Final = (FRAMES, NOTE)
"""Columns that say what came out."""
CONFIG: Final = {
    "name": st.column_config.TextColumn("Recording", help="What it is called on every page."),
    "width": st.column_config.NumberColumn("Width (px)", width=95, min_value=1, format="%g"),
    "height": st.column_config.NumberColumn("Height (px)", width=98, min_value=1, format="%g"),
    "fps": st.column_config.NumberColumn(
        "Frames/s",
        width=88,
        min_value=MIN_FPS,
        max_value=MAX_FPS,
        format="%g",
        help="Frames per second of the camera.",
    ),
    "context": st.column_config.TextColumn(
        "Traffic",
        help="How much a miss to the side costs: urban, rural, or a number from 0 (urban) to 1 "
        "(rural); empty: not stated, which counts as urban.",
    ),
    "speed_kmh": st.column_config.NumberColumn(
        "Speed (km/h)",
        width=116,
        min_value=0,
        format="%g",
        help="Of the car, for the time left to brake; empty: not stated, then the sidebar's speed "
        "is assumed.",
    ),
    "horizon": st.column_config.NumberColumn(
        "Horizon (px)",
        width=110,
        format="%.4g",
        help="Row of the horizon, from the top of the picture, for nearness by horizon; empty: not "
        "known.",
    ),
    "tags": st.column_config.TextColumn(
        "Tags", help="Words such as night; rain, separated by semicolons."
    ),
    "unit": st.column_config.TextColumn(
        "Part of",
        help="A drive, a route or a car that several recordings are of: they are not independent, "
        "so tests and intervals take them as one. Empty: it stands by itself.",
    ),
    "first_picture": st.column_config.NumberColumn(
        "First picture",
        step=1,
        format="%d",
        help="Only where boxes and pictures do not belong together: the number, as in the truth, "
        "of the frame that the first picture shows. Empty: from the file names.",
    ),
    FRAMES: st.column_config.NumberColumn(
        "Frames", width=70, format="localized", help="How many frames are evaluated."
    ),
    NOTE: st.column_config.TextColumn("Which picture shows which frame"),
}


def edit(
    table: pd.DataFrame,
    *,
    key: str,
    pictures: Sequence[str] = (),
    columns: Sequence[str] | None = None,
    disabled: Sequence[str] = READ_ONLY,
) -> pd.DataFrame:
    """The table as a person edits it; what was typed stays while other values are proposed.

    Parameters
    ----------
    pictures
        Labels to choose from.
    columns
        Those shown; None: all.
    disabled
        Columns that cannot be edited.
    """
    choice = st.column_config.SelectboxColumn(
        "Pictures",
        options=[NO_PICTURES, *pictures],
        required=True,
        help=f"Send pictures under “{WAYS}”, Upload; they appear here.",
    )
    edited: pd.DataFrame = st.data_editor(
        table,
        hide_index=True,
        num_rows="fixed",
        width="stretch",
        column_order=columns,
        column_config={**CONFIG, "pictures": choice},
        disabled=[name for name in disabled if name in table],
        placeholder=UNDEFINED,
        key=key,
    )
    return edited


def draw(
    choices: Mapping[str, str | None], labels: Mapping[str, str], notes: Mapping[str, str]
) -> None:
    """The table of what is open, and the button that applies what was changed in it.

    Parameters
    ----------
    choices
        Pictures to choose from: their paths, by label.
    labels
        Label of the pictures of each recording that has some.
    notes
        By which rule the pictures of a recording show its frames, or why there are none.
    """
    opened = state.opened()
    before = editable(opened.whole, opened.session, labels)
    first = opened.whole.frame_columns.first
    came_out: dict[str, Any] = {
        FRAMES: np.diff(first),
        NOTE: [notes.get(name, "") for name in before["name"]],
    }
    _draw_words(opened.whole)
    place = st.container()
    version = f"{state.workspace().n_opened}_{store.N_NAME_CHANGES.get()}"
    with st.expander("Fill this table from a CSV file, or save it as one"):
        file = st.file_uploader(
            "Fill the table from a CSV file",
            key=f"recordings_csv_{version}",  # what was applied is not filled in again
            type=["csv", "tsv", "txt"],
            help="Columns recording, width, height, fps, context, speed_kmh, horizon, tags, "
            "pictures, first_picture, title; all but the first may be missing. Pictures are looked "
            "for by name among those to choose from. Nothing changes until the table is applied.",
        )
        shown = before if file is None else _filled(before, file, choices)
        st.download_button(
            "Save the table (CSV)",
            partial(saved, opened.whole, opened.session),
            "recordings.csv",
            "text/csv",
            on_click="ignore",
            icon=":material/download:",
            key="recordings_save",
            help="As it is in use now: to be edited elsewhere, filled in here again, or sent along "
            "with the files.",
        )
    key = f"recordings_editor_{version}"
    with place, st.form(f"{key}_form", border=False):
        after = edit(
            shown.assign(**came_out),
            key=f"{key}_{'' if file is None else file.file_id}",
            pictures=[*choices],
            columns=[*COLUMNS[:-2], FRAMES, *COLUMNS[-2:], NOTE],
        )
        is_wanted = submit_button(
            "Apply to the recordings", icon=":material/check:", key="apply_recordings"
        )
    if is_wanted:
        _apply(before, after, choices)


def _draw_words(whole: Dataset) -> None:
    """What the table is for, and which traffic context holds."""
    st.caption(
        "Click a cell to change it, then apply the table. Drag the corner of a cell to repeat it "
        "below; paste cells from a spreadsheet. Sizes and rates that the files state need no "
        "change. The names are used on every page, in links and in exports. Traffic "
        f"({docs_link('context', 'context', doc='formats')}): "
        f"{count_contexts(whole.recordings['context'])}."
    )
    if state.params().edge_weight is not None:
        st.info(
            "The sidebar's traffic context has a value now, which holds for all recordings "
            "whatever they state.",
            icon=":material/info:",
        )


def _filled(
    table: pd.DataFrame, file: UploadedFile, choices: Mapping[str, str | None]
) -> pd.DataFrame:
    try:
        entries = _by_name_here(_entries(file), table["name"].tolist())
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return table
    if isinstance(entries, str):
        st.error(plain(entries), icon=":material/error:")
        return table
    what = count_text(len(entries), "recording")
    st.caption(f"{what} filled in above; apply the table to use it.")
    filled_in, lost = filled(table, entries, choices)
    if lost:
        st.warning(
            f"The file names pictures that are not here: {plain(listed(lost, most=MOST_NAMED))}. "
            f"Send them under “{WAYS}”, Upload, and fill the table again.",
            icon=":material/warning:",
        )
    return filled_in


def _by_name_here(
    entries: Mapping[str, RecordingEntry], names: Sequence[str]
) -> dict[str, RecordingEntry] | str:
    """The rows by what the recordings are called now; a file may name them as the data do."""
    if len(entries) == len(names) == 1:  # whatever it is called
        return dict(zip(names, entries.values(), strict=True))
    session: Session = state.opened().session
    now = {entry.name: name for name, entry in session.entries(names).items() if name in names}
    here = {name if name in names else now.get(name, name): row for name, row in entries.items()}
    stranger = next((name for name in here if name not in names), None)
    return here if stranger is None else no_such_recording(stranger, names)


def _entries(file: UploadedFile) -> dict[str, RecordingEntry]:
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
        changes: dict[str, dict[str, Any]] = changes_in(before, after, choices)
        if not changes:
            st.info("Nothing was changed in the table.", icon=":material/info:")
            return
        if {field for change in changes.values() for field in change} <= NAMES_ALONE:
            use_names({}, changes)
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")
        return
    opened = state.opened()
    session = with_recordings(opened.session, before["name"].tolist(), changes)
    try_to_open(replace(session, params=state.params()), label=opened.label)
