"""Load a session as a `Dataset`, step by step.

`load` reads each source: find its files and their format (`nvcore.inputs.files.find`), read columns
(`nvcore.inputs.readers`), interpret names (`nvcore.inputs.interpret`), normalize boxes
(`nvcore.inputs.box_layouts`), correct a system. Then it names recordings as the session does,
assigns frames (`nvcore.inputs.assign_frames`), and joins the other files of the session.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import copy_context
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, UnnamedClassesError
from nvcore.common.findings import Remedy, Step
from nvcore.common.progress import Progress, no_progress
from nvcore.common.subject import subjects
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset, refuse_doubles
from nvcore.dataset.provenance import Provenance, read_provenance
from nvcore.dataset.tables import tables_fingerprint
from nvcore.inputs.assign_frames import LoadedSource, place_sources
from nvcore.inputs.box_layouts import sizes_given, with_layout
from nvcore.inputs.codes import codes_beyond, with_codes
from nvcore.inputs.files.find import digest, find_files, located, system_names
from nvcore.inputs.interpret import renamed_reading, with_names_interpreted, without_row_numbers
from nvcore.inputs.readers.base import (
    Reading,
    ReadOptions,
    Role,
    conversion_text,
    joined_findings,
    select_boxes,
    warning,
)
from nvcore.inputs.readers.meaning.classes import class_names_beside
from nvcore.inputs.readers.table import FORMAT as TABLE
from nvcore.inputs.readers.table import read_table, table_as_file
from nvcore.inputs.recordings import check_names
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.recordings_file import with_recordings_file
from nvcore.inputs.speed import SPEEDS
from nvcore.settings.objects import PEDESTRIAN, Objects

S = TypeVar("S", bound=Source)


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
        Inputs and the facts that they lack. The dataset keeps the session as its settings.
    tables
        Tables in memory, by the sources whose files they replace.
    max_frames
        Largest number of evaluated frames of all recordings. None: no limit.
    progress
        Called with the name of the next step.

    Raises
    ------
    InputError
        If a file cannot be used; with file and line. If there are more frames than `max_frames`.
    MissingFactError
        If image size, frame rate or truth are needed and unknown, with the flag to use.
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
    inputs = (SPEEDS, *chain(*(subject.inputs() for subject in subjects())))
    reserved = [of.name for of in inputs if of.is_named(session)]
    path_names = system_names(session.systems, names)
    for source, by_path in zip(session.systems, path_names, strict=True):
        name = source.name or by_path
        while name in {*(other.subject for other in loaded), *reserved}:
            name += " (2)"
        progress(len(loaded) / n_steps, f"reading {name}")
        loaded.append(_read(session, source, name, "detections", truth.reading, tables.get(source)))
    progress(len(loaded) / n_steps, "placing boxes in frames")
    session = _with_ways_taken(session, loaded)
    loaded = _named_by_session(session, loaded)
    own = [entry.title or entry.name for entry in session.recordings]
    chosen = session.choosing_from([*loaded[0].reading.recordings["name"], *own])
    dataset = place_sources(chosen, loaded, max_frames)
    names = dataset.recordings["name"].tolist()
    session = with_codes(session.choosing_from(names), names)
    for of in inputs:
        if of.name in reserved or of.may_be_found:
            dataset = of.join(dataset, session)
    dataset = replace(dataset, findings=(*dataset.findings, *codes_beyond(dataset, session.codes)))
    return dataset.with_settings(session).only(session.only_tags, session.only)


def _refuse_past_pipes(session: Session) -> None:
    """Raise InputError for inputs that were pipes when the session was written."""
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
    """Read a single source, for example for conversion.

    Raises
    ------
    InputError
        If a file cannot be used.
    """
    files, file_format = find_files(source, folder or Path.cwd(), role)
    options = read_options(source, role, size, truth, objects)
    reading = with_names_interpreted(file_format.read(files, options), options, files)
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
    """Collect the options of a source's reader. `truth` is only for detections."""
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
    """Read a source from its files, or from the table that replaces them.

    `named` are names of the truth's classes by number, if its files lack them.
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
                # in parallel with reading, since both mostly release the GIL (context: pipes)
                hashing = pool.submit(copy_context().run, digest, files)
                reading = file_format.read(files, options)
                digests = hashing.result()
        else:
            files, file_format = [table_as_file(source.path[0])], TABLE
            reading = read_table(table, files[0], options)
            digests = [tables_fingerprint([table], list(map(str, table.columns)))]
        reading = with_names_interpreted(reading, options, files)
        reading = with_layout(reading, source, sizes_given(session), truth)
        check_names(reading)
        reading = without_row_numbers(reading, options)
    if truth is not None:
        reading = _same_single_recording(reading, truth)
    provenance = None
    if isinstance(source, SystemSource):
        reading = _corrected(reading, source)
        reading, provenance = _with_provenance(reading, source, session.folder, subject)
    reading = replace(
        reading,
        findings=joined_findings(
            replace(finding, subject=subject, steps=_steps_about(finding.steps, subject))
            for finding in reading.findings
        ),
    )
    return LoadedSource(subject, files, digests, file_format, reading, provenance)


def _picture_folders(session: Session) -> tuple[Path, ...]:
    """List the folders of the recordings' pictures, including those in glob patterns."""
    places = [session.folder / entry.pictures for entry in session.recordings if entry.pictures]
    return tuple(place.parent if glob.has_magic(place.name) else place for place in places)


