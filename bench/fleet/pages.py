"""Write the sections of docs/benchmarks.md and docs/scale.md from results of `bench.fleet`.

python -m bench.fleet.pages COSTS.json [--out docs]
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, Final

import numpy as np

from bench.fleet.simulate import LOCAL, SEED, Costs, Storage, costs_of, predicted, simulate
from bench.tables import growth_exponent, seconds_text, table
from bench.web.tables import put_section
from nvcore.common.wording import duration_text

MEASURED: Final = """\
## Fleet

A synthetic fleet (`bench/fleet/generate.py`: 4 pedestrians a frame, 4 + 4 detections, recordings of
1,000 to 3,000 frames) in a store on the local disk. *Ingest* is from boxes in memory to a store;
*from CSV* reads files first. *Scan* goes from the store to the tables of results, in batches of up
to 100,000 frames. It includes the start of its worker processes, and *finishing*, which computes
the measures of all recordings. *Top* lists the 20 worst encounters by night on rural roads.
*Growth* is the slope of log time over log frames. The first scan of a checkout compiles loops.
Load of the machine when it began: {load:.1f}.

{table}

Bytes a frame: {stored:.0f} in the store, {results:.1f} of results. Peak memory of a worker:
{peak:.0f} MB, {grown:.0f} MB of it from the second half of its life at the largest size
(target: less than 1,000 MB, steady). Two workers are {speedup:.2f} times as fast as one.
"""
LEAST_BATCHES: Final = 4
"""Minimum number of batches at the largest size for simulating larger ones."""
NAMES: Final = {"scan, 1": "scan, 1 worker", "scan, 2": "scan, 2 workers"}
PARTS: Final = {
    "time": "total",
    "plan, start": "metadata",
    "waits for storage": "storage",
    "last worker": "tail",
    "finishing": "finish",
}
"""Columns of the simulation by the names that `simulate` uses."""
SIMULATED: Final = """\
## Simulated

Measured: one worker compares {rate:,.0f} frames a second in batches of {costs.batch:,.0f} (the
standard deviation over {n} batches is {spread:.0%}); its start takes {costs.start_s:.1f} s. Of a
frame {costs.read:.0f} bytes are read and {costs.written:.0f} written. A recording costs
{plan_us:.0f} us in the plan, once, and {open_us:.0f} us and {memory:.1f} kB of memory in every
worker; a batch {finish:.1f} ms when the scan is finished. Assumed of an object store:
{total:.1f} GB/s for all workers together, {each:.0f} MB/s for one, {request:.0f} ms a request,
{cloud.requests} requests a batch; {cloud.slow:.0%} of the batches meet a machine that is
{cloud.times:.0f} times slower. Recordings have 2,000 frames, a worker is one core.

{table}

Two workers on the local disk, predicted from the batches of one worker (95 %), beside the
measurement:

{held}

