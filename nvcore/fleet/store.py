"""Stores of many recordings: appended to, never overwritten, read by whole recordings.

A store is a folder with four Delta tables (`nvcore.fleet.tables`). Data files are named by their
content. The table `sources` is committed last, and readers start from it, so an interrupted ingest
leaves nothing visible.
"""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from functools import cached_property
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
import pandas as pd

from nvcore.errors import FormatError, InputError, StoreError
from nvcore.extras import needs
from nvcore.fleet.location import Location
from nvcore.params import Params
from nvcore.wording import MOST_NAMED, count_text, did_you_mean, listed

with needs("fleet", "a store needs"):
    import pyarrow as pa
    import pyarrow.compute as pc
    import pyarrow.parquet as pq
    from deltalake import DeltaTable, Schema
    from deltalake.exceptions import DeltaError, TableNotFoundError
    from deltalake.transaction import AddAction, CommitProperties

    from nvcore.fleet.tables import ADDED_LATER, IN_MEMORY, RECORDINGS, SCHEMAS, TRUTH_KINDS

GROUP_ROWS: Final = 1 << 18
"""Rows of a Parquet row group."""
VERSIONS: Final = "versions.json"
"""File of a store with the version of each table after the last append; it may be behind."""
ROWS_IN: Final = {"recordings": "frames", "sources": "boxes"}
"""Tables with a row per version, and the table that holds the frames or boxes of each."""
_REFERS_TO: Final = {rows: name for name, rows in ROWS_IN.items()}
_CONTENT: Final = {
    "recordings": ["recording", "sha256"],
    "sources": ["recording", "source", "sha256"],
}
"""Columns that identify a version."""
_PAIR: Final = [*_CONTENT["sources"], "recording_sha256"]
"""Columns that identify a version of a source with the version of its recording."""
_STATED: Final = {"recordings": ["pictures", "first_picture"], "sources": ["kind"]}
"""Facts that a version keeps if a later input with the same content leaves the first one empty."""
_KEY: Final = re.compile(r"[a-z][a-z0-9_]{0,40}")
_COMMIT_RETRIES: Final = 100
"""Commits of other writers in between before a writer gives up."""
_THREADS: Final = 8


