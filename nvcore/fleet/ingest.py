"""Ingest sessions into a store: convert datasets to its tables and append them in batches."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING as REQUIRED
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, datetime
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.errors import InputError, NvcoreError, StoreError
from nvcore.extras import needs
from nvcore.findings import TRUTH_NAME, Finding
from nvcore.fleet.session import time_of
from nvcore.inputs.session import TABLES_OF_SUBJECTS, RecordingEntry, Session
from nvcore.inputs.toml_text import parse_toml
from nvcore.metrics.encounter_classes import texts_of_truth
from nvcore.params import Params
from nvcore.progress import Progress, no_progress
from nvcore.schema import NO_LABEL
from nvcore.wording import MOST_NAMED, did_you_mean, listed

with needs("fleet", "a store needs"):
    import pyarrow as pa

    from nvcore.fleet.store import Store
    from nvcore.fleet.tables import FACTS, IN_MEMORY, MISSING, RECORDINGS, SOURCES, TRUTH_KINDS

BATCH_ROWS: Final = 1 << 20
"""Boxes and frames after which a batch is appended."""
_LABEL_LETTERS: Final = 100
_UNKNOWN: Final = {**MISSING, "label": NO_LABEL, "attributes": -1}
"""Values of unknown cells of a dataset, by column; NaN in the others."""
CARRIED: Final = {
    "[compare]": "folder truth systems recordings recordings_file codes_file size fps frames "
    f"hashes pipes params only_tags only objects {' '.join(TABLES_OF_SUBJECTS)}",
    "[[recording]]": "name title width height fps frames horizon context speed_kmh speed tags "
    "unit recorded_at pictures first_picture",
    "[[system]]": "path format classes frame_base box_base boxes frame_names name threshold "
    "frame_step offset_frames offset_px scale",
    "[driver]": "detectability",
}
"""Fields of a session, by table, that a store holds or that are applied when it is read."""
_TABLE_OF: Final = {
    "[compare] published": "[[published]]",
    "[compare] codes": "[[code]]",
    "[compare] primary": "[primary]",
    "[compare] protocol": "[protocol]",
}
"""Tables of a session file that are fields of `Session`."""

_Texts = tuple[np.ndarray, list[str]]
"""A text for each row, as an index into a sorted list; -1 is none."""


def tables_of(
    dataset: Dataset,
    *,
    origin: str = "",
    truth_kind: str = "",
    labels: Mapping[str, str] | None = None,
) -> dict[str, pa.Table]:
    """Convert a dataset to the tables of a store: recordings, sources, frames and boxes.

    Parameters
    ----------
    origin
        URI of the session that it was loaded from.
    truth_kind
        ``annotated`` by people, ``automatic`` or ``absent``. Empty: as the store has it, else
        annotated.
    labels
        Labels of these versions, by ``truth`` or the system's name.

    Returns
    -------
    dict
        Frames are sorted by recording and frame, boxes by recording, source (in the order of the
        dataset) and frame. first_row and n_rows of recordings and sources refer to their rows.

    Raises
    ------
    InputError
        If a recording time or a name is invalid, or the truth should be absent and has boxes.
    """
    if truth_kind == "absent" and len(dataset.truth):
        raise InputError(
            f"the ground truth is to be absent, and has {len(dataset.truth):,} boxes", file=origin
        )
    sources = [TRUTH_NAME, *dataset.systems]
    frames = {name: dataset.frames[name].to_numpy() for name in ("frame", "speed_kmh")}
    columns, texts, stretch = _boxes_by_recording(dataset)
    counts = np.bincount(stretch, minlength=len(dataset.recordings) * len(sources))
    try:
        recordings = _recordings_of(dataset, frames, origin)
        names = recordings["recording"]
        rows = _sources_of(dataset, recordings, columns, texts, counts)
        rows["kind"] = [truth_kind, *["system"] * len(dataset.systems)] * len(names)
        rows["label"] = [(labels or {}).get(name, "") for name in rows["source"]]
        of_frames = {"recording": (dataset.frames["recording"].to_numpy(), names)}
        texts["recording"] = stretch // len(sources), names
        texts["source"] = stretch % len(sources), sources
        return {
            "recordings": _rows(recordings, RECORDINGS),
            "sources": _rows(rows, SOURCES),
            "frames": _table(frames, of_frames, IN_MEMORY["frames"]),
            "boxes": _table(columns, texts, IN_MEMORY["boxes"]),
        }
    except UnicodeEncodeError as error:
        raise InputError(
            f"a name is not valid UTF-8: {error.object[:40]!r}", file=origin
        ) from error


def _boxes_by_recording(
    dataset: Dataset,
) -> tuple[dict[str, np.ndarray], dict[str, _Texts], np.ndarray]:
    """Return the columns and texts with known values, sorted by recording and source.

    The third value is recording * number of sources + source, for each row.
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
    rank = np.full(len(names) + 1, -1, np.int32)  # the last entry is for -1, no text
    rank[order] = np.arange(len(names))
    return rank[codes], [names[place] for place in order]


