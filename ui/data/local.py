"""Data page: open files below the folder that the app was started with."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.errors import InputError, NvcoreError
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.objects import Objects
from nvcore.wording import count_text
from ui.access.files import Entry, LocalRoot, check_confined
from ui.confined.reading import find_confined, session_confined, with_recordings_confined
from ui.data.file_check import FileCheck, check_files, draw_file_check
from ui.data.form import OpeningForm, finish_form, forget_outcome
from ui.data.frames import FRAMES_HELP, FRAMES_LABEL, FrameList, check_frame_list, draw_frame_list
from ui.data.missing_inputs import MissingInputs, ask_for_missing
from ui.data.names import draw_recording, draw_system_name, proposed_names
from ui.data.objects import draw_objects
from ui.data.opening import draw_trouble, try_to_open
from ui.data.pictures import draw_checked
from ui.data.recordings_table import (
    RECORDINGS_HELP,
    RECORDINGS_LABEL,
    RecordingsTable,
    check_recordings,
    draw_recordings,
)
from ui.session import store
from ui.shell.messages import error_text
from ui.widgets.buttons import button
from ui.widgets.text import plain

PLACE: Final = "local"
SESSION: Final = "local_session"
TOP: Final = "(top folder)"
UP: Final = ".."
ROLES: Final = {
    "local_truth": "Ground truth",
    "local_x": "System X",
    "local_y": "System Y",
    "local_recordings": RECORDINGS_LABEL,
    "local_frames": FRAMES_LABEL,
    "local_pictures": "Pictures (not needed for the numbers)",
}
SYSTEMS: Final = ("local_x", "local_y")
SOURCES: Final = ("local_truth", *SYSTEMS)

_changed = partial(forget_outcome, PLACE)
_session_changed = partial(forget_outcome, SESSION)


def draw(root: LocalRoot) -> None:
    """A folder to look into, and what to take from it."""
    path = store.LOCAL_FOLDER.get()
    try:
        entries = root.entries(path)
    except InputError as error:
        st.warning(plain(str(error)), icon=":material/warning:")
        path, entries = "", root.entries()
        store.LOCAL_FOLDER.set(path)
    _draw_folder(path, entries)
    _draw_session(root, entries)
    st.markdown("**Or choose files and folders**, here and in other folders:")
    paths_of, form = _draw_form(root, entries)
    if button("Open these files", key="open_local", type="primary"):
        try_to_open(
            lambda: _session(root, paths_of, form),
            label=f"Files in {path}" if path else "Local files",
            place=PLACE,
        )


def _draw_form(root: LocalRoot, entries: list[Entry]) -> tuple[dict[str, list[str]], OpeningForm]:
    paths_of: dict[str, list[str]] = {}
    checks: list[FileCheck | None] = []
    name_fields = []
    objects = draw_objects(PLACE, _changed)
    for key in SOURCES:
        left, right = st.columns([1, 3])
        with right:
            paths_of[key] = _draw_role(key, entries)
            truth = checks[0] if checks else None
            role: Role = "detections" if checks else "truth"
            check = _check(root, paths_of[key], truth, objects, role=role)
            draw_file_check(check, truth)
        name_fields.append(left)
        checks.append(check)
    recordings = [] if checks[0] is None else checks[0].recordings
    frames_are_listed = bool(store.widget("local_frames").get())
    table = _draw_table(root, entries, [] if frames_are_listed else recordings)
    frames = _draw_frame_list(root, entries, recordings)
    paths_of["local_pictures"] = _draw_role("local_pictures", entries)
    places, missing = _find(root, paths_of["local_pictures"])
    with name_fields[0]:
        recording = draw_recording(recordings, places, place=PLACE, changed=_changed)
    proposed = proposed_names(
        [paths_of[key] for key in SYSTEMS], paths_of["local_truth"], [*recordings, recording]
    )
    names = []
    for number, (key, name) in enumerate(zip(SYSTEMS, proposed, strict=True), start=1):
        with name_fields[number]:
            title = ROLES[key].replace("S", "s")
            names.append(draw_system_name(title, name, number, key=f"{key}_name", changed=_changed))
    pictures = draw_checked(PLACE, places, recordings, missing)
    titles = ["the ground truth", *(f"system {key[-1].upper()}" for key in SYSTEMS)]
    checks_by_title = dict(zip(titles, checks, strict=True))
    form = finish_form(PLACE, names, recording, frames, table, pictures, checks_by_title, objects)
    return paths_of, form


def _draw_table(
    root: LocalRoot, entries: list[Entry], recordings: Sequence[str]
) -> RecordingsTable:
    files = [entry for entry in entries if not entry.is_folder]
    paths = _draw_role("local_recordings", files, most=1, help_text=RECORDINGS_HELP)
    if not paths:
        return RecordingsTable()
    try:
        root.find(paths[0])
    except InputError as error:
        return draw_recordings(RecordingsTable(trouble=str(error)))
    return draw_recordings(check_recordings(paths[0], root.folder), recordings)


def _draw_frame_list(root: LocalRoot, entries: list[Entry], recordings: Sequence[str]) -> FrameList:
    files = [entry for entry in entries if not entry.is_folder]
    paths = _draw_role("local_frames", files, most=1, help_text=FRAMES_HELP)
    if not paths:
        return FrameList()
    try:
        root.find(paths[0])
    except InputError as error:
        return draw_frame_list(FrameList(trouble=str(error)), recordings)
    return draw_frame_list(check_frame_list(paths[0], root.folder), recordings)


def _find(root: LocalRoot, paths: Sequence[str]) -> tuple[dict[str, Path], list[str]]:
    """Where the paths lead, and what is wrong with those that no longer exist."""
    places, missing = {}, []
    for path in paths:
        try:
            places[path] = root.find(path)
        except InputError as error:
            missing.append(str(error))
    return places, missing


def _check(
    root: LocalRoot,
    paths: Sequence[str],
    truth: FileCheck | None,
    objects: Objects,
    *,
    role: Role,
) -> FileCheck | None:
    """What the chosen paths hold, read only if they stay below the root."""
    if not paths:
        return None

    source = Source(path=tuple(paths))
    try:
        for path in paths:
            root.find(path)
        check_confined(Session(root.folder, source, ()), root.folder)
        paths_read = find_confined(source, root.folder, role).paths
    except NvcoreError as error:
        return FileCheck(trouble=error_text(error))
    key = (*paths, role, _state_of(root, paths_read))
    return check_files(
        key, lambda: source, role=role, folder=root.folder, truth=truth, objects=objects
    )


def _state_of(root: LocalRoot, files: Sequence[Path]) -> tuple[tuple[str, int, int], ...]:
    """A key that changes when a file does: a folder does not when one in it is edited.

    Includes what is read with them: seqinfo.ini beside MOTChallenge's files or up to two folders
    above.
    """
    folders = {folder for file in files for folder in file.parents[:3]}
    beside = [folder / "seqinfo.ini" for folder in sorted(folders)]
    states = []
    for file in (*files, *(path for path in beside if path.is_relative_to(root.folder))):
        try:
            status = file.stat()
        except OSError:  # reported when it is read
            continue
        states.append((str(file), status.st_mtime_ns, status.st_size))
    return tuple(states)


def _draw_folder(current: str, entries: list[Entry]) -> None:
    folders = [entry.path for entry in entries if entry.is_folder]
    n_files = len(entries) - len(folders)
    st.selectbox(
        f"Folder: {plain(current) or TOP}",
        [*([UP] if current else []), *folders],
        index=None,
        key="local_next",
        placeholder=(
            f"{count_text(len(folders), 'folder')}, {count_text(n_files, 'file')}; go to a folder"
        ),
        format_func=lambda path: "one up" if path == UP else path.rpartition("/")[2] + "/",
        on_change=_go,
    )


def _go() -> None:
    path, entry = store.LOCAL_FOLDER.get(), store.LOCAL_NEXT.get()
    if entry is not None:
        store.LOCAL_FOLDER.set(path.rpartition("/")[0] if entry == UP else entry)
        _session_changed()
    store.LOCAL_NEXT.set(None)


def _draw_session(root: LocalRoot, entries: list[Entry]) -> None:
    files = [entry.path for entry in entries if entry.path.lower().endswith(".toml")]
    if not files:
        return
    left, right = st.columns([4, 1], vertical_alignment="bottom")
    file = left.selectbox(
        "Session file", files, format_func=_last, key="local_session", on_change=_session_changed
    )
    is_wanted = button("Open session", key="open_local_session", width="stretch", at=right)
    facts = ask_for_missing(SESSION, [])
    draw_trouble(SESSION)
    if is_wanted:
        try_to_open(lambda: _session_file(root, file, facts), label=_last(file), place=SESSION)


def _draw_role(
    key: str, entries: list[Entry], *, most: int | None = None, help_text: str | None = None
) -> list[str]:
    """Files and folders of one role; what was chosen in other folders stays chosen."""
    before: list[str] = store.widget(key, []).get()
    options = [*before, *(entry.path for entry in entries if entry.path not in before)]
    return st.multiselect(
        ROLES[key], options, key=key, on_change=_changed, max_selections=most, help=help_text
    )


def _last(path: str) -> str:
    return path.rpartition("/")[2]


def _session_file(root: LocalRoot, path: str, facts: MissingInputs) -> Session:
    session = facts.added_to(session_confined(root.find(path)))
    return _with_recordings(root, session)


def _with_recordings(root: LocalRoot, session: Session) -> Session:
    """The session with its table of recordings read; nothing that it names leaves the root."""
    check_confined(session, root.folder)
    session = with_recordings_confined(session)
    check_confined(session, root.folder)
    return session


def _session(root: LocalRoot, paths_of: dict[str, list[str]], form: OpeningForm) -> Session:
    systems = [
        SystemSource(path=tuple(paths_of[key]), name=name)
        for key, name in zip(SYSTEMS, form.names, strict=True)
        if paths_of[key]
    ]
    form.check(has_truth=bool(paths_of["local_truth"]), has_systems=bool(systems))
    truth = Source(path=tuple(paths_of["local_truth"]))
    session = _with_recordings(root, form.session(root.folder, truth, tuple(systems)))
    session = form.with_pictures(session, {Path(path).name: path for path in form.pictures.usable})
    check_confined(session, root.folder)
    return session