def _with_ways_taken(session: Session, loaded: Sequence[LoadedSource]) -> Session:
    """Note in the session how names of pictures and numbers of classes were interpreted.

    A rerun then gives the same result, even without the files that named the classes.
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
    """Return names of classes by number from files beside the systems', or none if two differ."""
    names: Mapping[str, str] = {}
    for source in session.systems:
        try:
            own = class_names_beside(find_files(source, session.folder, "detections")[0]).names
        except InputError:  # reported when the system is read
            continue
        if own and names and own != names:
            return {}
        names = own or names
    return names


@contextmanager
def _about(subject: str) -> Iterator[None]:
    """Add the subject to the suggested fixes of InputErrors, since readers do not know it."""
    try:
        yield
    except InputError as error:
        error.steps = _steps_about(error.steps, subject)
        raise


def _steps_about(steps: Iterable[Step], subject: str) -> tuple[Step, ...]:
    return tuple(
        step if step.remedy is Remedy.OPTION else replace(step, subject=subject) for step in steps
    )


def _with_provenance(
    reading: Reading, source: SystemSource, folder: Path, subject: str
) -> tuple[Reading, Provenance | None]:
    """Read the provenance of detections, and return the reading with its facts and the record."""
    if source.provenance is None:
        return reading, None
    path = folder / source.provenance
    if os.path.exists(path):  # noqa: PTH110  # Path.exists raises for names that are too long
        record = read_provenance(path, source.provenance)
        conversion = conversion_text([reading.conversion, record.made_by])
        return replace(reading, conversion=conversion), record
    finding = warning(
        "missing-provenance",
        1,
        "The record of how these detections were made is not there: no file has that path.",
        "Correct the path, which starts from the folder of the session file. Until then nobody "
        "knows whether the system was trained on what it is scored on.",
        role=subject,
        file=source.provenance,
    )
    return replace(reading, findings=(*reading.findings, finding)), None


def _common_size(truth: Reading | None) -> tuple[int, int] | None:
    """Return the size of the truth's pictures if its files give a single one."""
    if truth is None:
        return None
    sizes = truth.recordings[["width", "height"]].drop_duplicates().to_numpy()
    if len(sizes) != 1 or not np.isfinite(sizes).all():
        return None
    return int(sizes[0, 0]), int(sizes[0, 1])


def _same_single_recording(reading: Reading, truth: Reading) -> Reading:
    """Treat a single recording on each side as the same one, regardless of file names."""
    theirs, ours = reading.recordings["name"].tolist(), truth.recordings["name"].tolist()
    if len(theirs) != 1 or len(ours) != 1 or theirs == ours:
        return reading
    fact = f"recording {theirs[0]!r} taken for the truth's only recording {ours[0]!r}"
    return renamed_reading(reading, {theirs[0]: ours[0]}, fact)


def _named_by_session(session: Session, loaded: list[LoadedSource]) -> list[LoadedSource]:
    """Rename the recordings of all sources as the session names them."""
    names = loaded[0].reading.recordings["name"].tolist()
    entries = {entry.name: entry for entry in session.recordings}
    if len(names) == len(entries) == 1:
        entries = {names[0]: session.recordings[0]}
    titles = {name: entry.title for name, entry in entries.items() if entry.title is not None}
    if not titles and len(names) == len(session.recordings) == 1:
        old, new = names[0], session.recordings[0].name
        if any((source.reading.recordings["name"] == new).any() for source in loaded):
            return loaded  # already renamed, or a system has another recording of this name
        titles = {old: new}
    if not titles:
        return loaded
    # including the systems' recordings: two of one name could not be told apart
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


def _corrected(reading: Reading, source: SystemSource) -> Reading:
    """Apply the corrections that the session names for a system."""
    boxes, facts = reading.boxes, []
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
    return replace(reading, boxes=boxes, conversion="; ".join([reading.conversion, *facts]))


def _at_rate(boxes: pd.DataFrame, step: float) -> tuple[pd.DataFrame, str]:
    """Multiply frame numbers by `step`, and describe the conversion.

    If several numbers round to one frame, only the nearest is kept, because the others are
    pictures between the frames.
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
