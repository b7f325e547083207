"""Map from each line of the library to the tests that run it.

Every test file runs once by itself with coverage's contexts. It leaves in .mutants: coverage
(lines), tests.json (seconds of each test), sources.json (hashes of the files).
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import as_completed
from functools import lru_cache
from pathlib import Path

from coverage import CoverageData

from scripts.mutants.operators import Mutant
from scripts.mutants.trial import ROOT, file_of, make_workers, record_file

LEFT_OUT = (
    "tests/ui", "tests/e2e", "tests/scripts", "tests/helpers",
    "tests/report/html", "tests/stability", "tests/people", "tests/ratings", "tests/driver/study",
    "tests/tools",
)  # fmt: skip
"""Tests that are far from the lines and take minutes without compiled functions. A mutant that only
they would notice counts as survived.
"""
FIRST_FILES, FIRST_S = 3, 5.0
"""First round: maximum number of files and of seconds of tests. Most mutants end there."""


def make_map(store: Path, tests: Sequence[str]) -> None:
    """Map the tests of the library that are new or changed, or the files or folders `tests`.

    An interrupted map is continued. After an edit of the library it starts again.
    """
    table, sources = store / "tests.json", store / "sources.json"
    library, test_files = digests("nvcore/**/*.py"), digests("tests/**/test_*.py")
    known = json.loads(sources.read_text()) if sources.exists() else {}
    coverage = CoverageData(str(store / "coverage"))
    recorded: dict[str, float | None] = {}
    if library.items() <= known.items():
        coverage.read()
        recorded = json.loads(table.read_text())
    else:
        coverage.erase()
        known = library
    to_do = [
        file for file, digest in test_files.items()
        if known.get(file) != digest and not file.startswith(LEFT_OUT)
    ]  # fmt: skip
    asked = [file for file in test_files if file.startswith(tuple(tests))] if tests else []
    with make_workers(store) as pool:
        jobs = {}
        for number, file in enumerate(asked or to_do):
            part = store / f"part-{number}"
            shutil.rmtree(part, ignore_errors=True)
            jobs[pool.submit(record_file, file, part)] = file, part
        for number, job in enumerate(as_completed(jobs), 1):
            file, part = jobs[job]
            outcome = job.result()
            recorded = {test: s for test, s in recorded.items() if file_of(test) != file}
            recorded.update(outcome.seconds, **dict.fromkeys(outcome.failed))
            for test in outcome.failed:
                print(f"Takes no part, as it is slow here or fails without a mutant: {test}")
            for lines in part.iterdir():
                coverage.update(read_coverage(lines))
            shutil.rmtree(part)
            known[file] = test_files[file]
            table.write_text(json.dumps(recorded, indent=0))
            sources.write_text(json.dumps(known, indent=0))
            if number % 20 == 0 or number == len(jobs):
                print(f"{number} of {len(jobs)} files of tests", flush=True)


def digests(pattern: str) -> dict[str, str]:
    """Return short hashes of the checkout's files."""
    return {str(path.relative_to(ROOT)): digest(path) for path in sorted(ROOT.glob(pattern))}


def read_coverage(file: Path) -> CoverageData:
    coverage = CoverageData(str(file))
    coverage.read()
    return coverage


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Map:
    """Map from lines to tests, with the duration of each test."""

    def __init__(self, store: Path, root: Path) -> None:
        self.root = root
        self.coverage = read_coverage(store / "coverage")
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
        by_line = self.coverage.contexts_by_lineno(path)
        return {line: self.seconds.keys() & contexts for line, contexts in by_line.items()}

    def covering(self, mutant: Mutant) -> set[str]:
        """Return tests that run the line, or its function or file if it runs on import."""
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
        """Return tests to run, at most `seconds` of them: few files first, then the rest.

        Tests of the file named after the module come first, quick ones before slow ones. A fixture
        may have run the line on behalf of another test of its file, so the other tests of a file
        follow those that ran the line themselves.
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
