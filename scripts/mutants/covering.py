"""Which tests run which line of the library; also the pytest plugin that learns it.

One run of the tests with coverage's contexts, in a copy of the project, leaves in .mutants:
coverage (lines), tests.json (seconds of each test), sources.json (the files as they were).
"""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Generator, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest
from coverage import CoverageData

from scripts.mutants.operators import Mutant

NOT_OF_THE_LIBRARY = ("tests/ui", "tests/e2e")
LIMIT_S = 30.0
"""Processor time of a test; a slower test takes no part."""
FIRST_FILES, FIRST_S = 3, 5.0
"""First round: tests of so many files and seconds at most. Most mutants end there."""


class TooSlow(BaseException):
    """A test has used up its processor time."""


class Limits:
    """Pytest plugin: the processor time of each test, and the same examples in every run."""

    def __init__(self, seconds: dict[str, float]) -> None:
        self.seconds = seconds
        self.started = 0.0

    def pytest_sessionstart(self) -> None:
        from hypothesis import settings

        settings.register_profile("mutants", deadline=None, derandomize=True, database=None)
        settings.load_profile("mutants")
        signal.signal(signal.SIGPROF, self.stop)

    def stop(self, *_: object) -> None:
        raise TooSlow

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.started = time.process_time()
        limit = self.seconds.get(item.nodeid, LIMIT_S)
        signal.setitimer(signal.ITIMER_PROF, limit, limit)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Generator[None, Any, Any]:
        report = yield
        report.processor_s = time.process_time() - self.started
        return report


class Record:
    """Pytest plugin: writes each test's seconds of processor time, null where it did not pass."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.seconds: dict[str, float | None] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        has_passed = report.passed and self.seconds.get(report.nodeid, 0.0) is not None
        self.seconds[report.nodeid] = report.processor_s if has_passed else None

    def pytest_sessionfinish(self) -> None:
        known = json.loads(self.file.read_text()) if self.file.exists() else {}
        self.file.write_text(json.dumps(known | self.seconds, indent=0))


def pytest_configure(config: pytest.Config) -> None:
    """Plugin by name (``-p scripts.mutants.covering``), as xdist's workers need the limits too."""
    config.pluginmanager.register(Limits({}))
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Record(Path(os.environ["NVCORE_MUTANTS"]) / "tests.json"))


def make_map(store: Path, tree: Path, tests: Sequence[str], workers: int) -> None:
    """Run the tests of the library in a copy; or `tests` alone, which joins them to the map."""
    rules = store / "coveragerc"
    rules.write_text(
        f"[run]\nsource = nvcore\nrelative_files = true\ndata_file = {store / 'coverage'}\n"
    )
    for left in store.glob("coverage.*"):  # of a run that was interrupted
        left.unlink()
    if not tests:
        for name in ("coverage", "tests.json"):
            (store / name).unlink(missing_ok=True)
    command = [
        sys.executable, "-m", "pytest", "-q", "--tb=line", "-p", "scripts.mutants.covering",
        "-p", "no:cacheprovider", "-n", str(workers), "--dist", "loadfile",
        "--cov", "--cov-append", "--cov-context=test", "--cov-report=", f"--cov-config={rules}",
        *[f"--ignore={folder}" for folder in NOT_OF_THE_LIBRARY], *tests,
    ]  # fmt: skip
    subprocess.run(command, cwd=tree, env={**os.environ, "NVCORE_MUTANTS": str(store)}, check=False)
    digests = {str(path.relative_to(tree)): digest(path) for path in tree.glob("nvcore/**/*.py")}
    (store / "sources.json").write_text(json.dumps(digests, indent=0))


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def file_of(test: str) -> str:
    return test.partition("::")[0]


class Map:
    """Which tests run which line, and how long each takes."""

    def __init__(self, store: Path, root: Path) -> None:
        self.root = root
        self.coverage = CoverageData(str(store / "coverage"))
        self.coverage.read()
        recorded = json.loads((store / "tests.json").read_text())
        self.seconds: dict[str, float] = {t: s for t, s in recorded.items() if s is not None}
        self.digests = json.loads((store / "sources.json").read_text())
        self.of_file = defaultdict(set)
        for test in self.seconds:
            self.of_file[file_of(test)].add(test)
        self.by_line = lru_cache(self._by_line)

    def _by_line(self, path: str) -> dict[int, set[str]]:
        if self.digests.get(path) != digest(self.root / path):
            raise SystemExit(f"{path} is not as it was when the map was made: run `map` again")
        contexts = self.coverage.contexts_by_lineno(path)
        return {
            line: {test for name in names if (test := name.rpartition("|")[0]) in self.seconds}
            for line, names in contexts.items()
        }

    def covering(self, mutant: Mutant) -> set[str]:
        """Tests that run the line; where it runs on import, those that run its function or file."""
        by_line = self.by_line(mutant.path)
        scope = mutant.scope or (1, max(by_line, default=1))
        on_import = not mutant.scope or mutant.line < scope[0]
        for first, last in [scope] if on_import else [(mutant.line, mutant.line), mutant.head]:
            tests: set[str] = set()
            tests.update(*(by_line.get(line, ()) for line in range(first, last + 1)))
            if tests:
                return tests
        return set()

    def rounds(self, mutant: Mutant, seconds: float) -> list[list[str]]:
        """Tests to run, `seconds` of them at most: few files first, then the rest.

        Tests of the file that is named after the module come first, quick ones before slow ones.
        A fixture may have run the line on behalf of another test of its file, so the other tests
        of a file follow those that ran the line themselves.
        """
        direct = self.covering(mutant)
        module = f"test_{Path(mutant.path).stem}"

        def place(test: str) -> tuple[bool, bool, float, str]:
            is_named = Path(file_of(test)).stem.startswith(module)
            return not is_named, test not in direct, self.seconds[test], test

        first: list[str] = []
        others: list[str] = []
        total = 0.0
        for test in sorted(direct.union(*(self.of_file[file_of(t)] for t in direct)), key=place):
            total += self.seconds[test]
            if first and total > seconds:
                break
            n_files = len({file_of(t) for t in [*first, test]})
            is_first = not others and total <= FIRST_S and n_files <= FIRST_FILES
            (first if is_first or not first else others).append(test)
        return [tests for tests in (first, others) if tests]
