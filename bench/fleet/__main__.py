"""Measure the cost of fleets: ingest, scan, finishing, queries. Simulate that of larger ones.

    python -m bench.fleet [--frames 1e5 1e6 1e7] [--keep FOLDER] [--out docs]

Each step runs in a fresh process, one after the other, on the fleet of `bench.fleet.generate`. A
scan's worker processes are observed from outside. Results are also written to FOLDER/costs.json,
from which `bench.fleet.pages` can rebuild the sections. 10^7 frames take 8 GB of disk.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any, Final

from bench.fleet.pages import write_pages
from bench.measure import peak_beyond, report
from bench.workers import run_worker

POLL_S: Final = 0.1
QUESTION: Final = "tag.night and tag.road = 'rural'"


def clocked(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """Return the result, wall-clock seconds, and processor seconds including ended children."""
    start, used = perf_counter(), _processor_s()
    result = work()
    return result, perf_counter() - start, _processor_s() - used


def _processor_s() -> float:
    usages = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


class Watch:
    """Peak memory, MB, of each worker process, sampled every tenth of a second."""

    def __enter__(self) -> Watch:
        self._seen: dict[int, list[float]] = {}
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._thread.join()

    @property
    def peak_mb(self) -> float:
        return max(peaks[-1] for peaks in self._seen.values())

    @property
    def grown_mb(self) -> float:
        """Return the maximum growth of a worker's peak in the second half of its life."""
        return max(peaks[-1] - peaks[len(peaks) // 2] for peaks in self._seen.values())

    def _look(self) -> None:
        while not self._is_over.wait(POLL_S):
            tasks = Path("/proc/self/task").glob("*/children")
            for pid in [int(pid) for task in tasks for pid in task.read_text().split()]:
                try:
                    status = Path(f"/proc/{pid}/status").read_text()
                except OSError:  # the process has just ended
                    continue
                lines = [line for line in status.splitlines() if line.startswith("VmHWM")]
                if lines:
                    peak_mb = int(lines[0].split()[1]) / 1024
                    self._seen.setdefault(pid, []).append(peak_mb)


def ingest(store: str, n_frames: int) -> dict[str, Any]:
    """Append the fleet to a store. Drawing it is not included in the time."""
    from bench.fleet.generate import draw_part, parts_of
    from nvcore.subjects.fleet.ingest import ingest_all
    from nvcore.subjects.fleet.store import Store

    drawing, n = [], 0

    def drawn(part: int) -> Any:
        nonlocal n
        dataset, *took = clocked(lambda: draw_part(part))
        drawing.append(took)
        n += len(dataset.frames)
        return dataset

    inputs = ((str(part), partial(drawn, part)) for part in parts_of(n_frames))
    _, seconds, used = clocked(lambda: ingest_all(inputs, Store(store)))
    return {
        "frames": n,
        "s": seconds - sum(of[0] for of in drawing),
        "cpu_s": used - sum(of[1] for of in drawing),
        "bytes": _bytes(store),
    }


def from_csv(folder: str, n_frames: int) -> dict[str, Any]:
    """Ingest CSV files with a session each."""
    from bench.csv_files import write_csv
    from bench.sets import make_set
    from nvcore.subjects.fleet.calls import ingest as run

    parts = n_frames // 20_000
    for part in range(parts):
        write_csv(make_set(20_000 + part), Path(folder) / f"{part}", one_recording=True)
        session = Path(folder) / f"{part}" / "session.toml"
        names = f'\n[[recording]]\nname = "r0000"\ntitle = "r{part}"\n'
        session.write_text(session.read_text() + names)
    done, seconds, used = clocked(lambda: run(folder, store=f"{folder}/store"))
    assert not done.errors, done.errors
    return {"frames": int(done.recordings["n_rows"].sum()), "s": seconds, "cpu_s": used}


def scan(store: str, out: str, workers: int) -> dict[str, Any]:
    """Run a scan with a number of processes, and return the cost of its parts."""
    from nvcore.subjects.fleet.folder import begin, finish
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.results import ScanParams
    from nvcore.subjects.fleet.scan import Job, drive, in_pool
    from nvcore.subjects.fleet.store import Store

    location = Location(out)
    params = ScanParams("FIR", "NIR")
    done_at = []

    def run() -> tuple[Any, Any]:
        start = perf_counter()
        plan, begin_s, _ = clocked(lambda: begin(Store(store).snapshot(), location, params))
        job = Job(plan.store, location.uri, plan.key)
        _, open_s, _ = clocked(job.missing)
        with Watch() as watch:
            sizes = {batch.key: batch.n_frames for batch in plan.batches}
            for batch in drive(job, partial(in_pool, n_workers=workers)):
                done_at.append((perf_counter() - start, sizes[batch]))
        _, finish_s, _ = clocked(lambda: finish(location, plan))
        return plan, {
            "begin_s": begin_s,
            "open_s": open_s,
            "finish_s": finish_s,
            "peak_mb": watch.peak_mb,
            "grown_mb": watch.grown_mb,
        }

    (plan, parts), seconds, used = clocked(run)
    return {
        "frames": plan.n_frames,
        "recordings": sum(len(batch.recordings) for batch in plan.batches),
        "batches": len(plan.batches),
        "s": seconds,
        "cpu_s": used,
        **parts,
        "done_at_s": done_at,
        "plan_bytes": len(plan.to_json()),
        "bytes": _bytes(out),
    }


def names(folder: str, recordings: int) -> dict[str, Any]:
    """Create a store that holds nothing but names of recordings."""
    import numpy as np
    import pandas as pd

    from nvcore.dataset.tables import dataset_from_tables
    from nvcore.subjects.fleet.ingest import ingest_all
    from nvcore.subjects.fleet.store import Store

    every = [f"r{number:08}" for number in range(recordings)]
    facts = pd.DataFrame({"name": every, "width": 640, "height": 480, "fps": 20.0, "unit": "car"})
    boxes = pd.DataFrame({name: [] for name in ("frame_index", "source", "x", "y", "w", "h")})
    frames = [np.arange(2)] * recordings
    dataset = dataset_from_tables(facts, frames, boxes, ["FIR", "NIR"], fingerprint="")
    _, seconds, used = clocked(lambda: ingest_all([("all", lambda: dataset)], Store(folder)))
    return {"s": seconds, "cpu_s": used}


def metadata(folder: str) -> dict[str, Any]:
    """Measure the cost per recording before the first one is compared."""
    from nvcore.subjects.fleet.folder import begin
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.results import ScanParams
    from nvcore.subjects.fleet.scan import Job
    from nvcore.subjects.fleet.store import Snapshot, Store

    out, params = Location(f"{folder}/results"), ScanParams("FIR", "NIR")

    def read() -> tuple[Any, ...]:
        plan, begin_s, _ = clocked(lambda: begin(Store(folder).snapshot(), out, params))

        def open_as_worker() -> None:
            Job(plan.store, out.uri, plan.key).missing()
            first = plan.batches[0].recordings[:1]
            Snapshot(Location(folder), plan.versions).read(first, params.sources)

        return plan, begin_s, clocked(open_as_worker)[1]

    (plan, begin_s, open_s), peak_mb = peak_beyond(read)
    return {
        "recordings": sum(len(batch.recordings) for batch in plan.batches),
        "s": begin_s + open_s,
        "begin_s": begin_s,
        "open_s": open_s,
        "plan_bytes": len(plan.to_json()),
        "memory": peak_mb * 1024**2,
    }


def top(out: str) -> dict[str, Any]:
    """Run the query that opens the worst moments."""
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.query import worst

    runs = [clocked(lambda: worst(Location(out), where=QUESTION)) for _ in range(5)]
    return {"s": median(run[1] for run in runs), "cpu_s": median(run[2] for run in runs)}


def _bytes(folder: str) -> int:
    return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())


STEPS: Final[dict[str, Callable[..., dict[str, Any]]]] = {
    "ingest": ingest,
    "from_csv": from_csv,
    "names": names,
    "metadata": metadata,
    "scan": scan,
    "top": top,
}


def measured(step: str, **arguments: Any) -> dict[str, Any]:
    """Return the results of a step, run in its own process."""
    print(f"{step} {arguments} ...", file=sys.stderr)
    os.sync()  # writes of earlier steps must not count
    python = Path(sys.executable)
    figures = run_worker(python, "bench.fleet", "--step", step, json.dumps(arguments))
    if "failed" in figures:
        sys.exit(f"{step} failed: {figures['failed']}")
    print(f"  {figures['s']:.2f} s", file=sys.stderr)
    return figures


def measure_names(folder: str) -> dict[str, Any]:
    """Measure the cost of names. The memory excludes the constant part of every process."""
    few, many = 5_000, 20_000
    for n in (few, many):
        measured("names", folder=f"{folder}/{n}", recordings=n)
    less, more = (measured("metadata", folder=f"{folder}/{n}") for n in (few, many))
    return more | {"memory": (more["memory"] - less["memory"]) * many / (many - few)}


def measure_size(n_frames: int, folder: Path) -> dict[str, Any]:
    """Measure all steps at one size."""
    store = str(folder / "store")
    costs = {"ingest": measured("ingest", store=store, n_frames=n_frames)}
    for n in (1, 2):
        out = str(folder / f"by {n}")
        costs[f"scan, {n}"] = measured("scan", store=store, out=out, workers=n)
    costs["top"] = measured("top", out=out)
    return costs


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=float, nargs="+", default=[1e5, 1e6, 1e7])
    parser.add_argument("--keep", type=Path, help="folder for stores and costs.json, kept")
    parser.add_argument("--out", type=Path, help="folder of the pages that sections go into")
    parser.add_argument("--step", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.step:
        name, arguments = options.step
        report(**STEPS[name](**json.loads(arguments)))
        return
    folder = options.keep or Path(tempfile.mkdtemp(prefix="fleet-"))
    known: dict[str, Any] = {"load": os.getloadavg()[0], "sizes": {}}
    try:
        with tempfile.TemporaryDirectory() as files:
            known["csv"] = measured("from_csv", folder=files, n_frames=100_000)
            known["metadata"] = measure_names(files)
        for n in map(int, options.frames):
            of_size = folder / f"{n}"
            shutil.rmtree(of_size, ignore_errors=True)
            known["sizes"][str(n)] = measure_size(n, of_size)
            (folder / "costs.json").write_text(json.dumps(known))
        write_pages(known, options.out)
    finally:
        if not options.keep:
            shutil.rmtree(folder)


if __name__ == "__main__":
    main()
