"""Stores of many recordings: appended to, never overwritten, read by whole recordings.

A store is a folder with four Delta tables (`nvcore.fleet.tables`). Their files are named by their
content and committed with the sources last, from which a reader goes to recordings and files: so
nothing is seen of what a broken ingest left behind.
"""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections import ChainMap, Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import cache, cached_property, partial
from itertools import groupby
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
import pandas as pd

from nvcore.errors import FormatError, InputError, StoreError
from nvcore.extras import needs
from nvcore.fleet.location import Location
from nvcore.wording import MOST_NAMED, did_you_mean, listed

with needs("fleet", "a store needs"):
    import pyarrow as pa
    import pyarrow.parquet as pq
    from deltalake import DeltaTable, Schema
    from deltalake.exceptions import DeltaError, TableNotFoundError
    from deltalake.transaction import AddAction, CommitProperties

    from nvcore.fleet.tables import IN_MEMORY, INDEX, SCHEMAS, TRUTH_KINDS

GROUP_ROWS: Final = 1 << 18
"""Rows from which on a row group is full; it holds whole sources, unless one is larger."""
MAX_GROUP_ROWS: Final = 1 << 20
ROWS_IN: Final = {"recordings": "frames", "sources": "boxes"}
"""Where the rows are that a row of the other table refers to."""
_REFERS_TO: Final = {rows: name for name, rows in ROWS_IN.items()}
_CONTENT: Final = {
    "recordings": ["recording", "sha256"],
    "sources": ["recording", "source", "sha256"],
}
"""What tells versions apart."""
_STATED: Final = {
    "recordings": ["recording", "sha256", "pictures", "first_picture"],
    "sources": ["recording", "source", "sha256", "recording_sha256", "label", "kind"],
}
"""What a row says; it is written if any of it is not so yet."""
_AMENDABLE: Final = {"recordings": ["pictures", "first_picture"], "sources": ["kind"]}
"""Facts of a version that it keeps where a later row does not state them."""
_INDEX: Final = [column.name for column in INDEX]
_KEY: Final = re.compile(r"[a-z][a-z0-9_]{0,40}")
_COMMIT_RETRIES: Final = 100
"""Writers that may come in between before one gives up."""
_THREADS: Final = 8
_LONGEST_IN_STATS: Final = 200


@dataclass
class _Learned:
    """What a writer knows of a table.

    Attributes
    ----------
    paths
        Files of which the rows are known.
    index
        Where the rows of a content lie.
    facts
        What is so, see `_facts_of`.
    newest
        Time of the newest row.
    """

    paths: set[str] = field(default_factory=set)
    index: dict[tuple[Any, ...], tuple[Any, ...]] = field(default_factory=dict)
    facts: dict[tuple[Any, ...], Any] = field(default_factory=dict)
    newest: datetime = datetime.min.replace(tzinfo=UTC)


