"""Data page: inputs as they were read, recordings and their pictures."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Final

import pandas as pd
import streamlit as st

from nvcore.dataset import Dataset
from nvcore.tables.inputs import inputs_table, left_out_table
from ui.session import state
from ui.session.workspace import Workspace
from ui.shell.messages import without_paths
from ui.views.data import horizon, recordings
from ui.views.data.opening import ask_for_change, draw_trouble
from ui.widgets.text import UNDEFINED, plain

_OLD_NAME: Final = re.compile(
    r"\b(the (?:only|truth's only) recording),? (?:'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\")"
)
MOST_TROUBLES: Final = 5
"""Largest number of named pictures that cannot be opened."""
IMAGES: Final = "single pictures sent"


def draw() -> None:
    """Draw inputs, recordings and notes of the open comparison."""
    space, dataset = state.workspace(), state.opened().dataset
    st.header("What was read")
    st.table(_inputs(dataset), width="stretch", hide_index=True)
    left_out = left_out_table(dataset)
    if not left_out.empty:
        counts = "; ".join(
            f"{row.subject}: {row.n_rows:,} {row.reason}" for row in left_out.itertuples()
        )
        st.caption(f"Rows that could not be placed: {plain(counts)}.")
    for note in dataset.notes:
        st.caption(plain(note[:1].upper() + note[1:]))
    st.button(
        "Add or replace files",
        key="change_files",
        icon=":material/note_add:",
        on_click=ask_for_change,
        help="Another system, more recordings, or another version of a file. Names, thresholds "
        "and settings stay.",
    )
    with st.expander(recordings.NAMES):
        recordings.draw_systems()
    draw_trouble("session")
    recordings.draw_names_changed()
    _draw_picture_troubles(space)
    notes = {state.recording_names()[row]: note for row, note in space.pictures.notes.items()}
    with st.expander(
        "Recordings: names, sizes, frame rates, speeds, traffic, tags and pictures",
        key="recordings",
        on_change="rerun",  # so it stays unfolded when its table is applied
    ):
        recordings.draw_open(*_all_pictures(space), notes)
    horizon.draw()


def _draw_picture_troubles(space: Workspace) -> None:
    """Draw a warning about pictures that cannot be opened."""
    own = space.pictures
    troubles = {row: note for row, note in own.notes.items() if row not in own.sources}
    if not troubles:
        return
    every = state.recording_names()
    lines = [f"- {plain(every[row])}: {plain(note)}" for row, note in troubles.items()]
    if len(lines) > MOST_TROUBLES:
        lines[MOST_TROUBLES:] = [f"- and {len(lines) - MOST_TROUBLES:,} more"]
    text = "\n".join(lines)
    st.warning(f"Recordings whose pictures cannot be opened:\n{text}", icon=":material/warning:")


def _inputs(dataset: Dataset) -> pd.DataFrame:
    """Tabulate the sources. Texts are Markdown that shows names literally."""
    x, y = state.systems()
    rows = []
    n_ignored = int(dataset.truth.ignore.sum())
    n_counted = len(dataset.truth) - n_ignored
    ignored = (
        f": {n_counted:,} {dataset.objects.plural}, {n_ignored:,} to be ignored"
        if n_ignored
        else ""
    )
    for number, source in enumerate(inputs_table(dataset).to_dict("records")):
        letter = {x: "X: ", y: "Y: "}.get(source["subject"], "")
        has_boxes = number <= len(dataset.systems)  # others are speeds and the like
        boxes = f"{source['n_boxes']:,}" if has_boxes else UNDEFINED
        rows.append(
            {
                "Source": f"{letter}{plain(source['subject'])}" if number else "Truth",
                "Files": files_text(source),
                "Format": plain(source["format"]),
                "Boxes": f"{boxes}{'' if number else ignored}",
                "Left out": plain(source["left_out"] or UNDEFINED),
                "Read as": plain(_without_old_name(source["conversion"])),
            }
        )
    return pd.DataFrame(rows)


def files_text(source: Mapping[Hashable, Any]) -> str:
    """Name the files of a row of the table of inputs, as Markdown."""
    more = f" and {source['n_files'] - 1:,} more" if source["n_files"] > 1 else ""
    return f"{plain(without_paths(source['first_file']))}{more}"


def _without_old_name(conversion: str) -> str:
    """Remove the file's own name for the only recording, which the next table shows.

    Examples
    --------
    >>> _without_old_name("the only file taken for the only recording, 'gt'; pixels as they are")
    'the only file taken for the only recording; pixels as they are'
    """
    return _OLD_NAME.sub(r"\1", conversion)


def _all_pictures(space: Workspace) -> tuple[dict[str, str | None], dict[str, str]]:
    """Return all pictures to choose from by label, and the label of each recording's own."""
    session = state.opened().session
    recordings = state.opened().whole.recordings["name"].tolist()
    entries = session.entries(recordings)
    choices: dict[str, str | None] = {}
    labels: dict[str, str] = {}
    for name in recordings:
        path = entries[name].pictures if name in entries else None
        if path is None:
            continue
        label = PurePosixPath(path).name
        if choices.get(label, path) != path:
            label = path if without_paths(path) == path else f"{label} ({name})"
        choices[label] = path
        labels[name] = label
    for label, place in sent_pictures(space).items():
        relative = space.path_in(session.folder, place)
        if relative not in choices.values():
            choices[label if label not in choices else f"{label} (sent)"] = relative
    return choices, labels


def sent_pictures(space: Workspace) -> dict[str, Path]:
    """Return videos, archives and the folder of single pictures sent in this form, by label."""
    stored = [file for file in list(space.stored.values()) if file.form == space.form]
    n_images = sum(file.kind == "image" for file in stored)
    return {
        file.name if file.kind != "image" else f"{IMAGES} ({n_images:,})": space.folder
        / file.source
        for file in stored
    }
