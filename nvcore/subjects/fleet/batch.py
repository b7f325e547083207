"""Compare a batch of a store's recordings by `nvcore.comparison.compare.compare`.

No number of a recording depends on the others (`nvcore.dataset.Dataset.each_alone`), so that the
results of batches only have to be concatenated.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, MutableMapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa

from nvcore.common.errors import InputError, NvcoreError
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.schema import (
    ATTRIBUTE_DTYPES,
    DETECTABILITY_COLUMNS,
    RECORDING_DTYPES,
    TRUTH,
    conform,
)
from nvcore.dataset.tables import dataset_from_tables
from nvcore.settings.defaults import Settings
from nvcore.settings.objects import PEDESTRIAN, objects_from
from nvcore.subjects.fleet.results import ScanParams, gather, result_tables
from nvcore.subjects.fleet.tables import MISSING, TRUTH_KINDS

__all__ = ["ScanParams", "dataset_of", "scan_batch"]

MAX_FRAMES: Final = 2_000_000
"""Most frames of a recording."""
_BOX_COLUMNS: Final = ("x", "y", "w", "h", "score", "track", "ignore", "distance_m", "occlusion")


def scan_batch(tables: Mapping[str, pa.Table], params: ScanParams) -> dict[str, pa.Table]:
    """Compare the recordings of a batch, each by itself.

    Parameters
    ----------
    tables
        Tables of whole recordings, as `nvcore.subjects.fleet.store.Snapshot.read` returns them.

    Returns
    -------
    dict
        Tables of results, with the columns of `nvcore.subjects.fleet.results.schema` and sorted by
        recording. A recording that cannot be compared is in ``quarantine`` only, with the reason.

    Raises
    ------
    InputError
        If a recording occurs twice.
    """
    batch, refused, parts = _Batch(tables, params), dict[str, str](), []
    waiting = batch.alike(refused)
    while waiting:
        names = waiting.pop()
        try:
            parts.append(batch.compare(names))
        except NvcoreError as error:
            if len(names) == 1:
                refused[names[0]] = str(error)
            else:  # bisect to find the recording that fails
                waiting += [names[: len(names) // 2], names[len(names) // 2 :]]
    return gather(parts, refused, has_frames=params.frames)


def dataset_of(tables: Mapping[str, pa.Table], params: ScanParams) -> Dataset:
    """Return the recordings of a batch as one dataset, with the settings that compare X and Y.

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
    batch = _Batch(tables, params)
    refused: dict[str, str] = {}
    groups = batch.alike(refused)
    for name, reason in refused.items():
        raise InputError(f"recording {name!r}: {reason}")
    if len(groups) > 1:
        raise InputError(
            f"recordings {groups[0][0]!r} and {groups[1][0]!r} differ in their objects or in the "
            "threshold of a system: open one of them, or give the thresholds"
        )
    return batch.dataset(groups[0] if groups else [])


