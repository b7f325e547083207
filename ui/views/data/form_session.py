"""Data page: the new or changed session that the form describes."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from dataclasses import fields as dataclass_fields
from pathlib import Path, PurePosixPath
from typing import Any, Final, Literal

import numpy as np
import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.file_kinds import unpacked_name
from nvcore.common.wording import MOST_NAMED, listed
from nvcore.dataset import Dataset
from nvcore.inputs.facts import labelled_paths, with_paths_in, without_files_of_run
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.inputs.session.changes import stated_by_recording
from nvcore.settings.objects import Objects
from ui.access.files import safe_name
from ui.confined.reading import find_confined
from ui.session import state, store
from ui.session.opening import (
    guess_pictures,
    names_in_files,
    recording_entry,
    recording_names,
    with_recordings,
)
from ui.session.uploads import store_copy
from ui.session.workspace import Opened
from ui.streamlit_inside.types import DeltaGenerator
from ui.views.data.file_check import FileCheck
from ui.views.data.missing_inputs import MissingInputs
from ui.views.data.names import with_recording_name
from ui.views.data.recordings import NAMES
from ui.views.data.side_files import ChosenPictures, RecordingsTable

Purpose = Literal["new", "add", "replace"]
PURPOSES: Final[Mapping[Purpose, str]] = {
    "new": "Open by themselves",
    "add": "Add to what is open",
    "replace": "Replace files of what is open",
}


@dataclass(frozen=True)
class Chosen:
    """Files of a field, or why they cannot be used.

    Attributes
    ----------
    folder
        Folder that the paths start from.
    known_as
        Paths as shown to the visitor.
    content
        Changes when the files do.
    """

    folder: Path
    paths: tuple[str, ...] = ()
    trouble: str = ""
    known_as: tuple[str, ...] = ()
    content: Hashable = ()

    @property
    def is_empty(self) -> bool:
        """True if nothing was chosen."""
        return not (self.paths or self.trouble)

    @property
    def is_there(self) -> bool:
        """False if files were removed since."""
        return all((self.folder / path).exists() for path in self.paths)

    def paths_from(self, folder: Path) -> tuple[str, ...]:
        """Return the paths relative to another folder."""
        return tuple(_path_in(folder, self.folder / path) for path in self.paths)


@dataclass
class Place(ABC):
    """Place that files come from, such as an upload.

    Attributes
    ----------
    name
        Name of the form, with which the keys of its widgets begin.
    label
        Name of the session on the pages.
    """

    name: str
    label: str
    section: str = field(default="", init=False)

    def begin(self, section: str) -> None:
        """Begin a section, whose name is part of the keys of its fields.

        Each purpose and each open comparison has its own. Call this before any field is drawn.
        """
        self.section = section

    def key(self, slot: str) -> str:
        """Return the key of a field."""
        return f"{self.name}_{self.section}{slot}"

    @abstractmethod
    def choose(
        self, slot: str, label: str, *, help_text: str | None = None, most: int | None = None
    ) -> Chosen:
        """Draw a field for files and return those chosen."""

    @abstractmethod
    def content(self, chosen: Chosen, source: Source, role: Role) -> Hashable:
        """Return a key that changes when a source's files do.

        Raises
        ------
        NvcoreError
            If they cannot be found.
        """

    @abstractmethod
    def choose_pictures(self) -> tuple[dict[str, Path], list[str]]:
        """Draw the field for pictures. Return them by label, and why others are refused."""

    @abstractmethod
    def finished(self, session: Session) -> Session:
        """Read the session's table of recordings, without files that the visitor may not name."""

    def take(self) -> None:  # noqa: B027  # local files stay where they are
        """Remember that the chosen files are being opened."""


@dataclass(frozen=True)
class SourceField:
    """Field of ground truth or a system, and the places on the page for more about it.

    Attributes
    ----------
    title
        Name of the field in sentences.
    name
        Name of the system, if it is open already.
    reading
        Fields of `Source` that say how to read the files.
    own
        Further files of a system, by key of a ``[[system]]``.
    """

    title: str
    role: Role
    name: str
    chosen: Chosen
    reading: dict[str, Any]
    own: dict[str, Chosen]
    below: DeltaGenerator
    beside: DeltaGenerator
    check: FileCheck | None = None

    @property
    def stated(self) -> dict[str, Any]:
        """Settings for reading the files, without those left to the files (None)."""
        return {name: value for name, value in self.reading.items() if value is not None}


