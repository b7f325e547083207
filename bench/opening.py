"""Measure opening a set of files (reading, placing, auditing, analysing) against reading alone.

    python -m bench.opening FOLDER [--repeat 3] [--profile]

FOLDER is an output of `bench.csv_files`, CSV or Parquet. Reading alone is pyarrow reading the three
files with its defaults, which may use all cores. It is timed before each opening, in the same
process, so that the ratio is meaningful on a busy machine as well. A run on a small set first loads
the compiled functions. Peak memory is that of loading alone.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

import pyarrow.csv
import pyarrow.parquet

from bench.csv_files import write_csv
from bench.measure import peak_beyond, report, versions
from bench.sets import make_set
from nvcore.auditing import audit
from nvcore.comparison.compare import compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session

WARM_FRAMES = 1_000
STEPS = ("load", "audit", "analyse")


def read_alone(folder: Path) -> float:
    """Return the seconds that pyarrow needs to read the three files."""
    start = perf_counter()
    for path in folder.glob("*.csv"):
        pyarrow.csv.read_csv(path)
    for path in folder.glob("*.parquet"):
        pyarrow.parquet.read_table(path)
    return perf_counter() - start


def open_all(folder: Path) -> dict[str, float]:
    """Return the seconds of each step from session to result, and the kB per frame of loading."""
    session = read_session(folder / "session.toml")
    times = [perf_counter()]
    dataset, peak_mb = peak_beyond(lambda: load(session))
    times.append(perf_counter())
    audit(dataset)
    times.append(perf_counter())
    compare(dataset)
    times.append(perf_counter())
    return {
        step: after - before for step, before, after in zip(STEPS, times, times[1:], strict=False)
    } | {"kb_a_frame": 1024 * peak_mb / len(dataset.frames)}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--profile", action="store_true", help="print where the time goes")
    options = parser.parse_args()
    is_parquet = (options.folder / "truth.parquet").exists()
    with tempfile.TemporaryDirectory() as small:
        write_csv(make_set(WARM_FRAMES), Path(small), ending="parquet" if is_parquet else "csv")
        open_all(Path(small))
    if options.profile:
        profile = cProfile.Profile()
        profile.runcall(open_all, options.folder)
        pstats.Stats(profile).sort_stats("tottime").print_stats(40)
        return
    runs = []
    for _ in range(options.repeat):
        alone = read_alone(options.folder)
        steps = open_all(options.folder)
        ratio = sum(steps[step] for step in STEPS) / alone
        runs.append(
            {"pyarrow": alone, **steps, "ratio": ratio, "load_ratio": steps["load"] / alone}
        )
    report(
        **{name: median(run[name] for run in runs) for name in runs[0]},
        runs=runs,
        versions=versions("numpy", "numba", "pandas", "pyarrow"),
    )


if __name__ == "__main__":
    main()
