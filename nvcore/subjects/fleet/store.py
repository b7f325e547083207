"""Append-only stores of many recordings, read by whole recordings.

A store is a folder with four Delta tables (`nvcore.subjects.fleet.tables`). Data files are named by
their content. The table `sources` is committed last, and readers start from it, so an interrupted
ingest leaves nothing visible.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from functools import cached_property
from itertools import accumulate, groupby
from operator import itemgetter
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
import pandas as pd

from nvcore.common.errors import FormatError, InputError, StoreError
from nvcore.common.extras import needs
from nvcore.common.wording import MOST_NAMED, count_text, did_you_mean, listed
from nvcore.settings.params import Params
from nvcore.subjects.fleet.location import Location

with needs("fleet", "a store needs"):
    import pyarrow as pa
    import pyarrow.compute as pc
    import pyarrow.parquet as pq
    from deltalake import DeltaTable, Schema
    from deltalake.exceptions import DeltaError, TableNotFoundError
    from deltalake.transaction import AddAction, CommitProperties

    from nvcore.subjects.fleet.tables import (
        ADDED_LATER,
        IN_MEMORY,
        RECORDINGS,
        SCHEMAS,
        TRUTH_KINDS,
    )

GROUP_ROWS: Final = 1 << 18
"""Rows of a Parquet row group."""
VERSIONS: Final = "versions.json"
"""File of a store with the version of each table after the last append. It may lag behind."""
ROWS_IN: Final = {"recordings": "frames", "sources": "boxes"}
"""Tables with a row per version, and the table that holds the frames or boxes of each."""
_CONTENT: Final = {
    "recordings": ["recording", "sha256"],
    "sources": ["recording", "source", "sha256"],
}
"""Columns that identify a version."""
_STATED: Final = {"recordings": ["pictures", "first_picture"], "sources": ["kind"]}
"""Facts that a version keeps if a later input with the same content leaves the first one empty."""
_COMMIT_RETRIES: Final = 100
"""Commits of other writers in between before a writer gives up."""
_THREADS: Final = 8

_Name = tuple[str, str]  # of a recording, and a source; without a source: of the recording itself
_Versions = tuple[tuple[_Name, str], ...]
Older = set[tuple[str, str, int, int]]
"""Recording, source (empty: the recording itself), version, and the version that is the newest."""


class Store:
    """Store of recordings in a folder, which the first append creates."""

    def __init__(self, location: Location | str | Path):
        self.location = location if isinstance(location, Location) else Location(location)
        self._known: dict[str, pa.Table] = {}

    def __repr__(self) -> str:
        return f"Store({self.location.uri!r})"

    def snapshot(self) -> Snapshot:
        """Return the store as it is now, unchanged by later appends.

        Raises
        ------
        InputError
            If there is no store.
        StoreError
            If it cannot be read, or the newest file of a Delta log is missing.
        """
        reached = _versions_reached(self.location)
        names = reversed(SCHEMAS)  # recordings are committed before the sources that refer to them
        tables = {name: table for name in names if (table := _opened(self.location, name))}
        if len(tables) < len(SCHEMAS):
            raise InputError("there is no store here", file=self.location.uri)
        return Snapshot(self.location, _checked(self.location, tables, reached), self._known)

    @cached_property
    def _tables(self) -> dict[str, DeltaTable]:
        """The Delta tables, created if they do not exist."""
        if self.location.list("plans/") and _opened(self.location, "sources") is None:
            uri = self.location.uri
            raise InputError("holds results of a scan; name another folder", file=uri)
        return {name: _opened(self.location, name) or self._create(name) for name in SCHEMAS}

    def _create(self, name: str) -> DeltaTable:
        with self.location.at(name, "made"):
            try:
                return DeltaTable.create(
                    f"{self.location.uri}/{name}",
                    Schema.from_arrow(SCHEMAS[name]),
                    storage_options=self.location.delta_options,
                )
            except DeltaError:
                if table := _opened(self.location, name):  # another writer was first
                    return table
                raise

    def append(
        self, batch: Sequence[Mapping[str, pa.Table]], *, newest: bool = False
    ) -> tuple[dict[str, pa.Table], Older]:
        """Append new versions of recordings and sources, with one commit per table.

        A version that the store has does not become the newest again; a row notes new labels, kinds
        of truth, pictures and parameters. If a batch has a version several times, the last one
        counts. Several writers may append at once. An interrupted append leaves nothing visible.

        Parameters
        ----------
        batch
            One or more results of `nvcore.subjects.fleet.ingest.tables_of`.
        newest
            Whether versions that the store has become the newest again.

        Returns
        -------
        dict
            Rows of ``recordings`` and ``sources`` whose content is new.
        set
            Given versions that are not the newest ones (`Older`).

        Raises
        ------
        StoreError
            If the store cannot be read or written.
        """
        tables, reached = self._tables, _versions_reached(self.location)
        with self.location.at("", "read"):
            for table in tables.values():
                table.update_incremental()
        _checked(self.location, tables, reached)
        given = {name: pa.concat_tables([of[name] for of in batch]) for name in SCHEMAS}
        new: dict[str, pa.Table] = {}
        actions: dict[str, list[AddAction]] = {}
        for name, data in ROWS_IN.items():
            own = given[name]["recording"]
            stored = _rows(self.location, name, tables[name], self._known, own).to_pylist()
            content, facts = itemgetter(*_CONTENT[name]), _STATED[name]
            known = {content(row): row for row in stored}
            rows: dict[tuple[str, ...], dict[str, Any]] = {}
            pieces = {}
            # the rows of a batch follow each other in its tables
            stops = np.cumsum(given[name]["n_rows"]).tolist()
            for row, stop in zip(given[name].to_pylist(), stops, strict=True):
                key = content(row)
                before = rows.get(key) or known.get(key) or row | {"kind": TRUTH_KINDS[0]}
                kept = ["file", "first_row", *([] if row[facts[0]] else facts)]
                rows[key] = row | {fact: before[fact] for fact in kept}
                if key not in known:
                    pieces[key] = given[data].slice(stop - row["n_rows"], row["n_rows"])
            order = sorted(pieces)
            whole = pa.concat_tables([given[data].slice(0, 0), *(pieces[key] for key in order)])
            actions[data] = self._put(data, whole)
            file = actions[data][0].path if len(whole) else ""
            starts = accumulate((len(pieces[key]) for key in order), initial=0)
            for key, start in zip(order, starts, strict=False):
                rows[key] |= {"file": file, "first_row": start}
            if name == "sources":
                older = _note_newest(stored, rows.values(), newest=newest)
            labels = {(content(row), of) for row in stored for of in ("", row.get("label", ""))}
            # later than stored rows, regardless of the clocks of other writers
            now = max([datetime.now(UTC), *(row["ingested_at"] for row in stored[-1:])])
            added: dict[tuple[str, ...], dict[str, Any]] = {}
            n_added = Counter[tuple[str, ...]]()
            for key, row in rows.items():
                if (
                    key not in known
                    or not row.get("amends", True)
                    or (key, row.get("label", "")) not in labels
                    or any(row.get(of) != known[key].get(of) for of in (*facts, "parameters"))
                ):
                    n_added[key[:-1]] += 1
                    at = now + n_added[key[:-1]] * timedelta(microseconds=1)
                    added[key] = row | {"ingested_at": at}
            made = pa.Table.from_pylist([*added.values()], SCHEMAS[name])
            new[name] = made.filter(pa.array([key not in known for key in added], pa.bool_()))
            actions[name] = self._put(name, made.sort_by("recording"))
        for name in SCHEMAS:  # in this order: nothing is visible before the last one
            if actions[name]:
                self._commit(name, actions[name])
        if any(actions.values()):
            after = _versions_reached(self.location)
            for name, table in tables.items():  # higher by 1, or by more with other writers
                after[name] = max(after[name], table.version() + bool(actions[name]))
            self.location.write(VERSIONS, json.dumps(after).encode())
        return new, older

    def _put(self, name: str, rows: pa.Table) -> list[AddAction]:
        """Write rows that are sorted by recording to a file, and return its commit action.

        No rows give no file and no action.
        """
        if not len(rows):
            return []
        sink = pa.BufferOutputStream()
        pq.write_table(
            rows.unify_dictionaries(),
            sink,
            row_group_size=GROUP_ROWS,
            compression="zstd",
            write_page_checksum=True,
            store_schema=False,
        )
        content = sink.getvalue()
        path = f"part-{hashlib.sha256(content).hexdigest()[:16]}.parquet"
        self.location.write(f"{name}/{path}", content.to_pybytes())
        stats = json.dumps({"numRecords": len(rows)})
        # older stores may be partitioned: new files get no value of the key
        parts = dict.fromkeys(self._tables[name].metadata().partition_columns)
        return [AddAction(path, content.size, parts, int(time.time() * 1000), True, stats)]

    def _commit(self, name: str, actions: list[Any]) -> None:
        table = self._tables[name]
        with self.location.at(name, "written"):
            table.create_write_transaction(
                actions,
                mode="append",
                schema=table.schema(),
                commit_properties=CommitProperties(max_commit_retries=_COMMIT_RETRIES),
            )


def _note_newest(
    stored: Sequence[dict[str, Any]], given: Collection[dict[str, Any]], *, newest: bool
) -> Older:
    """Set ``amends`` in given rows of sources. Return given versions that are not the newest."""
    numbers: dict[_Name, dict[str, int]] = {}
    last: dict[_Name, _Versions] = {}
    known: set[_Versions] = set()
    for row in (*stored, *given):
        own = versions_in(row)
        (recording, _), (source, _) = own
        if row["amends"] is None:  # a given row
            is_last = last.get(source) == own and last[recording][0] == own[0]
            row["amends"] = own in known and (is_last or not newest)
        if not row["amends"]:
            last[recording] = last[source] = own
        known.add(own)
        for name, version in own:
            numbers.setdefault(name, {}).setdefault(version, len(numbers[name]) + 1)
    return {
        (*name, numbers[name][version], numbers[name][dict(last[name])[name]])
        for row in given
        for name, version in versions_in(row)
        if version != dict(last[name])[name]
    }


def versions_in(row: Mapping[str, Any]) -> _Versions:
    """Return name and version of a row's recording, then of its source."""
    recording = row["recording"]
    return ((recording, ""), row["recording_sha256"]), ((recording, row["source"]), row["sha256"])


