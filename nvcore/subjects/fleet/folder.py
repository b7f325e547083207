"""Folder of a scan's state and results, with a checksum for each file.

    plans/<plan>.json              sources, settings, program and batches of a scan
    leases/<batch>/<attempt>.json  worker of a batch, and expiry of its lease
    done/<batch>.json              files that a batch has written, with their checksums
    <table>/<batch>-<hash>.parquet rows of a batch in a results table, listed in a Delta table
    newest.json                    plan that was begun last
    summary.json                   plan of the tables
    finished/<plan>.json           summary of each finished plan

Plans and tables are named by their content. Other files contain their checksum. Duplicate work of
two processes is therefore harmless, and batches with damaged files are computed again.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
from deltalake import DeltaTable
from deltalake.exceptions import CommitFailedError, TableNotFoundError
from deltalake.transaction import AddAction, RemoveAction

from nvcore.common.errors import InputError, StoreError
from nvcore.common.findings import Remedy, Step
from nvcore.common.wording import count_text, one_line
from nvcore.subjects.fleet.leases import attempt_of, is_held, seal, unseal
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.plan import Batch, Plan, hash_of, plan
from nvcore.subjects.fleet.results import ScanParams, Summary, reductions, schema
from nvcore.subjects.fleet.store import Snapshot

SUMMARY: Final = "summary.json"
_NEWEST: Final = "newest.json"
_COMMIT_ATTEMPTS: Final = 30
"""Attempts to commit a version of a results table, if several processes finish at once."""
_THREADS: Final = 16
_AGAIN: Final = "run the scan again, which computes what is missing"


def begin(
    snapshot: Snapshot,
    out: Location,
    params: ScanParams,
    *,
    recompute: bool = False,
    **options: Any,
) -> Plan:
    """Plan a scan of a store, and write the plan to the folder of results.

    Parameters
    ----------
    recompute
        Whether to continue if another program has written results.
    options
        Options of `nvcore.subjects.fleet.plan.plan`.

    Raises
    ------
    InputError
        If existing results are from another program.
    """
    made = plan(snapshot, params, **options)
    newest = None if recompute else newest_plan(out)
    if newest is not None:
        newest.check_programs(
            "its results are not mixed with those of this one: name another folder, or compute "
            "them anew",
            Step(Remedy.OPTION, "", "recompute"),
        )
    out.write(_path_of(made.key), made.to_json())
    out.write(_NEWEST, seal({"plan": made.key}))
    return made


def plan_shown(out: Location) -> Plan | None:
    """Read the plan of the finished tables, else the plan begun last, or return None.

    Raises
    ------
    InputError
        If the plan is missing or damaged.
    """
    for path in (SUMMARY, _NEWEST):
        if out.find(path) is None:
            continue
        shown = _sealed(out, path)
        found = None if shown is None else plan_in(out, shown["plan"])
        if found is None:
            damaged = path if shown is None else _path_of(shown["plan"])
            raise InputError(f"is missing or damaged; {_AGAIN}", file=f"{out.uri}/{damaged}")
        return found
    return None


def newest_plan(out: Location) -> Plan | None:
    """Read the plan that was begun last, or return None if it is missing or damaged."""
    newest = _sealed(out, _NEWEST)
    return None if newest is None else plan_in(out, newest["plan"])


def plan_in(out: Location, key: str) -> Plan | None:
    """Read the plan with this key, or return None if it is missing or damaged."""
    content = out.find(_path_of(key))
    return None if content is None or hash_of(content) != key else Plan.from_json(content)


def has_tables(out: Location) -> bool:
    """Whether a scan was finished here."""
    return out.find(SUMMARY) is not None


def _sealed(out: Location, path: str) -> dict[str, Any] | None:
    """Read a JSON file with a checksum, or return None if it is missing or damaged."""
    return unseal(out.find(path) or b"")


def _path_of(key: str) -> str:
    return f"plans/{key}.json"


def _is_finished(out: Location, its_plan: Plan) -> bool:
    return out.find(f"finished/{its_plan.key}.json") is not None


def write_batch(out: Location, key: str, tables: Mapping[str, pa.Table]) -> bytes:
    """Write the tables of a batch and return the record of them for the folder ``done``."""
    files = {}
    for name, table in tables.items():
        content = _as_parquet(table)
        sha256 = hashlib.sha256(content).hexdigest()
        path = f"{name}/{key}-{sha256[:8]}.parquet"
        out.write(path, content)
        files[name] = {"path": path, "size": len(content), "sha256": sha256, "rows": len(table)}
    n_frames = sum(tables["recordings"]["n_frames"].to_pylist())
    return seal({"files": files, "n_frames": n_frames})


def done_in(out: Location) -> set[str]:
    """Return the keys of finished batches, and delete empty files that crashed machines left."""
    entries = out.list("done/")
    for entry in entries:
        if not entry.size:
            out.delete(entry.path)
    names = (entry.path for entry in entries if entry.size)
    return {name.removeprefix("done/").removesuffix(".json") for name in names}


def _read_done(out: Location, batches: Sequence[Batch]) -> list[dict[str, Any]]:
    """Read which files each batch has written.

    Raises
    ------
    InputError
        If one of them is missing or damaged.
    """

    def read(batch: Batch) -> dict[str, Any]:
        path = f"done/{batch.key}.json"
        done = _sealed(out, path)
        if done is None:
            raise InputError(f"is missing or damaged; {_AGAIN}", file=f"{out.uri}/{path}")
        return done

    with ThreadPoolExecutor(_THREADS) as pool:
        return [*pool.map(read, batches)]


def _content(out: Location, file: Mapping[str, Any]) -> pa.Buffer:
    """Read a file of a table, memory-mapped if it is on a disk, and verify its checksum.

    Raises
    ------
    InputError
        If it is missing, or differs from the file that its batch has written.
    """
    path = file["path"]
    try:
        with out.at(path, "read"):
            if out.path:
                content = pa.memory_map(str(out.path / path)).read_buffer()
            else:
                content = pa.py_buffer(out.read(path))
        is_damaged = hashlib.sha256(content).hexdigest() != file["sha256"]
    except FileNotFoundError:
        is_damaged = True
    if is_damaged:
        raise InputError(f"is missing or damaged; {_AGAIN}", file=f"{out.uri}/{path}")
    return content


def repair(out: Location, its_plan: Plan, among: slice = slice(None)) -> list[str]:
    """Mark batches with a damaged file as not done, so that they are computed anew.

    Only the batches in the slice `among` of the plan are checked.

    Returns
    -------
    Path and fault of one file of each marked batch.
    """
    is_done = done_in(out)

    def check(batch: Batch) -> str:
        try:
            [done] = _read_done(out, [batch])
            for file in done["files"].values():
                _content(out, file)
        except InputError as error:
            out.delete(f"done/{batch.key}.json")
            return str(error)
        return ""

    with ThreadPoolExecutor(_THREADS) as pool:
        batches = [batch for batch in its_plan.batches[among] if batch.key in is_done]
        return [fault for fault in pool.map(check, batches) if fault]


def table_of(out: Location, its_plan: Plan, name: str) -> Any:
    """Open a table of a plan's results as an Arrow dataset, after verifying its files.

    Raises
    ------
    InputError
        If a file is missing or damaged.
    """
    return _open_table(out, name, _read_done(out, its_plan.batches))


def _open_table(out: Location, name: str, done: Sequence[Mapping[str, Any]]) -> Any:
    """Open a table as an Arrow dataset of the files that its batches have written."""
    files = [batch["files"][name] for batch in done]
    kind = ds.ParquetFileFormat()
    with ThreadPoolExecutor(_THREADS) as pool:
        contents = pool.map(lambda file: _content(out, file), files)
        parts = [kind.make_fragment(pa.BufferReader(content)) for content in contents]
    return ds.FileSystemDataset(parts, parts[0].physical_schema, kind)


def finish(out: Location, its_plan: Plan) -> Summary:
    """Summarize the results of all batches of a plan, and list their files in Delta tables.

    Any number of processes may do so. Tables of a finished plan that was begun later are kept.

    Raises
    ------
    InputError
        If batches are missing or damaged.
    """
    done = _read_done(out, its_plan.batches)
    recordings = _open_table(out, "recordings", done).to_table(columns=[*reductions()])
    quarantined = sum(batch["files"]["quarantine"]["rows"] for batch in done)
    summary = Summary.of(recordings, quarantined, its_plan.params)
    newest = newest_plan(out)
    if newest is None or newest.key == its_plan.key or not _is_finished(out, newest):
        for name in done[0]["files"]:
            _list_files(out.child(name), name, [batch["files"][name] for batch in done])
        out.write("summary.parquet", _as_parquet(pa.table(dict(summary.measures()))))
        for path in (SUMMARY, f"finished/{its_plan.key}.json"):
            out.write(path, seal({"plan": its_plan.key}))
    return summary


def _list_files(folder: Location, name: str, files: Sequence[Mapping[str, Any]]) -> None:
    """Commit changes to a folder's Delta table so that it lists exactly these files."""
    wanted = {file["path"].rpartition("/")[2]: file for file in files}
    storage: dict[str, Any] = {"storage_options": folder.delta_options}
    for attempt in range(_COMMIT_ATTEMPTS):
        with folder.at("", "written"), suppress(CommitFailedError):  # another was faster
            try:
                table = DeltaTable(folder.uri, **storage)
            except TableNotFoundError:
                table = DeltaTable.create(folder.uri, schema(name), mode="ignore", **storage)
            there = {uri.rpartition("/")[2] for uri in table.file_uris()}
            if there == wanted.keys():
                return
            now = int(time.time() * 1000)
            actions: list[AddAction | RemoveAction] = [
                *(
                    AddAction(path, of["size"], {}, 0, True, json.dumps({"numRecords": of["rows"]}))
                    for path, of in wanted.items()
                    if path not in there
                ),
                *(RemoveAction(path, True, now) for path in sorted(there - wanted.keys())),
            ]
            table.create_write_transaction(actions, "append", schema(name))
            continue
        time.sleep(0.1 * attempt)
    raise StoreError("cannot be written (other processes are always faster)", file=folder.uri)


