"""Data page: open files below the folder that the app was started with."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.errors import InputError
from nvcore.session import Session, Source, SystemSource
from nvcore.session_file import read_session
from ui.data_facts import Facts, draw_facts, forget_facts
from ui.data_opening import draw_trouble, forget_trouble, try_to_open
from ui.local_files import Entry, LocalRoot
from ui.opening import check_confined, guess_pictures, recording_names, with_recordings
from ui.text import plain

PLACE: Final = "local"
SESSION: Final = "local_session"
TOP: Final = "(top folder)"
UP: Final = ".."
ROLES: Final = {
    "local_truth": "Ground truth",
    "local_x": "System X",
    "local_y": "System Y",
    "local_pictures": "Pictures",
}


def draw(root: LocalRoot) -> None:
    """A folder to look into, and what to take from it."""
    here = st.session_state.setdefault("local_folder", "")
    try:
        entries = root.entries(here)
    except InputError as error:
        st.warning(plain(str(error)), icon=":material/warning:")
        here, entries = "", root.entries()
        st.session_state["local_folder"] = here
    _draw_folder(here, entries)
    _draw_session(root, entries)
    st.markdown("**Or choose files and folders**, here and in other folders:")
    chosen = {key: _draw_role(key, title, entries) for key, title in ROLES.items()}
    draw_trouble(PLACE)
    facts = draw_facts(PLACE, [root.find(path) for path in chosen["local_pictures"]])
    if st.button("Open these files", key="open_local", type="primary"):
        try_to_open(
            lambda: _session(root, chosen, facts), label=f"Files in {here or TOP}", place=PLACE
        )


def _draw_folder(here: str, entries: list[Entry]) -> None:
    folders = [entry.path for entry in entries if entry.is_folder]
    st.selectbox(
        f"Folder: {plain(here) or TOP}",
        [*([UP] if here else []), *folders],
        index=None,
        key="local_next",
        placeholder=f"{len(folders)} folders, {len(entries) - len(folders)} files; go to a folder",
        format_func=lambda path: "one up" if path == UP else path.rpartition("/")[2] + "/",
        on_change=_go,
    )


def _go() -> None:
    here, chosen = st.session_state["local_folder"], st.session_state["local_next"]
    if chosen is not None:
        st.session_state["local_folder"] = here.rpartition("/")[0] if chosen == UP else chosen
        _session_changed()
    st.session_state["local_next"] = None


def _draw_session(root: LocalRoot, entries: list[Entry]) -> None:
    files = [entry.path for entry in entries if entry.path.lower().endswith(".toml")]
    if not files:
        return
    left, right = st.columns([4, 1], vertical_alignment="bottom")
    file = left.selectbox(
        "Session file", files, format_func=_last, key="local_session", on_change=_session_changed
    )
    is_wanted = right.button("Open session", key="open_local_session", width="stretch")
    draw_trouble(SESSION)
    facts = draw_facts(SESSION, [])
    if is_wanted:
        try_to_open(lambda: _session_file(root, file, facts), label=_last(file), place=SESSION)


def _session_changed() -> None:
    forget_trouble(SESSION)
    forget_facts(SESSION)


def _draw_role(key: str, title: str, entries: list[Entry]) -> list[str]:
    """Files and folders of one role; what was chosen in other folders stays chosen."""
    before: list[str] = st.session_state.get(key, [])
    options = [*before, *(entry.path for entry in entries if entry.path not in before)]
    return st.multiselect(title, options, key=key, on_change=_changed)


def _changed() -> None:
    forget_trouble(PLACE)
    forget_facts(PLACE)


def _last(path: str) -> str:
    return path.rpartition("/")[2]


def _session_file(root: LocalRoot, path: str, facts: Facts) -> Session:
    session = facts.added_to(read_session(root.find(path)))
    check_confined(session, root.folder)
    return session


def _session(root: LocalRoot, chosen: dict[str, list[str]], facts: Facts) -> Session:
    if not chosen["local_truth"]:
        raise InputError("Choose the ground truth first: the boxes that both systems should find.")
    systems = [chosen[key] for key in ("local_x", "local_y") if chosen[key]]
    if not systems:
        raise InputError("Choose the detections of at least one system.")
    session = facts.session(
        folder=root.folder,
        truth=Source(path=tuple(chosen["local_truth"])),
        systems=tuple(SystemSource(path=tuple(paths)) for paths in systems),
    )
    check_confined(session, root.folder)
    pictures = {Path(path).name: path for path in chosen["local_pictures"]}
    if pictures:
        names = recording_names(session)
        whose = guess_pictures(names, pictures)
        changes = {name: {"pictures": pictures[label]} for name, label in whose.items()}
        session = with_recordings(session, names, changes)
        check_confined(session, root.folder)
    return session
