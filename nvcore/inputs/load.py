"""From a session to a `Dataset`: find the files, read them, put every box in its frame."""

from __future__ import annotations

import glob
import os
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import copy_context
from dataclasses import replace
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset, refuse_doubles
from nvcore.dataset.provenance import read_provenance
from nvcore.dataset.tables import tables_fingerprint
from nvcore.errors import InputError, UnnamedClassesError
from nvcore.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.added import Input
from nvcore.inputs.box_layouts import sizes_given, with_layout
from nvcore.inputs.codes import codes_beyond, with_codes
from nvcore.inputs.files import digest, find_files, located, system_names
from nvcore.inputs.placing import LoadedSource, place_sources
from nvcore.inputs.readers.base import (
    Lines,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    joined_findings,
    select_boxes,
    warning,
)
from nvcore.inputs.readers.meaning.classes import class_names_beside
from nvcore.inputs.readers.meaning.frame_names import times_as_frames
from nvcore.inputs.readers.meaning.names import LEAST_TIME
from nvcore.inputs.readers.table import FORMAT as TABLE
from nvcore.inputs.readers.table import read_table, table_as_file
from nvcore.inputs.recordings import check_names
from nvcore.inputs.recordings_file import with_recordings_file
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.speed import SPEEDS
from nvcore.inputs.subsets import renamed_reading, with_subsets_joined
from nvcore.objects import PEDESTRIAN, Objects
from nvcore.progress import Progress, no_progress
from nvcore.schema import NO_TRACK
from nvcore.subjects import contributed
from nvcore.wording import count_text

S = TypeVar("S", bound=Source)

ONCE_SHARE: Final = 0.98
"""Share of ids with a single box from which on ids number the boxes. (Our choice.)"""
LEAST_IDS: Final = 10
"""Fewer ids than this may occur once each by chance. (Our choice.)"""


def load(
    session: Session,
    *,
    tables: Mapping[Source, pd.DataFrame] | None = None,
    max_frames: int | None = None,
    progress: Progress = no_progress,
) -> Dataset:
    """Read everything that a session names.

    Parameters
    ----------
    session
        The inputs, and what they lack. The dataset carries it as its settings.
    tables
        Tables in memory, by the sources of the session whose files they replace.
    max_frames
        Most evaluated frames of all recordings; None: no limit.
    progress
        Called with the name of the next step.

    Raises
    ------
    InputError
        If a file cannot be used; with file and line. If there are more frames than `max_frames`.
    MissingFactError
        If image size, frame rate or truth are needed and unknown; with the flag to give.
    """
    _refuse_past_pipes(session)
    session = with_recordings_file(session)
    n_steps = 2 + len(session.systems)
    progress(0.0, "reading the ground truth")
    tables = tables or {}
    truth_table = tables.get(session.truth)
    try:
        truth = _read(session, session.truth, "truth", "truth", None, truth_table)
    except UnnamedClassesError:
        named = _names_of_systems(session)
        if not named:
            raise
        truth = _read(session, session.truth, "truth", "truth", None, truth_table, named)
    names = truth.reading.recordings["name"].tolist()
    loaded = [truth]
    inputs: tuple[Input, ...] = (SPEEDS, *contributed("inputs"))
    reserved = [of.name for of in inputs if of.is_named(session)]
    path_names = system_names(session.systems, names)
    for source, by_path in zip(session.systems, path_names, strict=True):
        name = source.name or by_path
        while name in {*(other.subject for other in loaded), *reserved}:
            name += " (2)"
        progress(len(loaded) / n_steps, f"reading {name}")
        system = _read(session, source, name, "detections", truth.reading, tables.get(source))
        loaded.append(_with_provenance(_corrected(system, source), source, session.folder))
    progress(len(loaded) / n_steps, "placing boxes in frames")
    session = _with_ways_taken(session, loaded)
    loaded = _named_by_session(session, loaded)
    own = [entry.title or entry.name for entry in session.recordings]
    chosen = session.choosing_from([*loaded[0].reading.recordings["name"], *own])

    def is_compared(name: str, tags: Collection[str]) -> bool:
        return {*chosen.only_tags} <= {*tags} and (not chosen.only or name in chosen.only)

    dataset = place_sources(session.of_all.as_titled, loaded, max_frames, is_compared)
    names = dataset.recordings["name"].tolist()
    session = with_codes(session.choosing_from(names), names)
    for of in inputs:
        if of.name in reserved or of.may_be_found:
            dataset = of.join(dataset, session)
    dataset = replace(dataset, findings=(*dataset.findings, *codes_beyond(dataset, session.codes)))
    return dataset.with_settings(session).only(session.only_tags, session.only)


