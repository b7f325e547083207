"""Data page: send ground truth, systems and pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import streamlit as st
from streamlit.typing import UploadedFile

from nvcore.errors import InputError, NvcoreError
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.objects import Objects
from nvcore.wording import MOST_NAMED, listed
from ui.data.file_check import FileCheck, check_files, draw_file_check
from ui.data.form import OpeningForm, finish_form, forget_outcome
from ui.data.frames import FRAMES_HELP, FRAMES_LABEL, FrameList, check_frame_list, draw_frame_list
from ui.data.inputs import sent_pictures
from ui.data.missing_inputs import draw_reading
from ui.data.names import draw_recording, draw_system_name, proposed_names
from ui.data.objects import draw_objects
from ui.data.opening import try_to_open
from ui.data.pictures import ChosenPictures, draw_checked
from ui.data.recordings_table import (
    RECORDINGS_HELP,
    RECORDINGS_LABEL,
    RecordingsTable,
    check_recordings,
    draw_recordings,
)
from ui.session import state, store
from ui.session.opening import relative_path, with_uploaded_recordings
from ui.session.uploads import (
    ANNOTATION_FOLDERS,
    begin_form,
    new_upload,
    remove_pictures,
    store_annotations,
)
from ui.session.workspace import Workspace
from ui.shell.messages import error_text
from ui.streamlit_inside.types import DeltaGenerator
from ui.widgets.buttons import button
from ui.widgets.text import plain
from ui.widgets.upload import upload_pictures

PLACE: Final = "upload"
LABEL: Final = "Uploaded files"
MOST_SYSTEMS: Final = 20
_CHOSEN: Final = "upload_chosen"
_OPENED: Final = "upload_opened"
FILES_HELP: Final = (
    "One file, one file for each recording, or a ZIP archive. Any format that the command line "
    "reads, also packed (`.gz`, `.zst`, `.xz`, `.bz2`). Where all files have the same name "
    "(MOTChallenge's gt.txt), send the folders as a ZIP archive: the recordings are named after "
    "them."
)


@dataclass(frozen=True)
class _Field:
    """What the form says of one source, and the places on the page for more about it."""

    title: str
    slot: str
    files: list[UploadedFile]
    reading: dict[str, Any]
    below: DeltaGenerator
    beside: DeltaGenerator

    @property
    def ids(self) -> tuple[str, ...]:
        """Identify the content of the files."""
        return tuple(file.file_id for file in self.files)


@dataclass(frozen=True)
class StoredForm:
    """The files of the form on disk: paths relative to their folder, or what is wrong, by slot."""

    ids: tuple[tuple[str, ...], ...]
    folder: Path
    paths: Mapping[str, tuple[str, ...]]
    troubles: Mapping[str, str]

    def source(self, field: _Field) -> Source:
        """The files of a field.

        Raises
        ------
        InputError
            If they could not be stored.
        """
        if field.slot in self.troubles:
            raise InputError(self.troubles[field.slot])
        return Source(path=self.paths[field.slot], **field.reading)

    def known_paths(self, field: _Field) -> list[str]:
        """Paths as the sender knows them, without the folders that are added here."""
        n_own = 1 + len(ANNOTATION_FOLDERS.parts)
        return ["/".join(path.split("/")[n_own:]) for path in self.paths.get(field.slot, ())]


_changed = partial(forget_outcome, PLACE)


def draw() -> None:
    """The form; its button opens the comparison."""
    space = state.workspace()
    st.caption(
        "Files stay on this server only while this browser tab is open; nobody else sees them."
    )
    objects = draw_objects(PLACE, _changed)
    truth, systems = _draw_truth(), _draw_systems()
    table = _draw_single("the recordings", "recordings", RECORDINGS_LABEL, RECORDINGS_HELP)
    frame_list = _draw_single("the evaluated frames", "frames", FRAMES_LABEL, FRAMES_HELP)
    _tell_lost(space, [truth, *systems, table, frame_list])
    with st.container():  # spinners go here: what comes below keeps its place, and its uploads
        stored = _store(space, [truth, *systems, table, frame_list])
        truth_check = _check(stored, truth, None, objects)
        checks = [_check(stored, system, truth_check, objects) for system in systems]
    recordings = [] if truth_check is None else truth_check.recordings
    with truth.below:
        draw_file_check(truth_check)
    with truth.beside:
        recording = draw_recording(recordings, sent_pictures(space), place=PLACE, changed=_changed)
    names = _draw_names(stored, truth, systems, [*recordings, recording])
    for system, check in zip(systems, checks, strict=True):
        with system.below:
            draw_file_check(check, truth_check)
    with table.below:
        rows = _check_table(space, stored, table, [] if frame_list.files else recordings)
    with frame_list.below:
        frames = _check_list(stored, frame_list, recordings)
    pictures = _draw_pictures(space, recordings)
    titles = [field.title for field in (truth, *systems)]
    checks_by_title = dict(zip(titles, [truth_check, *checks], strict=True))
    form = finish_form(PLACE, names, recording, frames, rows, pictures, checks_by_title, objects)
    with st.container(horizontal=True):
        if button("Open these files", key="open_upload", type="primary"):
            try_to_open(lambda: _session(truth, systems, stored, form), label=LABEL, place=PLACE)
        if any(stored.ids) or sent_pictures(space):
            st.button("Empty the form", key="empty_upload", on_click=_empty, args=(space,))


def has_lost(space: Workspace) -> bool:
    """Whether files were chosen and not opened before the page was loaded again."""
    return _CHOSEN in space.notes and not store.UPLOAD_CHOSEN.get()


def _key(name: str) -> str:
    """Key of a widget of the form; each form has its own."""
    form = state.workspace().form
    return f"{name}_{form}" if form else name


def _empty(space: Workspace) -> None:
    begin_form(space)
    for name in (_OPENED, _CHOSEN):
        space.notes.pop(name, None)
    store.UPLOAD_CHOSEN.pop()
    _changed()


def _tell_lost(space: Workspace, fields: Sequence[_Field]) -> None:
    """Say which chosen files a reload has dropped: browsers do not give them back.

    A form that is empty after something was opened from it is a new one.
    """
    names = [file.name for field in fields for file in field.files]
    ids = tuple(field.ids for field in fields)
    if names:
        store.UPLOAD_CHOSEN.set(True)
        if space.notes.get(_OPENED) != ids:
            space.notes[_CHOSEN] = names
    elif space.notes.pop(_OPENED, None) is not None:  # what was sent then has been opened
        begin_form(space)
    elif store.UPLOAD_CHOSEN.get():
        space.notes.pop(_CHOSEN, None)
    elif lost := space.notes.get(_CHOSEN):
        st.info(
            f"Before this page was loaded again, {plain(listed(lost, most=MOST_NAMED))} "
            f"{'was' if len(lost) == 1 else 'were'} chosen here and not opened yet: choose again.",
            icon=":material/refresh:",
        )


def _draw_truth() -> _Field:
    left, right = st.columns([1, 3])
    expander = "How to read the ground truth"
    key = _key("upload_truth")
    return _Field("the ground truth", "truth", *_ask(right, "Ground truth", expander, key), left)


def _ask(
    column: DeltaGenerator, label: str, expander: str, key: str, role: Role = "truth"
) -> tuple[list[UploadedFile], dict[str, Any], DeltaGenerator]:
    """Files, how to read them, and the place between the two fields."""
    files = column.file_uploader(
        label, accept_multiple_files=True, key=key, help=FILES_HELP, on_change=_changed
    )
    below = column.container()
    with column.expander(expander):
        return files, draw_reading(role, key, _changed), below


def _draw_systems() -> list[_Field]:
    n_systems = store.UPLOAD_SYSTEMS.get()
    systems = []
    for number in range(n_systems):
        left, right = st.columns([1, 3])
        title, expander = (
            f"system {number + 1}{({0: ' (X)', 1: ' (Y)'}).get(number, '')}",
            f"How to read system {number + 1}",
        )
        key = _key(f"upload_system_{number}")
        answers = _ask(right, f"Detections of {title}", expander, key, "detections")
        systems.append(_Field(title, f"system-{number + 1}", *answers, left))
    st.button(
        "Add a system",
        icon=":material/add:",
        key="add_system",
        on_click=_add_system,
        disabled=n_systems >= MOST_SYSTEMS,
    )
    return systems


def _draw_single(title: str, slot: str, label: str, help_text: str) -> _Field:
    """A field for a file of its own kind, which needs no reader."""
    _, right = st.columns([1, 3])
    file = right.file_uploader(
        label, key=_key(f"upload_{slot}"), help=help_text, on_change=_changed
    )
    files = [] if file is None else [file]
    return _Field(title, slot, files, {}, right.container(), right)


def _check_table(
    space: Workspace, stored: StoredForm, table: _Field, recordings: Sequence[str]
) -> RecordingsTable:
    if not table.files:
        return RecordingsTable()
    if table.slot in stored.troubles:
        return draw_recordings(RecordingsTable(trouble=stored.troubles[table.slot]))
    (path,) = stored.paths[table.slot]
    sent = [path.name for path in space.sent]
    return draw_recordings(check_recordings(path, stored.folder), recordings, sent)


def _check_list(stored: StoredForm, frame_list: _Field, recordings: Sequence[str]) -> FrameList:
    if not frame_list.files:
        return FrameList()
    if frame_list.slot in stored.troubles:
        return draw_frame_list(FrameList(trouble=stored.troubles[frame_list.slot]), recordings)
    (path,) = stored.paths[frame_list.slot]
    return draw_frame_list(check_frame_list(path, stored.folder), recordings)


def _draw_names(
    stored: StoredForm, truth: _Field, systems: Sequence[_Field], recordings: Sequence[str]
) -> list[str]:
    proposed = proposed_names(
        [stored.known_paths(system) for system in systems], stored.known_paths(truth), recordings
    )
    names = []
    for number, (system, name) in enumerate(zip(systems, proposed, strict=True)):
        key = _key(f"upload_name_{number}")
        with system.beside:
            names.append(
                draw_system_name(system.title, name, number + 1, key=key, changed=_changed)
            )
    return names


def _add_system() -> None:
    store.UPLOAD_SYSTEMS.set(store.UPLOAD_SYSTEMS.get() + 1)


def _draw_pictures(space: Workspace, recordings: Sequence[str]) -> ChosenPictures:
    st.markdown("Pictures (not needed for the numbers)")
    refused = upload_pictures(space, key=_key("upload_pictures"))
    sent = sent_pictures(space)
    if sent:
        left, right = st.columns([4, 1], vertical_alignment="center")
        left.caption(f"Here: {plain(', '.join(sent))}")
        right.button(
            "Remove all",
            key="remove_pictures",
            on_click=remove_pictures,
            args=(space, [key for key, file in space.stored.items() if file.form == space.form]),
            width="stretch",
        )
    return draw_checked(PLACE, sent, recordings, refused)


def _store(space: Workspace, fields: Sequence[_Field]) -> StoredForm:
    """The files on disk; written again only where other files were chosen."""
    ids = tuple(field.ids for field in fields)
    before = store.UPLOAD_STORED.get()
    is_same = before is not None and before.ids == ids and before.folder.is_dir()
    if before is not None and is_same and not before.troubles:  # there may be room by now
        return before
    if not any(ids):
        return StoredForm(ids, space.folder, {}, {})
    folder = new_upload(space)
    paths, troubles = {}, {}
    with st.spinner("Storing the files"):
        for field in fields:
            if not field.files:
                continue
            try:
                _refuse_equal_names(field.files)
                paths[field.slot] = store_annotations(space, folder, field.slot, field.files)
            except NvcoreError as error:
                troubles[field.slot] = error_text(error)
    stored = StoredForm(ids, folder, paths, troubles)
    store.UPLOAD_STORED.set(stored)
    return stored


def _refuse_equal_names(files: Sequence[UploadedFile]) -> None:
    """Raise InputError for files of one field that have the same name: browsers send no folders."""
    counts = Counter(file.name for file in files)
    name, n = counts.most_common(1)[0]
    if n > 1:
        raise InputError(
            f"{n} files are called {name}, and cannot be told apart: recordings are named after "
            "their folders, which are not sent along. Send a ZIP archive with the folders, such as "
            f"TUD-Campus/gt/{name}"
        )


def _check(
    stored: StoredForm, field: _Field, truth: FileCheck | None, objects: Objects
) -> FileCheck | None:
    if not field.files:
        return None
    role: Role = "truth" if field.slot == "truth" else "detections"
    key = (field.ids, repr(field.reading), stored.troubles.get(field.slot), role)
    return check_files(
        key,
        lambda: stored.source(field),
        role=role,
        folder=stored.folder,
        truth=truth,
        objects=objects,
    )


def _session(
    truth: _Field, systems: Sequence[_Field], stored: StoredForm, form: OpeningForm
) -> Session:
    sent = [pair for pair in zip(systems, form.names, strict=True) if pair[0].files]
    form.check(has_truth=bool(truth.files), has_systems=bool(sent))
    notes = state.workspace().notes
    notes[_OPENED] = stored.ids
    notes.pop(_CHOSEN, None)
    sources = tuple(
        SystemSource(path=stored.paths[system.slot], name=name or None, **system.reading)
        for system, name in sent
    )
    session = form.session(stored.folder, stored.source(truth), sources)
    session = with_uploaded_recordings(session, state.workspace().sent)
    pictures = form.pictures.usable.items()
    return form.with_pictures(
        session, {label: relative_path(path, stored.folder) for label, path in pictures}
    )