class Store:
    """A store of recordings at a location.

    Parameters
    ----------
    location
        Its folder, created by the first append.
    partition
        Key that divides the files of a new store: ``month``, ``unit`` or the key of a tag. None: as
        an existing store is divided; a new one is not.

    Raises
    ------
    InputError
        If `partition` is no such key.
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
        # what a source refers to is committed before it
        found = {name: _opened(self.location, name) for name in reversed(SCHEMAS)}
        tables = {name: table for name, table in found.items() if table is not None}
        if len(tables) < len(SCHEMAS):
            raise InputError("there is no store here", file=self.location.uri)
        return Snapshot(self.location, _checked(self.location, tables, reached), self._known)

    @cached_property
    def _tables(self) -> dict[str, DeltaTable]:
        """The Delta tables, created if they do not exist."""
        if self.location.list("plans/") and _opened(self.location, "sources") is None:
            uri = self.location.uri
            raise InputError("holds results of a scan; name another folder", file=uri)
        tables = {name: _opened(self.location, name) or self._create(name) for name in SCHEMAS}
        if self._wanted not in (None, _partition_of(tables["boxes"])):
            raise InputError(
                f"the store is divided by {_partition_of(tables['boxes']) or 'nothing'}, not by "
                f"{self._wanted}; this cannot be changed",
                file=self.location.uri,
            )
        return tables

    def _create(self, name: str) -> DeltaTable:
        parts = [self._wanted] if self._wanted and name in IN_MEMORY else []
        schema = pa.schema([*SCHEMAS[name], *((part, pa.string()) for part in parts)])
        with self.location.at(name, "made"):
            if self.location.path:
                (self.location.path / name).mkdir(parents=True, exist_ok=True)
            try:
                return DeltaTable.create(
                    f"{self.location.uri}/{name}",
                    Schema.from_arrow(schema),
                    partition_by=parts,
                    storage_options=self.location.delta_options,
                )
            except DeltaError:
                if table := _opened(self.location, name):  # another writer was first
                    return table
                raise

    def append(
        self, batch: Sequence[Mapping[str, pa.Table]], *, newest: bool = False
    ) -> dict[str, pa.Table]:
        """Append new versions of recordings and sources, with one commit per table.

        A version that the store has does not become the newest again; a row notes new labels, kinds
        of truth, pictures and parameters. Several writers may append at once. An interrupted append
        leaves nothing visible.

        Parameters
        ----------
        batch
            Tables of `nvcore.fleet.ingest.tables_of`.
        newest
            Whether versions that the store has become the newest again.

        Returns
        -------
        dict
            Rows of ``recordings`` and ``sources`` whose content is new.

        Raises
        ------
        InputError
            If the store is divided by another key.
        StoreError
            If it cannot be read or written.
        """
        tables = self._tables
        reached = _versions_reached(self.location)
        with self.location.at("", "read"):
            for table in tables.values():
                table.update_incremental()
        _checked(self.location, tables, reached)
        empty = {name: IN_MEMORY.get(name, of).empty_table() for name, of in SCHEMAS.items()}
        given = {name: pa.concat_tables([of[name] for of in (empty, *batch)]) for name in SCHEMAS}
        key = _partition_of(tables["boxes"])
        parts = {
            row["recording"]: _part_of(row, key) if key else ""
            for row in given["recordings"].to_pylist()
        }
        new: dict[str, pa.Table] = {}
        actions: dict[str, list[AddAction]] = {}
        for name, data in ROWS_IN.items():
            stored = _rows(self.location, name, tables[name], self._known)
            own = pc.is_in(stored["recording"], value_set=given[name]["recording"])
            stored = stored.filter(own).sort_by("ingested_at")
            rows = pa.concat_tables([stored, given[name]]).to_pandas()
            is_given = rows.index >= len(stored)
            content = rows.groupby(_CONTENT[name], sort=False).ngroup()
            is_new = is_given & ~content.duplicated()
            # the rows of a batch follow each other in its tables
            n_rows = rows["n_rows"].where(is_given, 0)
            rows["first_row"] = rows["first_row"].where(~is_given, n_rows.cumsum() - n_rows)
            actions[data] = []
            chosen = rows[is_new].sort_values(_CONTENT[name])
            for part, of_part in chosen.groupby(chosen["recording"].map(parts)):
                stretches = zip(of_part["first_row"], of_part["n_rows"], strict=True)
                pieces = pa.concat_tables([given[data].slice(*stretch) for stretch in stretches])
                if len(pieces):
                    actions[data].append(
                        self._put(data, pieces, {key: part or None} if key else {})
                    )
                    rows.loc[of_part.index, "file"] = actions[data][-1].path
                first_row = of_part["n_rows"].cumsum() - of_part["n_rows"]
                rows.loc[of_part.index, "first_row"] = first_row
            places = ["file", "first_row"]
            rows[places] = rows.groupby(content)[places].transform("first")
            if name == "recordings":  # of several inputs with other parameters the last one counts
                same = rows.groupby([content, is_given])
                rows["parameters"] = same["parameters"].transform("last")
            is_kept = is_new
            if (is_given & ~is_new).any():
                is_kept = is_new | (is_given & _says_more(name, rows, content))
            if name == "sources":
                rows["kind"] = rows["kind"].replace("", TRUTH_KINDS[0])
                is_known = rows.duplicated(_PAIR).to_numpy()
                if newest:
                    is_known = is_known & ~_is_behind(rows, is_given)
                rows["amends"] = rows["amends"].where(~is_given, is_known)
                is_kept |= is_given & ~is_known
            # later than what is stored, whatever the clocks of other writers say
            start = max([pd.Timestamp(datetime.now(UTC)), *rows["ingested_at"][~is_given][-1:]])
            kept = rows[is_kept]
            order = kept.groupby(_CONTENT[name][:-1]).cumcount() + 1
            kept = kept.assign(ingested_at=start + order * timedelta(microseconds=1))
            made = pa.Table.from_pandas(kept, SCHEMAS[name], preserve_index=False)
            new[name] = made.filter(pa.array(is_new[is_kept]))
            actions[name] = [self._put(name, made.sort_by("recording"), {})] if len(made) else []
        for name in SCHEMAS:  # in this order: nothing is visible before the last one
            if actions[name]:
                self._commit(name, actions[name])
        if any(actions.values()):
            reached = _versions_reached(self.location)
            for of, table in tables.items():  # higher by 1, or by more with other writers
                reached[of] = max(reached[of], table.version() + bool(actions[of]))
            self.location.write(VERSIONS, json.dumps(reached).encode())
        return new

    def _put(self, name: str, rows: pa.Table, values: Mapping[str, str | None]) -> AddAction:
        """Write a file of rows sorted by recording, and return its entry for the commit."""
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
        return AddAction(path, content.size, values, int(time.time() * 1000), True, stats)

    def _commit(self, name: str, actions: list[Any]) -> None:
        table = self._tables[name]
        with self.location.at(name, "written"):
            table.create_write_transaction(
                actions,
                mode="append",
                schema=table.schema(),
                partition_by=table.metadata().partition_columns,
                commit_properties=CommitProperties(max_commit_retries=_COMMIT_RETRIES),
            )


def _says_more(name: str, rows: pd.DataFrame, content: pd.Series) -> pd.Series:
    """Whether each row says something else of a version than the rows before it.

    Facts that a row does not state are filled in from the rows before it.
    """
    facts = _STATED[name]
    place = pd.Series(np.where(rows[facts[0]] != "", rows.index, -1)).groupby(content).cummax()
    rows[facts] = rows[facts].take(np.where(place < 0, rows.index, place)).to_numpy()
    facts = [*facts, "parameters"] if name == "recordings" else facts
    said = pd.Series([*map(repr, rows[facts].itertuples(index=False, name=None))])
    says_more: pd.Series = said != said.groupby(content).shift()
    if name == "sources":
        says_more |= (rows["label"] != "") & ~rows.duplicated([*_CONTENT[name], "label"])
    return says_more


def _is_behind(rows: pd.DataFrame, is_given: np.ndarray) -> np.ndarray:
    """Whether a version of a source, or of its recording, is not the newest in the store."""
    counting = rows[~is_given & ~rows["amends"].to_numpy(bool)]
    newest = counting.drop_duplicates(["recording", "source"], keep="last")[_PAIR]
    last = counting.drop_duplicates("recording", keep="last")[["recording", "recording_sha256"]]
    found = rows[_PAIR].merge(newest.merge(last), how="left", indicator=True)
    return (found["_merge"] != "both").to_numpy()


class Snapshot:
    """A store at one time. Its pickle is small, as another process reads the rows again.

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
        """Rows of recordings or sources, oldest first."""
        table = _opened(self.location, name, self.versions[name])
        if table is None:  # it existed when the snapshot was made
            raise StoreError("cannot be read (it is not there)", file=self.location.uri)
        rows: pd.DataFrame = _rows(self.location, name, table, self._known).to_pandas()
        return rows.sort_values(["ingested_at", *_CONTENT[name]], ignore_index=True)

    @cached_property
    def _stated(self) -> pd.DataFrame:
        """Rows of sources, oldest first."""
        return self._table("sources")

    @cached_property
    def _counting(self) -> pd.DataFrame:
        """Rows of sources that make a version the newest."""
        return self._stated[~self._stated["amends"]]

    @cached_property
    def recordings(self) -> pd.DataFrame:
        """The newest version of every recording: the one with which a source came last."""
        came = self._counting[["recording", "recording_sha256", "ingested_at"]]
        came = came.set_axis([*_CONTENT["recordings"], "ingested_at"], axis=1)
        first = came.groupby(_CONTENT["recordings"])["ingested_at"].transform("first")
        newest = came.assign(ingested_at=first).drop_duplicates("recording", keep="last")
        rows = self._table("recordings").drop_duplicates(_CONTENT["recordings"], keep="last")
        rows = rows.drop(columns="ingested_at").merge(newest)
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
        rows = self._stated.assign(label=self._stated["label"].replace("", None))
        contents = rows.groupby(_CONTENT["sources"])  # a row that states nothing changes nothing
        rows = contents.last().assign(ingested_at=contents["ingested_at"].first()).reset_index()
        rows = rows.sort_values(["recording", "source", "ingested_at", "sha256"], ignore_index=True)
        rows["label"] = rows["label"].fillna("")
        return rows.assign(version=rows.groupby(["recording", "source"]).cumcount() + 1)

    def older(self, given: pd.DataFrame) -> pd.DataFrame:
        """Count the given versions that are not the newest ones.

        `given` has the columns recording, source (empty: the recording itself) and sha256; the
        result has source, version, newest (the version that is) and n_recordings.
        """
        key = ["recording", "source"]
        of_recordings = self._counting.assign(source="", sha256=self._counting["recording_sha256"])
        came = pd.concat([self._counting, of_recordings])[[*key, "sha256"]]
        last = came.drop_duplicates(key, keep="last")
        came = came.drop_duplicates(ignore_index=True)
        came["version"] = came.groupby(key).cumcount() + 1
        newest = came.merge(last).rename(columns={"version": "newest"})
        rows = given.merge(came).merge(newest[[*key, "newest"]]).query("version != newest")
        counts = rows.groupby(["source", "version", "newest"])["recording"].size()
        return counts.rename("n_recordings").reset_index()

    def pick(self, source: str) -> pd.DataFrame:
        """Return one version of a source per recording, as rows of `sources` by recording.

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
        rows, names = self.sources, self.sources["source"].unique().tolist()
        name, at, version = source.rpartition("@")
        if source in names:
            name, at = source, ""
        elif name not in names:
            known = did_you_mean(source, names, f"there are {listed(names, most=MOST_NAMED)}")
            raise InputError(f"there is no source {source!r}; {known}", file=self.location.uri)
        rows, came = (of[of["source"] == name] for of in (rows, self._counting))
        # what came with another version of its recording is of other frames or another picture
        newest = self.recordings["sha256"].reindex(came["recording"]).to_numpy()
        came = came[came["recording_sha256"] == newest][["recording", "sha256"]]
        if at:
            labelled = self._stated[self._stated["source"] == name]
            labelled = labelled[(labelled["label"] == version) & (version != "")]
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
        rows = rows.merge(came, on=["recording", "sha256"])
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
            two refer to the last two. The column source holds the names asked for. A table is read
            when it is first looked up.

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
        rows_of = {"recordings": chosen, "sources": found}

        def make(name: str) -> pa.Table:
            if name in _REFERS_TO:
                return self._read_rows(name, rows_of[_REFERS_TO[name]])
            first_row = rows_of[name]["n_rows"].cumsum() - rows_of[name]["n_rows"]
            own = rows_of[name].assign(file="", first_row=first_row)
            return pa.Table.from_pandas(own, SCHEMAS[name], preserve_index=False)

        return _WhenAsked(make)

    def _read_rows(self, name: str, rows: pd.DataFrame) -> pa.Table:
        """Read the stretches of rows that versions refer to, in their order."""
        schema = IN_MEMORY[name]
        # recording and source are known from the versions and need not be read
        given = [column for column in ("recording", "source") if column in schema.names]
        own = pa.schema([column for column in schema if column.name not in given])
        texts = [column.name for column in own if pa.types.is_dictionary(column.type)]
        pieces = {-1: own.empty_table()}
        placed = rows.assign(place=range(len(rows)), stop=rows["first_row"] + rows["n_rows"])
        for file, of_file in placed[placed["n_rows"] > 0].groupby("file", sort=False):
            first, last = int(of_file["first_row"].min()), int(of_file["stop"].max())
            with _file_of(self.location, f"{name}/{file!s}", texts) as parquet:
                if last > parquet.metadata.num_rows:
                    raise ValueError("it has fewer rows than the store says")
                n_of_group = parquet.metadata.row_group(0).num_rows  # the last one may be smaller
                groups = range(first // n_of_group, -(-last // n_of_group))
                table = parquet.read_row_groups([*groups], columns=own.names)
            stretches = of_file[["place", "first_row", "n_rows"]].itertuples(index=False)
            for place, first_row, n_rows in stretches:
                pieces[place] = table.slice(first_row - groups[0] * n_of_group, n_rows)
        whole = pa.concat_tables([pieces[place] for place in sorted(pieces)])
        whole = whole.unify_dictionaries().combine_chunks()
        version = np.repeat(np.arange(len(rows)), rows["n_rows"])
        for position, column in enumerate(given):
            of_version = pa.array(rows[column], pa.string()).dictionary_encode()
            whole = whole.add_column(position, schema.field(column), of_version.take(version))
        return whole.cast(schema)


def other_settings(recordings: pd.DataFrame, params: Params) -> str:
    """Say which settings of recordings a scan does not use, or return an empty text."""
    used, others, n, words = asdict(params), set(), 0, {None: "the default"}
    for text, count in recordings["parameters"].value_counts().items():
        given = json.loads(str(text) or "{}")
        differing = [name for name, value in given.items() if value != used.get(name)]
        others |= {(name, str(words.get(given[name], given[name]))) for name in differing}
        n += int(count) if differing else 0
    texts = [
        f"{name} {' or '.join(value for _, value in values)} "
        f"(the scan uses {words.get(used.get(name), used.get(name))})"
        for name, values in groupby(sorted(others), key=itemgetter(0))
    ]
    ingested = f"{n:,} of {count_text(len(recordings), 'recording')} {'was' if n == 1 else 'were'}"
    return f"{ingested} ingested with other settings: {', '.join(texts)}" if n else ""


class _WhenAsked(dict[str, pa.Table]):
    """Tables by name, each read when it is first looked up."""

    def __init__(self, read: Callable[[str], pa.Table]):
        self._read = read

    def __missing__(self, name: str) -> pa.Table:
        self[name] = self._read(name)
        return self[name]


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
    """Return the versions that the tables had at some time, none for a store without the file."""
    try:
        content = json.loads(location.find(VERSIONS) or b"{}")
        return {name: int(content.get(name, 0)) for name in SCHEMAS}
    except (ValueError, TypeError, AttributeError) as error:
        raise StoreError("is damaged; delete it", file=f"{location.uri}/{VERSIONS}") from error


def _checked(
    location: Location, tables: Mapping[str, DeltaTable], reached: Mapping[str, int]
) -> dict[str, int]:
    """Return the versions of tables, or raise StoreError if one is older than it was."""
    versions = {name: table.version() for name, table in tables.items()}
    for name, version in versions.items():
        if version < reached[name]:
            raise StoreError(
                f"version {reached[name]} of this table is missing, the newest is {version}; "
                f"restore the log, or delete {VERSIONS} and ingest again what was lost",
                file=f"{location.uri}/{name}/_delta_log",
            )
    return versions


def _partition_of(table: DeltaTable) -> str | None:
    return next(iter(table.metadata().partition_columns), None)


def _rows(location: Location, name: str, table: DeltaTable, known: dict[str, pa.Table]) -> pa.Table:
    """Read the rows of recordings or sources, cached by file in `known`."""
    schema = SCHEMAS[name]

    def read(path: str) -> pa.Table:
        with _file_of(location, path) as parquet:
            rows = parquet.read()
            for column, value in ADDED_LATER.items():
                if column in schema.names and column not in rows.column_names:
                    rows = rows.append_column(column, pa.repeat(value, len(rows)))
            return rows.select(schema.names).cast(schema)

    with location.at(name, "read"):
        files = pa.table(table.get_add_actions())["path"].to_pylist()
    paths = [f"{name}/{unquote(file)}" for file in files]
    new = [path for path in paths if path not in known]
    with ThreadPoolExecutor(_THREADS) as pool:
        known.update(zip(new, pool.map(read, new), strict=True))
    return pa.concat_tables([schema.empty_table(), *(known[path] for path in paths)])


def _part_of(row: Mapping[str, Any], partition: str) -> str:
    """Return the part of a divided store for a recording, empty if it has no such key."""
    if partition == "unit":
        return str(row["unit"])
    if partition == "month":
        return f"{row['recorded_at']:%Y-%m}" if row["recorded_at"] else ""
    start = f"{partition}="
    return next((tag[len(start) :] for tag in row["tags"] if tag.startswith(start)), "")
