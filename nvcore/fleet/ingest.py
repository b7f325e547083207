"""Sessions into a store: a dataset as the tables of one, many of them a batch at a time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.errors import InputError, NvcoreError, StoreError
from nvcore.extras import needs
from nvcore.findings import TRUTH_NAME, Finding
from nvcore.fleet.session import time_of
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.inputs.toml_text import parse_toml
from nvcore.metrics.encounter_classes import texts_of_truth
from nvcore.progress import Progress, no_progress
from nvcore.schema import NO_LABEL
from nvcore.wording import MOST_NAMED, did_you_mean, listed

with needs("fleet", "a store needs"):
    import pyarrow as pa

    from nvcore.fleet.store import Store, keys_of
    from nvcore.fleet.tables import FACTS, IN_MEMORY, MISSING, RECORDINGS, SOURCES, TRUTH_KINDS

BATCH_ROWS: Final = 1 << 20
"""Boxes and frames from which on a batch is appended."""
MOST_TOML_BYTES: Final = 16 << 20
_LABEL_LETTERS: Final = 100
_UNKNOWN: Final = {**MISSING, "label": NO_LABEL, "attributes": -1}
"""What stands in a column where nothing is known; in one of floats it is NaN."""

_Texts = tuple[np.ndarray, list[str]]
"""A text for each row, as its place among these, which are sorted; -1: none."""


def tables_of(
    dataset: Dataset,
    *,
    origin: str = "",
    truth_kind: str = "",
    labels: Mapping[str, str] | None = None,
) -> dict[str, pa.Table]:
    """A dataset as tables of a store: recordings, sources, frames and boxes.

    Parameters
    ----------
    origin
        URI of the session that it was loaded from.
    truth_kind
        Whether the truth is ``annotated`` by people, ``automatic`` or ``absent``. Empty: as the
        store has it, else annotated.
    labels
        What the user calls these versions, by ``truth`` or the system's name.

    Returns
    -------
    dict
        Frames and boxes are sorted by recording, boxes then by source in the order of the dataset,
        both then by frame; first_row and n_rows of recordings and sources say where in them.

    Raises
    ------
    InputError
        If a time of recording is none, a name is no text, or truth that should be absent is there.
    """
    if truth_kind == "absent" and len(dataset.truth):
        raise InputError(
            f"the ground truth is to be absent, and has {len(dataset.truth):,} boxes", file=origin
        )
    frames = {name: dataset.frames[name].to_numpy() for name in ("frame", "speed_kmh")}
    columns, boxes, stretch = _boxes_by_recording(dataset)
    n_sources = len(dataset.systems) + 1
    counts = np.bincount(stretch, minlength=len(dataset.recordings) * n_sources)
    try:
        recordings = _recordings_of(dataset, frames, origin)
        names = recordings["recording"]
        sources = _sources_of(dataset, recordings, columns, boxes, counts)
        sources["kind"] = [truth_kind, *["system"] * len(dataset.systems)] * len(names)
        sources["label"] = [(labels or {}).get(name, "") for name in sources["source"]]
        recording = dataset.frames["recording"].to_numpy()
        source_names = [TRUTH_NAME, *dataset.systems]
        texts = {
            "recording": _texts(stretch // n_sources, names),
            "source": _texts(stretch % n_sources, source_names),
            **{name: _texts(*of_rows) for name, of_rows in boxes.items()},
        }
        return {
            "recordings": _rows(recordings, RECORDINGS),
            "sources": _rows(sources, SOURCES),
            "frames": _table(frames, {"recording": _texts(recording, names)}, IN_MEMORY["frames"]),
            "boxes": _table(columns, texts, IN_MEMORY["boxes"]),
        }
    except UnicodeEncodeError as error:
        raise InputError(
            f"a name is not valid UTF-8: {error.object[:40]!r}", file=origin
        ) from error


def _boxes_by_recording(
    dataset: Dataset,
) -> tuple[dict[str, np.ndarray], dict[str, _Texts], np.ndarray]:
    """Columns and texts in which anything is known, by recording and source; and which these are.

    That is recording * sources + source of each row.
    """
    boxes, n_sources = dataset.boxes, len(dataset.systems) + 1
    frame_index = boxes["frame_index"].to_numpy()
    recording = dataset.frames["recording"].to_numpy()[frame_index].astype(np.int64)
    stretch = recording * n_sources + boxes["source"].to_numpy()
    columns = {name: boxes[name].to_numpy() for name in IN_MEMORY["boxes"].names if name in boxes}
    columns = {name: of for name, of in columns.items() if _is_any_known(name, of)}
    columns["frame"] = dataset.frames["frame"].to_numpy()[frame_index]
    texts = texts_of_truth(dataset)
    if len(texts.categories):
        columns["attributes"] = np.full(len(boxes), -1, np.int32)
        columns["attributes"][: len(texts)] = texts.codes
    if len(dataset.recordings) > 1:  # a dataset has all of one source first
        order = np.argsort(stretch, kind="stable")
        stretch = stretch[order]
        columns = {name: of[order] for name, of in columns.items()}
    named = {"label": dataset.labels, "attributes": texts.categories}
    known = {name: _sorted(columns.pop(name), of) for name, of in named.items() if name in columns}
    return columns, known, stretch


def _sorted(codes: np.ndarray, texts: Iterable[object]) -> _Texts:
    names = [str(text) for text in texts]
    order = np.array(sorted(range(len(names)), key=names.__getitem__), int)
    rank = np.full(len(names) + 1, -1, np.int32)  # the last one is that of -1, no text
    rank[order] = np.arange(len(names))
    return rank[codes], [names[place] for place in order]


def _recordings_of(
    dataset: Dataset, frames: Mapping[str, np.ndarray], origin: str
) -> dict[str, list[Any]]:
    table, settings = dataset.recordings, dataset.settings
    names = table["name"].tolist()
    stated, folder = {}, Path()
    if isinstance(settings, Session):
        stated, folder = settings.entries(names), settings.folder
    entries = {name: stated.get(name, RecordingEntry(name)) for name in names}
    first = dataset.frame_columns.first
    counts = np.diff(first)
    times = [time_of(entry.recorded_at) for entry in entries.values()]
    columns = {name: table[name].tolist() for name in FACTS}
    columns |= {
        "tags": [[*tags] for tags in table["tags"]],
        "unit": table["unit"].tolist(),
        "recorded_at": times,
        "objects": [[dataset.objects.singular, dataset.objects.plural]] * len(names),
    }
    facts = [json.dumps(of, default=str) for of in zip(*columns.values(), strict=True)]
    step_s = dataset.frames["step_s"].to_numpy()
    return {
        "recording": names,
        "sha256": [
            _sha256(of, slice(start, start + n), frames, {})
            for of, start, n in zip(facts, first, counts, strict=False)
        ],
        **columns,
        "pictures": [
            "" if entry.pictures is None else str((folder / entry.pictures).absolute())
            for entry in entries.values()
        ],
        "first_picture": [entry.first_picture for entry in entries.values()],
        "duration_s": np.bincount(
            dataset.frames["recording"], weights=step_s, minlength=len(names)
        ).tolist(),
        "source": [origin] * len(names),
        "first_row": first[:-1].tolist(),
        "n_rows": counts.tolist(),
    }


def _sources_of(
    dataset: Dataset,
    recordings: Mapping[str, list[Any]],
    columns: Mapping[str, np.ndarray],
    texts: Mapping[str, _Texts],
    counts: np.ndarray,
) -> dict[str, list[Any]]:
    names, sources = recordings["recording"], [TRUTH_NAME, *dataset.systems]
    params, (x, y) = dataset.params_of(), dataset.compared()
    thresholds: dict[str | None, float | None] = {
        **dict(zip(dataset.systems, dataset.settings.thresholds, strict=False)),
        x: params.threshold_x,
        y: params.threshold_y,
    }
    inputs = {
        str(subject): group.tolist()
        for subject, group in dataset.inputs.groupby("subject", sort=False)["sha256"]
    }
    left_out = dataset.left_out.groupby(["recording", "subject"]).size().to_dict()
    starts = np.cumsum(counts) - counts
    every = [(name, source) for name in names for source in sources]
    return {
        "recording": [name for name, _ in every],
        "source": [source for _, source in every],
        "sha256": [
            _sha256(repr(thresholds.get(source)), slice(start, start + n), columns, texts)
            for (_, source), start, n in zip(every, starts, counts, strict=True)
        ],
        "recording_sha256": [of for of in recordings["sha256"] for _ in sources],
        "threshold": [thresholds.get(source) for _, source in every],
        "inputs": [inputs.get(source, []) for _, source in every],
        "n_left_out": [left_out.get(key, 0) for key in every],
        "first_row": starts.tolist(),
        "n_rows": counts.tolist(),
    }


def _is_any_known(name: str, column: np.ndarray) -> bool:
    unknown = _UNKNOWN.get(name)
    return any(  # mostly the first value says it
        bool(np.any(~np.isnan(part) if unknown is None else part != unknown))
        for part in (column[:1], column)
    )


def _sha256(
    facts: str, rows: slice, columns: Mapping[str, np.ndarray], texts: Mapping[str, _Texts]
) -> str:
    """sha256 over rows by themselves; a column in which nothing is known does not count."""
    digest = hashlib.sha256(facts.encode())
    for name, column in columns.items():
        part = column[rows]
        if _is_any_known(name, part):
            digest.update(f"\n{name} {len(part)}\n".encode())
            digest.update(part.tobytes())
    for name, (codes, names) in texts.items():
        used, places = np.unique(codes[rows], return_inverse=True)
        if len(used) and used[-1] >= 0:
            own = [names[code] if code >= 0 else None for code in used]
            digest.update(f"\n{name} {json.dumps(own)}\n".encode())
            digest.update(places.astype(np.int32).tobytes())
    return digest.hexdigest()


def _texts(codes: np.ndarray, texts: list[str]) -> pa.DictionaryArray:
    codes = codes.astype(np.int32, copy=False)
    places = pa.array(codes, mask=codes < 0)
    return pa.DictionaryArray.from_arrays(places, pa.array(texts, pa.string()))


def _rows(columns: Mapping[str, list[Any]], schema: pa.Schema) -> pa.Table:
    n = len(columns["recording"])
    index = {"file": [""] * n, "group": [0] * n}
    now = {"ingested_at": [pd.Timestamp.now("UTC")] * n}
    return pa.table({**columns, **index, **now}, schema=schema)


def _table(
    columns: Mapping[str, np.ndarray], texts: Mapping[str, pa.Array], schema: pa.Schema
) -> pa.Table:
    n_rows = len(columns["frame"])
    arrays = []
    for of in schema:
        if of.name in texts:
            arrays.append(texts[of.name])
        elif of.name in columns:
            arrays.append(pa.array(columns[of.name], of.type, from_pandas=True))
        elif pa.types.is_floating(of.type) or pa.types.is_dictionary(of.type):
            arrays.append(pa.nulls(n_rows, of.type))
        else:
            arrays.append(pa.repeat(pa.scalar(_UNKNOWN[of.name], of.type), n_rows))
    return pa.table(arrays, schema=schema)


@dataclass
class Ingested:
    """What an ingest did.

    Attributes
    ----------
    recordings, sources
        Rows of `nvcore.fleet.tables.RECORDINGS` and `SOURCES` that were appended.
    n_known
        Sources of recordings that the store had already.
    errors
        What could not be ingested, by its name, and why; nothing of it was.
    findings
        What was found while the others were read.
    not_stored
        What a store does not take, and in how many inputs it was.
    """

    recordings: pd.DataFrame
    sources: pd.DataFrame
    n_known: int = 0
    errors: dict[str, NvcoreError] = field(default_factory=dict)
    findings: dict[str, tuple[Finding, ...]] = field(default_factory=dict)
    not_stored: dict[str, int] = field(default_factory=dict)


def ingest_all(
    inputs: Iterable[tuple[str, Callable[[], Dataset]]],
    store: Store,
    *,
    truth_kind: str = "",
    labels: Mapping[str, str] | None = None,
    progress: Progress = no_progress,
) -> Ingested:
    """Append datasets to a store, as few commits as will do.

    Parameters
    ----------
    inputs
        Name of each, and what loads it.
    progress
        Called with the name of the next one; the share is 0 as long as their number is unknown.

    Raises
    ------
    InputError
        If a label or the kind of truth is invalid.
    StoreError
        If the store cannot be read or written. What was appended until then is in it.
    """
    labels = labels or {}
    if truth_kind not in ("", *TRUTH_KINDS):
        raise InputError(f"truth_kind: expected {listed(TRUTH_KINDS)}, found {truth_kind[:40]!r}")
    for name, label in labels.items():
        if not label.strip() or label.isdecimal() or "@" in label or len(label) > _LABEL_LETTERS:
            raise InputError(
                f"a version of {name!r} cannot be called {label[:_LABEL_LETTERS]!r}; expected a "
                f"name of at most {_LABEL_LETTERS} letters without @ that is no number"
            )
    done = Ingested(RECORDINGS.empty_table().to_pandas(), SOURCES.empty_table().to_pandas())
    batch: list[dict[str, pa.Table]] = []
    seen: dict[tuple[str, str], tuple[str, str]] = {}
    rows: dict[str, list[pa.Table]] = {"recordings": [], "sources": []}

    def append() -> None:
        new = store.append(batch)
        done.n_known += sum(len(of["sources"]) for of in batch) - len(new["sources"])
        for name, tables in rows.items():
            tables.append(new[name])
        batch.clear()

    for name, load in inputs:
        progress(0.0, name)
        try:
            dataset = load()
            tables = tables_of(dataset, origin=name, truth_kind=truth_kind, labels=labels)
            _check_seen(tables, name, seen)
        except StoreError:
            raise
        except NvcoreError as error:
            done.errors[name] = error
            continue
        if dataset.findings:
            done.findings[name] = dataset.findings
        for text in _not_stored(dataset):
            done.not_stored[text] = done.not_stored.get(text, 0) + 1
        batch.append(tables)
        if sum(len(of["boxes"]) + len(of["frames"]) for of in batch) >= BATCH_ROWS:
            append()
    if batch:
        append()
    if rows["recordings"]:
        done.recordings, done.sources = (pa.concat_tables(of).to_pandas() for of in rows.values())
    names = {source for _, source in seen} - {""}
    for name in set(labels) - names if names else ():
        known = did_you_mean(name, names, f"they are {listed(sorted(names), most=MOST_NAMED)}")
        done.errors[f"label of {name}"] = InputError(f"no source is called so; {known}")
    return done


def _check_seen(
    tables: Mapping[str, pa.Table], name: str, seen: dict[tuple[str, str], tuple[str, str]]
) -> None:
    """Refuse a recording that another input has with other content: it may be another drive."""
    own = {
        (recording, source): sha256
        for recording, source, sha256 in (
            *((of, "", sha) for of, sha in keys_of(tables["recordings"], ["recording", "sha256"])),
            *keys_of(tables["sources"], ["recording", "source", "sha256"]),
        )
    }
    for key, sha256 in own.items():
        if key in seen and seen[key][0] != sha256:
            recording, source = key
            differs = f"another {source!r}" if source else "other facts or frames"
            raise InputError(
                f"recording {recording!r} is in {seen[key][1]} as well, with {differs}; if it is "
                "another one, give it a title, else ingest one after the other",
                file=name,
            )
    seen.update({key: (sha256, name) for key, sha256 in own.items()})


def _not_stored(dataset: Dataset) -> list[str]:
    """What of a dataset a store does not take, in words."""
    settings = dataset.settings
    entries = settings.recordings if isinstance(settings, Session) else ()
    kinds = {
        "codes": settings.codes,
        "records of how detections were made": dataset.provenance,
        "operating points of others": settings.published,
        "pictures of visible light": any(entry.visible for entry in entries),
        **{f"inputs of {name}": of for name, of in dataset.of_subjects.items()},
    }
    return [kind for kind, content in kinds.items() if content]


def sessions_in(
    paths: Iterable[Path], load: Callable[[Path], Dataset]
) -> Iterator[tuple[str, Callable[[], Dataset]]]:
    """Session files, also those in folders, as `ingest_all` takes them."""
    for path in paths:
        try:
            files = session_files(path)
        except InputError as error:  # of this one alone
            yield str(path), partial(_fail, error)
        else:
            yield from ((str(file), partial(load, file)) for file in files)


def _fail(error: InputError) -> Dataset:
    raise error


def session_files(folder: Path) -> list[Path]:
    """Session files in a folder and its folders: TOML that names ground truth, or cannot be read.

    Raises
    ------
    InputError
        If there are none. What is no folder is taken for a session file.
    """
    if not folder.is_dir():
        return [folder]
    files = [path for path in sorted(folder.rglob("*.toml")) if _is_session(path)]
    if not files:
        raise InputError("holds no session file: TOML with [truth] and [[system]]", file=folder)
    return files


def _is_session(path: Path) -> bool:
    try:
        if path.stat().st_size > MOST_TOML_BYTES:
            return True
        return "truth" in parse_toml(path.read_bytes(), file=path)
    except (OSError, InputError):
        return True  # reading it says what is wrong
