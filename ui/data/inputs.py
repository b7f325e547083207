"""Data page: what was read, with which conversion; recordings and their pictures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from nvcore.tables.inputs import inputs_table, left_out_table
from nvcore.wording import UNDEFINED
from ui.data import context
from ui.data.opening import draw_trouble, try_to_open
from ui.data.recordings import editor, names
from ui.session import state
from ui.session.opening import recording_entry, relative_path, with_recordings
from ui.session.workspace import Stored, Workspace
from ui.shell.messages import without_paths
from ui.widgets.text import plain

_OLD_NAME: Final = re.compile(
    r"\b(the (?:only|truth's only) recording),? (?:'(?:[^'\\]|\\.)*'|\"(?:[^\"\\]|\\.)*\")"
)
NONE: Final = "no pictures"
MOST_IN_TABLE: Final = 12
"""Recordings that are shown without scrolling."""
IMAGES: Final = "single pictures sent"


def draw() -> None:
    """Inputs, recordings and notes of the open comparison."""
    space, dataset = state.workspace(), state.opened().dataset
    st.subheader("What was read")
    st.table(_inputs(dataset), width="stretch", hide_index=True)
    left_out = left_out_table(dataset)
    if not left_out.empty:
        counts = "; ".join(
            f"{row.subject}: {row.n_rows:,} {row.reason}" for row in left_out.itertuples()
        )
        st.caption(f"Rows that could not be placed: {plain(counts)}.")
    recordings = _recordings(space, dataset)
    if len(recordings) > MOST_IN_TABLE:
        st.dataframe(recordings, hide_index=True, width="stretch")
    else:  # shows long texts in full, but takes them for Markdown
        st.table(recordings.map(plain), width="stretch", hide_index=True)
    for note in dataset.notes:
        st.caption(plain(note[:1].upper() + note[1:]))
    draw_trouble("session")
    names.draw_done()
    with st.expander("Change the recordings: names, sizes, rates, traffic, tags, pictures"):
        editor.draw(*_all_pictures(space))
    with st.expander("Change the names of the systems"):
        names.draw_systems()
    with st.expander("Traffic context of the recordings"):
        context.draw()
    with st.expander("Pictures of the recordings"):
        _draw_pictures(space)


def _inputs(dataset: Dataset) -> pd.DataFrame:
    """One row per source; the texts are Markdown that shows names as they are."""
    x, y = state.systems()
    rows = []
    n_ignored = int(dataset.truth.ignore.sum())
    n_counted = len(dataset.truth) - n_ignored
    ignored = f": {n_counted:,} pedestrians, {n_ignored:,} to be ignored" if n_ignored else ""
    for number, source in enumerate(inputs_table(dataset).to_dict("records")):
        letter = {x: "X: ", y: "Y: "}.get(source["subject"], "")
        more = f" and {source['n_files'] - 1:,} more" if source["n_files"] > 1 else ""
        rows.append(
            {
                "Source": f"{letter}{plain(source['subject'])}" if number else "Truth",
                "Files": f"{plain(without_paths(source['first_file']))}{more}",
                "Format": plain(source["format"]),
                "Boxes": f"{source['n_boxes']:,}{'' if number else ignored}",
                "Read as": plain(_without_old_name(source["conversion"])),
            }
        )
    return pd.DataFrame(rows)


def _without_old_name(conversion: str) -> str:
    """The text without the name that the file gives the only recording: the next table has it.

    Examples
    --------
    >>> _without_old_name("the only file taken for the only recording, 'gt'; pixels as they are")
    'the only file taken for the only recording; pixels as they are'
    """
    return _OLD_NAME.sub(r"\1", conversion)


def _recordings(space: Workspace, dataset: Dataset) -> pd.DataFrame:
    table, first = dataset.recordings, dataset.frame_columns.first
    n_rows = len(table)
    return pd.DataFrame(
        {
            "Recording": table["name"],
            "Size (px)": [
                f"{w:g} × {h:g}" for w, h in zip(table["width"], table["height"], strict=True)
            ],
            "Frames per second": [f"{fps:g}" for fps in table["fps"]],
            "Traffic": [context.context_text(value) for value in table["context"]],
            "Tags": [", ".join(tags) or UNDEFINED for tags in table["tags"]],
            "Evaluated frames": first[1:] - first[:-1],
            "Pictures": [_pictures_text(space, recording) for recording in range(n_rows)],
        }
    )


def _pictures_text(space: Workspace, recording: int) -> str:
    note = space.picture_notes.get(recording, "")
    pictures = space.pictures.get(recording)
    if pictures is None:
        return note or NONE
    return ": ".join(part for part in (pictures.name, note) if part)


def _all_pictures(space: Workspace) -> tuple[dict[str, str | None], dict[str, str]]:
    """Pictures to choose from for all recordings, by label; and the label of each one's own."""
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
        relative = relative_path(place, session.folder)
        if relative not in choices.values():
            choices[label if label not in choices else f"{label} (sent)"] = relative
    return choices, labels


def _draw_pictures(space: Workspace) -> None:
    session, label = state.opened().session, state.opened().label
    every = state.opened().whole.recordings["name"].tolist()
    name = every[0]
    if len(every) > 1:
        name = st.selectbox("Recording", every, key="pictures_recording")
    entry = recording_entry(session, every, name)
    choices = picture_choices(space, session, entry.pictures)
    entries = [NONE, *choices]
    now = next((label for label, path in choices.items() if path == entry.pictures), NONE)
    with st.form(f"pictures_{every.index(name)}", border=False):
        left, right = st.columns([2, 1])
        picture = left.selectbox(
            "Pictures",
            entries,
            index=entries.index(now),
            help="Send pictures under “Open another comparison”, Upload; they appear here.",
        )
        first_picture = right.number_input(
            "Frame number of the first picture",
            value=entry.first_picture,
            step=1,
            placeholder="as guessed",
            help="Only where boxes and pictures do not belong together: the number, as in the "
            "truth, of the frame that the first picture shows. Empty: from the file names.",
        )
        is_wanted = st.form_submit_button("Use these pictures")
    if is_wanted:
        first = None if first_picture is None else int(first_picture)
        change = {"pictures": choices.get(picture), "first_picture": first}
        changed = with_recordings(session, every, {name: change})
        try_to_open(replace(changed, params=state.params()), label=label)


def picture_choices(
    space: Workspace, session: Session, current: str | None
) -> dict[str, str | None]:
    """Pictures to choose from for a recording: its own and those that were sent; paths by label."""
    choices: dict[str, str | None] = {}
    if current is not None:
        choices[PurePosixPath(current).name] = current
    for label, path in sent_pictures(space).items():
        relative = relative_path(path, session.folder)
        if relative != current:
            choices[label if label not in choices else f"{label} (sent)"] = relative
    return choices


def sent_pictures(space: Workspace) -> dict[str, Path]:
    """Videos, archives and the folder of single pictures that were sent, by label."""
    stored: Sequence[Stored] = list(space.stored.values())
    paths = {file.name: space.folder / file.place for file in stored if file.kind != "image"}
    images = [file for file in stored if file.kind == "image"]
    if images:
        paths[f"{IMAGES} ({len(images):,})"] = (space.folder / images[0].place).parent
    return paths
