"""From a session to a `Dataset`: find the files, read them, put every box in its frame."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from nvcore.dataset import (
    Dataset,
    dataset_from_tables,
    refuse_doubles,
    tables_fingerprint,
    what_is_stated,
)
from nvcore.errors import InputError, MissingFactError
from nvcore.inputs.evaluated_frames import own_frames, parse_frames
from nvcore.inputs.files import digest, find_files, located, system_names
from nvcore.inputs.hashes import changed_input
from nvcore.inputs.placing import REASONS, Places
from nvcore.inputs.readers.base import (
    Format,
    Reading,
    ReadOptions,
    Role,
    SourceFile,
    joined_findings,
)
from nvcore.inputs.readers.table import FORMAT as TABLE
from nvcore.inputs.readers.table import read_table, table_as_file
from nvcore.inputs.recordings import (
    NO_BOX,
    check_listed,
    contradicted_facts,
    describe_recordings,
    missing_pictures,
)
from nvcore.inputs.recordings_file import with_recordings_file
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.progress import Progress, no_progress
from nvcore.schema import BOX_DTYPES


@dataclass(frozen=True)
class _Loaded:
    """One source, read."""

    subject: str
    files: list[SourceFile]
    digests: list[str]
    format: Format
    reading: Reading


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
    session = with_recordings_file(session)
    n_steps = 2 + len(session.systems)
    progress(0.0, "reading the ground truth")
    tables = tables or {}
    truth = _read(session, session.truth, "truth", "truth", None, tables.get(session.truth))
    names = truth.reading.recordings["name"].tolist()
    loaded = [truth]
    path_names = system_names(session.systems, names)
    for source, by_path in zip(session.systems, path_names, strict=True):
        name = source.name or by_path
        while name in {other.subject for other in loaded}:
            name += " (2)"
        progress(len(loaded) / n_steps, f"reading {name}")
        table = tables.get(source)
        system = _read(session, source, name, "detections", truth.reading, table)
        loaded.append(_corrected(system, source))
    progress(len(loaded) / n_steps, "placing boxes in frames")
    dataset = _place(session.of_all.as_titled, _named_by_session(session, loaded), max_frames)
    session = session.choosing_from(dataset.recordings["name"].tolist())
    return dataset.with_settings(session).only(session.only_tags, session.only)


def read_source(
    source: Source,
    *,
    role: Role,
    folder: Path | None = None,
    size: tuple[int, int] | None = None,
    truth: Reading | None = None,
) -> Reading:
    """Read a single source, for conversion for example.

    Raises
    ------
    InputError
        If a file cannot be used.
    """
    files, file_format = find_files(source, folder or Path.cwd(), role)
    reading = file_format.read(files, read_options(source, role, size, truth))
    return replace(reading, findings=joined_findings(reading.findings))


def read_options(
    source: Source, role: Role, size: tuple[int, int] | None, truth: Reading | None
) -> ReadOptions:
    """What the reader of a source needs to know; truth only for detections."""
    return ReadOptions(
        role=role,
        classes=source.classes,
        size=size,
        frame_base=source.frame_base,
        box_base=source.box_base,
        recordings=() if truth is None else tuple(truth.recordings["name"]),
        images=None if truth is None else truth.images,
    )


def _read(
    session: Session,
    source: Source,
    subject: str,
    role: Role,
    truth: Reading | None,
    table: pd.DataFrame | None,
) -> _Loaded:
    """A source read, from its files or from the table that replaces them."""
    options = read_options(source, role, session.common_size or _common_size(truth), truth)
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
    if truth is not None:
        reading = _same_single_recording(reading, truth)
    reading = replace(
        reading,
        findings=joined_findings(replace(finding, subject=subject) for finding in reading.findings),
    )
    return _Loaded(subject, files, digests, file_format, reading)


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
    return replace(_renamed(reading, {theirs[0]: ours[0]}), conversion=conversion)


def _renamed(reading: Reading, titles: Mapping[str, str]) -> Reading:
    """The reading with other names of some of its recordings, by the old ones."""

    def renamed(table: pd.DataFrame | None, column: str = "recording") -> Any:
        if table is None:
            return None
        names = table[column]
        if isinstance(names.dtype, pd.CategoricalDtype):
            names = names.cat.rename_categories(lambda name: titles.get(name, name))
        else:
            names = pd.Series(
                [titles.get(name, name) for name in names], index=names.index, dtype=object
            )
        return table.assign(**{column: names})

    return replace(
        reading,
        boxes=renamed(reading.boxes),
        recordings=renamed(reading.recordings, "name"),
        images=renamed(reading.images),
        annotated=renamed(reading.annotated),
    )


def _named_by_session(session: Session, loaded: list[_Loaded]) -> list[_Loaded]:
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
    return [replace(source, reading=_renamed(source.reading, titles)) for source in loaded]


def _corrected(system: _Loaded, source: SystemSource) -> _Loaded:
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
    if source.offset_frames:
        boxes = boxes.assign(frame=boxes["frame"] + source.offset_frames)
        facts.append(f"frame numbers moved by {source.offset_frames:+d}")
    if not facts:
        return system
    conversion = "; ".join([system.reading.conversion, *facts])
    return replace(system, reading=replace(system.reading, boxes=boxes, conversion=conversion))


def _place(session: Session, loaded: list[_Loaded], max_frames: int | None) -> Dataset:
    """The dataset of all sources, every box in its frame."""
    truth = loaded[0].reading
    check_listed(session, truth)
    recordings = describe_recordings(session, truth)
    frames, notes = _frames(session, truth, recordings)
    n_frames = sum(map(len, frames))
    if max_frames is not None and n_frames > max_frames:
        raise InputError(
            f"there are {n_frames:,} evaluated frames; expected at most {max_frames:,}. Open fewer "
            "recordings at a time, or give the frames to evaluate"
        )
    keep = [i for i, listed in enumerate(frames) if len(listed)]
    recordings = recordings.iloc[keep].reset_index(drop=True)
    frames = [frames[i] for i in keep]
    places = Places(recordings["name"], frames)
    tables: list[dict[str, np.ndarray]] = []
    left_out, inputs = [], []
    n_files = 0
    for number, source in enumerate(loaded):
        boxes = source.reading.boxes
        file = boxes["file"].to_numpy() + np.int32(n_files)
        position, fault = places.of(boxes)
        columns = {name: boxes[name].to_numpy() for name in BOX_DTYPES}
        columns |= {
            "file": file,
            "frame_index": position,
            "source": np.full(len(boxes), number, np.int16),
        }
        lost = np.flatnonzero(fault)
        if len(lost):
            columns = {name: values[fault == 0] for name, values in columns.items()}
        tables.append(columns)
        left_out.append(
            boxes.iloc[lost][["recording", "frame"]]
            .astype({"recording": object})
            .assign(
                file=file[lost],
                line=boxes["line"].to_numpy()[lost],
                reason=np.array(REASONS, dtype=object)[fault[lost]],
                subject=source.subject,
            )
        )
        inputs.append(
            pd.DataFrame(
                {
                    "subject": source.subject,
                    "file": [file.name for file in source.files],
                    "sha256": source.digests,
                    "format": source.format.name,
                    "conversion": source.reading.conversion,
                }
            )
        )
        n_files += len(source.files)
    all_inputs = pd.concat(inputs, ignore_index=True)
    findings = [finding for source in loaded for finding in source.reading.findings]
    for source in loaded:
        first = source.files[0].name
        findings += changed_input(source.subject, first, source.digests, session.hashes)
    findings += contradicted_facts(truth, recordings)
    findings += missing_pictures(session, recordings["name"].tolist())
    return dataset_from_tables(
        recordings,
        frames,
        pd.DataFrame(
            {name: np.concatenate([table[name] for table in tables]) for name in tables[0]},
            copy=False,
        ),
        [source.subject for source in loaded[1:]],
        fingerprint=_fingerprint(session, loaded, recordings, frames),
        inputs=all_inputs,
        left_out=pd.concat(left_out, ignore_index=True),
        findings=tuple(findings),
        notes=tuple(notes),
        settings=session,
    )


def _frames(
    session: Session, truth: Reading, recordings: pd.DataFrame
) -> tuple[list[np.ndarray], list[str]]:
    """Listed frames of every recording, and in words how they were chosen."""
    entries = session.entries(recordings["name"].tolist())
    texts = {name: entry.frames for name, entry in entries.items() if entry.frames is not None}
    common = None if session.frames is None else parse_frames(session.frames, session.folder)
    listed_frames = own_frames(
        truth, [] if common is not None else [n for n in recordings["name"] if n not in texts]
    )
    frames: list[np.ndarray] = []
    reasons: dict[str, list[str]] = {}
    for name in recordings["name"]:
        if name in texts:
            listed, reason = parse_frames(texts[name], session.folder), "as the session says"
        elif common is not None:
            listed, reason = common, "as given for all recordings"
        else:
            listed, reason = listed_frames[name]
        frames.append(listed)
        reasons.setdefault(reason, []).append(name)
    counts = dict(zip(recordings["name"], map(len, frames), strict=True))
    notes = [
        f"evaluated frames of {names[0] if len(names) == 1 else f'{len(names)} recordings'}: "
        f"{reason} ({sum(counts[name] for name in names)} in all)"
        for reason, names in reasons.items()
    ]
    if not sum(len(listed) for listed in frames):
        raise MissingFactError(NO_BOX, file=session.truth.path[0], facts=("frames",))
    return frames, notes


def _fingerprint(
    session: Session, loaded: list[_Loaded], recordings: pd.DataFrame, frames: list[np.ndarray]
) -> str:
    """sha256 over the input bytes and the reader settings."""
    digest_ = hashlib.sha256()
    sources: list[Source] = [session.truth, *session.systems]
    for item, source in zip(loaded, sources, strict=True):
        settings = {**asdict(source), "path": None, "format": item.format.name}
        settings |= {"threshold": None, "name": None}
        digest_.update(f"{item.subject}\n{item.digests}\n{settings}\n".encode())
    digest_.update(what_is_stated(recordings).to_csv(index=False).encode())
    for listed in frames:
        digest_.update(listed.astype(np.int64).tobytes())
    return digest_.hexdigest()
