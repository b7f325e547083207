"""The program that puts mistakes into the library: which mistakes, and whether tests notice."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from coverage import CoverageData

from scripts.mutants.covering import Map, digest, read_coverage
from scripts.mutants.operators import Mutant, mutants_of

SOURCE = '''\
"""A module: 1 + 1 in its docstring stays."""

LIMIT: tuple[int, "a < b"] = (7, None)


def clamp(value, low=0):
    """Not below `low`: 2 < 3."""
    assert low < 10
    if value <= low and not value % 2:
        raise ValueError(f"{value} < {low + 1}")
    return max(value, low)
'''


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "clamping.py").write_text(SOURCE)
    return tmp_path


def find(root: Path, mutation: str) -> Mutant:
    (mutant,) = (m for m in mutants_of(root, "clamping.py") if m.mutation == mutation)
    return mutant


def test_mutations_spare_texts_annotations_and_assertions(root: Path) -> None:
    assert [(m.line, m.mutation) for m in mutants_of(root, "clamping.py")] == [
        (3, "7 -> 8"),
        (6, "0 -> 1"),
        (9, "<= -> <"),
        (9, "<= -> >"),
        (9, "and -> or"),
        (9, "not ->"),
        (9, "% -> /"),
        (9, "2 -> 3"),
        (11, "max -> min"),
        (11, "max(value, low) -> None"),
    ]


def test_a_mutant_is_the_file_with_one_change(root: Path) -> None:
    mutated = find(root, "and -> or").apply(SOURCE)
    assert mutated == SOURCE.replace("low and not", "low or not")


@pytest.mark.parametrize(
    ("line", "mutations"),
    [
        ("a = (b) not in (c)", ["not in -> in"]),
        ("a = b[c : d + 1]", ["c ->", "d + 1 ->", "+ -> -", "1 -> 2"]),
        ("a -= b", ["-= -> +="]),
        ("a = 'é' + b if c() else -d", ["c() -> not (c())", "- ->"]),
        ("a = f(b, side='left', strict=True)", ["'left' -> 'right'"]),
        ("a = [b.min() for b in c if b]", ["min -> max", "b -> not (b)"]),
    ],
)
def test_mutations_of_a_line(tmp_path: Path, line: str, mutations: list[str]) -> None:
    (tmp_path / "line.py").write_text(line, "utf-8")
    shown = [mutant.mutation for mutant in mutants_of(tmp_path, "line.py")]
    assert sorted(shown) == sorted(mutations)


def test_an_edit_elsewhere_changes_neither_name_nor_order_of_a_mutant(root: Path) -> None:
    before = find(root, "max -> min")
    (root / "clamping.py").write_text(SOURCE.replace("\n\ndef", "\nMORE = 3\n\n\ndef"))
    after = find(root, "max -> min")
    assert after.line != before.line
    assert (after.key, after.order(0)) == (before.key, before.order(0))


def test_a_mutant_meets_the_tests_that_run_its_line_those_of_its_module_first(root: Path) -> None:
    coverage = CoverageData(str(root / "coverage"))
    for test, lines in {
        "test_all.py::test_quick": [9, 11],
        "test_clamping.py::test_slow": [9, 11],
        "test_clamping.py::test_of_other_lines": [9],
        "test_other.py::test_elsewhere": [9],
    }.items():
        coverage.set_context(test)
        coverage.add_lines({"clamping.py": lines})
    coverage.write()
    seconds = {
        "test_all.py::test_quick": 0.1,
        "test_clamping.py::test_slow": 2,
        "test_clamping.py::test_of_other_lines": 0.1,
        "test_other.py::test_elsewhere": 0.1,
        "test_clamping.py::test_that_fails_anyway": None,
    }
    (root / "tests.json").write_text(json.dumps(seconds))
    (root / "sources.json").write_text(json.dumps({"clamping.py": digest(root / "clamping.py")}))
    mapped = Map(root, root)
    assert mapped.rounds(find(root, "max -> min"), 60) == [
        [
            "test_clamping.py::test_slow",
            "test_clamping.py::test_of_other_lines",
            "test_all.py::test_quick",
        ]
    ]
    assert mapped.covering(find(root, "0 -> 1")) == {t for t, s in seconds.items() if s}
    (root / "clamping.py").write_text(SOURCE + "\n")
    with pytest.raises(SystemExit, match="run `map` again"):
        Map(root, root).covering(find(root, "max -> min"))


def run_in_worker(root: Path, statements: str) -> list[str]:
    """Lines that statements print in a worker; trials fork, which this process with threads cannot.

    `mutants` holds the mutants of clamping.py by what they change.
    """
    begin = f"""