def _refuse_past_pipes(session: Session) -> None:
    """Raise InputError for what came through a pipe in the run that wrote the session."""
    for path in session.paths():
        if path in session.pipes:
            raise InputError(
                "was a pipe when the session was written, and what came through it is gone; store "
                "it in a file, and name that file in the session",
                file=path,
            )


def read_source(
    source: Source,
    *,
    role: Role,
    folder: Path | None = None,
    size: tuple[int, int] | None = None,
    truth: Reading | None = None,
    objects: Objects = PEDESTRIAN,
) -> Reading:
    """Read a single source, for conversion for example.

    Raises
    ------
    InputError
        If a file cannot be used.
    """
    files, file_format = find_files(source, folder or Path.cwd(), role)
    options = read_options(source, role, size, truth, objects)
    reading = _with_named(file_format.read(files, options), options, files)
    reading = with_layout(reading, source, {} if size is None else {"": size}, truth)
    check_names(reading)
    return replace(reading, findings=joined_findings(reading.findings))


def read_options(
    source: Source,
    role: Role,
    size: tuple[int, int] | None,
    truth: Reading | None,
    objects: Objects,
) -> ReadOptions:
    """What the reader of a source needs to know; truth only for detections."""
    return ReadOptions(
        role=role,
        objects=objects,
        classes=source.classes,
        size=size,
        frame_base=source.frame_base,
        box_base=source.box_base,
        frame_names=source.frame_names,
        named=None if truth is None else truth.named,
        boxes=None if truth is None else truth.boxes,
        recordings=() if truth is None else tuple(truth.recordings["name"]),
        images=None if truth is None else truth.images,
        categories={} if truth is None else truth.categories,
        numbering="coco" if truth is None else truth.numbering,
    )


def _read(
    session: Session,
    source: Source,
    subject: str,
    role: Role,
    truth: Reading | None,
    table: pd.DataFrame | None,
    named: Mapping[str, str] | None = None,
) -> LoadedSource:
    """A source read, from its files or from the table that replaces them.

    `named` are names of the truth's classes by their numbers, which its files lack.
    """
    size = session.common_size or _common_size(truth)
    options = read_options(source, role, size, truth, session.objects)
    if named:
        options = replace(options, categories=named, numbering="list")
    if truth is None:
        options = replace(options, picture_folders=_picture_folders(session))
    with _about(subject):
        if table is None:
            files, file_format = find_files(source, session.folder, role)
            with located(files), ThreadPoolExecutor(1) as pool:
                # beside reading: neither holds the lock for long; the context knows of pipes
                hashing = pool.submit(copy_context().run, digest, files)
                reading = file_format.read(files, options)
                digests = hashing.result()
        else:
            files, file_format = [table_as_file(source.path[0])], TABLE
            reading = read_table(table, files[0], options)
            digests = [tables_fingerprint([table], list(map(str, table.columns)))]
        reading = _with_named(reading, options, files)
        reading = with_layout(reading, source, sizes_given(session), truth)
        check_names(reading)
        reading = _without_row_numbers(reading, options)
    if truth is not None:
        reading = _same_single_recording(reading, truth)
    reading = replace(
        reading,
        findings=joined_findings(
            replace(finding, subject=subject, steps=_steps_about(finding.steps, subject))
            for finding in reading.findings
        ),
    )
    return LoadedSource(subject, files, digests, file_format, reading)


