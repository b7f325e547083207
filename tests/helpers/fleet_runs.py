"""Small fleets to be scanned, and what happens to the workers that scan them.

The functions that take the tables of a batch run in workers, as `Options.run`: they end, stop or
starve the process that calls them. What happened to whom they leave as files in a folder.
"""

from __future__ import annotations

import gc
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from approach import approach
from builders import Box, Place, make_dataset
from deltalake import DeltaTable
from numba.core.dispatcher import Dispatcher
from places import ROOT

from nvcore.dataset import Dataset
from nvcore.subjects.fleet.batch import scan_batch
from nvcore.subjects.fleet.folder import begin
from nvcore.subjects.fleet.ingest import tables_of
from nvcore.subjects.fleet.leases import unseal
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.plan import Plan
from nvcore.subjects.fleet.results import ScanParams
from nvcore.subjects.fleet.scan import Job, Options
from nvcore.subjects.fleet.store import Store

PARAMS = ScanParams("x", "y", frames=True)
PATIENCE_S = 100.0


def small_fleet(n: int = 12, first: int = 0) -> Dataset:
    """Recordings r0, r1, ... of 40 frames: those from `first` on.

    In each a car drives up to two pedestrians; the systems have false alarms, too.
    """
    rng = np.random.default_rng(7 + first)
    sources: tuple[list[Box], ...] = ([], [], [])
    for recording in range(n):
        starts = (0, *rng.integers(5, 38, 2).tolist())
        for boxes, start in zip(sources, starts, strict=True):
            shown = range(start, 40)
            boxes += approach(shown, 4.5, recording=recording, centre=30.0 + recording)
            boxes += approach(shown, 6, recording=recording, centre=20, track=2)
            boxes += approach(range(start % 9), 5, recording=recording, centre=80, track=3)
    dataset = make_dataset(*sources, places=[Place(range(40), horizon=40.0)] * n)
    names = [f"r{first + recording}" for recording in range(n)]
    return replace(dataset, recordings=dataset.recordings.assign(name=names))


def append_to(store: str | Path | Location, dataset: Dataset, *, without: str = "") -> str:
    """Append recordings to a store, perhaps without one of the systems; its URI."""
    made, tables = Store(store), tables_of(dataset)
    has_it = pc.not_equal(tables["sources"]["source"], without)
    made.append([tables | {"sources": tables["sources"].filter(has_it)}])
    return made.location.uri


def begin_scan(
    store: str | Path, out: str | Path, params: ScanParams = PARAMS, **options: Any
) -> tuple[Plan, Job]:
    """A scan of batches of two of the recordings of `small_fleet`, none of which is done yet."""
    run = Options(**options)
    place = Location(out, dict(run.storage))
    plan = begin(
        Store(Location(store, dict(run.storage))).snapshot(), place, params, frames_per_batch=100
    )
    return plan, Job(plan.store, place.uri, plan.key, run)


def files_of(out: Path | Location) -> dict[str, bytes]:
    """Content of all files with results, by path."""
    place = out if isinstance(out, Location) else Location(out)
    return {
        entry.path: place.read(entry.path)
        for entry in place.list()
        if entry.path.endswith(".parquet") or entry.path.startswith("done/")
    }


def table_of(out: Path, name: str) -> pa.Table:
    """A table of results, of the files that Delta lists."""
    files = DeltaTable(out / name).file_uris()
    return pa.concat_tables([pq.read_table(file) for file in files])


def quarantine_of(out: Path) -> dict[str, str]:
    """Why recordings are in quarantine, by name."""
    rows = table_of(out, "quarantine").sort_by("recording").to_pydict()
    return dict(zip(*rows.values(), strict=True))


def attempts_of(out: Path) -> dict[str, int]:
    """How often each batch was begun."""
    return {path.name: len([*path.iterdir()]) for path in (out / "leases").iterdir()}


