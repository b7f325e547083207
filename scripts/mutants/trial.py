"""One mutant against its tests, in a copy of the project and a process of its own.

A worker imports once what is large and not ours; each trial forks from there, which saves most of
the seconds that a fresh pytest takes to start.
"""

from __future__ import annotations

import compileall
import importlib
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence
from importlib.util import cache_from_source
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import pytest

from scripts.mutants.covering import NOT_OF_THE_LIBRARY, Limits, file_of
from scripts.mutants.operators import Mutant

ROOT = Path(__file__).resolve().parents[2]
LARGE = ("pandas", "numba", "scipy.stats", "plotly.graph_objects", "PIL")
MEMORY_BYTES = 8 * 2**30
"""Of one trial, as some mutants ask for all there is."""
CRASHES = [-number for number in (signal.SIGSEGV, signal.SIGABRT, signal.SIGBUS, signal.SIGFPE)]
"""Exit codes of a process that its own code brought down, rather than somebody else."""

tree: Path
"""This worker's copy."""


def copy_project(copy: Path) -> Path:
    """A fresh copy of the files that git knows or would know."""
    shutil.rmtree(copy, ignore_errors=True)
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    paths = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for path in filter(None, paths.split("\0")):
        if (ROOT / path).is_file():
            (copy / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / path, copy / path)
    return copy


def use_copy(copy: Path) -> None:
    """Environment of tests in a copy: plain Python, its modules, the recordings of the checkout."""
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    os.environ["PYTHONPATH"] = str(copy)
    os.environ.setdefault("NVCORE_REALDATA", str(ROOT.parent / "shared" / "realdata"))


def start_worker(copies: Any) -> None:
    """Take a copy, compile its files, import what is large."""
    global tree
    tree = copies.get()
    use_copy(tree)
    compileall.compile_dir(tree / "nvcore", quiet=2)
    run_tests([], {}, 600)
    for name in LARGE:
        importlib.import_module(name)


class Choice:
    """Pytest plugin: these tests alone, in this order; keeps the name of the one that fails."""

    def __init__(self, tests: Sequence[str]) -> None:
        self.place = {test: place for place, test in enumerate(tests)}
        self.failed = "collection"

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        selected = [item for item in items if item.nodeid in self.place]
        items[:] = sorted(selected, key=lambda item: self.place[item.nodeid])

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = report.nodeid


def in_child(tests: Sequence[str], limits: dict[str, float], answer: Connection) -> None:
    """Run tests in the copy until one fails; without tests, only compile them all."""
    os.setsid()
    os.chdir(tree)
    log = os.open("pytest.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    sys.path.insert(0, str(tree))
    if tests:  # else compiled mutants would stay behind
        sys.dont_write_bytecode = True
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
    test_files = [*dict.fromkeys(map(file_of, tests))] or ["tests", "--collect-only"]
    test_files += [f"--ignore={folder}" for folder in NOT_OF_THE_LIBRARY]
    choice = Choice(tests)
    code = pytest.main(
        ["-x", "-q", "--tb=short", "-p", "no:cacheprovider", "-p", "no:xdist",
         "-W", "ignore::pytest.PytestAssertRewriteWarning", *test_files],
        plugins=[choice, Limits(limits)],
    )  # fmt: skip
    answer.send((int(code), choice.failed))
    os._exit(0)


def run_tests(tests: Sequence[str], limits: dict[str, float], seconds: float) -> str:
    """The first test that fails, empty if none does; "time" or "crash" if that ends the run."""
    fork = get_context("fork")
    receiver, sender = fork.Pipe(duplex=False)
    child = fork.Process(target=in_child, args=(tests, limits, sender))
    child.start()
    sender.close()
    try:
        code, failed = receiver.recv() if receiver.poll(seconds) else (1, "time")
    except EOFError:
        child.join()
        crashed = child.exitcode in CRASHES
        code, failed = (1, "crash") if crashed else (pytest.ExitCode.USAGE_ERROR, "")
    finally:
        if child.is_alive() and child.pid:
            os.killpg(child.pid, signal.SIGKILL)
        child.join()
    if code == pytest.ExitCode.USAGE_ERROR or (
        tests and code == pytest.ExitCode.NO_TESTS_COLLECTED
    ):
        raise RuntimeError(f"pytest could not run: see {tree / 'pytest.log'}")
    return failed if code in (1, 2, 3) else ""


def try_mutant(mutant: Mutant, rounds: list[list[str]], seconds: dict[str, float]) -> str:
    """What notices the mutant, as `run_tests` says it; empty if nothing does."""
    file = tree / mutant.path
    source = file.read_text("utf-8")
    Path(cache_from_source(str(file))).unlink(missing_ok=True)
    file.write_text(mutant.apply(source), "utf-8")
    try:
        for tests in rounds:
            limits = {test: 5 + 5 * seconds[test] for test in tests}
            if noticed := run_tests(tests, limits, 600 + 20 * sum(seconds[t] for t in tests)):
                return noticed
        return ""
    finally:
        file.write_text(source, "utf-8")
