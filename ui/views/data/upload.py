"""Data page: send ground truth, systems and pictures."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import streamlit as st
from streamlit.typing import UploadedFile

from nvcore.common.errors import NvcoreError
from nvcore.common.wording import MOST_NAMED, listed
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session, Source
from ui.session import state, store
from ui.session.opening import with_uploaded_recordings
from ui.session.uploads import (
    ANNOTATION_FOLDERS,
    begin_form,
    refuse_equal_names,
    remove_pictures,
    store_in_form,
)
from ui.session.workspace import Workspace
from ui.shell.messages import error_text
from ui.views.data.form import draw_form
from ui.views.data.form_session import Chosen, Place
from ui.views.data.inputs import sent_pictures
from ui.views.data.opening import forget_outcome
from ui.widgets.text import plain
from ui.widgets.upload import upload_pictures

PLACE: Final = "upload"
_CHOSEN: Final = "upload_chosen"
_OPENED: Final = "upload_opened"


@dataclass(frozen=True)
class OpenedFrom:
    """Section of the form from which files were last opened, with its fields and their files."""

    section: str
    keys: tuple[str, ...]
    ids: tuple[str, ...]


@dataclass
class Uploads(Place):
    """Uploaded files of the form that is being filled in."""

    space: Workspace
    files: dict[str, list[UploadedFile]] = field(default_factory=dict)
    """The files of each field, by its key."""

    @property
    def all_files(self) -> list[UploadedFile]:
        """The files of all fields."""
        return [file for files in self.files.values() for file in files]

    def begin(self, section: str) -> None:
        """Begin a section. Begin a new form if the files opened last are no longer in their fields.

        This must happen before any field is drawn, because a redrawn field loses its files.
        """
        super().begin(section)
        opened: OpenedFrom | None = self.space.notes.get(_OPENED)
        if opened is not None and (
            opened.section != section
            or not any(store.widget(key, None).get() for key in opened.keys)
        ):
            self.space.notes.pop(_OPENED)
            begin_form(self.space)

    def key(self, slot: str) -> str:
        """Return the key of a field. Each form has its own."""
        form = self.space.form
        return f"{super().key(slot)}_{form}" if form else super().key(slot)

    def choose(
        self, slot: str, label: str, *, help_text: str | None = None, most: int | None = None
    ) -> Chosen:
        """Draw a field for files. They are stored again only if others were chosen."""
        key = self.key(slot)
        sent = st.file_uploader(
            label,
            accept_multiple_files=most != 1,
            key=key,
            help=help_text,
            on_change=forget_outcome,
            args=(PLACE,),
        )
        files = sent if isinstance(sent, list) else [] if sent is None else [sent]
        self.files[key] = files
        with st.container():  # spinners go here: fields below keep their place, and their files
            return self._stored(slot, key, files)

    def _stored(self, slot: str, key: str, files: Sequence[UploadedFile]) -> Chosen:
        kept, ids = store.UPLOADED.of(key), _ids(files)
        chosen = kept.get()
        if chosen is None or chosen.content != ids or not chosen.is_there:
            chosen = Chosen(self.space.folder)
            if files:
                with st.spinner("Storing the files"):
                    chosen = self._store(slot, files)
            kept.set(chosen)
        return chosen

    def _store(self, slot: str, files: Sequence[UploadedFile]) -> Chosen:
        try:
            refuse_equal_names(files)
            folder, paths = store_in_form(self.space, slot, files)
        except NvcoreError as error:
            return Chosen(self.space.folder, trouble=error_text(error))
        n_own = 1 + len(ANNOTATION_FOLDERS.parts)
        known_as = tuple("/".join(path.split("/")[n_own:]) for path in paths)
        return Chosen(folder, paths, known_as=known_as, content=_ids(files))

    def content(self, chosen: Chosen, _source: Source, _role: Role) -> Hashable:
        """Return a key that identifies the content of a field's files."""
        return chosen.content

    def choose_pictures(self) -> tuple[dict[str, Path], list[str]]:
        """Draw the field for pictures."""
        refused = upload_pictures(self.space, key=self.key("pictures"))
        sent = sent_pictures(self.space)
        if sent:
            left, right = st.columns([4, 1], vertical_alignment="center")
            left.caption(f"Here: {plain(', '.join(sent))}")
            stored = self.space.stored.items()
            own = [key for key, file in stored if file.form == self.space.form]
            right.button(
                "Remove all",
                key="remove_pictures",
                on_click=remove_pictures,
                args=(self.space, own),
                width="stretch",
            )
        return sent, refused

    def finished(self, session: Session) -> Session:
        """Read the session's table of recordings, which may name only pictures that were sent."""
        return with_uploaded_recordings(session, self.space.sent)

    def take(self) -> None:
        """Remember that the files are being opened."""
        keys = tuple(key for key, files in self.files.items() if files)
        self.space.notes[_OPENED] = OpenedFrom(self.section, keys, _ids(self.all_files))
        self.space.notes.pop(_CHOSEN, None)


def draw() -> None:
    """Draw the form for uploads."""
    space = state.workspace()
    st.caption(
        "Files stay on this server only while this browser tab is open; nobody else sees them."
    )
    lost, uploads = st.container(), Uploads(PLACE, "Uploaded files", space)
    draw_form(uploads)
    with lost:
        _tell_lost(uploads)
    if uploads.all_files or sent_pictures(space):
        st.button("Empty the form", key="empty_upload", on_click=_empty, args=(space,))


def _ids(files: Sequence[UploadedFile]) -> tuple[str, ...]:
    """Return keys that identify the content of files."""
    return tuple(file.file_id for file in files)


def has_lost(space: Workspace) -> bool:
    """Whether files were chosen and not opened before the page was loaded again."""
    return _CHOSEN in space.notes and not store.UPLOAD_CHOSEN.get()


def _empty(space: Workspace) -> None:
    begin_form(space)
    for name in (_OPENED, _CHOSEN):
        space.notes.pop(name, None)
    store.UPLOAD_CHOSEN.pop()
    forget_outcome(PLACE)


def _tell_lost(uploads: Uploads) -> None:
    """Name the chosen files that a reload has dropped, since browsers do not restore them."""
    notes, files = uploads.space.notes, uploads.all_files
    if files:
        store.UPLOAD_CHOSEN.set(True)
        opened: OpenedFrom | None = notes.get(_OPENED)
        if opened is None or opened.ids != _ids(files):
            notes[_CHOSEN] = [file.name for file in files]
    elif store.UPLOAD_CHOSEN.get():
        notes.pop(_CHOSEN, None)
    elif lost := notes.get(_CHOSEN):
        st.info(
            f"Before this page was loaded again, {plain(listed(lost, most=MOST_NAMED))} "
            f"{'was' if len(lost) == 1 else 'were'} chosen here and not opened yet: choose again.",
            icon=":material/refresh:",
        )
