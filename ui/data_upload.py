"""Data page: send ground truth, systems and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import streamlit as st
from streamlit.runtime.uploaded_file_manager import UploadedFile

from nvcore.errors import InputError
from nvcore.session import Session, Source, SystemSource
from ui import state
from ui.data_facts import Facts, draw_facts, draw_reading, forget_facts
from ui.data_inputs import sent_pictures
from ui.data_opening import draw_trouble, forget_trouble, try_to_open
from ui.opening import guess_pictures, recording_names, relative_path, with_recordings
from ui.text import plain
from ui.upload_component import upload_pictures
from ui.uploads import new_upload, remove_pictures, store_annotations
from ui.workspace import Workspace

PLACE: Final = "upload"
LABEL: Final = "Uploaded files"
MOST_SYSTEMS: Final = 20
FILES_HELP: Final = (
    "One file, one file for each recording, or a ZIP archive. Any format that the command line "
    "reads. Where all files have the same name (MOTChallenge's gt.txt), send the folders as a ZIP "
    "archive: the recordings are named after them."
)


@dataclass(frozen=True)
class _Chosen:
    """What the form says of one source."""

    files: list[UploadedFile]
    reading: dict[str, Any]
    name: str = ""


def draw() -> None:
    """The form; its button opens the comparison."""
    space = state.workspace()
    st.caption(
        "Files stay on this server only while this browser tab is open; nobody else sees them."
    )
    truth = _draw_truth()
    systems = _draw_systems()
    _draw_pictures(space)
    draw_trouble(PLACE)
    facts = draw_facts(PLACE, sent_pictures(space).values())
    if st.button("Open these files", key="open_upload", type="primary"):
        try_to_open(lambda: _session(space, truth, systems, facts), label=LABEL, place=PLACE)


def _changed() -> None:
    forget_trouble(PLACE)
    forget_facts(PLACE)


def _draw_truth() -> _Chosen:
    files = st.file_uploader(
        "Ground truth", accept_multiple_files=True, key="upload_truth", help=FILES_HELP,
        on_change=_changed,
    )  # fmt: skip
    with st.expander("How to read the ground truth"):
        reading = draw_reading("truth", "upload_truth", _changed)
    return _Chosen(files, reading)


def _draw_systems() -> list[_Chosen]:
    n_systems = st.session_state.setdefault("upload_systems", 2)
    found = []
    for number in range(n_systems):
        left, right = st.columns([1, 3])
        letter = {0: " (X)", 1: " (Y)"}.get(number, "")
        name = left.text_input(
            f"Name of system {number + 1}{letter}", key=f"upload_name_{number}",
            placeholder="as the file", on_change=_changed,
        )  # fmt: skip
        files = right.file_uploader(
            f"Detections of system {number + 1}{letter}", accept_multiple_files=True,
            key=f"upload_system_{number}", help=FILES_HELP, on_change=_changed,
        )  # fmt: skip
        with right.expander(f"How to read system {number + 1}"):
            reading = draw_reading("detections", f"upload_system_{number}", _changed)
        found.append(_Chosen(files, reading, name.strip()))
    st.button(
        "Add a system", icon=":material/add:", key="add_system", on_click=_add_system,
        disabled=n_systems >= MOST_SYSTEMS,
    )  # fmt: skip
    return found


def _add_system() -> None:
    st.session_state["upload_systems"] += 1


def _draw_pictures(space: Workspace) -> None:
    st.markdown("Pictures (not needed for the figures)")
    upload_pictures(space, key="upload_pictures")
    sent = sent_pictures(space)
    if not sent:
        return
    left, right = st.columns([4, 1], vertical_alignment="center")
    left.caption(f"Here: {plain(', '.join(sent))}")
    right.button(
        "Remove all", key="remove_pictures", on_click=_remove_all, args=(space,), width="stretch"
    )


def _remove_all(space: Workspace) -> None:
    remove_pictures(space, list(space.stored))


def _session(space: Workspace, truth: _Chosen, systems: list[_Chosen], facts: Facts) -> Session:
    given = [system for system in systems if system.files]
    if not truth.files:
        raise InputError("Choose the ground truth first: the boxes that both systems should find.")
    if not given:
        raise InputError("Choose the detections of at least one system.")
    with st.spinner("Storing the files"):
        folder = new_upload(space)
        truth_paths = store_annotations(space, folder, "truth", truth.files)
        system_paths = [
            store_annotations(space, folder, f"system-{number}", system.files)
            for number, system in enumerate(given, start=1)
        ]
    session = facts.session(
        folder=folder,
        truth=Source(path=truth_paths, **truth.reading),
        systems=tuple(
            SystemSource(path=paths, name=system.name or None, **system.reading)
            for system, paths in zip(given, system_paths, strict=True)
        ),
    )
    pictures = sent_pictures(space)
    if not pictures:
        return session
    with st.spinner("Reading the ground truth"):
        names = recording_names(session)
    whose = guess_pictures(names, pictures)
    changes = {
        name: {"pictures": relative_path(pictures[label], folder)} for name, label in whose.items()
    }
    return with_recordings(session, names, changes)