@dataclass(frozen=True)
class Status:
    """Progress of a scan.

    Attributes
    ----------
    plan
        Plan of the scan.
    n_done, n_frames_done
        Number of batches that are done, and of frames that were compared in them.
    n_running
        Number of batches that a worker may be working on.
    n_lost
        Number of attempts whose workers died, at other unfinished batches.
    n_quarantined
        Number of recordings in finished batches that could not be compared.
    is_finished
        Whether all batches are done and the tables were written.
    reason
        Name of one such recording, and the reason.
    """

    plan: Plan
    n_done: int
    n_frames_done: int
    n_running: int
    n_lost: int
    n_quarantined: int
    is_finished: bool
    reason: str = ""

    def __str__(self) -> str:
        plan = self.plan
        lines = [
            f"{plan.params.x} and {plan.params.y} of {plan.store}: {self.n_done:,} of "
            f"{count_text(len(plan.batches), 'batch', 'batches')} done, {self.n_frames_done:,} of "
            f"{count_text(plan.n_frames, 'frame')} compared"
        ]
        if not self.is_finished:
            n = count_text(self.n_running, "batch", "batches")
            is_idle = "; run the scan again to go on" if not self.n_running else ""
            lines += [f"at work on {n}{is_idle}"]
        if self.n_lost:
            lines += [f"{count_text(self.n_lost, 'attempt')} ended without a word; others go on"]
        lines += [
            f"{count_text(n, 'recording')} without {source}, or with one of another version of the "
            "recording, left out"
            for source, n in plan.left_out.items()
        ]
        if self.n_quarantined:
            n = count_text(self.n_quarantined, "recording")
            lines += [f"{n} in quarantine (table quarantine), such as {self.reason}"]
        return "\n".join(map(one_line, lines))


