"""Assign each box of all sources to its row of the frames table."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass
from itertools import compress
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.memory import check_room
from nvcore.common.wording import listed
from nvcore.dataset import INPUT_COLUMNS, Dataset
from nvcore.dataset.provenance import Provenance, provenance_json
from nvcore.dataset.schema import BOX_DTYPES, TRUTH
from nvcore.dataset.sources import ReadAs
from nvcore.dataset.tables import dataset_from_tables, what_is_stated
from nvcore.inputs.evaluated_frames import frames_there, own_frames, parse_frames
from nvcore.inputs.facts import is_open_range
from nvcore.inputs.files.hashes import changed_input
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.readers.base import Format, Reading, SourceFile
from nvcore.inputs.readers.meaning.classes import merged
from nvcore.inputs.recordings import (
    NO_BOX,
    NO_BOX_STEPS,
    check_listed,
    contradicted_facts,
    describe_recordings,
    missing_label_files,
    missing_pictures,
    single_frames,
)
from nvcore.inputs.session import SYSTEM_KEYS_OF_SUBJECTS, Session

REASONS: Final = ("", "unknown recording", "frame not listed", "not a number", "no area")
"""Reasons why a box has no frame, in the order of the checks. The first means that it has one."""
DENSE: Final = 4
"""Frame numbers per listed one up to which a table of all numbers is fastest."""
NO_FRAMES: Final = np.empty(0, np.int64)
BLOCK: Final = 1 << 15
"""Number of boxes that are placed at a time."""


class FramePlaces:
    """Index from recording and frame number to a row of the frames table."""

    def __init__(self, names: pd.Series[str], frames: list[np.ndarray]) -> None:
        self._names = pd.Index(names)
        # one number per recording and frame; frames outside the list share the places at its ends,
        # so that a frame number of any size fits
        self._before = np.array([numbers[0] - 1 for numbers in frames])
        self._span = np.array([numbers[-1] - numbers[0] + 3 for numbers in frames])
        self._start = np.cumsum(self._span) - self._span
        self._listed = np.concatenate(
            [self._start[i] + (f - self._before[i]) for i, f in enumerate(frames)]
        )
        self._row_of: np.ndarray | None = None
        n_keys, n_rows = int(self._span.sum()), len(self._listed)
        if n_keys <= DENSE * n_rows:  # else few frames of long recordings
            self._row_of = np.full(n_keys, -1, np.int64)
            self._row_of[self._listed] = np.arange(n_rows)

    def of(self, boxes: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """Return each box's row in the frames table and its fault, an int8 index of `REASONS`."""
        names = boxes["recording"].array
        of_name = self._names.get_indexer(names.categories)
        codes, frame = names.codes, boxes["frame"].to_numpy()
        x, y, w, h = (boxes[name].to_numpy() for name in "xywh")
        position, fault = np.empty(len(boxes), np.int64), np.zeros(len(boxes), np.int8)
        last = self._before + self._span - 1
        shift = self._start - self._before
        # block by block, so that intermediate results stay in the processor's cache
        for begin in range(0, len(boxes), BLOCK):
            rows = slice(begin, begin + BLOCK)
            of_row = of_name[codes[rows]]
            key = np.clip(frame[rows], self._before[of_row], last[of_row]) + shift[of_row]
            position[rows], is_listed = self._rows_of(key)
            finite = np.isfinite(x[rows]) & np.isfinite(y[rows])
            finite &= np.isfinite(w[rows]) & np.isfinite(h[rows])
            has_area = (w[rows] > 0) & (h[rows] > 0)
            if not (is_listed & finite & has_area).all() or of_row.min() < 0:
                fault[rows] = np.select([of_row < 0, ~is_listed, ~finite, ~has_area], range(1, 5))
        return position, fault

    def _rows_of(self, key: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the row of each key in the frames table, and whether it exists."""
        if self._row_of is None:
            position = np.minimum(np.searchsorted(self._listed, key), len(self._listed) - 1)
            return position, self._listed[position] == key
        position = self._row_of[key]
        return position, position >= 0


@dataclass(frozen=True)
class LoadedSource:
    """Ground truth or a system that has been read.

    Attributes
    ----------
    subject
        ``truth``, or the system's name.
    files, digests
        Its files, and their sha256.
    provenance
        Record of how its detections were made. None: nothing is known.
    """

    subject: str
    files: list[SourceFile]
    digests: list[str]
    format: Format
    reading: Reading
    provenance: Provenance | None = None


def place_sources(session: Session, loaded: list[LoadedSource], max_frames: int | None) -> Dataset:
    """Build the dataset of all sources, with every box assigned to its frame.

    Parameters
    ----------
    session
        Only its recordings are compared. The size and rate of others may be unknown.
    loaded
        Ground truth first, then the systems of the session in their order.
    max_frames
        Largest number of evaluated frames of all recordings. None: no limit.

    Raises
    ------
    InputError
        If there are more frames than `max_frames`, or a list of frames cannot be used.
    MissingFactError
        If image size, frame rate or frames are needed and unknown.
    """
    truth, chosen = loaded[0].reading, session
    session = session.of_all.as_titled
    check_listed(session, truth)
    recordings, is_compared = describe_recordings(session, chosen, truth)
    frames, notes = _frames(session, loaded[0], recordings, is_compared)
    n_frames = sum(map(len, frames))
    if max_frames is not None and n_frames > max_frames:
        raise InputError(
            f"there are {n_frames:,} evaluated frames; expected at most {max_frames:,}. Open fewer "
            "recordings at a time, or give the frames to evaluate"
        )
    check_room(n_frames, sum(len(source.reading.boxes) for source in loaded))
    keep = [i for i, numbers in enumerate(frames) if len(numbers)]
    recordings = recordings.iloc[keep].reset_index(drop=True)
    frames = [frames[i] for i in keep]
    places = FramePlaces(recordings["name"], frames)
    tables: list[dict[str, np.ndarray]] = []
    left_out = []
    n_files = 0
    labels, label_places = merged(source.reading.labels for source in loaded)
    for number, source in enumerate(loaded):
        placed, lost = _placed(source, number, places, n_files)
        if source.reading.labels:
            placed["label"] = label_places[number][placed["label"]]
        tables.append(placed)
        left_out.append(lost)
        n_files += len(source.files)
    own_names = recordings["name"].tolist()
    findings = [finding for source in loaded for finding in source.reading.findings]
    for source in loaded:
        names = [file.name for file in source.files]
        findings += changed_input(source.subject, names, source.digests, session.hashes)
    findings += [*contradicted_facts(truth, recordings), *missing_pictures(session, own_names)]
    if session.frames is None:
        findings += single_frames(truth, own_names, np.array([*map(len, frames)]))
    if truth.named is not None and len(loaded[0].files) >= len(truth.named.table):
        findings += missing_label_files(own_names, frames)
    return dataset_from_tables(
        recordings,
        frames,
        pd.DataFrame(_joined(tables), copy=False),
        [source.subject for source in loaded[1:]],
        fingerprint=_fingerprint(session, loaded, recordings, frames),
        inputs=pd.DataFrame(
            [
                (of.subject, file.name, sha256, of.format.name, of.reading.conversion)
                for of in loaded
                for file, sha256 in zip(of.files, of.digests, strict=True)
            ],
            columns=list(INPUT_COLUMNS),
        ),
        left_out=pd.concat(left_out, ignore_index=True),
        findings=tuple(findings),
        notes=tuple(notes),
        settings=session,
        provenance={
            source.subject: source.provenance for source in loaded if source.provenance is not None
        },
        labels=labels,
        read_as={
            source.subject: ReadAs(
                source.reading.layout,
                source.reading.has_score_beside,
                source.reading.left_out,
                source.format.name if source.format in FORMATS else None,
                source.reading.usual,
            )
            for source in loaded
        },
        **({} if truth.attributes is None else {"attributes": truth.attributes}),
    )


def _joined(tables: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Concatenate the columns of all sources, with NaN where a source lacks a column.

    This empties the tables, so that no column is in memory twice.
    """
    n_rows = [len(table["x"]) for table in tables]
    return {
        name: np.concatenate(
            [
                table.pop(name) if name in table else np.broadcast_to(np.nan, n)
                for table, n in zip(tables, n_rows, strict=True)
            ]
        )
        for name in list(tables[0])
    }


def _placed(
    source: LoadedSource, number: int, places: FramePlaces, n_files: int
) -> tuple[dict[str, np.ndarray], pd.DataFrame]:
    """Return columns of the boxes that have a place, and the rows of those that have none.

    This empties the reading's table, so that `_joined` can free memory.

    Parameters
    ----------
    number
        Number of the source in the boxes.
    n_files
        Number of files of earlier sources.
    """
    boxes = source.reading.boxes
    file = boxes["file"].to_numpy() + np.int32(n_files)
    position, fault = places.of(boxes)
    lost = np.flatnonzero(fault)
    left_out = (
        boxes.iloc[lost][["recording", "frame", *"xywh"]]
        .astype({"recording": object})
        .assign(
            file=file[lost],
            line=boxes["line"].to_numpy()[lost],
            reason=np.array(REASONS, dtype=object)[fault[lost]],
            subject=source.subject,
        )
    )
    columns = {name: boxes.pop(name).to_numpy() for name in BOX_DTYPES}
    del boxes["recording"], boxes["frame"]
    if number != TRUTH or np.isnan(columns["detectability"]).all():
        del columns["detectability"]
    columns |= {
        "file": file,
        "frame_index": position,
        "source": np.broadcast_to(np.int16(number), len(file)),
    }
    if len(lost):
        columns = {name: values[fault == 0] for name, values in columns.items()}
    return columns, left_out


def _frames(
    session: Session, truth: LoadedSource, recordings: pd.DataFrame, is_compared: list[bool]
) -> tuple[list[np.ndarray], list[str]]:
    """Return the listed frames of every recording, with a text on how they were chosen."""
    entries = session.entries(recordings["name"].tolist()).items()
    texts = {name: entry.frames for name, entry in entries if entry.frames is not None}
    given = {name: texts.get(name, session.frames) for name in recordings["name"]}
    asked = dict.fromkeys(text for text in (session.frames, *texts.values()) if text is not None)
    lists = {text: parse_frames(text, session.folder) for text in asked if not is_open_range(text)}
    without_list = [name for name, text in given.items() if text not in lists]
    own = own_frames(truth.reading, without_list, truth.files)
    frames: list[np.ndarray] = []
    reasons: dict[str, list[str]] = {}
    for name, text in given.items():
        if text is None or (name in own and not len(own[name][0])):
            numbers, reason = own[name]
        else:
            numbers = lists.get(text, NO_FRAMES)
            if name in own:
                numbers = parse_frames(text, session.folder, own[name][0])
            reason = "as the session says" if name in texts else "as given for all recordings"
            if not len(numbers):
                reason = f"none is in {text}; recording left out"
        frames.append(numbers)
        reasons.setdefault(reason, []).append(name)
    counts = dict(zip(recordings["name"], map(len, frames), strict=True))
    notes = [
        f"evaluated frames of {names[0] if len(names) == 1 else f'{len(names)} recordings'}: "
        f"{reason} ({sum(counts[name] for name in names):,} in all)"
        for reason, names in reasons.items()
    ]
    compared = [*compress(counts, is_compared)]
    if not any(counts[name] for name in compared):
        there = {name: own[name][0] for name in compared if name in own}
        if any(map(len, there.values())):
            raise InputError(f"no frame is in {listed([*map(repr, asked)])}: {frames_there(there)}")
    if not any(map(len, frames)):
        path = session.truth.path[0]
        text = session.objects.say(NO_BOX)
        raise MissingFactError(text, file=path, facts=("frames",), steps=NO_BOX_STEPS)
    return frames, notes


def _fingerprint(
    session: Session, loaded: list[LoadedSource], recordings: pd.DataFrame, frames: list[np.ndarray]
) -> str:
    """Hash the input bytes and the reader settings with SHA-256."""
    digest = hashlib.sha256()
    for item, (source, _) in zip(loaded, session.sources, strict=True):
        settings = {**asdict(source), "path": None, "format": item.format.name}
        settings |= {"threshold": None, "name": None}
        for name, default in (("frame_names", None), ("frame_step", 1.0)):
            if settings.get(name) == default:
                settings.pop(name, None)
        for name in ("provenance", *SYSTEM_KEYS_OF_SUBJECTS):
            settings.pop(name, None)  # paths: the record and the content of subjects count instead
        if not item.reading.is_laid_out:
            del settings["boxes"]
        # stating a default does not change the fingerprint
        usual = item.reading.usual
        settings |= {name: None for name in usual if settings[name] == usual[name]}
        digest.update(f"{item.subject}\n{item.digests}\n{settings}\n".encode())
        if item.provenance is not None:
            digest.update(provenance_json(item.provenance))
    if not session.objects.are_pedestrians:
        digest.update(f"objects {session.objects.given()}\n".encode())
    digest.update(what_is_stated(recordings).to_csv(index=False).encode())
    for numbers in frames:
        digest.update(numbers.astype(np.int64).tobytes())
    return digest.hexdigest()