class _Batch:
    """The tables of a batch, divided by recording and source."""

    def __init__(self, tables: Mapping[str, pa.Table], params: ScanParams):
        self._tables, self._params = tables, params
        self._recordings = tables["recordings"].to_pandas().set_index("recording").sort_index()
        names = self._recordings.index
        if names.has_duplicates:
            double = names[names.duplicated()][0]
            raise InputError(f"recording {double!r} is twice in one batch; read one version of it")
        facts = tables["sources"].select(["recording", "source", "sha256", "kind", "threshold"])
        self._sources = {(of["recording"], of["source"]): of for of in facts.to_pylist()}
        self._divided: dict[str, dict[tuple[str, ...], list[pa.Table]]] = {}

    def alike(self, refused: MutableMapping[str, str]) -> list[list[str]]:
        """Group recordings by objects and thresholds, and note in `refused` why others fail."""
        groups: dict[tuple[Any, ...], list[str]] = {}
        for name in map(str, self._recordings.index):
            try:
                groups.setdefault(self._settings_of(name), []).append(name)
            except InputError as error:
                refused[name] = str(error)
        return [*groups.values()]

    def compare(self, names: Sequence[str]) -> dict[str, pa.Table]:
        """Compare the recordings of a group from `alike`, and return their tables of results."""
        params = self._params
        result = compare(self.dataset(names, each_alone=True))
        sources = [self._sources.get((name, params.truth), {"kind": "absent"}) for name in names]
        truth = [of["kind"] or TRUTH_KINDS[0] for of in sources]
        tables = result_tables(result, truth, params.frames)
        result.forget()  # break its reference cycle to free memory now
        return tables

    def dataset(self, names: Sequence[str], *, each_alone: bool = False) -> Dataset:
        """Return the recordings of a group from `alike` as a dataset, in this order.

        Raises
        ------
        InputError
            If frames or boxes are damaged.
        """
        own, recordings = self._params, self._recordings.loc[[*names]]
        objects, x, y = self._settings_of(names[0]) if names else ((), None, None)
        settings = Settings(
            x=own.x,
            y=own.y,
            params=replace(own.params, threshold_x=x, threshold_y=y),
            objects=objects_from(objects) if objects else PEDESTRIAN,
        )
        versions = [*recordings["sha256"]]
        versions += [
            self._sources.get((name, of), {}).get("sha256") for name in names for of in own.sources
        ]
        frames = self._rows_of("frames", [(name,) for name in names])
        boxes, more = self._boxes(names, [of["frame"].to_numpy() for of in frames])
        dataset = dataset_from_tables(
            recordings.reindex(columns=[*RECORDING_DTYPES]).assign(
                name=np.array(names, dtype=object),
                tags=[_listed(tags) for tags in recordings["tags"]],
            ),
            [of["frame"].to_numpy() for of in frames],
            boxes,
            [own.x, own.y],
            fingerprint=hashlib.sha256("\n".join(map(str, versions)).encode()).hexdigest(),
            settings=settings,
            each_alone=each_alone,
            **more,
        )
        speed_kmh = np.concatenate([[], *(of["speed_kmh"].to_numpy() for of in frames)])
        return replace(dataset, frames=dataset.frames.assign(speed_kmh=speed_kmh))

    def _settings_of(self, name: str) -> tuple[tuple[str, ...], float | None, float | None]:
        """Return the objects of a recording and the thresholds of X and Y.

        Raises
        ------
        InputError
            If the recording cannot be compared.
        """
        own = self._params
        for of in (own.x, own.y):
            if (name, of) not in self._sources:
                raise InputError(f"there are no results of {of} for it")
        n_frames = self._recordings["n_rows"][name]
        if n_frames > MAX_FRAMES:
            raise InputError(
                f"it has {n_frames:,} frames; a scan compares at most {MAX_FRAMES:,} of one "
                "recording: divide it"
            )
        x, y = own.params.threshold_x, own.params.threshold_y
        return (
            _listed(self._recordings["objects"][name]),
            self._sources[name, own.x]["threshold"] if x is None else x,
            self._sources[name, own.y]["threshold"] if y is None else y,
        )

    def _boxes(
        self, names: Sequence[str], frames: Sequence[np.ndarray]
    ) -> tuple[pd.DataFrame, dict[str, Any]]:
        """Return the boxes of recordings, and the dataset's fields for labels and attributes."""
        keys = [(name, of) for of in self._params.sources for name in names]
        parts = self._rows_of("boxes", keys)
        table = pa.concat_tables([self._tables["boxes"].slice(0, 0), *parts])
        columns = _columns(table, _BOX_COLUMNS)
        key = np.repeat(np.arange(len(keys)), [len(part) for part in parts])
        x, y, w, h = (columns[side] for side in ("x", "y", "w", "h"))
        for row in np.flatnonzero(~((w > 0) & (h > 0) & np.isfinite(x + y + w + h)))[:1]:
            name, of = keys[key[row]]
            raise InputError(
                f"recording {name!r}, {of}: expected boxes with a width and a height, found "
                f"x, y, w, h {x[row]:g}, {y[row]:g}, {w[row]:g}, {h[row]:g}; ingest it again"
            )
        first, index = np.cumsum([0, *map(len, frames)]), [np.empty(0, np.int64)]
        for number, (name, of) in enumerate(keys):
            row = number % len(names)
            of_box = parts[number]["frame"].to_numpy()
            index.append(first[row] + _places(of_box, frames[row], f"recording {name!r}, {of}"))
        columns["frame_index"] = np.concatenate(index)
        columns["source"] = key // max(len(names), 1)
        more: dict[str, Any] = {}
        if table["detectability"].null_count < len(table):
            columns |= _columns(table, DETECTABILITY_COLUMNS)
        if table["label"].null_count < len(table):
            labels = _texts(table["label"])
            columns["label"], more["labels"] = labels.codes, tuple(labels.categories)
        if table["attributes"].null_count < len(table):
            texts = _texts(table["attributes"])
            line = np.flatnonzero((texts.codes >= 0) & (columns["source"] == TRUTH))
            columns["line"] = np.arange(len(table))
            of_lines = {"line": line, "attributes": texts[line]}
            more["attributes"] = conform(of_lines, ATTRIBUTE_DTYPES, n_rows=len(line))
        return pd.DataFrame(columns, copy=False), more

    def _rows_of(self, name: str, keys: Sequence[tuple[str, ...]]) -> list[pa.Table]:
        """Return the rows of a table for each key: recording, or recording and source.

        The table is split when it is first used.
        """
        if name not in self._divided:
            self._divided[name] = _divided(self._tables[name])
        nothing = self._tables[name].slice(0, 0)
        return [pa.concat_tables(self._divided[name].get(key, [nothing])) for key in keys]


