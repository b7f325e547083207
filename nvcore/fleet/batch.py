"""Comparison of some recordings of a store, by the library's own `compare`.

No number of a recording depends on the others (`nvcore.dataset.Dataset.each_alone`), so that the
results of batches only have to be concatenated.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from nvcore.comparison import compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.errors import InputError, NvcoreError, StoreError
from nvcore.fleet.results import ScanParams, Summary, gather, result_tables
from nvcore.fleet.tables import MISSING, TRUTH_KINDS
from nvcore.objects import PEDESTRIAN, objects_from
from nvcore.params import Params
from nvcore.schema import (
    ATTRIBUTE_DTYPES,
    DETECTABILITY_COLUMNS,
    RECORDING_DTYPES,
    TRUTH,
    categories_of,
    conform,
)
from nvcore.settings import Settings

__all__ = ["ScanParams", "dataset_of", "scan_batch"]

MAX_FRAMES: Final = 2_000_000
"""Most frames of a recording."""
_BOX_COLUMNS: Final = ["x", "y", "w", "h", "score", "track", "ignore", "distance_m", "occlusion"]


def scan_batch(
    tables: Mapping[str, pa.Table], params: ScanParams
) -> tuple[dict[str, pa.Table], Summary]:
    """Compare the recordings of a batch, each with the numbers that it has by itself.

    Parameters
    ----------
    tables
        ``recordings``, ``sources``, ``frames`` and ``boxes`` with the columns of
        `nvcore.fleet.tables`, whole recordings only; `source` as `params` names it. Frames are
        sorted by recording and frame, boxes of one source in one frame are in the file's order.

    Returns
    -------
    tables
        ``recordings``, ``encounters``, ``events``, ``intervals``, ``episodes``, ``quarantine``,
        and ``frames`` if asked for, with the columns of `nvcore.fleet.results.schema`, sorted by
        recording. A recording that cannot be compared is in ``quarantine`` alone, with the reason.
    summary
        Measures of these recordings, to be merged with those of other batches.

    Raises
    ------
    InputError
        If a recording is there twice.
    StoreError
        If a table cannot be read.
    """
    batch, refused, parts = BatchTables(tables), dict[str, str](), []
    waiting = batch.alike(params, refused)
    while waiting:
        names = waiting.pop()
        try:
            parts.append(batch.compare(names, params))
        except StoreError:  # no fault of a recording
            raise
        except NvcoreError as error:
            if len(names) == 1:
                refused[names[0]] = str(error)
            else:  # find the one at fault: compare each half by itself
                waiting += [names[: len(names) // 2], names[len(names) // 2 :]]
    results = gather(parts, refused, has_frames=params.frames)
    return results, Summary.of(results, params)


def dataset_of(tables: Mapping[str, pa.Table], params: ScanParams) -> Dataset:
    """The recordings of a batch as one dataset, whose settings are to compare X and Y as asked.

    Parameters
    ----------
    tables
        As for `scan_batch`.

    Raises
    ------
    InputError
        If a system was not run on a recording, if recordings differ in their objects or in the
        threshold of a system, or if frames or boxes are damaged.
    """
    batch = BatchTables(tables)
    refused: dict[str, str] = {}
    groups = batch.alike(params, refused)
    for name, reason in refused.items():
        raise InputError(f"recording {name!r}: {reason}")
    if len(groups) > 1:
        raise InputError(
            f"recordings {groups[0][0]!r} and {groups[1][0]!r} differ in their objects or in the "
            "threshold of a system: open one of them, or give the thresholds"
        )
    return batch.dataset(groups[0] if groups else [], params)


_Rows = dict[tuple[str, ...], list[slice]]
"""Stretches of rows with the same texts."""


class BatchTables:
    """The tables of a batch, and where the rows of each recording and source lie in them.

    Parameters
    ----------
    tables
        As for `scan_batch`.

    Raises
    ------
    InputError
        If a recording is there twice.
    """

    def __init__(self, tables: Mapping[str, pa.Table]):
        self._tables = tables
        self.recordings = tables["recordings"].to_pandas().set_index("recording").sort_index()
        if self.recordings.index.has_duplicates:
            double = self.recordings.index[self.recordings.index.duplicated()][0]
            raise InputError(f"recording {double!r} is twice in one batch; read one version of it")
        self._sources = tables["sources"].to_pandas().set_index(["recording", "source"])
        self._rows: dict[str, _Rows] = {}
        self._columns: dict[tuple[str, str], np.ndarray] = {}

    def alike(self, params: ScanParams, refused: MutableMapping[str, str]) -> list[list[str]]:
        """Group recordings that one comparison can hold, by name; the others are `refused`.

        They are of the same objects, and their systems have the same thresholds.
        """
        stored = self._sources["threshold"].to_dict()
        groups: dict[tuple[str, ...], list[str]] = {}
        for name, objects in self.recordings["objects"].items():
            missing = [of for of in (params.x, params.y) if (name, of) not in stored]
            n_frames = self._count("frames", (str(name),))
            if missing:
                refused[str(name)] = f"there are no results of {missing[0]} for it"
                continue
            if n_frames > MAX_FRAMES:
                refused[str(name)] = (
                    f"it has {n_frames:,} frames; a scan compares at most {MAX_FRAMES:,} of one "
                    "recording: divide it"
                )
                continue
            given = params.params.threshold_x, params.params.threshold_y
            own = [
                repr(stored[name, of]) if value is None else ""
                for of, value in zip((params.x, params.y), given, strict=True)
            ]
            groups.setdefault((*_listed(objects), *own), []).append(str(name))
        return [*groups.values()]

    def compare(self, names: Sequence[str], params: ScanParams) -> dict[str, pa.Table]:
        """Compare recordings that are `alike`; see `result_tables`."""
        result = compare(self.dataset(names, params, each_alone=True))
        kinds = self._sources["kind"].to_dict()
        # annotated, automatic or absent
        truth = [kinds.get((name, params.truth), "absent") or TRUTH_KINDS[0] for name in names]
        tables = result_tables(result, truth, params.frames)
        result.forget()  # it holds itself: free it now
        return tables

    def dataset(
        self, names: Sequence[str], params: ScanParams, *, each_alone: bool = False
    ) -> Dataset:
        """Recordings that are `alike` as a dataset, in this order.

        Raises
        ------
        InputError
            If frames or boxes are damaged.
        """
        recordings = self.recordings.loc[[*names]]
        frames = [self._column("frames", "frame", (name,)) for name in names]
        boxes, more = self._boxes(names, frames, params)
        if each_alone:
            more["each_alone"] = True
        versions = [*map(str, recordings["sha256"]), *self._versions(names, params)]
        dataset = dataset_from_tables(
            recordings[[name for name in RECORDING_DTYPES if name in recordings]].assign(
                name=pd.Series([*names], recordings.index, dtype=object),
                tags=[tuple(_listed(tags)) for tags in recordings["tags"]],
            ),
            frames,
            boxes,
            [params.x, params.y],
            fingerprint=hashlib.sha256("\n".join(versions).encode()).hexdigest(),
            settings=self._settings(names, params),
            **more,
        )
        speed_kmh = self._column("frames", "speed_kmh", *((name,) for name in names))
        return replace(dataset, frames=dataset.frames.assign(speed_kmh=speed_kmh))

    def _settings(self, names: Sequence[str], params: ScanParams) -> Settings:
        """Those of recordings that are `alike`, with their objects and thresholds."""
        stated: dict[str, Any] = params.params.given()
        for letter, of in (("x", params.x), ("y", params.y)):
            stored = self._sources["threshold"][names[0], of] if names else None
            if pd.notna(stored):
                stated.setdefault(f"threshold_{letter}", float(stored))
        objects = _listed(self.recordings["objects"][names[0]]) if names else ()
        kind = objects_from(objects) if objects else PEDESTRIAN
        return Settings(x=params.x, y=params.y, params=Params(**stated), objects=kind)

    def _versions(self, names: Sequence[str], params: ScanParams) -> list[str]:
        hashes = self._sources["sha256"].to_dict()
        return [str(hashes.get((name, of))) for name in names for of in params.sources]

    def _boxes(
        self, names: Sequence[str], frames: Sequence[np.ndarray], params: ScanParams
    ) -> tuple[pd.DataFrame, dict[str, Any]]:
        """Boxes of the recordings for a dataset, by source and recording, and fields of it."""
        keys = [(name, of) for of in params.sources for name in names]
        counts = [self._count("boxes", key) for key in keys]
        first = np.cumsum([0, *(len(listed) for listed in frames)])
        number, place = self._column("boxes", "frame", *keys), 0
        index = np.empty(len(number), np.int64)
        for (name, of), n, row in zip(keys, counts, [*range(len(names))] * 3, strict=True):
            index[place : place + n] = first[row] + _places(
                number[place : place + n], frames[row], f"recording {name!r}, {of}"
            )
            place += n
        columns = {name: self._column("boxes", name, *keys) for name in _BOX_COLUMNS}
        columns["frame_index"] = index
        columns["source"] = np.repeat(np.repeat([0, 1, 2], len(names)), counts)
        _check_boxes(columns, keys, np.repeat(np.arange(len(keys)), counts))
        given = self._tables["boxes"]
        more: dict[str, Any] = {}
        if given["detectability"].null_count < len(given):
            columns |= {name: self._column("boxes", name, *keys) for name in DETECTABILITY_COLUMNS}
        if given["label"].null_count < len(given):
            columns["label"], more["labels"] = self._texts("label", keys)
        if given["attributes"].null_count < len(given):
            code, texts = self._texts("attributes", keys)
            line = np.flatnonzero((code >= 0) & (columns["source"] == TRUTH))
            columns["line"] = np.arange(len(code))
            of_lines = {"line": line, "attributes": categories_of(code[line], texts)}
            more["attributes"] = conform(of_lines, ATTRIBUTE_DTYPES, n_rows=len(line))
        return pd.DataFrame(columns, copy=False), more

    def _rows_of(self, table: str) -> _Rows:
        """Where the rows of each recording (and source) lie; found when first asked for."""
        if table not in self._rows:
            names = ["recording", "source"] if table == "boxes" else ["recording"]
            self._rows[table] = _runs(self._tables[table], names)
        return self._rows[table]

    def _count(self, table: str, key: tuple[str, ...]) -> int:
        return sum(rows.stop - rows.start for rows in self._rows_of(table).get(key, ()))

    def _column(self, table: str, name: str, *keys: tuple[str, ...]) -> np.ndarray:
        """A column of the rows of these keys; missing cells are NaN, or as `MISSING` has them."""
        if (table, name) not in self._columns:
            column = self._tables[table][name]
            if name in MISSING:
                column = pc.fill_null(column, MISSING[name])
            self._columns[table, name] = column.to_numpy()
        return self._gather(self._columns[table, name], table, keys)

    def _texts(
        self, name: str, keys: Sequence[tuple[str, ...]]
    ) -> tuple[np.ndarray, tuple[str, ...]]:
        """Codes of a column of texts of the boxes, -1: none, and what they count."""
        code, known = _coded(self._tables["boxes"][name])
        used = sorted(np.unique(code[code >= 0]), key=lambda number: known[number])
        place = np.full(len(known) + 1, -1)
        place[used] = np.arange(len(used))
        texts = tuple(known[number] for number in used)
        return self._gather(place[code], "boxes", keys), texts

    def _gather(
        self, values: np.ndarray, table: str, keys: Sequence[tuple[str, ...]]
    ) -> np.ndarray:
        parts = [values[rows] for key in keys for rows in self._rows_of(table).get(key, ())]
        return parts[0] if len(parts) == 1 else np.concatenate([values[:0], *parts])


def _listed(values: Any) -> tuple[str, ...]:
    """A cell of a list column; empty where it is missing."""
    return () if values is None else tuple(map(str, values))


def _coded(column: pa.ChunkedArray) -> tuple[np.ndarray, list[str]]:
    """A column of texts as numbers, -1: none, and the text of each number."""
    is_coded = pa.types.is_dictionary(column.type)
    coded = column.unify_dictionaries() if is_coded else column.dictionary_encode()
    whole = coded.combine_chunks()
    return pc.fill_null(whole.indices, -1).to_numpy(), whole.dictionary.to_pylist()


def _runs(table: pa.Table, names: Sequence[str]) -> _Rows:
    """Rows with each combination of texts, in stretches."""
    if not len(table):
        return {}
    codes, texts = zip(*(_coded(table[name]) for name in names), strict=True)
    is_new = np.any([np.diff(code) != 0 for code in codes], axis=0)
    starts = np.concatenate([[0], np.flatnonzero(is_new) + 1])
    runs: _Rows = {}
    for start, stop in pairwise([*starts.tolist(), len(table)]):
        key = tuple(of[code[start]] for of, code in zip(texts, codes, strict=True))
        runs.setdefault(key, []).append(slice(start, stop))
    return runs


def _places(number: np.ndarray, listed: np.ndarray, whose: str) -> np.ndarray:
    """Where frame numbers stand among the listed ones of a recording; InputError if they do not."""
    if (np.diff(listed) <= 0).any():
        raise InputError(f"{whose}: its frames are not in order; ingest it again")
    if len(listed) and listed[-1] - listed[0] == len(listed) - 1:  # every frame
        place: np.ndarray = number - listed[0]
        is_there = (place >= 0) & (place < len(listed))
    else:
        place = np.searchsorted(listed, number)
        is_there = place < len(listed)
        is_there[is_there] = listed[place[is_there]] == number[is_there]
    if not is_there.all():
        frame = int(number[np.argmin(is_there)])
        raise InputError(
            f"{whose}: a box is in frame {frame}, which is not listed; ingest it again"
        )
    return place


def _check_boxes(
    columns: Mapping[str, np.ndarray], keys: Sequence[tuple[str, str]], key: np.ndarray
) -> None:
    """InputError if a box is none."""
    x, y, w, h = (columns[side] for side in ("x", "y", "w", "h"))
    is_box = (w > 0) & (h > 0) & np.isfinite(x + y + w + h)
    if not is_box.all():
        row = int(np.argmin(is_box))
        name, of = keys[key[row]]
        raise InputError(
            f"recording {name!r}, {of}: expected boxes with a width and a height, found x, y, w, h "
            f"{x[row]:g}, {y[row]:g}, {w[row]:g}, {h[row]:g}; ingest it again"
        )