class Store:
    """A store of recordings, by its location.

    Parameters
    ----------
    location
        Its folder; made when it is first appended to.
    partition
        How new files are divided: by ``month``, ``unit`` or the key of a tag. None: as the store
        is; a new one is not divided.

    Raises
    ------
    InputError
        If a store cannot be divided by that.
    """

    def __init__(self, location: Location | str | Path, *, partition: str | None = None):
        self.location = location if isinstance(location, Location) else Location(location)
        columns = {name for schema in SCHEMAS.values() for name in schema.names} - {"unit"}
        if partition is not None and (not _KEY.fullmatch(partition) or partition in columns):
            raise InputError(
                f"a store cannot be divided by {partition[:40]!r}; expected month, unit, or "
                "the key of a tag in lower-case letters that is none of its columns"
            )
        self._wanted = partition
        self._known: dict[str, pa.Table] = {}
        self._learned = {name: _Learned() for name in ROWS_IN}

    def __reduce__(self) -> Any:
        return partial(Store, self.location, partition=self._wanted), ()

    def __repr__(self) -> str:
        return f"Store({self.location.uri!r})"

    def snapshot(self) -> Snapshot:
        """What the store holds now, whatever is appended later.

        Raises
        ------
        InputError
            If there is no store.
        StoreError
            If it cannot be read.
        """
        versions: dict[str, int] = {}
        for name in reversed(SCHEMAS):  # so that all is there that a source refers to
            table = _opened(self.location, name)
            if table is None:
                raise InputError("there is no store here", file=self.location.uri)
            versions[name] = table.version()
        return Snapshot(self.location, versions, self._known)

    @cached_property
    def _broken(self) -> set[str]:
        """Files of frames and boxes that are not there as the log has them: written anew."""
        broken = set()
        for name in IN_MEMORY:
            there = {entry.path: entry.size for entry in self.location.list(f"{name}/")}
            logged = _files(self.location, name, self._tables[name])
            broken |= {path for path, size in logged.items() if there.get(path) != size}
        return broken

    @cached_property
    def _tables(self) -> dict[str, DeltaTable]:
        """The tables, made where there are none."""
        if self.location.list("plans/") and _opened(self.location, "sources") is None:
            uri = self.location.uri
            raise InputError("holds results of a scan; name another folder", file=uri)
        tables = {name: _opened(self.location, name) or self._made(name) for name in SCHEMAS}
        if self._wanted not in (None, _partition_of(tables["boxes"])):
            raise InputError(
                f"the store is divided by {_partition_of(tables['boxes']) or 'nothing'}, not by "
                f"{self._wanted}; this cannot be changed",
                file=self.location.uri,
            )
        return tables

    def _made(self, name: str) -> DeltaTable:
        schema, parts = _divided(name, self._wanted)
        with self.location.at(name, "made"):
            if self.location.path:
                (self.location.path / name).mkdir(parents=True, exist_ok=True)
            try:
                return DeltaTable.create(
                    f"{self.location.uri}/{name}",
                    schema,
                    partition_by=parts,
                    storage_options=self.location.delta_options,
                )
            except DeltaError:
                table = _opened(self.location, name)  # another writer may have been first
                if table is None:
                    raise
                return table

    def append(self, batch: Sequence[Mapping[str, pa.Table]]) -> dict[str, pa.Table]:
        """Append recordings and sources by one commit of each table; what is there is left out.

        Of content that is there, a row is written without its boxes or frames if it was not the
        newest of its source, or if something else is said of it (label, kind of truth, pictures).
        Content whose file is missing or cut is written again. It is safe beside other writers, and
        may break off anywhere: then nothing of it is seen.

        Parameters
        ----------
        batch
            Tables of `nvcore.fleet.ingest.tables_of`.

        Returns
        -------
        dict
            The rows of recordings and of sources whose content was not there.

        Raises
        ------
        InputError
            If the store is divided in another way than this one is to be.
        StoreError
            If it cannot be read or written.
        """
        tables, appended, new, actions = self._tables, {}, {}, {}
        partition = _partition_of(tables["boxes"])
        with self.location.at("", "read"):
            for table in tables.values():
                table.update_incremental()
        for name, data in ROWS_IN.items():
            stored = self._stored(name)
            rows = pa.concat_tables([SCHEMAS[name].empty_table(), *(of[name] for of in batch)])
            pieces = [
                (part, of[data].slice(first, n))
                for of in batch
                for part, first, n in zip(
                    _parts_of(of["recordings"], of[name]["recording"], partition),
                    of[name]["first_row"].to_pylist(),
                    of[name]["n_rows"].to_pylist(),
                    strict=True,
                )
            ]
            contents = keys_of(rows, _CONTENT[name])
            places = {key: place for place, key in enumerate(contents) if key not in stored.index}
            order = sorted(places, key=lambda key: (pieces[places[key]][0] or "", *key))
            actions[data], written = self._written(
                data, [pieces[places[key]] for key in order], partition
            )
            self._broken.difference_update(f"{data}/{action.path}" for action in actions[data])
            index = ChainMap(dict(zip(order, written, strict=True)), stored.index)
            facts: ChainMap[tuple[Any, ...], Any] = ChainMap({}, stored.facts)
            chosen, amended = [], []
            for place, row in enumerate(keys_of(rows, _STATED[name])):
                own = _facts_of(name, row, facts)
                if any(facts.get(key) != of for key, of in own.items()):
                    facts |= own
                    chosen.append(place)
                    amended.append(own[contents[place]])
            taken = rows.take(pa.array(chosen, pa.int64()))
            taken = _with_columns(taken, _INDEX, [index[contents[place]] for place in chosen])
            taken = _with_columns(taken, _AMENDABLE[name], amended)
            # later than all that is there, whatever the clocks of those who wrote it
            start = max(datetime.now(UTC), stored.newest + timedelta(microseconds=1))
            repeats: Counter[tuple[Any, ...]] = Counter()
            times = []
            for place in chosen:
                key = contents[place][:-1]
                times.append((start + timedelta(microseconds=repeats[key]),))
                repeats[key] += 1
            appended[name] = _with_columns(taken, ["ingested_at"], times)
            is_new = [contents[place] in places for place in chosen]
            new[name] = appended[name].filter(pa.array(is_new, pa.bool_()))
        for name, rows in appended.items():
            actions[name] = [self._put(name, [rows.sort_by("recording")], {})] if len(rows) else []
        for name in SCHEMAS:  # in this order: nothing is seen before the last one
            if actions[name]:
                self._commit(name, actions[name], partition)
        return new

    def _stored(self, name: str) -> _Learned:
        """What is in a table of recordings or sources, of which only new files are looked at."""
        learned = self._learned[name]
        paths = _files(self.location, name, self._tables[name])
        new = [path for path in paths if path not in learned.paths]
        rows = _rows(self.location, name, new, self._known)
        if self._broken:
            files = [f"{ROWS_IN[name]}/{path}" for path in rows["file"].to_pylist()]
            rows = rows.filter(pa.array([path not in self._broken for path in files], pa.bool_()))
        rows = rows.sort_by("ingested_at")
        index = keys_of(rows, _INDEX)
        learned.index.update(zip(keys_of(rows, _CONTENT[name]), index, strict=True))
        for row in keys_of(rows, _STATED[name]):
            learned.facts |= _facts_of(name, row, learned.facts)
        if len(rows):
            learned.newest = max(learned.newest, rows["ingested_at"][-1].as_py())
        learned.paths.update(new)
        return learned

    def _written(
        self, name: str, pieces: Sequence[tuple[str | None, pa.Table]], partition: str | None
    ) -> tuple[list[AddAction], list[tuple[Any, ...]]]:
        """Write stretches of rows, into a file for each part; where they lie, by `_INDEX`."""
        actions, places = [], []
        for part, of_part in groupby(pieces, key=lambda piece: piece[0]):
            groups: list[list[pa.Table]] = []
            spots, n_groups, n_in_group, n_rows = [], 0, 0, 0
            for _, rows in of_part:
                n = len(rows)
                if n and (n_in_group >= GROUP_ROWS or n_in_group + n > MAX_GROUP_ROWS):
                    n_groups, n_in_group = n_groups + -(-n_in_group // MAX_GROUP_ROWS), 0
                if n:
                    groups += [[]] * (not n_in_group)
                    groups[-1].append(rows)
                spots.append((n_groups, n_rows, n) if n else (0, 0, 0))
                n_in_group, n_rows = n_in_group + n, n_rows + n
            path = ""
            if n_rows:
                values = {} if partition is None else {partition: part}
                actions.append(self._put(name, map(pa.concat_tables, groups), values))
                path = actions[-1].path
            places += [(path if n else "", group, first, n) for group, first, n in spots]
        return actions, places

    def _put(
        self, name: str, groups: Iterable[pa.Table], values: Mapping[str, str | None]
    ) -> AddAction:
        """Write a file of rows sorted by recording; what is committed of it."""
        sink = pa.BufferOutputStream()
        schema = IN_MEMORY.get(name, SCHEMAS[name])
        n_rows, names = 0, []
        with pq.ParquetWriter(
            sink,
            schema,
            compression="zstd",
            write_page_checksum=True,
            store_schema=False,
        ) as writer:
            for rows in groups:
                writer.write_table(rows.combine_chunks(), row_group_size=MAX_GROUP_ROWS)
                n_rows += len(rows)
                names += [rows["recording"][place].as_py() for place in (0, -1)]
        content = sink.getvalue().to_pybytes()
        path = f"part-{hashlib.sha256(content).hexdigest()[:16]}.parquet"
        self.location.write(f"{name}/{path}", content)
        stats: dict[str, Any] = {"numRecords": n_rows}
        if max(map(len, names)) <= _LONGEST_IN_STATS:
            stats |= {
                "minValues": {"recording": min(names)},
                "maxValues": {"recording": max(names)},
            }
        return AddAction(
            path, len(content), values, int(time.time() * 1000), True, json.dumps(stats)
        )

    def _commit(self, name: str, actions: list[Any], partition: str | None) -> None:
        schema, parts = _divided(name, partition)
        with self.location.at(name, "written"):
            self._tables[name].create_write_transaction(
                actions,
                mode="append",
                schema=schema,
                partition_by=parts,
                commit_properties=CommitProperties(max_commit_retries=_COMMIT_RETRIES),
            )


class Snapshot:
    """A store as it was at one time. It pickles small: another process reads it anew.

    Parameters
    ----------
    location
        Of the store.
    versions
        Delta versions of its tables.

    Attributes
    ----------
    recordings
        The newest version of every recording, by recording; columns of `tables.RECORDINGS`.
    sources
        Every version of every source, by recording, source and version; columns of
        `tables.SOURCES`, and version: 1 and up, by when it first came.
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

    def __getstate__(self) -> dict[str, Any]:
        return {"location": self.location, "versions": self.versions, "_known": {}, "_picked": {}}

    def _table(self, name: str) -> pd.DataFrame:
        """Rows of recordings or sources, by when they came."""
        table = _opened(self.location, name, self.versions[name])
        if table is None:  # where it was when the snapshot was made
            raise StoreError("cannot be read (it is not there)", file=self.location.uri)
        files = [*_files(self.location, name, table)]
        rows: pd.DataFrame = _rows(self.location, name, files, self._known).to_pandas()
        return rows.sort_values(["ingested_at", *_CONTENT[name]], ignore_index=True)

    @cached_property
    def _stated(self) -> pd.DataFrame:
        """Rows of sources, by when they came."""
        return self._table("sources")

    @cached_property
    def recordings(self) -> pd.DataFrame:
        """The newest version of every recording: that with which a source came last."""
        key = ["recording", "recording_sha256"]
        first = self._stated.groupby(key, sort=False)["ingested_at"].min()
        keys = pd.MultiIndex.from_frame(self._stated[key].drop_duplicates("recording", keep="last"))
        rows = self._table("recordings").drop_duplicates(_CONTENT["recordings"], keep="last")
        rows = rows.set_index(_CONTENT["recordings"]).loc[keys].reset_index()
        rows["ingested_at"] = first.loc[keys].to_numpy()
        return _by_recording(rows.sort_values("recording"))

    @cached_property
    def sources(self) -> pd.DataFrame:
        """Every version of every source."""
        label = self._stated["label"]
        rows = self._stated.assign(label=label.where(label != ""))
        contents = rows.groupby(_CONTENT["sources"], sort=False)
        first, label = contents["ingested_at"].transform("min"), contents["label"].transform("last")
        rows = rows.assign(ingested_at=first, label=label.fillna(""))
        rows = rows.drop_duplicates(_CONTENT["sources"], keep="last")
        rows = rows.sort_values(["ingested_at", *_CONTENT["sources"]])
        numbers = rows.groupby(["recording", "source"], sort=False).cumcount() + 1
        rows = rows.assign(version=numbers.astype("int64"))
        return rows.sort_values(["recording", "source", "version"], ignore_index=True)

    def pick(self, source: str) -> pd.DataFrame:
        """One version of a source in each recording that has it, in the recording's newest version.

        Parameters
        ----------
        source
            A name, for what came last; with ``@2`` the second version, with ``@label`` the newest
            that was called so.

        Returns
        -------
        DataFrame
            Rows of `sources`, by recording.

        Raises
        ------
        InputError
            If there is no such source or version.
        """
        if source in self._picked:
            return self._picked[source]
        rows, names = self.sources, self.sources["source"].unique().tolist()
        name, at, version = source.rpartition("@")
        if source in names:
            name, at = source, ""
        elif name not in names:
            known = did_you_mean(source, names, f"there are {listed(names, most=MOST_NAMED)}")
            raise InputError(f"there is no source {source!r}; {known}", file=self.location.uri)
        rows, stated = rows[rows["source"] == name], self._stated
        stated = stated[stated["source"] == name]
        # what came with another version of its recording is of other frames or another picture
        newest = self.recordings["sha256"].reindex(stated["recording"]).to_numpy()
        came = stated[stated["recording_sha256"] == newest][["recording", "sha256"]]
        if at:
            labelled = stated[(stated["label"] == version) & (version != "")]
            wanted = pd.concat([rows[rows["version"].map(str) == version], labelled])
            if wanted.empty:
                labels = sorted({label for label in rows["label"] if label})
                raise InputError(
                    f"there is no version {version!r} of {name!r}; there are 1 to "
                    f"{rows['version'].max()}"
                    f"{', and ' + listed(labels, most=MOST_NAMED) if labels else ''}",
                    file=self.location.uri,
                )
            wanted = wanted.drop_duplicates("recording", keep="last")
            came = came.merge(wanted[["recording", "sha256"]])
        came = came.drop_duplicates("recording", keep="last")
        self._picked[source] = _by_recording(rows.merge(came, on=["recording", "sha256"]))
        return self._picked[source]

    def read(self, recordings: Sequence[str], sources: Sequence[str]) -> dict[str, pa.Table]:
        """Whole recordings, with these sources alone.

        Parameters
        ----------
        recordings
            Names.
        sources
            As for `pick`. A recording may have some of them only.

        Returns
        -------
        dict
            recordings and sources, whose first_row and n_rows say where their rows are in the other
            two: frames, by recording and frame; boxes, by recording, source in the order asked for,
            and frame. The column source has the sources as asked for. Each is read when it is first
            looked up, with these errors, too.

        Raises
        ------
        InputError
            If there is no such recording or source, or a file is damaged.
        StoreError
            If the store cannot be read.
        """
        names = sorted({*recordings})
        chosen = _rows_of(self.recordings, names)
        if len(chosen) < len(names):
            missing = min({*names}.difference(chosen["recording"]))
            raise InputError(f"there is no recording {missing!r}", file=self.location.uri)
        picked = [(self.pick(of), of) for of in sources]

        @cache
        def rows_of(name: str) -> pd.DataFrame:
            if name == "recordings":
                return chosen
            rows = [_rows_of(rows, names).assign(source=of) for rows, of in picked]
            return pd.concat([self.sources[:0], *rows]).sort_values("recording", kind="stable")

        def make(name: str) -> pa.Table:
            rows = rows_of(_REFERS_TO.get(name, name))
            if name in _REFERS_TO:
                return self._read_rows(name, rows)
            first_row = rows["n_rows"].cumsum() - rows["n_rows"]
            own = rows.assign(file="", group=0, first_row=first_row)
            return pa.Table.from_pandas(own, SCHEMAS[name], preserve_index=False)

        return _WhenAsked(make)

    def _read_rows(self, name: str, rows: pd.DataFrame) -> pa.Table:
        schema = IN_MEMORY[name]
        # which recording and source rows are of is known beforehand, and need not be read
        given = [column for column in ("recording", "source") if column in schema.names]
        columns = [column for column in schema.names if column not in given]
        texts = [column for column in columns if pa.types.is_dictionary(schema.field(column).type)]
        pieces: list[pa.Table] = [None] * len(rows)
        firsts, counts = rows["first_row"].to_numpy(), rows["n_rows"].to_numpy()
        for file, places in rows.assign(place=range(len(rows))).groupby("file", sort=False)[
            "place"
        ]:
            if not file:
                continue
            of_file = places.to_numpy()
            with _file_of(self.location, f"{name}/{file!s}", texts) as parquet:
                sizes = [
                    parquet.metadata.row_group(i).num_rows for i in range(parquet.num_row_groups)
                ]
                starts = np.cumsum([0, *sizes])
                first, last = firsts[of_file], firsts[of_file] + counts[of_file]
                if last.max() > starts[-1]:
                    raise ValueError("it has fewer rows than the store says")
                group = np.searchsorted(starts, first, side="right") - 1
                stops = np.searchsorted(starts, last)
                groups = np.unique(
                    np.concatenate([np.arange(*ends) for ends in zip(group, stops, strict=True)])
                )
                table = parquet.read_row_groups(groups.tolist(), columns=columns)
            is_read = np.zeros(len(sizes), bool)
            is_read[groups] = True
            start_in_table = np.cumsum([0, *np.where(is_read, sizes, 0)])
            for place, of, start in zip(of_file, group, first, strict=True):
                pieces[place] = table.slice(start_in_table[of] + start - starts[of], counts[place])
        own = pa.schema([schema.field(column) for column in columns])
        whole = pa.concat_tables(
            [own.empty_table(), *(piece for piece in pieces if piece is not None)]
        )
        whole = whole.unify_dictionaries().combine_chunks()
        for position, column in enumerate(given):
            codes, names = pd.factorize(rows[column])
            codes = pa.array(np.repeat(codes.astype(np.int32), counts))
            texts = pa.DictionaryArray.from_arrays(codes, pa.array([*names], pa.string()))
            whole = whole.add_column(position, schema.field(column), texts)
        return whole.cast(schema)


def _by_recording(rows: pd.DataFrame) -> pd.DataFrame:
    """Rows of one recording each, with its name as index, too."""
    return rows.set_axis(rows["recording"].array)


def _rows_of(rows: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Those of recordings of these names, in this order, as far as they are there."""
    place = rows.index.get_indexer(pd.Index([*names]))
    return rows.iloc[place[place >= 0]]


class _WhenAsked(dict[str, pa.Table]):
    """Tables by name, read when they are first looked up."""

    def __init__(self, read: Callable[[str], pa.Table]):
        self._read = read

    def __missing__(self, name: str) -> pa.Table:
        self[name] = self._read(name)
        return self[name]


@contextmanager
def _file_of(location: Location, path: str, texts: Sequence[str] = ()) -> Iterator[pq.ParquetFile]:
    """A Parquet file of a store; that it is damaged or missing is an error of its own."""
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
            except MemoryError:
                raise
            except OSError as error:
                if error.errno is not None:
                    raise
                raise FormatError(f"is damaged ({error})", file=uri) from error
            except (pa.ArrowException, KeyError, ValueError) as error:
                raise FormatError(f"is damaged ({error})", file=uri) from error
    except FileNotFoundError as error:
        if not location.list("sources/_delta_log/"):  # this machine does not see the store
            raise StoreError("cannot be read (it is not there)", file=location.uri) from error
        raise InputError("is missing in the store", file=uri) from error


def _opened(location: Location, name: str, version: int | None = None) -> DeltaTable | None:
    """A table of a store, as it was at a version; None: there is none."""
    with location.at(name, "read"):
        try:
            return DeltaTable(
                f"{location.uri}/{name}", version, storage_options=location.delta_options
            )
        except TableNotFoundError:
            return None


def _divided(name: str, partition: str | None) -> tuple[Schema, list[str]]:
    """Schema of a table and by which columns it is divided: frames and boxes alone are."""
    schema = SCHEMAS[name]
    parts = [partition] if partition is not None and name in IN_MEMORY else []
    for part in parts:
        schema = schema.append(pa.field(part, pa.string()))
    return Schema.from_arrow(schema), parts


def _partition_of(table: DeltaTable) -> str | None:
    return next(iter(table.metadata().partition_columns), None)


def _files(location: Location, name: str, table: DeltaTable) -> dict[str, int]:
    """Files of a table by their path within the location, and their bytes."""
    with location.at(name, "read"):
        actions = pa.table(table.get_add_actions(flatten=True))
    paths = [f"{name}/{unquote(path)}" for path in map(str, actions["path"].to_pylist())]
    return dict(zip(paths, actions["size_bytes"].to_pylist(), strict=True))


def _rows(
    location: Location, name: str, paths: Sequence[str], known: dict[str, pa.Table]
) -> pa.Table:
    """Rows of files of recordings or sources; `known` has those that were read before."""

    def read(path: str) -> pa.Table:
        with _file_of(location, path) as parquet:
            return parquet.read().select(SCHEMAS[name].names).cast(SCHEMAS[name])

    if new := [path for path in paths if path not in known]:
        with ThreadPoolExecutor(_THREADS) as pool:
            known.update(zip(new, pool.map(read, new), strict=True))
    return pa.concat_tables([SCHEMAS[name].empty_table(), *(known[path] for path in paths)])


def keys_of(rows: pa.Table, columns: Sequence[str]) -> list[tuple[Any, ...]]:
    """Cells of these columns, a tuple for each row."""
    return [*zip(*(rows[name].to_pylist() for name in columns), strict=True)]


def _facts_of(
    name: str, row: tuple[Any, ...], facts: Mapping[tuple[Any, ...], Any]
) -> dict[tuple[Any, ...], Any]:
    """What is so once a row with these cells of `_STATED` is written, beside what was before.

    By the content of a version, what is amendable; by a source, its newest content and the version
    of the recording with which it came; by a source and a label, its content.
    """
    if name == "recordings":  # of other pictures another one may be the first
        recording, sha256, pictures, first_picture = row
        before = facts.get((recording, sha256), ("", None))
        return {(recording, sha256): (pictures, first_picture) if pictures else before}
    recording, source, sha256, recording_sha256, label, kind = row
    content = recording, source, sha256
    return {
        content: (kind or facts.get(content, (TRUTH_KINDS[0],))[0],),
        (recording, source): (sha256, recording_sha256),
        **({(recording, source, "label", label): sha256} if label else {}),
    }


def _with_columns(
    rows: pa.Table, names: Sequence[str], cells: Sequence[tuple[Any, ...]]
) -> pa.Table:
    """Rows with other cells in these columns, a tuple of them for each row."""
    for name, values in zip(names, zip(*cells, strict=True), strict=bool(cells)):
        place = rows.schema.get_field_index(name)
        field = rows.schema.field(place)
        rows = rows.set_column(place, field, pa.array(values, field.type))
    return rows


def _parts_of(
    recordings: pa.Table, names: pa.ChunkedArray, partition: str | None
) -> list[str | None]:
    """In which part of a divided store these recordings are; None: in the one of all others."""
    units, times = recordings["unit"].to_pylist(), recordings["recorded_at"].to_pylist()
    parts = {}
    for name, unit, when, tags in zip(
        recordings["recording"].to_pylist(),
        units,
        times,
        recordings["tags"].to_pylist(),
        strict=True,
    ):
        of_tags = (tag.partition("=")[2] for tag in tags if tag.startswith(f"{partition}="))
        part = next(of_tags, None)
        if partition == "unit":
            part = unit
        elif partition == "month" and when is not None:
            part = f"{when:%Y-%m}"
        parts[name] = part or None
    return [parts[name] for name in names.to_pylist()]