def _picture_folders(session: Session) -> tuple[Path, ...]:
    """Folders in which pictures of recordings are, also where a pattern picks from them."""
    places = [session.folder / entry.pictures for entry in session.recordings if entry.pictures]
    return tuple(place.parent if glob.has_magic(place.name) else place for place in places)


def _with_named(reading: Reading, options: ReadOptions, files: Sequence[SourceFile]) -> Reading:
    """The reading with what the names of its pictures tell: how they were understood, rates."""
    if reading.named is None and reading.images is None:
        reading = _with_times_numbered(reading, options, files)
    reading = with_subsets_joined(reading, options)
    if reading.named is None:
        return reading
    named = reading.named.with_empty
    table = reading.recordings
    by_times = table["name"].map(named.rates).astype(float)
    facts = dict.fromkeys([*named.facts, reading.conversion])
    return replace(
        reading,
        named=named,
        findings=(*reading.findings, *named.findings),
        conversion="; ".join(filter(None, facts)),
        recordings=table.assign(fps=table["fps"].fillna(by_times)),
    )


def _without_row_numbers(reading: Reading, options: ReadOptions) -> Reading:
    """Drop track ids that number the boxes: nearly all of a recording occur once.

    The ids of a recording are judged by themselves if they are at least `LEAST_IDS`, and by those
    of the whole reading. A recording with boxes in a single frame proves nothing.
    """
    ids = reading.boxes.loc[reading.boxes["track"] != NO_TRACK, ["recording", "track", "frame"]]
    once = ~ids.duplicated(["recording", "track"], keep=False)
    if np.count_nonzero(once) < ONCE_SHARE * LEAST_IDS:
        return reading
    first = ~ids.duplicated(["recording", "track"])
    by_recording = ids.assign(ids=first, once=once).groupby("recording", observed=True)
    table = by_recording[["ids", "once"]].sum()
    table = table[by_recording["frame"].min() < by_recording["frame"].max()]
    n_ids, n_once = table.sum()
    if n_ids < LEAST_IDS or n_once < ONCE_SHARE * n_ids:
        is_numbered = (table["ids"] >= LEAST_IDS) & (table["once"] >= ONCE_SHARE * table["ids"])
        table = table[is_numbered]
    if table.empty:
        return reading
    n_ids, n_once = table.sum()
    is_truth, objects = options.role == "truth", options.objects
    finding = Finding(
        Severity.WARNING if is_truth else Severity.NOTE,
        "row-number-ids",
        options.role,
        int(n_ids),
        f"{n_once:,} of {n_ids:,} track ids occur once only, as row numbers do: they are no track "
        "ids, and boxes are linked by their overlap from frame to frame instead.",
        objects.say("Give all boxes of {a_one} the same id, if it is known.")
        if is_truth
        else "Nothing to do: only alerts depend on the tracks of a system.",
        example=f"recording {table.index[0]}",
    )
    track = reading.boxes["track"].mask(reading.boxes["recording"].isin(table.index), NO_TRACK)
    return replace(
        reading,
        boxes=reading.boxes.assign(track=track),
        findings=(*reading.findings, finding),
    )


