"""Data page: what the forms of local files and of uploads have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import streamlit as st

from nvcore.errors import InputError
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.objects import PEDESTRIAN, Objects
from nvcore.wording import listed
from ui.data.file_check import FileCheck, unusable
from ui.data.frames import FrameList
from ui.data.missing_inputs import MissingInputs, ask_for_missing
from ui.data.names import with_recording_name
from ui.data.opening import draw_trouble
from ui.data.pictures import ChosenPictures
from ui.data.recordings import before
from ui.data.recordings.before import TypedRecordings
from ui.data.recordings_table import RecordingsTable
from ui.session import store
from ui.session.opening import (
    guess_pictures,
    recording_entry,
    recording_names,
    with_recordings,
)


def forget_outcome(place: str) -> None:
    """To be called when a choice in this part of the page has changed."""
    store.TROUBLES.of(place).pop()
    store.ASKED_FACTS.of(place).pop()


@dataclass(frozen=True)
class OpeningForm:
    """What is to be opened, besides the files of the truth and of the systems."""

    names: list[str]
    recording: str
    frames: FrameList
    recordings: RecordingsTable
    pictures: ChosenPictures
    facts: MissingInputs
    unusable: str
    place: str = ""
    unnamed: tuple[str, ...] = ()
    sizes: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    typed: TypedRecordings = field(default_factory=TypedRecordings)
    objects: Objects = PEDESTRIAN

    def check(self, *, has_truth: bool, has_systems: bool) -> None:
        """Raise `InputError` if something needed is missing or cannot be used."""
        if not has_truth:
            raise InputError(
                "Choose the ground truth first: the boxes that both systems should find."
            )
        if not has_systems:
            raise InputError("Choose the detections of at least one system.")
        for wrong in (
            self.unusable,
            self.frames.stops,
            self.recordings.stops,
            self.pictures.stops,
            self.typed.trouble,
        ):
            if wrong:
                raise InputError(wrong)
        self._ask_for_names()

    def _ask_for_names(self) -> None:
        """Ask once for names that the files do not tell; who opens again keeps the numbers."""
        asked = store.ASKED_NAMES.of(self.place)
        if self.unnamed and asked.get() != self.unnamed:
            asked.set(self.unnamed)
            raise InputError(
                f"The files' names do not tell what {listed(self.unnamed)} "
                f"{'is' if len(self.unnamed) == 1 else 'are'}: type the names of the systems. "
                "Or open once more to go on with these."
            )

    def session(self, folder: Path, truth: Source, systems: tuple[SystemSource, ...]) -> Session:
        """The session; its table of recordings is not read yet, and pictures are missing."""
        return self.facts.session(
            frame_list=self.frames.path,
            folder=folder,
            truth=truth,
            systems=systems,
            recordings_file=self.recordings.file,
            objects=self.objects,
        )

    def with_pictures(self, session: Session, paths: Mapping[str, str]) -> Session:
        """The session with pictures, given by their labels, and what was typed of recordings.

        Pictures that its table of recordings names stay.
        """
        if not (paths or self.recording or self.sizes or self.typed.changes):
            return session
        with st.spinner("Reading the ground truth"):
            names = recording_names(session)
        whose = guess_pictures(names, paths)
        changes: dict[str, dict[str, object]] = {
            name: {"pictures": paths[label]}
            for name, label in whose.items()
            if recording_entry(session, names, name).pictures is None
        }
        for name, (width, height) in self.sizes.items():
            if name in names and recording_entry(session, names, name).width is None:
                size = {"width": float(width), "height": float(height)}
                changes[name] = {**changes.get(name, {}), **size}
        for name, change in self.typed.changes.items():
            if name in names:
                changes[name] = {**changes.get(name, {}), **change}
        return with_recording_name(with_recordings(session, names, changes), names, self.recording)


def finish_form(
    place: str,
    names: list[str],
    recording: str,
    frames: FrameList,
    table: RecordingsTable,
    pictures: ChosenPictures,
    checks: Mapping[str, FileCheck | None],
    objects: Objects,
) -> OpeningForm:
    """Ask what the files leave open, and say why they could not be opened.

    The `checks` are by what the page calls the files, those of the ground truth first.
    """
    first, *_ = checks.values()
    unknown = {name for check in checks.values() if check is not None for name in check.unknown}
    format_name = "" if first is None else first.format
    unknown -= table.known([] if first is None else first.recordings)
    sizes = {} if first is None else first.sizes
    facts = ask_for_missing(place, pictures.usable.values(), unknown, format_name, sizes)
    others = {name: size for name, size in sizes.items() if len({*sizes.values()}) > 1}
    typed = TypedRecordings()
    if unknown:
        typed = before.draw(place, first, table.entries, facts, others)
    draw_trouble(place)
    return OpeningForm(
        names=names,
        recording=recording,
        frames=frames,
        recordings=table,
        pictures=pictures,
        facts=facts,
        unusable=unusable(checks.items()),
        place=place,
        unnamed=tuple(
            name
            for number, (name, check) in enumerate(zip(names, [*checks.values()][1:], strict=True))
            if check is not None and name == f"System {number + 1}"
        ),
        sizes=others,
        typed=typed,
        objects=objects,
    )
