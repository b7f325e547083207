"""Data page: open files below the folder that the app was started with."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.wording import count_text
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session, Source
from ui.access.files import Entry, LocalRoot, check_confined
from ui.confined.reading import find_confined, session_confined, with_recordings_confined
from ui.session import store
from ui.views.data.form import draw_form
from ui.views.data.form_session import Chosen, Place
from ui.views.data.missing_inputs import MissingInputs, ask_for_missing
from ui.views.data.opening import draw_trouble, forget_outcome, try_to_open
from ui.widgets.buttons import button
from ui.widgets.text import plain

PLACE: Final = "local"
SESSION: Final = "local_session"
TOP: Final = "(top folder)"
UP: Final = ".."
PATTERN: Final = "Choose, or type a pattern such as */{}"
_session_changed = partial(forget_outcome, SESSION)


@dataclass
class LocalFiles(Place):
    """Files and folders below the local root. One folder is listed at a time."""

    root: LocalRoot
    patterns: tuple[list[str], list[str]]
    entries: Sequence[Entry]

    def choose(
        self, slot: str, label: str, *, help_text: str | None = None, most: int | None = None
    ) -> Chosen:
        """Draw a field for files, folders and patterns. Those of other folders stay chosen."""
        options = [entry.path for entry in self.entries if not (most == 1 and entry.is_folder)]
        if most is None:
            options = [*self.patterns[0], *options]
        more = {"max_selections": most, "help": help_text}
        paths = self._select(slot, label, options, on_change=forget_outcome, args=(PLACE,), **more)
        try:
            files = tuple(chain(*map(self.root.matches, paths)))
        except InputError as error:
            return Chosen(self.root.folder, trouble=str(error))
        return Chosen(self.root.folder, files, known_as=tuple(paths), content=files)

    def _select(self, slot: str, label: str, options: Sequence[str], **more: Any) -> list[str]:
        key = self.key(slot)
        chosen: list[str] = store.widget(key, []).get()
        options = [*chosen, *(path for path in options if path not in chosen)]
        if more.get("max_selections") is None:
            example = "img1" if slot == "pictures" else "gt/gt.txt"
            more |= {"accept_new_options": True, "placeholder": PATTERN.format(example)}
        return st.multiselect(label, options, key=key, **more)

    def content(self, chosen: Chosen, source: Source, role: Role) -> Hashable:
        """Return a key that changes when a file does: a folder does not when one in it is edited.

        It includes files that are read along: seqinfo.ini beside those of MOTChallenge or up to
        two folders above.
        """
        check_confined(Session(chosen.folder, source, ()), chosen.folder)
        files = find_confined(source, chosen.folder, role).paths
        folders = {folder for file in files for folder in file.parents[:3]}
        beside = [folder / "seqinfo.ini" for folder in sorted(folders)]
        states = []
        for file in (*files, *(path for path in beside if path.is_relative_to(chosen.folder))):
            try:
                status = file.stat()
            except OSError:  # reported when it is read
                continue
            states.append((str(file), status.st_mtime_ns, status.st_size))
        return (chosen.content, *states)

    def choose_pictures(self) -> tuple[dict[str, Path], list[str]]:
        """Draw the field for pictures."""
        places: dict[str, Path] = {}
        missing = []
        paths = [*self.patterns[1], *(entry.path for entry in self.entries)]
        for path in self._select("pictures", "Pictures", paths):
            try:
                places |= {name: self.root.find(name) for name in self.root.matches(path)}
            except InputError as error:
                missing.append(str(error))
        return places, missing

    def finished(self, session: Session) -> Session:
        """Read the session's table of recordings. Nothing that it names leaves the root."""
        return _with_recordings(self.root, session)


def draw(root: LocalRoot) -> None:
    """Draw a folder to browse, and the form for the files taken from it."""
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
    label = f"Files in {path}" if path else "Local files"
    draw_form(LocalFiles(PLACE, label, root, root.patterns(path), entries))


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


def _last(path: str) -> str:
    return path.rpartition("/")[2]


def _session_file(root: LocalRoot, path: str, facts: MissingInputs) -> Session:
    return _with_recordings(root, facts.added_to(session_confined(root.find(path))))


def _with_recordings(root: LocalRoot, session: Session) -> Session:
    """Read the session's table of recordings. Nothing that it names leaves the root."""
    check_confined(session, root.folder)
    session = with_recordings_confined(session)
    check_confined(session, root.folder)
    return session