def _with_times_numbered(
    reading: Reading, options: ReadOptions, files: Sequence[SourceFile]
) -> Reading:
    """The reading with frames in place of times, where its format has frame numbers alone."""
    tables = [reading.boxes] if reading.annotated is None else [reading.boxes, reading.annotated]
    is_stated = options.frame_names == "times"
    if not len(tables[-1]) or (tables[-1]["frame"].iloc[0] < LEAST_TIME and not is_stated):
        return reading
    columns = ["recording", "frame", "file", "line"]  # line 0: it is not known
    rows = pd.concat(
        [
            table.reindex(columns=columns, fill_value=0).astype({"recording": object})
            for table in tables
        ]
    )
    recording, frame, file, line = (rows[name].to_numpy() for name in columns)
    times = times_as_frames(frame, recording, options, Lines(files, file, line))
    if times is None:
        return reading
    recording, frame, named = times
    n = len(reading.boxes)
    boxes = reading.boxes.assign(recording=pd.Categorical(recording[:n]), frame=frame[:n])
    annotated = reading.annotated
    if annotated is not None:
        annotated = annotated.assign(recording=recording[n:], frame=frame[n:])
    return replace(reading, boxes=boxes, annotated=annotated, named=named)


def _with_ways_taken(session: Session, loaded: Sequence[LoadedSource]) -> Session:
    """The session with how names of pictures and numbers of classes were understood.

    A rerun then does the same, also without the files that named the classes.
    """

    def stated(source: S, reading: Reading) -> S:
        named = reading.named
        if reading.classes and source.classes is None:
            source = replace(source, classes=reading.classes)
        is_told = named is None or named.is_joined or named.how not in ("times", "order", "scenes")
        if is_told or named is None or source.frame_names is not None:
            return source
        return replace(source, frame_names=named.how)

    truth, *systems = (source.reading for source in loaded)
    return replace(
        session,
        truth=stated(session.truth, truth),
        systems=tuple(map(stated, session.systems, systems)),
    )


def _names_of_systems(session: Session) -> Mapping[str, str]:
    """Names of classes by number that lie beside the systems' files; none where two differ."""
    class_names: list[Mapping[str, str]] = []
    for source in session.systems:
        try:
            names = class_names_beside(find_files(source, session.folder, "detections")[0]).names
        except InputError:  # reported when the system is read
            continue
        class_names += [names] if names else []
    return (
        class_names[0]
        if class_names and all(names == class_names[0] for names in class_names)
        else {}
    )


@contextmanager
def _about(subject: str) -> Iterator[None]:
    """Within it, the ways on of errors know whose files they are about; readers do not."""
    try:
        yield
    except InputError as error:
        error.steps = _steps_about(error.steps, subject)
        raise


def _steps_about(steps: Iterable[Step], subject: str) -> tuple[Step, ...]:
    return tuple(
        step if step.remedy is Remedy.OPTION else replace(step, subject=subject) for step in steps
    )


def _with_provenance(system: LoadedSource, source: SystemSource, folder: Path) -> LoadedSource:
    """The system with the record of how its detections were made, if one is named."""
    if source.provenance is None:
        return system
    path = folder / source.provenance
    if os.path.exists(path):  # noqa: PTH110  # Path.exists raises for names that are too long
        record = read_provenance(path, source.provenance)
        facts = [system.reading.conversion, record.made_by]
        reading = replace(system.reading, conversion="; ".join(filter(None, facts)))
        return replace(system, reading=reading, provenance=record)
    finding = warning(
        "missing-provenance",
        1,
        "The record of how these detections were made is not there: no file has that path.",
        "Correct the path, which starts from the folder of the session file. Until then nobody "
        "knows whether the system was trained on what it is scored on.",
        role=system.subject,
        file=source.provenance,
    )
    findings = (*system.reading.findings, finding)
    return replace(system, reading=replace(system.reading, findings=findings))


def _common_size(truth: Reading | None) -> tuple[int, int] | None:
    """The size of the truth's pictures, where its files give a single one."""
    if truth is None:
        return None
    sizes = truth.recordings[["width", "height"]].drop_duplicates().to_numpy()
    if len(sizes) != 1 or not np.isfinite(sizes).all():
        return None
    return int(sizes[0, 0]), int(sizes[0, 1])


