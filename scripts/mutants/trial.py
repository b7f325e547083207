"""Copies of the project in which workers try mutants and record which test runs which line.

A worker imports large external packages once. Each run of pytest forks from it, which saves most of
the start time.
"""

from __future__ import annotations

import filecmp
import importlib
import os
import shutil
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib.util import cache_from_source
from itertools import count
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from scripts.mutants.forked import Outcome, Task, run_pytest
from scripts.mutants.operators import Mutant

ROOT = Path(__file__).resolve().parents[2]
LARGE = (
    "pandas", "numba", "scipy.stats", "plotly.graph_objects", "pyarrow.parquet", "cv2", "PIL",
    "hypothesis", "xml.etree.ElementTree",
)  # fmt: skip
WORKERS = 2
RECORDED_S = 10.0
"""Maximum processor time of a test while its lines are recorded. Slower tests take no part."""
SPARE_S = 15.0
"""Additional processor time that a test may take with a mutant, beyond five times its usual one."""

tree: Path
"""This worker's copy."""


def copy_project(copy: Path) -> Path:
    """Copy tracked and untracked files of the project, keeping compiled files of the last copy."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    paths = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    wanted = {path for path in filter(None, paths.split("\0")) if (ROOT / path).is_file()}
    for file in copy.rglob("*"):
        is_compiled = file.parent.name == "__pycache__"
        if file.is_file() and not is_compiled and str(file.relative_to(copy)) not in wanted:
            file.unlink()
    for path in wanted:
        if not is_same(ROOT / path, copy / path):
            (copy / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / path, copy / path)
    return copy


def is_same(file: Path, copy: Path) -> bool:
    if not copy.exists() or file.stat().st_mtime_ns != copy.stat().st_mtime_ns:
        return False
    return filecmp.cmp(file, copy, shallow=False)


def make_workers(store: Path) -> ProcessPoolExecutor:
    """Create worker processes with a copy of the project each."""
    fork = get_context("fork")
    copies = fork.Queue()
    for number in range(WORKERS):
        copies.put(copy_project(store / f"tree-{number}"))
    return ProcessPoolExecutor(WORKERS, fork, start_worker, (copies,))


def start_worker(copies: Any) -> None:
    """Take a copy, and import large packages.

    Tests run the copy's modules as plain Python, on the recordings of `$NVCORE_REALDATA`.
    """
    global tree
    tree = copies.get()
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    os.environ["PYTHONPATH"] = str(tree)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # compiled files serve the next trials
    sys.dont_write_bytecode = False
    for name in LARGE:
        importlib.import_module(name)


def record_file(test_file: str, folder: Path) -> Outcome:
    """Run a test file, continuing after a test that takes too long and counts as failed.

    Recorded lines go to files in `folder`, one per process, as coverage starts again in each.
    """
    whole = Outcome()
    folder.mkdir()
    for number in count():
        done = [*whole.seconds, *whole.failed]
        task = Task([test_file], limit=RECORDED_S, without=done, coverage=folder / str(number))
        outcome = run_pytest(tree, task)
        whole.seconds.update(outcome.seconds)
        whole.failed += outcome.failed
        if "collection" in (outcome.stopped_in, *outcome.failed):
            whole.failed = [test_file]
            break
        if not outcome.stopped_in:
            break
        whole.failed.append(outcome.stopped_in)
    return whole


def run_tests(tests: list[str], seconds: dict[str, float]) -> tuple[str, str]:
    """Return the first failing test and why (see `Outcome`), or empty texts if all pass."""
    files = [*dict.fromkeys(map(file_of, tests))]
    limits = {test: SPARE_S + 5 * seconds[test] for test in tests}
    outcome = run_pytest(tree, Task(["-x", *files], limits, only=tests))
    noticed_by = next(iter(outcome.failed), outcome.stopped_in)
    return noticed_by, outcome.why if noticed_by else ""


def file_of(test: str) -> str:
    return test.partition("::")[0]


def try_mutant(
    mutant: Mutant, rounds: list[list[str]], seconds: dict[str, float]
) -> tuple[str, str]:
    """Return what `run_tests` returns for the mutant, empty if it survives."""
    file = tree / mutant.path
    source, times = file.read_text("utf-8"), file.stat()
    file.write_text(mutant.apply(source), "utf-8")
    try:
        for tests in rounds:
            noticed_by, why = run_tests(tests, seconds)
            if noticed_by:
                return noticed_by, why
        return "", ""
    finally:
        file.write_text(source, "utf-8")
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))
        Path(cache_from_source(str(file))).unlink(missing_ok=True)