class Snapshot:
    """A store at one time. Its pickle is small, as another process reads the rows again.

    Parameters
    ----------
    location
        Location of the store.
    versions
        Delta versions of its tables.

    Attributes
    ----------
    recordings
        The newest version of every recording, by recording; columns of `tables.RECORDINGS`.
    sources
        Every version of every source, by recording, source and version; columns of
        `tables.SOURCES`, and version: counted from 1 in the order of the first ingest.
    """

    def __init__(
        self,
        location: Location,
        versions: Mapping[str, int],
        known: dict[str, pa.Table] | None = None,
    ):
        self.location = location
        self.versions = dict(versions)
        self._known = {} if known is None else known
        self._picked: dict[str, pd.DataFrame] = {}

    def __reduce__(self) -> tuple[type[Snapshot], tuple[Location, dict[str, int]]]:
        return Snapshot, (self.location, self.versions)

    def _table(self, name: str) -> pd.DataFrame:
        """Return the rows of recordings or sources, oldest first."""
        table = _opened(self.location, name, self.versions[name])
        if table is None:  # it existed when the snapshot was made
            raise StoreError("cannot be read (it is not there)", file=self.location.uri)
        return pd.DataFrame(_rows(self.location, name, table, self._known).to_pandas())

    @cached_property
    def _stated(self) -> pd.DataFrame:
        """Rows of sources, oldest first, with their version number."""
        rows = self._table("sources")
        is_first = ~rows.duplicated(_CONTENT["sources"])
        number = is_first.groupby([rows["recording"], rows["source"]]).cumsum()
        version = number.groupby([rows[key] for key in _CONTENT["sources"]]).transform("first")
        return rows.assign(version=version, label=rows["label"].replace("", None))

    @cached_property
    def recordings(self) -> pd.DataFrame:
        """Newest version of every recording: the one that its last ingested source refers to."""
        came = self._stated[~self._stated["amends"]]
        came = came[["recording", "recording_sha256", "ingested_at"]]
        came = came.set_axis([*_CONTENT["recordings"], "ingested_at"], axis=1)
        newest = came.drop_duplicates("recording", keep="last")[_CONTENT["recordings"]]
        rows = self._table("recordings").drop_duplicates(_CONTENT["recordings"], keep="last")
        first = came.drop_duplicates(_CONTENT["recordings"])
        rows = rows.drop(columns="ingested_at").merge(newest).merge(first)
        if len(rows) < len(newest):
            raise StoreError(
                "a commit is missing: the table sources refers to recordings that are not there",
                file=f"{self.location.uri}/recordings/_delta_log",
            )
        rows = rows[RECORDINGS.names].set_axis(rows["recording"].array)
        return pd.DataFrame(rows.sort_index())

    @cached_property
    def sources(self) -> pd.DataFrame:
        """Every version of every source."""
        contents = self._stated.groupby(_CONTENT["sources"])
        rows = contents.last()  # of stated facts: a row without any changes nothing
        rows = rows.assign(
            ingested_at=contents["ingested_at"].first(), label=rows["label"].fillna("")
        )
        order = ["recording", "source", "version"]
        return rows.reset_index().sort_values(order, ignore_index=True)

    def pick(self, source: str) -> pd.DataFrame:
        """Return one version of a source per recording: rows of `sources`, indexed by recording.

        Sources that came with another version of the recording than its newest are left out.

        Parameters
        ----------
        source
            A name for the newest version, a name with ``@2`` for the second one, or with ``@label``
            for the newest with that label.

        Raises
        ------
        InputError
            If there is no such source or version.
        """
        if source in self._picked:
            return self._picked[source]
        names = self.sources["source"].unique().tolist()
        name, at, version = source.rpartition("@")
        if source in names:
            name, at = source, ""
        elif name not in names:
            known = did_you_mean(source, names, f"there are {listed(names, most=MOST_NAMED)}")
            raise InputError(f"there is no source {source!r}; {known}", file=self.location.uri)
        rows = self._stated[self._stated["source"] == name]
        # sources of another version of the recording have other frames or another picture size
        newest = self.recordings["sha256"].reindex(rows["recording"]).to_numpy()
        came = rows[~rows["amends"] & (rows["recording_sha256"] == newest)][_CONTENT["sources"]]
        if at:
            wanted = rows[(rows["version"].map(str) == version) | (rows["label"] == version)]
            if wanted.empty:
                labels = sorted(rows["label"].dropna().unique())
                raise InputError(
                    f"there is no version {version!r} of {name!r}; there are 1 to "
                    f"{rows['version'].max()}"
                    f"{', and ' + listed(labels, most=MOST_NAMED) if labels else ''}",
                    file=self.location.uri,
                )
            wanted = wanted.drop_duplicates("recording", keep="last")
            came = came.merge(wanted[_CONTENT["sources"]])
        rows = self.sources.merge(came.drop_duplicates("recording", keep="last"))
        self._picked[source] = rows.set_axis(rows["recording"].array)
        return self._picked[source]

    def read(self, recordings: Sequence[str], sources: Sequence[str]) -> dict[str, pa.Table]:
        """Read whole recordings with some of their sources.

        Parameters
        ----------
        sources
            As for `pick`. A recording need not have all of them.

        Returns
        -------
        dict
            ``recordings``, ``sources``, ``frames`` (by recording and frame) and ``boxes`` (by
            recording, source in the order asked for, and frame); first_row and n_rows of the first
            two refer to the last two. The column source holds the names asked for.

        Raises
        ------
        InputError
            If there is no such recording or source, or a file is missing or damaged.
        StoreError
            If the store cannot be read.
        """
        names = sorted({*recordings})
        chosen = self.recordings[self.recordings.index.isin(names)]
        if len(chosen) < len(names):
            missing = min({*names}.difference(chosen["recording"]))
            known = f"there are {count_text(len(self.recordings), 'recording')}"
            known = did_you_mean(missing, self.recordings.index.tolist(), known)
            raise InputError(f"there is no recording {missing!r}; {known}", file=self.location.uri)
        picked = [self.pick(of).assign(source=of) for of in sources]
        picked = [rows[rows.index.isin(names)] for rows in picked]
        found = pd.concat([self.sources[:0], *picked]).sort_values("recording", kind="stable")
        tables = {}
        for name, rows in (("recordings", chosen), ("sources", found)):
            tables[ROWS_IN[name]] = self._read_rows(ROWS_IN[name], rows)
            own = rows.assign(file="", first_row=rows["n_rows"].cumsum() - rows["n_rows"])
            tables[name] = pa.Table.from_pandas(own, SCHEMAS[name], preserve_index=False)
        return tables

    def _read_rows(self, name: str, rows: pd.DataFrame) -> pa.Table:
        """Read the frames or boxes of the given versions, in their order."""
        schema = IN_MEMORY[name]
        # recording and source are known from the versions and need not be read
        given = [column for column in ("recording", "source") if column in schema.names]
        own = pa.schema([column for column in schema if column.name not in given])
        texts = [column.name for column in own if pa.types.is_dictionary(column.type)]
        read: dict[str, tuple[pa.Table, int]] = {}
        rows = rows[rows["n_rows"] > 0]
        for file, of_file in rows.groupby("file"):
            last = (of_file["first_row"] + of_file["n_rows"]).max()
            with _file_of(self.location, f"{name}/{file}", texts) as parquet:
                if last > parquet.metadata.num_rows:
                    raise ValueError("it has fewer rows than the store says")
                n_of_group = parquet.metadata.row_group(0).num_rows  # the last one may be smaller
                groups = range(of_file["first_row"].min() // n_of_group, -(-last // n_of_group))
                table = parquet.read_row_groups([*groups], columns=own.names)
            read[str(file)] = table, groups[0] * n_of_group
        stretches = rows[["file", "first_row", "n_rows"]].itertuples(index=False)
        pieces = [read[file][0].slice(at - read[file][1], n_rows) for file, at, n_rows in stretches]
        whole = pa.concat_tables([own.empty_table(), *pieces])
        whole = whole.unify_dictionaries().combine_chunks()
        version = np.repeat(np.arange(len(rows)), rows["n_rows"])
        for position, column in enumerate(given):
            of_version = pa.array(rows[column], pa.string()).dictionary_encode()
            whole = whole.add_column(position, schema.field(column), of_version.take(version))
        return whole.cast(schema)


def other_settings(recordings: pd.DataFrame, params: Params) -> str:
    """Describe settings of recordings that differ from a scan's, or return an empty text."""
    used = asdict(params)
    shown = {None: "the default"}
    differing = [
        {
            (name, str(shown.get(value, value)))
            for name, value in json.loads(text or "{}").items()
            if value != used.get(name)
        }
        for text in recordings["parameters"]
    ]
    texts = [
        f"{name} {' or '.join(value for _, value in values)} "
        f"(the scan uses {shown.get(used.get(name), used.get(name))})"
        for name, values in groupby(sorted(set().union(*differing)), key=itemgetter(0))
    ]
    n, of = sum(map(bool, differing)), count_text(len(recordings), "recording")
    verb = "was" if n == 1 else "were"
    return f"{n:,} of {of} {verb} ingested with other settings: {', '.join(texts)}" if n else ""


@contextmanager
def _file_of(location: Location, path: str, texts: Sequence[str] = ()) -> Iterator[pq.ParquetFile]:
    """Open a Parquet file of a store, or raise an error that names it."""
    uri = f"{location.uri}/{path}"
    try:
        with location.at(path, "read"), location.open(path) as source:
            try:
                yield pq.ParquetFile(
                    source,
                    read_dictionary=[*texts],
                    pre_buffer=location.path is None,
                    page_checksum_verification=True,
                )
            except (pa.ArrowException, OSError, KeyError, ValueError) as error:
                if isinstance(error, MemoryError) or getattr(error, "errno", None) is not None:
                    raise
                raise FormatError(f"is damaged ({error})", file=uri) from error
    except FileNotFoundError as error:
        if not location.list("sources/_delta_log/"):  # this machine does not see the store
            raise StoreError("cannot be read (it is not there)", file=location.uri) from error
        raise InputError("is missing in the store", file=uri) from error


def _opened(location: Location, name: str, version: int | None = None) -> DeltaTable | None:
    """Open a table of a store at a version, or return None if it does not exist."""
    with location.at(name, "read"):
        try:
            return DeltaTable(
                f"{location.uri}/{name}", version, storage_options=location.delta_options
            )
        except TableNotFoundError:
            return None


def _versions_reached(location: Location) -> dict[str, int]:
    """Return the table versions that an earlier append recorded, 0 without such a file."""
    try:
        content = json.loads(location.find(VERSIONS) or b"{}")
        return {name: int(content.get(name, 0)) for name in SCHEMAS}
    except (ValueError, TypeError, AttributeError) as error:
        raise StoreError("is damaged; delete it", file=f"{location.uri}/{VERSIONS}") from error


def _checked(
    location: Location, tables: Mapping[str, DeltaTable], reached: Mapping[str, int]
) -> dict[str, int]:
    """Return the versions of tables, or raise StoreError if one is older than recorded."""
    versions = {name: table.version() for name, table in tables.items()}
    for name, version in versions.items():
        if version < reached[name]:
            raise StoreError(
                f"version {reached[name]} of this table is missing, the newest is {version}; "
                f"restore the log, or delete {VERSIONS} and ingest again what was lost",
                file=f"{location.uri}/{name}/_delta_log",
            )
    return versions


def _rows(
    location: Location,
    name: str,
    table: DeltaTable,
    known: dict[str, pa.Table],
    recordings: pa.ChunkedArray | None = None,
) -> pa.Table:
    """Read rows of recordings or sources, oldest first, caching them by file in `known`."""
    schema = SCHEMAS[name]

    def read(path: str) -> pa.Table:
        with _file_of(location, path) as parquet:
            rows = parquet.read()
            for column in {*schema.names}.difference(rows.column_names):
                rows = rows.append_column(column, pa.repeat(ADDED_LATER[column], len(rows)))
            return rows.select(schema.names).cast(schema)

    with location.at(name, "read"):
        files = pa.table(table.get_add_actions())["path"].to_pylist()
    paths = [f"{name}/{unquote(file)}" for file in files]
    new = [path for path in paths if path not in known]
    with ThreadPoolExecutor(_THREADS) as pool:
        known.update(zip(new, pool.map(read, new), strict=True))
    rows = pa.concat_tables([schema.empty_table(), *(known[path] for path in paths)])
    if recordings is not None:
        rows = rows.filter(pc.is_in(rows["recording"], value_set=recordings))
    return rows.sort_by([(column, "ascending") for column in ("ingested_at", *_CONTENT[name])])