def _recordings_of(
    dataset: Dataset, frames: Mapping[str, np.ndarray], origin: str
) -> dict[str, list[Any]]:
    settings, objects = dataset.settings, dataset.objects
    names = dataset.recordings["name"].tolist()
    entries, folder = [RecordingEntry(name) for name in names], Path()
    if isinstance(settings, Session):
        stated, folder = settings.entries(names), settings.folder
        entries = [stated.get(entry.name, entry) for entry in entries]
    first = dataset.frame_columns.first
    facts = {name: dataset.recordings[name].tolist() for name in FACTS}
    facts |= {
        "tags": [[*tags] for tags in dataset.recordings["tags"]],
        "unit": dataset.recordings["unit"].tolist(),
        "recorded_at": [time_of(entry.recorded_at) for entry in entries],
        "objects": [[objects.singular, objects.plural]] * len(names),
    }
    texts = [json.dumps(of, default=str) for of in zip(*facts.values(), strict=True)]
    recording, step_s = dataset.frames["recording"], dataset.frames["step_s"]
    return {
        "recording": names,
        **facts,
        "sha256": [
            _sha256(text, slice(*ends), frames, {})
            for text, ends in zip(texts, pairwise(first), strict=True)
        ],
        "pictures": [
            "" if entry.pictures is None else str((folder / entry.pictures).absolute())
            for entry in entries
        ],
        "first_picture": [entry.first_picture for entry in entries],
        "duration_s": np.bincount(recording, step_s, minlength=len(names)).tolist(),
        "parameters": [_stated_parameters(settings.params)] * len(names),
        "source": [origin] * len(names),
        "first_row": first[:-1].tolist(),
        "n_rows": np.diff(first).tolist(),
    }


def _stated_parameters(params: Params) -> str:
    """Return the settings that are not the default as JSON; thresholds are facts of sources."""
    default = asdict(Params(threshold_x=params.threshold_x, threshold_y=params.threshold_y))
    stated = {name: value for name, value in asdict(params).items() if value != default[name]}
    return json.dumps(stated, sort_keys=True) if stated else ""


def _sources_of(
    dataset: Dataset,
    recordings: Mapping[str, list[Any]],
    columns: Mapping[str, np.ndarray],
    texts: Mapping[str, _Texts],
    counts: np.ndarray,
) -> dict[str, list[Any]]:
    sources, (x, y) = [TRUTH_NAME, *dataset.systems], dataset.compared()
    params = dataset.params_of()
    thresholds: dict[str | None, float | None] = {
        **dict(zip(dataset.systems, dataset.settings.thresholds, strict=False)),
        x: params.threshold_x,
        y: params.threshold_y,
    }
    inputs = dataset.inputs.groupby("subject")["sha256"].agg(list).to_dict()
    left_out = dataset.left_out.groupby(["recording", "subject"]).size().to_dict()
    starts = np.cumsum(counts) - counts
    every = [(name, source) for name in recordings["recording"] for source in sources]
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
    return any(  # the first value is mostly enough
        bool(np.any(~np.isnan(part) if unknown is None else part != unknown))
        for part in (column[:1], column)
    )


def _sha256(
    facts: str, rows: slice, columns: Mapping[str, np.ndarray], texts: Mapping[str, _Texts]
) -> str:
    """Return the sha256 of facts and rows; columns without a known value do not count."""
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


def _rows(columns: Mapping[str, list[Any]], schema: pa.Schema) -> pa.Table:
    n = len(columns["recording"])
    own = {"file": [""] * n, "ingested_at": [datetime.now(UTC)] * n, "amends": [False] * n}
    return pa.table({name: {**own, **columns}[name] for name in schema.names}, schema=schema)


def _table(
    columns: Mapping[str, np.ndarray], texts: Mapping[str, _Texts], schema: pa.Schema
) -> pa.Table:
    n_rows = len(columns["frame"])
    arrays = []
    for of in schema:
        if of.name in texts:
            codes, names = texts[of.name]
            places = pa.array(codes.astype(np.int32, copy=False), mask=codes < 0)
            array = pa.DictionaryArray.from_arrays(places, pa.array(names, pa.string()))
        elif of.name in columns:
            array = pa.array(columns[of.name], of.type, from_pandas=True)
        else:
            array = pa.repeat(pa.scalar(MISSING.get(of.name), of.type), n_rows)
        arrays.append(array)
    return pa.table(arrays, schema=schema)


@dataclass
class Ingested:
    """Result of an ingest.

    Attributes
    ----------
    recordings, sources
        Appended rows of `nvcore.fleet.tables.RECORDINGS` and `SOURCES`.
    n_known
        Number of sources that the store had already.
    errors
        Inputs that could not be ingested, by name; nothing of them is stored.
    findings
        Findings of the readers, by input.
    not_stored
        Keys of sessions that a store does not hold, and the number of inputs that state them.
    older
        Given versions that are not the newest ones: source, version, newest and n_recordings.
    """

    recordings: pd.DataFrame
    sources: pd.DataFrame
    n_known: int = 0
    errors: dict[str, NvcoreError] = field(default_factory=dict)
    findings: dict[str, tuple[Finding, ...]] = field(default_factory=dict)
    not_stored: dict[str, int] = field(default_factory=dict)
    older: pd.DataFrame = field(default_factory=pd.DataFrame)


