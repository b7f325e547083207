"""What a fleet costs: ingest, scan, merging, questions; written to docs/benchmarks.md.

    python -m bench.fleet [--frames 1e5 1e6 1e7] [--workers 1 2] [--keep FOLDER] [--out FILE]

Each step runs in a fresh process, one after the other, on the fleet of `bench.fleet.generate`; a
scan's worker processes are looked at from outside. Figures go to FOLDER/costs.json, too, which
`bench.fleet.simulate` reads. 10^7 frames take some 2 GB of disk and twenty minutes on two cores.
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
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from multiprocessing import active_children
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any, Final

from bench.measure import report
from bench.tables import growth_exponent, seconds_text, table
from bench.web.tables import put_section
from bench.workers import run_worker

SECTION = """\
## Fleet

A synthetic fleet (`bench/fleet/generate.py`: 4 pedestrians a frame, 4 + 4 detections, recordings of
1,000 to 3,000 frames) in a store on the local disk. *Ingest* is from boxes in memory to a store,
drawing them is not in it; *from CSV* reads files first. *Scan* goes from the store to the tables of
results, in batches of 250,000 frames, with its worker processes' start in it; *finishing* merges
what the batches gave and is in it, too. *Second scan* is the same with another alpha. *Top* are the
20 worst encounters by night on rural roads. *Growth* is the slope of log time over log frames. Load
of the machine when it began: {load:.1f}.

{table}

