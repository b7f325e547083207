"""Data page: the form for a session's files, to open them or to change the open session."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, partial
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.common.wording import listed
from nvcore.inputs.facts import labelled_paths
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import RecordingEntry, Source, SystemSource
from nvcore.settings.objects import Objects
from nvcore.tables.inputs import inputs_table, left_out_table
from ui.session import state, store
from ui.session.opening import guess_pictures
from ui.session.workspace import Opened
from ui.views.data.file_check import FileCheck, check_files, draw_file_check
from ui.views.data.form_session import (
    PURPOSES,
    Chosen,
    Form,
    Place,
    Purpose,
    SourceField,
    joined,
    titles_by_name,
)
from ui.views.data.inputs import files_text
from ui.views.data.missing_inputs import MissingInputs, ask_for_missing, draw_reading
from ui.views.data.names import draw_name, draw_objects, draw_recording, proposed_names
from ui.views.data.opening import draw_trouble, forget_outcome, try_to_open
from ui.views.data.side_files import (
    FRAMES_HELP,
    FRAMES_LABEL,
    RECORDINGS_HELP,
    RECORDINGS_LABEL,
    ChosenPictures,
    RecordingsTable,
    draw_frame_list,
    draw_pictures,
    draw_recordings,
)
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import plain

PURPOSE_HELP: Final = (
    "Add: another system, or recordings, with ground truth and the detections of every system. "
    "Replace: another version of a file, such as a system's next release, or a corrected ground "
    "truth. Names, thresholds, corrections and settings stay."
)
MOST_SYSTEMS: Final = 20
READING: Final = tuple(spec.name for spec in fields(Source) if spec.name != "path")
"""Fields of a source with settings for reading its files."""
FILES_HELP: Final = (
    "One file, one file for each recording, or a folder (as a ZIP archive where it is sent). Any "
    "format that the command line reads, also packed (`.gz`, `.zst`, `.xz`, `.bz2`). Where all "
    "files have the same name (MOTChallenge's gt.txt), the recordings are named after the folders."
)


def draw_form(place: Place) -> None:
    """Draw the form. Its button opens the session that it describes."""
    changed = partial(forget_outcome, place.name)
    chosen_purpose = store.FORM_PURPOSE.of(place.name)
    chosen_purpose.setdefault("new")
    purpose = choose_side_by_side(
        "These files", PURPOSES, chosen_purpose.key, on_change=changed, help=PURPOSE_HELP
    )
    opened = None if purpose == "new" else state.opened()
    place.begin("" if opened is None else f"change_{state.workspace().n_opened}_")
    objects = draw_objects(place.name, changed) if opened is None else opened.dataset.objects
    form_fields = _Fields(place, purpose, opened, objects, changed)
    open_truth = None if opened is None else opened.session.truth
    truth = form_fields.draw_source("truth", "the ground truth", "truth", open_truth)
    systems = form_fields.draw_systems(truth)
    new_names = [] if truth.check is None else truth.check.recordings
    recordings = new_names or form_fields.open_names
    with st.columns([1, 3])[1]:
        rows = place.choose("recordings", RECORDINGS_LABEL, help_text=RECORDINGS_HELP, most=1)
        below = st.container()
        frames = Chosen(Path())
        if purpose == "new" or (purpose == "replace" and len(form_fields.open_names) == 1):
            listing = place.choose("frames", FRAMES_LABEL, help_text=FRAMES_HELP, most=1)
            frames = draw_frame_list(listing, recordings)
        labels = labelled_paths(RecordingEntry)
        with st.expander(f"More by recording: {_beginnings(labels.values())}"):
            series = {
                name: _by_name(place.choose(name, label), recordings)
                for name, label in labels.items()
            }
    st.markdown("Pictures (not needed for the numbers)")
    places, refused = place.choose_pictures()
    with below:
        names_of_pictures = [path.name for path in places.values()]
        known = [*recordings, *(titles_by_name(opened) if opened else ())]
        table = draw_recordings(rows, [] if frames.paths else known, names_of_pictures)
    recording = ""
    if opened is None:
        with truth.beside:
            recording = draw_recording(new_names, places, place=place.name, changed=changed)
    names = form_fields.draw_names(truth, systems, [*recordings, recording])
    pictures = draw_pictures(place.name, places, recordings, refused)
    facts = _ask(place.name, (truth, *systems), table, pictures)
    form = Form(place, purpose, opened, objects, truth, systems, names, recordings, recording,
                frames, table, series, pictures, facts)  # fmt: skip
    draw_trouble(place.name)
    if button("Open these files" if opened is None else "Change the comparison",
              key=f"open_{place.name}", type="primary"):  # fmt: skip
        label = place.label if opened is None else opened.label
        try_to_open(
            form.session,
            label=label,
            place=place.name,
            check=form.check,
            words=form.words,
            field_of=form.field_of,
        )


def _beginnings(labels: Iterable[str]) -> str:
    """List labels without their texts in brackets."""
    return listed([label.partition(" (")[0].lower() for label in labels])


@dataclass(frozen=True)
class _Fields:
    """Fields of the form for one purpose."""

    place: Place
    purpose: Purpose
    opened: Opened | None
    objects: Objects
    changed: Callable[[], None]

    @property
    def open_names(self) -> list[str]:
        """Names of the open recordings that files are added to."""
        return [] if self.opened is None else self.opened.whole.recordings["name"].tolist()

    @property
    def open_systems(self) -> tuple[str, ...]:
        """Names of the open systems that files are added to."""
        return () if self.opened is None else self.opened.whole.systems

    def draw_source(
        self,
        name: str,
        title: str,
        role: Role,
        now: Source | None,
        truth: Callable[[], FileCheck | None] = lambda: None,
    ) -> SourceField:
        """Draw the fields of ground truth or of a system, and read the files by themselves.

        Parameters
        ----------
        now
            Source in the open session.
        truth
            Reads the ground truth. It takes long, and is called only if a system has files.
        """
        label = "Ground truth" if role == "truth" else f"Detections of {plain(title)}"
        left, right = st.columns([1, 3])
        system = title if now is not None and role == "detections" else ""
        with right:
            chosen = self.place.choose(name, label, help_text=FILES_HELP)
            below = st.container()
            reading, own = self._draw_rare(name, title, role, now)
        if now is not None and self.opened is not None:
            table = inputs_table(self.opened.whole)
            row = table[table["subject"] == system] if system else table
            left.caption(f"Now: {files_text(row.iloc[0].to_dict())}")
        source = SourceField(title, role, system, chosen, reading, own, below, left)
        if chosen.is_empty:
            return source
        against = truth()
        check = self._check(source, against)
        with below:
            draw_file_check(check)
        return replace(source, check=check)

    def _draw_rare(
        self, name: str, title: str, role: Role, now: Source | None
    ) -> tuple[dict[str, Any], dict[str, Chosen]]:
        """Draw the settings for reading a source, and its further files. Return both.

        Added files are read like the existing ones.
        """
        labels = labelled_paths(SystemSource) if role == "detections" else {}
        reading = {} if now is None else {key: getattr(now, key) for key in READING}
        is_fixed = now is not None and self.purpose == "add"
        if is_fixed and not labels:
            return reading, {}
        with st.expander(f"{'More files of' if is_fixed else 'How to read'} {plain(title)}"):
            if not is_fixed:
                typed = draw_reading(role, self.place.key(name), self.changed)
                given = {key: value for key, value in typed.items() if value is not None}
                reading = {**typed, **reading, **given}
            own = {
                key: self.place.choose(f"{name}_{key}", text, most=1)
                for key, text in labels.items()
            }
        return reading, own

    def draw_systems(self, truth: SourceField) -> list[SourceField]:
        """Draw the fields of the systems, and the button for one more."""
        n_more = store.MORE_SYSTEMS.of(self.place.key("systems"))
        usual = {"new": 2, "add": len(self.open_systems) + 1, "replace": len(self.open_systems)}
        n_systems = usual[self.purpose] + n_more.get()
        now = [] if self.opened is None else self.opened.session.systems
        titles = [*self.open_systems]
        for number in range(len(titles), n_systems):
            letter = {0: " (X)", 1: " (Y)"}.get(number, "")
            titles.append(f"system {number + 1}{letter}")

        @cache
        def against() -> FileCheck | None:
            if self.opened is None:
                return truth.check
            session = self.opened.session
            source = joined(session.truth, truth, session.folder, self.purpose)
            return self._check_open(source, "truth", content=truth.chosen.content)

        systems: list[SourceField] = []
        for number, title in enumerate(titles):
            source = now[number] if number < len(now) else None
            system = self.draw_source(f"system_{number}", title, "detections", source, against)
            if source is None and system.check is not None and system.check.boxes[0]:
                with system.below:
                    self._draw_same(system.check, systems, against())
            systems.append(system)
        if self.purpose != "replace":
            st.button(
                "Add a system",
                icon=":material/add:",
                key=f"add_system_{self.place.name}",
                on_click=lambda: n_more.set(n_more.get() + 1),
                disabled=n_systems >= MOST_SYSTEMS,
            )
        return systems

    def draw_names(
        self, truth: SourceField, systems: Sequence[SourceField], recordings: Sequence[str]
    ) -> list[str]:
        """Draw the names of systems that are not open yet, and return those of all."""
        n_open = len(self.open_systems)
        new = systems[n_open:]
        in_files = titles_by_name(self.opened) if self.opened else ()
        proposed = proposed_names(
            [system.chosen.known_as for system in new],
            truth.chosen.known_as,
            [*recordings, *self.open_systems, *in_files],
            first=n_open + 1,
        )
        names = [*self.open_systems]
        for number, (system, name) in enumerate(zip(new, proposed, strict=True), start=n_open):
            key, label = self.place.key(f"name_{number}"), f"Name of {system.title}"
            with system.beside:
                names.append(draw_name(label, name, key=key, changed=self.changed))
                if names[-1] == name == f"System {number + 1}":
                    st.caption("The files' names do not tell which system this is: type its name.")
        return names

    def _check(self, source: SourceField, truth: FileCheck | None) -> FileCheck:
        chosen = source.chosen
        if chosen.trouble:
            return FileCheck(trouble=chosen.trouble)
        role = source.role
        what = Source(path=chosen.paths, **source.reading)
        return check_files(
            lambda: (self.place.content(chosen, what, role), repr(what), role),
            what,
            role=role,
            folder=chosen.folder,
            truth=truth,
            objects=self.objects,
        )

    def _check_open(
        self, source: Source, role: Role, truth: FileCheck | None = None, content: Hashable = ()
    ) -> FileCheck:
        """Read a source of the open comparison, with the files of a field of this `content`."""
        assert self.opened is not None
        key = (state.workspace().n_opened, content, repr(source), role)
        return check_files(
            lambda: key,
            source,
            role=role,
            folder=self.opened.session.folder,
            truth=truth,
            objects=self.objects,
        )

    def _draw_same(
        self, check: FileCheck, before: Sequence[SourceField], truth: FileCheck | None
    ) -> None:
        """Say whether a further system has the same boxes as one that is open, or one above it."""
        same = [
            other.title
            for other in before
            if other.check is not None and other.check.boxes == check.boxes
        ]
        if self.opened is not None:
            left_out = left_out_table(self.opened.whole).groupby("subject")["n_rows"].sum()
            for name, system in zip(self.open_systems, self.opened.session.systems, strict=True):
                n_boxes = len(self.opened.whole.system(name))
                is_possible = n_boxes <= check.boxes[0] <= n_boxes + left_out.get(name, 0)
                if (
                    is_possible
                    and self._check_open(system, "detections", truth).boxes == check.boxes
                ):
                    same.append(name)
        if same:
            st.warning(
                f"The file has the same boxes as {plain(same[-1])}.", icon=":material/content_copy:"
            )


def _by_name(chosen: Chosen, recordings: Sequence[str]) -> dict[str, Path]:
    """Return a file for each recording, matched by name."""
    if chosen.trouble:
        st.error(plain(chosen.trouble), icon=":material/error:")
    whose = guess_pictures(recordings, chosen.paths)
    left = [path for path in chosen.paths if path not in whose.values()]
    if left:
        names = plain(listed([Path(path).name for path in left]))
        st.warning(
            f"Of no recording by their names, and not used: {names}.", icon=":material/warning:"
        )
    return {name: chosen.folder / path for name, path in whose.items()}


def _ask(
    place: str, sources: Sequence[SourceField], table: RecordingsTable, pictures: ChosenPictures
) -> MissingInputs:
    """Ask for facts that the files lack."""
    checks = [source.check or FileCheck() for source in sources]
    first = checks[0]
    unknown = {name for check in checks for name in check.unknown} - table.known(first.recordings)
    usable = pictures.usable.values()
    return ask_for_missing(place, usable, unknown, first.format, first.sizes)