from pathlib import Path
from scripts.mutants import trial
from scripts.mutants.operators import mutants_of
trial.tree = Path({str(root)!r})
mutants = {{mutant.mutation: mutant for mutant in mutants_of(trial.tree, "clamping.py")}}
"""
    done = subprocess.run(
        [sys.executable, "-c", begin + statements],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.splitlines()


def test_a_mutant_is_noticed_by_a_failure_or_by_time_or_survives(root: Path) -> None:
    test = "test_of_clamping.py::test_values_stay_above_the_limit"
    (root / "test_of_clamping.py").write_text(
        "from clamping import clamp\n\n"
        "def test_values_stay_above_the_limit():\n"
        "    assert clamp(1) is not None\n"
        "    while clamp(1) != 1: pass\n"
    )
    lines = run_in_worker(
        root,
        f"""
trial.SPARE_S = 0.3
for change in ("max(value, low) -> None", "<= -> <", "max -> min"):
    print(trial.try_mutant(mutants[change], [[{test!r}]], {{{test!r}: 0}}))
""",
    )
    assert lines == [str((test, "failure")), str(("", "")), str((test, "time"))]
    assert (root / "clamping.py").read_text() == SOURCE
    assert "line 5 in test_values" in (root / "pytest.log").read_text()  # where it was


def test_a_mutant_is_noticed_by_a_file_that_it_keeps_from_being_collected(root: Path) -> None:
    (root / "test_of_clamping.py").write_text(
        "from clamping import clamp\n\nEXPECTED = clamp(1) + 1\n\ndef test_one():\n    pass\n"
    )
    test = "test_of_clamping.py::test_one"
    lines = run_in_worker(
        root,
        f"""
mutant = mutants["max(value, low) -> None"]
print(trial.try_mutant(mutant, [[{test!r}]], {{{test!r}: 0}}))
""",
    )
    assert lines == [str(("collection", "failure"))]


def test_a_test_that_never_ends_does_not_keep_the_others_from_being_recorded(root: Path) -> None:
    (root / "nvcore").mkdir()
    (root / "nvcore" / "__init__.py").write_text("def double(n):\n    return 2 * n\n")
    (root / "test_of_doubling.py").write_text(
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from nvcore import double\n\n"
        "def test_before():\n"
        "    double(0)\n\n"
        "def spin():\n"
        "    while True: pass\n\n"
        "def test_threads():\n"
        "    with ThreadPoolExecutor(2) as pool: pool.submit(spin)\n\n"
        "def test_after():\n"
        "    double(1)\n"
    )
    lines = run_in_worker(
        root,
        """
trial.RECORDED_S = 0.3
outcome = trial.record_file("test_of_doubling.py", Path("coverage"))
print(*outcome.failed, *outcome.seconds)
""",
    )
    before, endless, after = (
        f"test_of_doubling.py::test_{name}" for name in ("before", "threads", "after")
    )
    assert lines == [f"{endless} {before} {after}"]
    recorded = [read_coverage(root / "coverage" / name) for name in ("0", "1")]
    assert [data.contexts_by_lineno("nvcore/__init__.py")[2] for data in recorded] == [
        [before],
        [after],
    ]