@dataclass(frozen=True)
class Form:
    """Choices and entries of a person, and the session that they describe.

    Attributes
    ----------
    opened
        Comparison that is changed. None if the files are opened by themselves.
    names
        Names of all systems.
    recordings
        Recordings of the ground truth chosen, else those open.
    recording
        Name of the only recording, or "".
    series
        Files by recording, by key of a ``[[recording]]``.
    """

    place: Place
    purpose: Purpose
    opened: Opened | None
    objects: Objects
    truth: SourceField
    systems: Sequence[SourceField]
    names: Sequence[str]
    recordings: Sequence[str]
    recording: str
    frames: Chosen
    table: RecordingsTable
    series: Mapping[str, Mapping[str, Path]]
    pictures: ChosenPictures
    facts: MissingInputs

    def session(self) -> Session:
        """Return the session.

        Raises
        ------
        NvcoreError
            If something needed is missing or cannot be used.
        """
        session = self._new() if self.opened is None else self._changed(self.opened)
        self.place.take()
        return session

    def _new(self) -> Session:
        if self.truth.chosen.is_empty:
            raise InputError(
                "Choose the ground truth first: the boxes that both systems should find."
            )
        if all(system.chosen.is_empty for system in self.systems):
            raise InputError("Choose the detections of at least one system.")
        self._refuse_wrong()
        folder = self.truth.chosen.folder
        session = Session(
            folder=folder,
            truth=Source(path=self.truth.chosen.paths, **self.truth.reading),
            systems=tuple(self._new_systems(folder)),
            frames=self._frames_from(folder),
            recordings_file=self.table.file,
            objects=self.objects,
        )
        session = self.place.finished(self.facts.added_to(session))
        more = (self.pictures.usable, self.recording, self.facts.sizes, *self.series.values())
        if not any(more):
            return session
        with st.spinner("Reading the ground truth"):
            names = recording_names(session)
        session = with_recordings(session, names, self._changes(session, names))
        return with_recording_name(session, names, self.recording)

    def _changed(self, opened: Opened) -> Session:
        """Return the open session with the choices of the form."""
        self._refuse_wrong()
        session = state.live_session()
        names, folder = opened.whole.recordings["name"].tolist(), session.folder
        added = []
        if not self.truth.chosen.is_empty:
            added = [name for name in self.recordings if name not in names]
            if self.purpose == "add":
                session = self._with_room(session, names)
        n_open = len(session.systems)
        systems = [
            replace(joined(source, new, folder, self.purpose), **_own_files(new, folder))
            for source, new in zip(session.systems, self.systems, strict=False)
        ]
        systems += self._new_systems(folder, n_open)
        truth = joined(session.truth, self.truth, folder, self.purpose)
        is_same = (truth, *systems) == (session.truth, *session.systems)
        sources = dict(zip(("truth", *opened.whole.systems), session.sources, strict=True))
        now = dict(zip(sources, (truth, *systems), strict=False))
        changed = replace(
            session,
            truth=truth,
            systems=tuple(systems),
            frames=self._frames_from(folder) or session.frames,
            only=(*session.only, *added) if session.only else (),
            recordings_file=None,
            hashes={
                name: text
                for name, text in session.hashes.items()
                if name in now and now[name] == sources[name][0]
            },
        )
        every = [*names, *added]
        changes = self._changes(changed, every)
        if is_same and not changes and not self.frames.paths:
            raise InputError("Choose the files to add, or those to take the place of others.")
        return with_recordings(changed, every, changes)

    def _frames_from(self, folder: Path) -> str | None:
        return next(iter(self.frames.paths_from(folder)), None)

    def _new_systems(self, folder: Path, n_open: int = 0) -> list[SystemSource]:
        """Return the systems with files behind those that are open."""
        return [
            SystemSource(
                path=new.chosen.paths_from(folder),
                name=name or None,
                **new.reading,
                **_own_files(new, folder),
            )
            for new, name in zip(self.systems[n_open:], self.names[n_open:], strict=True)
            if not new.chosen.is_empty
        ]

    def _with_room(self, session: Session, names: list[str]) -> Session:
        """Return the session ready for further recordings.

        Raises
        ------
        InputError
            If one of them is open already, or a system has no detections for them.
        """
        in_files = recording_names(session) if len(names) == 1 else None
        session = stated_by_recording(session, names, in_files)
        if in_files is not None:  # files of the only recording need not be named after it
            systems = [
                _named_after(source, session.folder, *in_files, slot=f"named_{number}")
                for number, source in enumerate(session.systems)
            ]
            session = replace(session, systems=tuple(systems))
        known = {*names, *(entry.name for entry in session.recordings)}
        if again := [name for name in self.recordings if name in known]:
            raise InputError(
                f"{listed(again)} {'is' if len(again) == 1 else 'are'} open already. To put the "
                f"file in the place of the one before, choose “{PURPOSES['replace']}”."
            )
        without = [system.name for system in self.systems if system.name and system.chosen.is_empty]
        if without:
            raise InputError(
                f"Choose the detections of {listed(without)} as well: without them "
                f"{self.objects.plural} in the added recordings count as missed."
            )
        return session

    def check(self, dataset: Dataset) -> None:
        """Refuse data in which boxes that are open now are gone. Ask once if files are replaced.

        Raises
        ------
        InputError
            With the sources and recordings.
        """
        if self.opened is None:
            return
        whole, is_added = self.opened.whole, self.purpose == "add"
        names = names_in_files(self.opened.session, whole)
        then = _n_boxes(dataset, {name: name for name in dataset.recordings["name"]})
        assert isinstance(dataset.settings, Session)
        then |= _n_boxes(dataset, names_in_files(dataset.settings, dataset))
        lost = [
            (source, name)
            for (source, name), n in _n_boxes(whole, {name: name for name in names}).items()
            if max(then.get((source, of), 0) for of in (name, names[name])) < (n if is_added else 1)
        ]
        if not lost:
            return
        words = listed([f"{source} in {name}" for source, name in lost], most=MOST_NAMED)
        if is_added:
            raise InputError(
                f"Boxes would be lost: {words}. Name each file after its recording, and open all "
                "of them by themselves."
            )
        self._ask_once(
            f"No box would be left: {words}. If this is meant, press the button once more. "
            "Else choose all files of that source, or those with the names of the ones before."
        )

    def _ask_once(self, question: str) -> None:
        """Raise InputError with a question, unless it was asked before."""
        asked = store.ASKED_ONCE.of(self.place.name)
        if question not in asked.get():
            asked.set(asked.get() | {question})
            raise InputError(question)

    @property
    def words(self) -> str:
        """Message after opening: names of added or replaced inputs."""
        if self.opened is None:
            return ""
        chosen = [
            (system, name)
            for system, name in zip(self.systems, self.names, strict=True)
            if not system.chosen.is_empty
        ]
        if self.purpose == "add":
            known = {*self.opened.whole.recordings["name"], *titles_by_name(self.opened)}
            parts = [name for system, name in chosen if not system.name]
            if not self.truth.chosen.is_empty:
                parts += [name for name in self.recordings if name not in known]
            return f"Added: {listed(parts, most=MOST_NAMED)}." if parts else ""
        parts = [f"{name} (by {_file_names(system.chosen)})" for system, name in chosen]
        keeps = f" Names stay: see “{NAMES}”." if parts else ""
        parts += [] if self.truth.chosen.is_empty else ["ground truth"]
        return f"Replaced: {listed(parts, most=MOST_NAMED)}.{keeps}" if parts else ""

    def field_of(self, file: str) -> str:
        """Return the title of the field of a file that is read only with the session, or "".

        Paths start from the folder of the session.
        """
        titles = {
            path: labelled_paths(RecordingEntry)[key].partition(" (")[0]
            for key, path_of in self.series.items()
            for path in path_of.values()
        } | {
            chosen.folder / path: f"{system.title}, {label[:1].lower()}{label[1:]}"
            for system in self.systems
            for key, chosen in system.own.items()
            for label in [labelled_paths(SystemSource)[key].partition(" (")[0]]
            for path in chosen.paths
        }
        folder = self.truth.chosen.folder if self.opened is None else self.opened.session.folder
        return titles.get(Path(os.path.normpath(folder / file)), "")

    def _refuse_wrong(self) -> None:
        reasons = "cannot be used: the reason stands"
        fields = (self.truth, *self.systems)
        bad = [source.title for source in fields if source.check and source.check.trouble]
        where = "its field" if len(bad) == 1 else "their fields"
        own = [file for system in self.systems for file in system.own.values()]
        for wrong in (
            bad and f"The files of {' and '.join(bad)} {reasons} at {where}.",
            *(file.trouble for file in own),
            self._overlap(),
            self.frames.trouble and f"The list of evaluated frames {reasons} at its field.",
            self.table.trouble and f"The table of recordings {reasons} at its field.",
            self.pictures.stops,
        ):
            if wrong:
                raise InputError(wrong)
        unnamed = [
            name
            for number, (system, name) in enumerate(zip(self.systems, self.names, strict=True), 1)
            if system.check is not None and name == f"System {number}"
        ]
        if unnamed:
            self._ask_once(
                f"The files' names do not tell what {listed(unnamed)} "
                f"{'is' if len(unnamed) == 1 else 'are'}: type the names of the systems. "
                "Or open once more to go on with these."
            )

    def _overlap(self) -> str:
        """Say which added detections belong to recordings in which their system has some."""
        if self.opened is None or self.purpose != "add":
            return ""
        whole, title_of = self.opened.whole, titles_by_name(self.opened)
        names = whole.recordings["name"].tolist()
        for system in self.systems:
            if not system.name or system.check is None:
                continue
            rows = whole.system(system.name).frame_index
            own = {names[number] for number in np.unique(whole.frame_columns.recording[rows])}
            twice = sorted(own & {title_of.get(name, name) for name in system.check.boxed})
            if twice:
                return (
                    f"{system.name} has detections in {listed(twice)} already. To put the file in "
                    f"the place of the one before, choose “{PURPOSES['replace']}”."
                )
        return ""

    def _changes(self, session: Session, names: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Return fields of `RecordingEntry` to be changed, by recording.

        Pictures that the session states stay, if its files are opened by themselves.
        """
        paths = {
            label: _path_in(session.folder, path) for label, path in self.pictures.usable.items()
        }
        changes: dict[str, dict[str, Any]] = {name: {} for name in names}
        if self.opened is not None:
            for name in [] if self.truth.chosen.is_empty else self.recordings:
                changes[name] |= self.facts.of_recording
        for name, (width, height) in self.facts.sizes.items():
            if name in changes and recording_entry(session, names, name).width is None:
                changes[name] |= {"width": width, "height": height}
        if self.opened is not None:
            title_of = titles_by_name(self.opened)
            for name, row in self.table.entries.items():
                own = name if name in changes else title_of.get(name, name)
                changes.setdefault(own, {}).update(_stated(row))
        for name, label in guess_pictures(names, paths).items():
            if self.opened or recording_entry(session, names, name).pictures is None:
                changes[name]["pictures"] = paths[label]
        for key, file_of in self.series.items():
            for name, file in file_of.items():
                if name in changes:
                    changes[name][key] = _path_in(session.folder, file)
        return {name: change for name, change in changes.items() if change}


def titles_by_name(opened: Opened) -> dict[str, str]:
    """Return the names of open recordings on the pages, by their names in the files."""
    in_files = names_in_files(opened.session, opened.whole)
    return {name: title for title, name in in_files.items()}


def joined(source: Source, new: SourceField, folder: Path, purpose: Purpose) -> Any:
    """Return the source with a field's files added, or replacing its own.

    If the source has several files, and each new file has the name of one and no other, only these
    are replaced.
    """
    if new.chosen.is_empty:
        return source
    paths = new.chosen.paths_from(folder)
    if purpose == "add":
        return replace(source, path=(*source.path, *paths), **new.stated)
    by_name = {PurePosixPath(path).name: path for path in paths}
    names = [PurePosixPath(path).name for path in source.path]
    are_unique = len(names) == len({*names}) and len(paths) == len(by_name)
    if len(names) > 1 and are_unique and by_name.keys() <= {*names}:
        paths = tuple(
            by_name.get(name, path) for name, path in zip(names, source.path, strict=True)
        )
    return replace(without_files_of_run(source), path=paths, **new.stated)


def _n_boxes(dataset: Dataset, called: Mapping[str, str]) -> dict[tuple[str, str], int]:
    """Count boxes by source and recording, without empty entries.

    `called` maps recordings to the names in the result.
    """
    names = [called[name] for name in dataset.recordings["name"]]
    sources = {name: dataset.system(name) for name in dataset.systems}
    of_frame = dataset.frame_columns.recording
    n_boxes: dict[tuple[str, str], int] = {}
    for source, boxes in {"the ground truth": dataset.truth, **sources}.items():
        numbers, counts = np.unique(of_frame[boxes.frame_index], return_counts=True)
        keys = ((source, names[number]) for number in numbers)
        n_boxes |= dict(zip(keys, counts.tolist(), strict=True))
    return n_boxes


def _named_after(source: SystemSource, folder: Path, recording: str, *, slot: str) -> SystemSource:
    """Return the source of the only recording with its file named after that recording."""
    files = find_confined(source, folder, "detections").paths
    if len(files) != 1:
        return source
    stem = PurePosixPath(unpacked_name(files[0].name)).stem
    if stem == recording:
        return source
    name = safe_name(recording + files[0].name[len(stem) :])
    copy = store_copy(state.workspace(), slot, files[0], name)
    return replace(source, path=(_path_in(folder, copy),))


def _file_names(chosen: Chosen) -> str:
    return listed([PurePosixPath(path).name for path in chosen.known_as], most=2)


def _path_in(folder: Path, path: Path) -> str:
    return state.workspace().path_in(folder, path)


def _stated(row: RecordingEntry) -> dict[str, Any]:
    """Return the facts in a row of a table of recordings, without the files that it names."""
    row = replace(with_paths_in(row, lambda _: None), frames=None)
    names = [spec.name for spec in dataclass_fields(row) if spec.name != "name"]
    values = {name: getattr(row, name) for name in names}
    return {name: value for name, value in values.items() if value not in (None, ())}


def _own_files(system: SourceField, folder: Path) -> dict[str, Any]:
    """Return paths of further files of a system, by key of a ``[[system]]``."""
    return {key: path for key, file in system.own.items() for path in file.paths_from(folder)}
