"""Ingest sessions into a store: convert datasets to its tables and append them in batches."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING as REQUIRED
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime
from functools import partial
from itertools import pairwise, product
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError, NvcoreError, SessionError
from nvcore.common.extras import needs
from nvcore.common.findings import TRUTH_NAME, Finding
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import MOST_NAMED, count_text, did_you_mean, listed
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_LABEL
from nvcore.inputs.session import TABLES_OF_SUBJECTS, RecordingEntry, Session
from nvcore.inputs.session.toml_text import parse_toml
from nvcore.metrics.encounter_classes import texts_of_truth
from nvcore.settings.params import Params

with needs("fleet", "a store needs"):
    import pyarrow as pa

    from nvcore.subjects.fleet.store import Older, Store, versions_in
    from nvcore.subjects.fleet.tables import (
        FACTS,
        IN_MEMORY,
        MISSING,
        RECORDINGS,
        SOURCES,
        TRUTH_KINDS,
    )

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
    "[compare] rules": "[gate]",
}
"""Tables of a session file that are fields of `Session`."""

_Columns = Mapping[str, np.ndarray | pd.Categorical]


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
        If a recording time or a name is invalid, two sources have the same name, or the truth
        should be absent and has boxes.
    """
    if truth_kind == "absent" and len(dataset.truth):
        raise InputError(
            f"the ground truth is to be absent, and has {len(dataset.truth):,} boxes", file=origin
        )
    sources = [TRUTH_NAME, *dataset.systems]
    if double := [name for name in sources if sources.count(name) > 1]:
        raise InputError(f"two sources are called {double[0]!r}; rename one", file=origin)
    frames: dict[str, Any] = {
        name: dataset.frames[name].to_numpy() for name in ("frame", "speed_kmh")
    }
    boxes, stretch = _boxes_by_recording(dataset)
    try:
        recordings = _recordings_of(dataset, frames, origin)
        counts = np.bincount(stretch, minlength=len(recordings) * len(sources))
        rows = _sources_of(dataset, recordings, boxes, counts, truth_kind, labels or {})
        names = [row["recording"] for row in recordings]
        frames["recording"] = _texts(dataset.frames["recording"].to_numpy(), names)
        boxes["recording"] = _texts(stretch // len(sources), names)
        boxes["source"] = _texts(stretch % len(sources), sources)
        return {
            "recordings": pa.Table.from_pylist(recordings, RECORDINGS),
            "sources": pa.Table.from_pylist(rows, SOURCES),
            "frames": _table(frames, IN_MEMORY["frames"]),
            "boxes": _table(boxes, IN_MEMORY["boxes"]),
        }
    except UnicodeEncodeError as error:
        raise InputError(
            f"a name is not valid UTF-8: {error.object[:40]!r}", file=origin
        ) from error


def _boxes_by_recording(dataset: Dataset) -> tuple[dict[str, Any], np.ndarray]:
    """Return the columns of boxes with known values, sorted by recording and source.

    The second value is recording * number of sources + source, for each row.
    """
    boxes, n_sources = dataset.boxes, len(dataset.systems) + 1
    frame_index = boxes["frame_index"].to_numpy()
    recording = dataset.frames["recording"].to_numpy()[frame_index].astype(np.int64)
    stretch = recording * n_sources + boxes["source"].to_numpy()
    columns: dict[str, Any] = {
        name: of
        for name in IN_MEMORY["boxes"].names
        if name in boxes and _is_any_known(name, of := boxes[name].to_numpy())
    }
    columns["frame"] = dataset.frames["frame"].to_numpy()[frame_index]
    if "label" in columns:
        columns["label"] = _texts(columns.pop("label"), dataset.labels)
    texts = texts_of_truth(dataset)
    if len(texts.categories):
        codes = np.full(len(boxes), -1)
        codes[: len(texts)] = texts.codes
        columns["attributes"] = _texts(codes, texts.categories)
    if len(dataset.recordings) > 1:  # a dataset is sorted by source first
        order = np.argsort(stretch, kind="stable")
        stretch = stretch[order]
        columns = {name: of[order] for name, of in columns.items()}
    return columns, stretch


def _texts(codes: np.ndarray, texts: Iterable[object]) -> pd.Categorical:
    """Return the texts that integer codes index, as a categorical with sorted categories."""
    names = pd.Index([*map(str, texts)], dtype=object)
    found = pd.Categorical.from_codes(codes, names, validate=False)
    return found.reorder_categories(names.sort_values())


def _recordings_of(
    dataset: Dataset, frames: Mapping[str, np.ndarray], origin: str
) -> list[dict[str, Any]]:
    settings, objects = dataset.settings, dataset.objects
    entries, folder = {}, Path()
    if isinstance(settings, Session):
        entries, folder = settings.entries(dataset.recordings["name"].tolist()), settings.folder
    first = dataset.frame_columns.first
    stated = dataset.recordings.to_dict("records")
    step_s = dataset.frames["step_s"].to_numpy()
    durations_s = np.bincount(dataset.frames["recording"], step_s, minlength=len(stated))
    given = dict(vars(settings.params).items() - vars(Params()).items())
    given = {name: of for name, of in given.items() if not name.startswith("threshold_")}
    rows = []
    for row, ends, duration_s in zip(stated, pairwise(first), durations_s, strict=True):
        entry = entries.get(row["name"], RecordingEntry(row["name"]))
        facts = {name: row[name] for name in FACTS} | {
            "tags": [*row["tags"]],
            "unit": row["unit"],
            "recorded_at": _time_of(entry.recorded_at),
            "objects": [objects.singular, objects.plural],
        }
        own = {
            "recording": row["name"],
            "sha256": _sha256(json.dumps([*facts.values()], default=str), slice(*ends), frames),
            "pictures": str((folder / entry.pictures).absolute()) if entry.pictures else "",
            "first_picture": entry.first_picture,
            "duration_s": duration_s,
            "parameters": json.dumps(given, sort_keys=True) if given else "",
            "source": origin,
            "first_row": ends[0],
            "n_rows": ends[1] - ends[0],
        }
        rows.append(facts | own)
    return rows


def _time_of(text: str | None) -> datetime | None:
    if text is None:
        return None
    try:
        when = datetime.fromisoformat(text)
        return when.replace(tzinfo=UTC) if when.tzinfo is None else when.astimezone(UTC)
    except (ValueError, OverflowError) as error:
        raise SessionError(
            f"recorded_at: expected a time such as 2026-03-01T18:20:00+01:00, found {text[:40]!r}"
        ) from error


def _sources_of(
    dataset: Dataset,
    recordings: list[dict[str, Any]],
    boxes: _Columns,
    counts: np.ndarray,
    truth_kind: str,
    labels: Mapping[str, str],
) -> list[dict[str, Any]]:
    params, (x, y) = dataset.params_of(), dataset.compared()
    thresholds: dict[str | None, float | None] = {
        **dict(zip(dataset.systems, dataset.settings.thresholds, strict=False)),
        x: params.threshold_x,
        y: params.threshold_y,
    }
    inputs = dataset.inputs.groupby("subject")["sha256"].agg(list).to_dict()
    left_out = dataset.left_out.groupby(["recording", "subject"]).size().to_dict()
    every = product(recordings, [TRUTH_NAME, *dataset.systems])
    ends = pairwise([0, *np.cumsum(counts).tolist()])
    return [
        {
            "recording": of["recording"],
            "source": source,
            "sha256": _sha256(repr(thresholds.get(source)), slice(start, stop), boxes),
            "recording_sha256": of["sha256"],
            "kind": "system" if source != TRUTH_NAME else truth_kind,
            "label": labels.get(source, ""),
            "threshold": thresholds.get(source),
            "inputs": inputs.get(source, []),
            "n_left_out": left_out.get((of["recording"], source), 0),
            "first_row": start,
            "n_rows": stop - start,
        }
        for (of, source), (start, stop) in zip(every, ends, strict=True)
    ]


def _is_any_known(name: str, column: np.ndarray) -> bool:
    unknown = _UNKNOWN.get(name)
    return any(  # the first value is mostly enough
        bool(np.any(~np.isnan(part) if unknown is None else part != unknown))
        for part in (column[:1], column)
    )


def _sha256(facts: str, rows: slice, columns: _Columns) -> str:
    """Hash facts and rows with SHA-256, skipping columns without known values."""
    digest = hashlib.sha256(facts.encode())
    for name, column in columns.items():
        part = column[rows]
        if isinstance(part, pd.Categorical):
            used, places = np.unique(part.codes, return_inverse=True)
            if used.max(initial=-1) >= 0:
                own = [part.categories[code] if code >= 0 else None for code in used]
                digest.update(f"\n{name} {json.dumps(own)}\n".encode())
                digest.update(places.astype(np.int32).tobytes())
        elif _is_any_known(name, part):
            digest.update(f"\n{name} {len(part)}\n".encode())
            digest.update(part.tobytes())
    return digest.hexdigest()


def _table(columns: _Columns, schema: pa.Schema) -> pa.Table:
    n_rows = len(columns["frame"])
    arrays = [
        pa.array(columns[of.name], of.type, from_pandas=True)
        if of.name in columns
        else pa.repeat(pa.scalar(MISSING.get(of.name), of.type), n_rows)
        for of in schema
    ]
    return pa.table(arrays, schema=schema)


@dataclass
class Ingested:
    """Result of an ingest.

    Attributes
    ----------
    recordings, sources
        Appended rows of `nvcore.subjects.fleet.tables.RECORDINGS` and `SOURCES`.
    n_known
        Number of sources that the store had already.
    errors
        Errors of inputs that could not be ingested, by name. Nothing of them is stored.
    findings
        Findings of the readers, by input.
    not_stored
        Keys of sessions that a store does not hold, and the number of inputs that state them.
    older
        Given versions that are not the newest ones: source, version, newest and n_recordings.
    """

    recordings: pd.DataFrame = field(default_factory=pd.DataFrame)
    sources: pd.DataFrame = field(default_factory=pd.DataFrame)
    n_known: int = 0
    errors: dict[str, NvcoreError] = field(default_factory=dict)
    findings: dict[str, tuple[Finding, ...]] = field(default_factory=dict)
    not_stored: Counter[str] = field(default_factory=Counter)
    older: pd.DataFrame = field(default_factory=pd.DataFrame)

    def __str__(self) -> str:
        n_frames, n_boxes = (int(of["n_rows"].sum()) for of in (self.recordings, self.sources))
        known = count_text(self.n_known, "source was", "sources were")
        return (
            f"{count_text(len(self.recordings), 'recording')} ({count_text(n_frames, 'frame')}), "
            f"{count_text(len(self.sources), 'source')} ({count_text(n_boxes, 'box', 'boxes')}) "
            f"appended{f'; {known} there already' if self.n_known else ''}"
        )


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
        Called with share 0, since the number of inputs is unknown, and the name of the next input.

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
    done = Ingested()
    new = [({"recordings": RECORDINGS.empty_table(), "sources": SOURCES.empty_table()}, Older())]
    batch: list[dict[str, pa.Table]] = []
    seen: dict[tuple[str, str], tuple[str, str]] = {}
    for name, load in inputs:
        progress(0.0, name)
        try:
            dataset = load()
            tables = tables_of(dataset, origin=name, truth_kind=truth_kind, labels=labels)
            _check_seen(tables, name, seen)
        except NvcoreError as error:
            done.errors[name] = error
            continue
        if dataset.findings:
            done.findings[name] = dataset.findings
        done.not_stored.update(not_stored(dataset))
        batch.append(tables)
        done.n_known += len(tables["sources"])
        if sum(len(of["boxes"]) + len(of["frames"]) for of in batch) >= BATCH_ROWS:
            new.append(store.append(batch, newest=newest))
            batch = []
    if batch:
        new.append(store.append(batch, newest=newest))
    done.recordings, done.sources = (
        pa.concat_tables([tables[of] for tables, _ in new]).to_pandas()
        for of in ("recordings", "sources")
    )
    done.n_known -= len(done.sources)
    columns = ["recording", "source", "version", "newest"]
    older = pd.DataFrame(sorted(set().union(*(of for _, of in new))), columns=columns)
    done.older = older.groupby(columns[1:], as_index=False).agg(n_recordings=("recording", "size"))
    names = {source for _, source in seen} - {""}
    for name in set(labels) - names if names else ():
        known = did_you_mean(name, names, f"they are {listed(sorted(names), most=MOST_NAMED)}")
        done.errors[f"label of {name}"] = InputError(f"no source is called so; {known}")
    return done


def _check_seen(
    tables: Mapping[str, pa.Table], name: str, seen: dict[tuple[str, str], tuple[str, str]]
) -> None:
    """Refuse a recording if an earlier input has one of that name with other content.

    The recordings may be different drives.
    """
    own = dict(of for row in tables["sources"].to_pylist() for of in versions_in(row))
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
    """Return the keys of a session file that are set but that a store does not hold."""
    settings = dataset.settings
    tables: list[tuple[str, Any]] = [("[compare]", settings)]
    if isinstance(settings, Session):
        tables += [("[[recording]]", of) for of in settings.recordings]
        tables += [("[[system]]", of) for of in settings.systems]
        tables += [(f"[{name}]", getattr(settings, name)) for name in TABLES_OF_SUBJECTS]
    stated = []
    for table, of in tables:
        for spec in fields(of):
            factory, key = spec.default_factory, f"{table} {spec.name}"
            default = spec.default if factory is REQUIRED else factory()
            if (
                spec.name not in CARRIED.get(table, "").split()
                and getattr(of, spec.name) != default
            ):
                stated.append(_TABLE_OF.get(key, key))
    if dataset.of("alerts") and not any(key.startswith("[[system]] alert") for key in stated):
        stated.append("alerts in files of detections")
    return [*dict.fromkeys(stated)]


def sessions_in(
    paths: Iterable[Path], load: Callable[[Path], Dataset]
) -> Iterator[tuple[str, Callable[[], Dataset]]]:
    """Yield the name and a loader of each session file at the paths, for `ingest_all`."""
    for path in paths:
        files = [*filter(_is_session, sorted(path.rglob("*.toml")))] if path.is_dir() else [path]
        yield from ((str(file), partial(load, file)) for file in files)
        if not files:
            yield str(path), partial(_refuse_folder, path)


def _refuse_folder(folder: Path) -> Dataset:
    raise InputError("holds no session file: TOML with [truth] and [[system]]", file=folder)


def _is_session(path: Path) -> bool:
    """Whether a TOML file has a table ``truth``.

    Also True for a file that cannot be read, since loading it explains why.
    """
    try:
        return "truth" in parse_toml(path.read_bytes(), file=path)
    except (OSError, InputError):
        return True