That two workers on one machine slow each other down is not in the model. 10^8 frames on this
machine, two workers: {middle:.1f} minutes ({low:.1f} to {high:.1f}) from the store to the summary
by the model, {corrected:.1f} if it is as far off as at the largest size (target: 10).
"""
MOST_MEMORY: Final = 4e9
"""Maximum memory for names in a worker, bytes."""
SETTINGS: Final[tuple[tuple[str, Storage, dict[str, int]], ...]] = (
    ("ten times the storage's bandwidth", Storage(total=125e9), {}),
    ("batches four times as large", Storage(), {"times": 4}),
    ("no slow machines", Storage(slow=0.0), {}),
    ("divided into 100 stores", Storage(), {"stores": 100}),
)
"""Variants to simulate at a thousand workers."""


def measured_section(known: dict[str, Any]) -> str:
    """Return the section of docs/benchmarks.md."""
    sizes = [known["sizes"][n] for n in sorted(known["sizes"], key=int)]
    n_frames = [of["ingest"]["frames"] for of in sizes]
    scans = {name: [of[name] for of in sizes] for name in sizes[0] if "scan" in name}
    rows = [_steps("ingest", n_frames, [of["ingest"] for of in sizes])]
    for name, steps in scans.items():
        rows.append(_steps(NAMES[name], n_frames, steps))
        finishing = [{"s": of["finish_s"]} for of in steps]
        rows.append(_steps("… of it finishing", n_frames, finishing))
    rows.append(_steps("top", n_frames, [{"s": of["top"]["s"]} for of in sizes]))
    csv = known["csv"]
    rate = f"{csv['frames'] / csv['cpu_s']:,.0f}"
    empty = [""] * (len(sizes) - 1)
    from_csv = f"ingest from CSV, {csv['frames']:,} frames"
    rows.append([from_csv, seconds_text(csv["s"]), *empty, "", rate])
    head = ["", *(f"{n:,} frames" for n in n_frames), "growth", "frames a second a core"]
    of_scans = [of for steps in scans.values() for of in steps]
    one, two = (sizes[-1][name]["s"] for name in ("scan, 1", "scan, 2"))
    return MEASURED.format(
        load=known["load"],
        table=table(head, rows),
        stored=sizes[-1]["ingest"]["bytes"] / n_frames[-1],
        results=sizes[-1]["scan, 1"]["bytes"] / n_frames[-1],
        peak=max(of["peak_mb"] for of in of_scans),
        grown=max(sizes[-1][name]["grown_mb"] for name in ("scan, 1", "scan, 2")),
        speedup=one / two,
    )


def _steps(name: str, n_frames: list[int], steps: list[dict[str, Any]]) -> list[str]:
    """Return a row: time at each size, growth, and rate per core at the largest size."""
    growth = growth_exponent(n_frames, [of["s"] for of in steps])
    rate = f"{n_frames[-1] / steps[-1]['cpu_s']:,.0f}" if "cpu_s" in steps[-1] else ""
    times = [seconds_text(of["s"]) for of in steps]
    return [name, *times, "" if np.isnan(growth) else f"{growth:.2f}", rate]


def simulated_section(known: dict[str, Any]) -> str:
    """Return the section of docs/scale.md."""
    costs, cloud, rows = costs_of(known), Storage(), []
    for n_frames in (1e9, 1e11):
        for workers in (10, 100, 1_000):
            rows.append(_row(costs, cloud, n_frames, workers, ""))
        for change, storage, more in SETTINGS:
            rows.append(_row(costs, storage, n_frames, 1_000, change, **more))
    held = []
    for n in sorted(known["sizes"], key=int):
        scan = known["sizes"][n]["scan, 2"]
        low, middle, high = predicted(costs, LOCAL, scan["frames"], 2)
        span = f"{middle:.0f} s ({low:.0f} to {high:.0f})"
        ratio = scan["s"] / middle
        held.append([f"{scan['frames']:,}", span, f"{scan['s']:.0f} s", f"{ratio:.2f}"])
    low, middle, high = (of / 60 for of in predicted(costs, LOCAL, 1e8, 2))
    return SIMULATED.format(
        rate=1 / np.median(costs.frame_s),
        spread=float(np.std(costs.frame_s) / np.mean(costs.frame_s)),
        n=len(costs.frame_s),
        costs=costs,
        plan_us=costs.plan_s * 1e6,
        open_us=costs.open_s * 1e6,
        memory=costs.memory / 1000,
        finish=costs.finish_s[0] * 1000,
        total=cloud.total / 1e9,
        each=cloud.each / 1e6,
        request=cloud.request_s * 1000,
        cloud=cloud,
        table=table(["frames, workers", "changed", *PARTS, "memory of names"], rows),
        held=table(["frames", "predicted", "measured", "measured / predicted"], held),
        low=low,
        middle=middle,
        corrected=middle * ratio,
        high=high,
    )


def _row(
    costs: Costs, storage: Storage, n_frames: float, workers: int, change: str, **more: int
) -> list[str]:
    found = simulate(costs, storage, n_frames, workers, np.random.default_rng(SEED), **more)
    name = f"10^{np.log10(n_frames):.0f}, {workers:,}"
    if found["memory"] > MOST_MEMORY:
        times = ["–"] * len(PARTS)
    else:
        times = [duration_text(found[of]) for of in PARTS.values()]
    return [name, change, *times, f"{found['memory'] / 1e9:.1f} GB"]


def write_pages(known: dict[str, Any], docs: Path | None) -> None:
    """Print both sections, and write them into the pages of that folder."""
    sections = {"benchmarks.md": measured_section(known)}
    largest = known["sizes"][max(known["sizes"], key=int)]
    if largest["scan, 1"]["batches"] >= LEAST_BATCHES:
        sections["scale.md"] = simulated_section(known)
    for page, section in sections.items():
        print(section)
        if docs is not None:
            put_section(docs / page, section)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("costs", type=Path)
    parser.add_argument("--out", type=Path, help="the folder of the pages")
    options = parser.parse_args()
    write_pages(json.loads(options.costs.read_text()), options.out)


if __name__ == "__main__":
    main()
