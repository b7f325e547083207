"""Run the benchmarks, print the tables and write docs/benchmarks.md.

    python -m bench.run [--quick] [--sizes 1000 ...] [--others-at 100000] [--before CHECKOUT]
                        [--out FILE]

Every measurement runs in a fresh process, one after the other; other tools run in their own
environments (.venv-bench, made by `make bench`). `--quick` takes about a minute at small sizes and
writes no file unless `--out` is given.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from bench.command_line import measure_command_line
from bench.tables import write_tables
from bench.web.tables import web_section
from bench.workers import ROOT, TOOLS_PYTHON, run_worker

MOTMETRICS_PYTHON = ROOT / ".venv-bench" / "motmetrics" / "bin" / "python"

BESIDE = (
    ("numpy loop", "bench.baselines", Path(sys.executable)),
    ("scipy hausdorff", "bench.baselines", Path(sys.executable)),
    ("hotcoco", "bench.others", TOOLS_PYTHON),
    ("hotcoco compare", "bench.others", TOOLS_PYTHON),
    ("faster-coco-eval", "bench.others", TOOLS_PYTHON),
    ("ultrafast-pycocotools", "bench.others", TOOLS_PYTHON),
    ("vernier", "bench.others", TOOLS_PYTHON),
    ("TrackEval CLEAR", "bench.others", TOOLS_PYTHON),
    ("motmetrics", "bench.others", MOTMETRICS_PYTHON),
)
"""Name, module and interpreter of the tools that run beside ours."""

FROM_FILES = (
    ("nvcore, from files", "bench.from_files", Path(sys.executable)),
    ("TrackEval Evaluator, from files", "bench.from_files", TOOLS_PYTHON),
    ("TrackEval preprocessing + CLEAR", "bench.from_files", TOOLS_PYTHON),
)
"""Same for tools that start from the set as MOTChallenge files."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--sizes", type=int, nargs="+")
    parser.add_argument("--others-at", type=int)
    parser.add_argument("--repeat", type=int)
    parser.add_argument("--before", type=Path, help="a checkout of an earlier version")
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    quick = options.quick
    sizes = options.sizes or ([1_000, 10_000] if quick else [1_000, 10_000, 100_000, 1_000_000])
    others_at = options.others_at or (5_000 if quick else 100_000)
    repeat = str(options.repeat or (3 if quick else 7))
    others_repeat = str(options.repeat or (1 if quick else 5))
    out = options.out or (None if quick else ROOT / "docs" / "benchmarks.md")

    ours: dict[int, dict[str, Any]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for n in sorted({*sizes, others_at}):
            path = Path(folder) / f"{n}.npz"
            subprocess.run(
                [sys.executable, "-m", "bench.sets", str(n), str(path)], cwd=ROOT, check=True
            )
            print(f"nvcore, {n:,} frames ...", file=sys.stderr)
            ours[n] = run_worker(Path(sys.executable), "bench.ours", str(path), "--repeat", repeat)
            if "failed" in ours[n]:
                sys.exit(f"nvcore failed at {n:,} frames: {ours[n]['failed']}")
            if n != others_at:
                path.unlink()
        path, mot = Path(folder) / f"{others_at}.npz", Path(folder) / "mot"
        subprocess.run(
            [sys.executable, "-m", "bench.mot_files", str(path), str(mot)], cwd=ROOT, check=True
        )
        beside = {}
        for start, workers in ((path, BESIDE), (mot, FROM_FILES)):
            for name, module, python in workers:
                print(f"{name}, {others_at:,} frames ...", file=sys.stderr)
                beside[name] = run_worker(
                    python, module, name, str(start), "--repeat", others_repeat
                )
    print("command line ...", file=sys.stderr)
    command_line = measure_command_line(ROOT)
    print("browser ...", file=sys.stderr)
    frames = ["0", "5000"] if quick else ["0", "100000", "1000000"]
    web = run_worker(Path(sys.executable), "bench.web", "--frames", *frames)
    text = write_tables(ours, beside, others_at, command_line) + "\n" + web_section(web)
    with tempfile.TemporaryDirectory() as folder:
        page = out or Path(folder) / "benchmarks.md"
        page.write_text(text, encoding="utf-8")
        paired = ["bench.paired", *(["--quick"] if quick else [])]
        sliders = ["bench.web.sliders", "--frames", *frames[:2]]
        for section in (paired, sliders):
            print(f"{section[0]} ...", file=sys.stderr)
            before = ["--before", str(options.before)] if options.before else []
            subprocess.run(
                [sys.executable, "-m", *section, *before, "--out", str(page)],
                cwd=ROOT,
                stdout=subprocess.DEVNULL,
                check=True,
            )
        print(page.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