Bytes: {bytes}. Peak memory of a worker: {peak}. {speedup}
"""
ALPHA: Final = 0.8
POLL_S: Final = 0.1
QUESTION: Final = "tag.night and tag.road = 'rural'"


def clocked(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """Result, seconds by the clock, and of the processor by this process and those that ended."""
    start, used = perf_counter(), _processor_s()
    result = work()
    return result, perf_counter() - start, _processor_s() - used


def _processor_s() -> float:
    usages = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


class Watch:
    """Peak memory, MB, of each worker process, looked at every tenth of a second."""

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
        """By how much the peak of any of them has grown in the second half of its life."""
        return max(peaks[-1] - peaks[len(peaks) // 2] for peaks in self._seen.values())

    def _look(self) -> None:
        while not self._is_over.wait(POLL_S):
            for process in active_children():
                try:
                    status = Path(f"/proc/{process.pid}/status").read_text()
                except OSError:  # it has just ended
                    continue
                lines = [line for line in status.splitlines() if line.startswith("VmHWM")]
                if lines:
                    peak_mb = int(lines[0].split()[1]) / 1024
                    self._seen.setdefault(process.pid or 0, []).append(peak_mb)


def ingest(store: str, n_frames: int) -> dict[str, Any]:
    """Append the fleet; drawing it does not count."""
    from bench.fleet.generate import draw_part, parts_of
    from nvcore.fleet.ingest import ingest_all
    from nvcore.fleet.store import Store

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
    """Ingest of CSV files with a session each."""
    from bench.csv_files import write_csv
    from bench.sets import make_set
    from nvcore.fleet.face import ingest as run

    parts = n_frames // 20_000
    for part in range(parts):
        write_csv(make_set(20_000 + part), Path(folder) / f"{part}", one_recording=True)
        session = Path(folder) / f"{part}" / "session.toml"
        names = f'\n[[recording]]\nname = "r0000"\ntitle = "r{part}"\n'
        session.write_text(session.read_text() + names)
    done, seconds, used = clocked(lambda: run(folder, store=f"{folder}/store"))
    assert not done.errors, done.errors
    return {"frames": int(done.recordings["n_rows"].sum()), "s": seconds, "cpu_s": used}


def scan(store: str, out: str, workers: int, alpha: float | None) -> dict[str, Any]:
    """A scan by so many processes, and what its parts take."""
    from nvcore.fleet.location import Location
    from nvcore.fleet.pool import in_pool
    from nvcore.fleet.results import ScanParams
    from nvcore.fleet.scan import Job, begin, drive, finish
    from nvcore.fleet.store import Store
    from nvcore.params import Params

    location = Location(out)
    params = ScanParams("FIR", "NIR", params=Params() if alpha is None else Params(alpha=alpha))
    done_at = []

    def run() -> tuple[Any, Any]:
        start = perf_counter()
        plan, begin_s, _ = clocked(lambda: begin(Store(store), location, params))
        job = Job(plan.store, location.uri, plan.key)
        _, open_s, _ = clocked(job.missing)
        with Watch() as watch:
            for _ in drive(job, partial(in_pool, n_workers=workers)):
                done_at.append(perf_counter() - start)
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


def top(out: str) -> dict[str, Any]:
    """The question that opens the worst moments."""
    from nvcore.fleet.location import Location
    from nvcore.fleet.query import worst

    runs = [clocked(lambda: worst(Location(out), where=QUESTION)) for _ in range(5)]
    return {"s": median(run[1] for run in runs), "cpu_s": median(run[2] for run in runs)}


def _bytes(folder: str) -> int:
    return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())


STEPS: Final = {"ingest": ingest, "from_csv": from_csv, "scan": scan, "top": top}


def measured(step: str, **arguments: Any) -> dict[str, Any]:
    """Figures of a step, in a process of its own."""
    print(f"{step} {arguments} ...", file=sys.stderr)
    python = Path(sys.executable)
    figures = run_worker(python, "bench.fleet", "--step", step, json.dumps(arguments))
    if "failed" in figures:
        sys.exit(f"{step} failed: {figures['failed']}")
    print(f"  {figures['s']:.2f} s", file=sys.stderr)
    return figures


def measure_size(n_frames: int, workers: list[int], folder: Path) -> dict[str, Any]:
    """All steps at one size."""
    store = str(folder / "store")
    costs = {"ingest": measured("ingest", store=store, n_frames=n_frames)}
    for n in workers:
        out = str(folder / f"by {n}")
        costs[f"scan, {n}"] = measured("scan", store=store, out=out, workers=n, alpha=None)
    out = str(folder / f"by {workers[-1]}")
    costs["top"] = measured("top", out=out)
    again = {"store": store, "out": out, "workers": workers[-1], "alpha": ALPHA}
    costs["second scan"] = measured("scan", **again)
    return costs


def rows_of(costs: dict[int, dict[str, Any]]) -> Iterator[list[str]]:
    """Rows of the table: clock, and frames a second of one core."""
    sizes = sorted(costs)
    for step in costs[sizes[0]]:
        of_step = [costs[n].get(step) for n in sizes]
        known = [(of["frames"], of) for of in of_step if of is not None and "frames" in of]
        known = known or [
            (costs[n]["ingest"]["frames"], of) for n, of in zip(sizes, of_step, strict=True) if of
        ]
        exponent = growth_exponent([n for n, _ in known], [of["s"] for _, of in known])
        rates = [] if step == "top" else [f"{n / of['cpu_s']:,.0f}" for n, of in known[-1:]]
        cells = ["–" if of is None else seconds_text(of["s"]) for of in of_step]
        name = step.replace("scan, 1", "scan, 1 worker").replace("scan, 2", "scan, 2 workers")
        yield [name, *cells, f"{exponent:.2f}" if exponent == exponent else "", *(rates or [""])]
        if step.startswith("scan"):
            cells = [seconds_text(of["finish_s"]) for of in of_step if of]
            finish_s = [of["finish_s"] for _, of in known]
            exponent = growth_exponent([n for n, _ in known], finish_s)
            shown = f"{exponent:.2f}" if exponent == exponent else ""
            yield ["… of it finishing", *cells, shown, ""]


def section_of(costs: dict[int, dict[str, Any]], csv: dict[str, Any], load: float) -> str:
    """The section of docs/benchmarks.md."""
    sizes = sorted(costs)
    largest = costs[sizes[-1]]
    scans = [of for step, of in largest.items() if step.startswith("scan, ")]
    n = largest["ingest"]["frames"]
    rows = [*rows_of(costs)]
    rate = f"{csv['frames'] / csv['cpu_s']:,.0f}"
    first = f"from CSV, {csv['frames']:,} frames"
    rows.insert(1, [first, seconds_text(csv["s"]), *[""] * (len(sizes) - 1), "", rate])
    head = ["", *(f"{costs[of]['ingest']['frames']:,} frames" for of in sizes), "growth"]
    peaks = {of["peak_mb"] for step in costs.values() for of in step.values() if "peak_mb" in of}
    grown = max(of["grown_mb"] for of in scans)
    rates = [of["frames"] / of["s"] for of in scans]
    return SECTION.format(
        load=load,
        table=table([*head, "frames a second a core"], rows),
        bytes=f"{largest['ingest']['bytes'] / n:.0f} a frame in the store, "
        f"{scans[-1]['bytes'] / n:.1f} of results",
        peak=f"{max(peaks):.0f} MB, {grown:.0f} MB of it in the second half of its life at "
        f"{n:,} frames (target: less than 1,000 MB)",
        speedup="From one worker to two: "
        + ", ".join(f"{after / before:.2f} times as fast" for before, after in pairwise(rates))
        + ".",
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=float, nargs="+", default=[1e5, 1e6, 1e7])
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--keep", type=Path, help="folder for stores and costs.json, kept")
    parser.add_argument("--out", type=Path, help="the page that the section goes into")
    parser.add_argument("--step", nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.step:
        name, arguments = options.step
        report(**STEPS[name](**json.loads(arguments)))
        return
    load = os.getloadavg()[0]
    folder = options.keep or Path(tempfile.mkdtemp(prefix="fleet-"))
    try:
        costs = {}
        with tempfile.TemporaryDirectory() as files:
            csv = measured("from_csv", folder=files, n_frames=100_000)
        for n in map(int, options.frames):
            of_size = folder / f"{n}"
            shutil.rmtree(of_size, ignore_errors=True)
            costs[n] = measure_size(n, options.workers, of_size)
            (folder / "costs.json").write_text(json.dumps(costs, indent=1))
        section = section_of(costs, csv, load)
        print(section)
        if options.out:
            put_section(options.out, section)
    finally:
        if not options.keep:
            shutil.rmtree(folder)


if __name__ == "__main__":
    main()