def _same_single_recording(reading: Reading, truth: Reading) -> Reading:
    """One recording on both sides is the same one, whatever the files are called."""
    theirs, ours = reading.recordings["name"].tolist(), truth.recordings["name"].tolist()
    if len(theirs) != 1 or len(ours) != 1 or theirs == ours:
        return reading
    note = f"recording {theirs[0]!r} taken for the truth's only recording {ours[0]!r}"
    conversion = "; ".join(part for part in (reading.conversion, note) if part)
    return replace(renamed_reading(reading, {theirs[0]: ours[0]}), conversion=conversion)


def _named_by_session(session: Session, loaded: list[LoadedSource]) -> list[LoadedSource]:
    """The sources with the recordings called as the session calls them."""
    names = loaded[0].reading.recordings["name"].tolist()
    entries = {entry.name: entry for entry in session.recordings}
    if len(names) == len(entries) == 1:
        entries = {names[0]: session.recordings[0]}
    titles = {name: entry.title for name, entry in entries.items() if entry.title is not None}
    if not titles and len(names) == len(session.recordings) == 1:
        old, new = names[0], session.recordings[0].name
        if any((source.reading.recordings["name"] == new).any() for source in loaded):
            return loaded  # it is called so already, or a system holds another one of that name
        titles = {old: new}
    if not titles:
        return loaded
    # those of the systems too: of two recordings none can be told from the other any longer
    of_all = [name for source in loaded for name in source.reading.recordings["name"]]
    listed_names = dict.fromkeys([*of_all, *entries])
    refuse_doubles("recordings", [titles.get(name, name) for name in listed_names])
    return [
        replace(
            source,
            reading=renamed_reading(source.reading, titles),
            provenance=source.provenance and source.provenance.renamed(titles),
        )
        for source in loaded
    ]


def _corrected(system: LoadedSource, source: SystemSource) -> LoadedSource:
    """Apply the corrections that the session names for a system."""
    boxes, facts = system.reading.boxes, []
    if source.scale != (1, 1):
        across, down = source.scale
        factors = {"x": across, "w": across, "y": down, "h": down}
        boxes = boxes.assign(**{name: boxes[name] * by for name, by in factors.items()})
        facts.append(f"coordinates scaled by {across:g}, {down:g}")
    if any(source.offset_px):
        dx, dy = source.offset_px
        boxes = boxes.assign(x=boxes["x"] + dx, y=boxes["y"] + dy)
        facts.append(f"boxes moved by {dx:g}, {dy:g} px")
    if source.frame_step != 1:
        boxes, fact = _at_rate(boxes, source.frame_step)
        facts.append(fact)
    if source.offset_frames:
        boxes = boxes.assign(frame=boxes["frame"] + source.offset_frames)
        facts.append(f"frame numbers moved by {source.offset_frames:+d}")
    if not facts:
        return system
    conversion = "; ".join([system.reading.conversion, *facts])
    return replace(system, reading=replace(system.reading, boxes=boxes, conversion=conversion))


def _at_rate(boxes: pd.DataFrame, step: float) -> tuple[pd.DataFrame, str]:
    """Boxes with frame numbers at another rate, and that in words.

    Of several numbers that come to one frame only the nearest stays: the others are pictures
    between the frames.
    """
    exact = boxes["frame"].to_numpy() * step
    frame = np.floor(exact + 0.5).astype(np.int64)
    away = pd.Series(np.abs(exact - frame), index=boxes.index)
    groups = [boxes["recording"], pd.Series(frame, index=boxes.index)]
    nearest = away.groupby(groups, observed=True).transform("min").to_numpy()
    first = boxes["frame"].where(away <= nearest).groupby(groups, observed=True).transform("min")
    is_nearest = boxes["frame"].to_numpy() == first.to_numpy()
    fact = f"frame numbers multiplied by {step:g}"
    if not is_nearest.all():
        n_between = int(np.count_nonzero(~is_nearest))
        fact += f", {count_text(n_between, 'box', 'boxes')} between the frames left out"
    return select_boxes(boxes.assign(frame=frame), is_nearest), fact