def _listed(values: Any) -> tuple[str, ...]:
    """Return a cell of a list column as texts, empty if it is missing."""
    return () if values is None else tuple(map(str, values))


def _divided(table: pa.Table) -> dict[tuple[str, ...], list[pa.Table]]:
    """Split a table into slices by recording, and by source if it has that column."""
    names = [name for name in ("recording", "source") if name in table.column_names]
    texts = [table[name].unify_dictionaries().dictionary_encode() for name in names]
    codes = np.stack([of.combine_chunks().indices for of in texts])
    starts = np.flatnonzero(np.diff(codes, prepend=-1).any(axis=0))
    keys = zip(*(of.take(pa.array(starts)).to_pylist() for of in texts), strict=True)
    divided: dict[tuple[str, ...], list[pa.Table]] = {}
    for key, start, n_rows in zip(keys, starts, np.diff(starts, append=len(table)), strict=True):
        divided.setdefault(key, []).append(table.slice(start, n_rows))
    return divided


def _columns(table: pa.Table, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Return columns of boxes, with missing cells as NaN or as in `MISSING`."""
    columns = {name: table[name] for name in names}
    columns |= {name: columns[name].fill_null(MISSING[name]) for name in names if name in MISSING}
    return {name: column.to_numpy() for name, column in columns.items()}


def _texts(column: pa.ChunkedArray) -> pd.Categorical[Any]:
    """Return a column of texts as a categorical with sorted categories, without unused ones."""
    texts = pd.Categorical(column.unify_dictionaries().to_pandas()).remove_unused_categories()
    return texts.reorder_categories(sorted(texts.categories))


def _places(number: np.ndarray, listed: np.ndarray, whose: str) -> np.ndarray:
    """Return the positions of frame numbers in a recording's list of frames.

    Raises
    ------
    InputError
        If listed frames are not sorted, or a frame is missing.
    """
    if (np.diff(listed) <= 0).any():
        raise InputError(f"{whose}: its frames are not in order; ingest it again")
    place = np.searchsorted(listed, number)
    is_missing = place == np.searchsorted(listed, number, side="right")
    for frame in number[is_missing][:1]:
        raise InputError(
            f"{whose}: a box is in frame {frame}, which is not listed; ingest it again"
        )
    return place