def ingest_all(
    inputs: Iterable[tuple[str, Callable[[], Dataset]]],
    store: Store,
    *,
    truth_kind: str = "",
    labels: Mapping[str, str] | None = None,
    newest: bool = False,
    progress: Progress = no_progress,
) -> Ingested:
    """Append datasets to a store, in batches.

    Parameters
    ----------
    inputs
        Name of each input, and a function that loads it.
    truth_kind, labels
        As of `tables_of`.
    newest
        Whether versions that the store has become the newest again.
    progress
        Called with the name of the next input; the share is always 0, their number is unknown.

    Raises
    ------
    InputError
        If a label or the kind of truth is invalid.
    StoreError
        If the store cannot be read or written. Batches that were appended before stay.
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
        new = store.append(batch, newest=newest)
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
        for key in not_stored(dataset):
            done.not_stored[key] = done.not_stored.get(key, 0) + 1
        batch.append(tables)
        if sum(len(of["boxes"]) + len(of["frames"]) for of in batch) >= BATCH_ROWS:
            append()
    if batch:
        append()
    if rows["recordings"]:
        done.recordings, done.sources = (pa.concat_tables(of).to_pandas() for of in rows.values())
    if done.n_known:
        columns = ["recording", "source", "sha256"]
        given = [(*key, sha256) for key, (sha256, _) in seen.items()]
        done.older = store.snapshot().older(pd.DataFrame(given, columns=columns))
    names = {source for _, source in seen} - {""}
    for name in set(labels) - names if names else ():
        known = did_you_mean(name, names, f"they are {listed(sorted(names), most=MOST_NAMED)}")
        done.errors[f"label of {name}"] = InputError(f"no source is called so; {known}")
    return done


def _check_seen(
    tables: Mapping[str, pa.Table], name: str, seen: dict[tuple[str, str], tuple[str, str]]
) -> None:
    """Refuse a recording that another input has with other content: it may be another drive."""
    recordings, sources = tables["recordings"], tables["sources"]
    keys = recordings.select(["recording", "sha256"]).to_pylist()
    keys += sources.select(["recording", "source", "sha256"]).to_pylist()
    own = {(row["recording"], row.get("source", "")): row["sha256"] for row in keys}
    for (recording, source), sha256 in own.items():
        earlier, where = seen.get((recording, source), (sha256, name))
        if earlier != sha256:
            differs = f"another {source!r}" if source else "other facts or frames"
            raise InputError(
                f"recording {recording!r} is in {where} as well, with {differs}; if it is "
                "another one, give it a title, else ingest one after the other",
                file=name,
            )
    seen.update({key: (sha256, name) for key, sha256 in own.items()})


def not_stored(dataset: Dataset) -> list[str]:
    """Return the keys that a session states and a store does not hold, as its file has them."""
    settings = dataset.settings
    tables: list[tuple[str, Any]] = [("[compare]", settings)]
    if isinstance(settings, Session):
        tables += [("[[recording]]", of) for of in settings.recordings]
        tables += [("[[system]]", of) for of in settings.systems]
        tables += [(f"[{name}]", getattr(settings, name)) for name in TABLES_OF_SUBJECTS]
    stated = []
    for table, of in tables:
        for spec in fields(of):
            factory = spec.default_factory
            default = spec.default if factory is REQUIRED else factory()
            if (
                getattr(of, spec.name) != default
                and spec.name not in CARRIED.get(table, "").split()
            ):
                key = f"{table} {spec.name}"
                stated.append(_TABLE_OF.get(key, key))
    if dataset.of("alerts") and not any(key.startswith("[[system]] alert") for key in stated):
        stated.append("alerts in files of detections")
    return [*dict.fromkeys(stated)]


def sessions_in(
    paths: Iterable[Path], load: Callable[[Path], Dataset]
) -> Iterator[tuple[str, Callable[[], Dataset]]]:
    """Yield session files, also those in folders, as `ingest_all` takes them."""
    for path in paths:
        files = filter(_is_session, sorted(path.rglob("*.toml"))) if path.is_dir() else [path]
        file = None
        for file in files:
            yield str(file), partial(load, file)
        if file is None:
            yield str(path), partial(_refuse_folder, path)


def _refuse_folder(folder: Path) -> Dataset:
    raise InputError("holds no session file: TOML with [truth] and [[system]]", file=folder)


def _is_session(path: Path) -> bool:
    """Whether a TOML file has a table ``truth``, or cannot be read: loading it says why."""
    try:
        return "truth" in parse_toml(path.read_bytes(), file=path)
    except (OSError, InputError):
        return True