def failures_of(out: Path) -> set[str]:
    """Why batches failed as a whole, so that their recordings were taken one at a time."""
    attempts = [unseal(path.read_bytes()) or {} for path in out.glob("leases/*/*.json")]
    return {attempt["failed"] for attempt in attempts if "failed" in attempt}


def until(holds: Callable[[], object], what: str) -> None:
    """Wait for a condition."""
    end = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end, f"waited in vain: {what}"
        threading.Event().wait(0.02)


def process(*command: object) -> subprocess.Popen[bytes]:
    """A Python process, which finds the project and these helpers."""
    helpers = str(ROOT / "tests" / "helpers")
    return subprocess.Popen(
        [sys.executable, *map(str, command)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), helpers])},
    )


def named(tables: Mapping[str, pa.Table]) -> list[str]:
    return tables["recordings"]["recording"].to_pylist()


def killed_at(recording: str, folder: Path, times: int) -> Callable[..., Any]:
    """Its worker is killed so many times, whenever it comes to this recording; empty: to any."""
    return partial(_killed_at, recording, folder, times)


def _killed_at(
    recording: str, folder: Path, times: int, tables: Mapping[str, pa.Table], params: ScanParams
) -> Any:
    if recording in ("", *named(tables)):
        number = len([*folder.glob("killed-*")])
        if number < times:
            (folder / f"killed-{number}").write_text(" ".join(named(tables)))
            os.kill(os.getpid(), signal.SIGKILL)
    return scan_batch(tables, params)


def stopped_at(recording: str, folder: Path) -> Callable[..., Any]:
    """Its worker stands still at this recording, and says so, until a file "on" is there."""
    return partial(_stopped_at, recording, folder)


def _stopped_at(
    recording: str, folder: Path, tables: Mapping[str, pa.Table], params: ScanParams
) -> Any:
    if recording in named(tables):
        (folder / "stops").write_text(str(os.getpid()))
        (folder / "stops").rename(folder / "stopped")
        until((folder / "on").exists, "the file that lets this worker go on")
    return scan_batch(tables, params)


def starved_at(recording: str, n_bytes: int) -> Callable[..., Any]:
    """From this recording on its worker can write no file of more bytes, as on a full disk."""
    return partial(_starved_at, recording, n_bytes)


def _starved_at(
    recording: str, n_bytes: int, tables: Mapping[str, pa.Table], params: ScanParams
) -> Any:
    if recording in named(tables):
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, n_bytes))
    return scan_batch(tables, params)


def compiled_in(folder: Path) -> Callable[..., Any]:
    """Its worker leaves word of how many loops it had to compile, and how many it has loaded."""
    return partial(_compiled_in, folder)


def _compiled_in(folder: Path, tables: Mapping[str, pa.Table], params: ScanParams) -> Any:
    results = scan_batch(tables, params)
    loops = [of for of in gc.get_objects() if isinstance(of, Dispatcher)]
    stats = [of.stats for of in loops if "nvcore" in of.py_func.__module__]
    misses, hits = (
        sum(sum(getattr(of, name).values()) for of in stats)
        for name in ("cache_misses", "cache_hits")
    )
    (folder / f"compiled-{os.getpid()}").write_text(f"{misses} {hits}")
    return results


def broken_at(recordings: Sequence[str]) -> Callable[..., Any]:
    """These recordings cannot be compared."""
    return partial(_broken_at, recordings)


def _broken_at(
    recordings: Sequence[str], tables: Mapping[str, pa.Table], params: ScanParams
) -> Any:
    for name in named(tables):
        if name in recordings:
            raise ZeroDivisionError(f"of {name}")
    return scan_batch(tables, params)


class UnpicklableError(Exception):
    """As errors of libraries that are compiled may be."""

    def __reduce__(self) -> Any:
        raise TypeError("does not pickle")


def unpicklable(*_: Any) -> Any:
    """Nothing can be compared."""
    raise UnpicklableError("of all")


def hours_later() -> float:
    """A clock by which every lease of now has expired."""
    return time.time() + 10_000