def status(out: Location, its_plan: Plan | None = None, clock: Any = time.time) -> Status:
    """Return the progress of a scan: `its_plan`, or by default the one begun last.

    Parameters
    ----------
    clock
        Function that returns seconds since 1970.

    Raises
    ------
    InputError
        If there is no scan, or one of its files is damaged.
    """
    its_plan = its_plan or newest_plan(out)
    if its_plan is None:
        raise InputError("there is no scan, or its plan is damaged", file=out.uri)
    is_done = done_in(out)
    batches = [batch for batch in its_plan.batches if batch.key in is_done]
    left = {batch.key for batch in its_plan.batches} - is_done
    leases = [entry.path for entry in out.list("leases/") if entry.path.split("/")[1] in left]
    done = _read_done(out, batches)
    with ThreadPoolExecutor(_THREADS) as pool:
        attempts = [*map(attempt_of, pool.map(out.read, leases))]
    refused = [of for of in (batch["files"]["quarantine"] for batch in done) if of["rows"]]
    held = [is_held(attempt, clock()) for attempt in attempts]
    first = None
    if refused:
        [first] = pq.read_table(pa.BufferReader(_content(out, refused[0]))).slice(0, 1).to_pylist()
    return Status(
        its_plan,
        len(done),
        sum(batch["n_frames"] for batch in done),
        sum(held),
        sum(attempt["ended"] is None for attempt in attempts) - sum(held),
        sum(of["rows"] for of in refused),
        not left and _is_finished(out, its_plan),
        f"{first['recording']}: {first['reason']}" if first else "",
    )


def forget_quarantined(out: Location, its_plan: Plan) -> None:
    """Mark batches with quarantined recordings as not done, so that they are computed anew."""
    is_done = done_in(out)
    batches = [batch for batch in its_plan.batches if batch.key in is_done]
    for batch, done in zip(batches, _read_done(out, batches), strict=True):
        if done["files"]["quarantine"]["rows"]:
            for entry in out.list(f"leases/{batch.key}/"):
                out.delete(entry.path)
            out.delete(f"done/{batch.key}.json")


def _as_parquet(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd", use_dictionary=False)
    return bytes(sink.getvalue())
