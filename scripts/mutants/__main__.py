"""Make small changes to the library, and find those that its tests do not notice.

    python -m scripts.mutants map [TESTS ...]      which test runs which line: new tests, or TESTS
    python -m scripts.mutants run [--sample 240]   a fixed sample of mutants against those tests
    python -m scripts.mutants table                the share killed, by folder, to docs/quality.md

Every mutant lives in a copy of the project (.mutants/tree-N), never in the checkout. It is tested
with the tests that run its line, quick ones first, until one fails or `--seconds` of tests have
passed. A test that exceeds its time kills the mutant. Compiled functions run as plain Python.
Results are kept in .mutants/results.jsonl, so that an interrupted run can continue. `--again`
repeats survivors, `--fresh` discards all. Survivors that no test can distinguish from the original
are listed in equivalent.toml with the reason.

Neither mutmut 3 (no code outside functions, no decorated and thus no compiled functions) nor
cosmic-ray (one command for all mutants, run in the checkout) can do this.
"""

from __future__ import annotations

import argparse
import difflib
import json
import tomllib
from collections.abc import Iterable, Sequence
from concurrent.futures import as_completed
from pathlib import Path

from scripts.mutants.covering import Map, make_map
from scripts.mutants.operators import Key, Mutant, mutants_of
from scripts.mutants.trial import ROOT, make_workers, run_tests, try_mutant

STORE = ROOT / ".mutants"
RESULTS = STORE / "results.jsonl"
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
QUALITY = ROOT / "docs" / "quality.md"
MARKS = ("<!-- mutants: written by `scripts.mutants table` -->", "<!-- end of mutants -->")
FOLDERS = ("nvcore/metrics", "nvcore/evidence", "nvcore/metrics/detection", "nvcore/inputs")


def pick_sample(folders: Sequence[str], size: int, seed: int) -> dict[str, list[Mutant]]:
    """Pick equally many mutants of every folder, by hash, so that an edit changes few of them."""
    share = -(-size // len(folders))
    sample = {}
    for folder in folders:
        place = ROOT / folder
        files = sorted(place.rglob("*.py")) if place.is_dir() else [place]
        mutants = [m for file in files for m in mutants_of(ROOT, str(file.relative_to(ROOT)))]
        sample[folder] = sorted(mutants, key=lambda m: m.order(seed))[:share]
    return sample


def read_results(file: Path = RESULTS) -> dict[Key, str]:
    """Read which test killed each mutant, empty for a survivor. The last result counts."""
    lines = file.read_text("utf-8").splitlines() if file.exists() else []
    return {tuple(row["key"]): row["killed_by"] for row in map(json.loads, lines)}


def read_equivalents() -> dict[Key, str]:
    """Read the reason for each mutant that no test can distinguish from the original."""
    listed = tomllib.loads(EQUIVALENT.read_text("utf-8"))["mutant"]
    return {(m["file"], m["line"], m["mutation"], m.get("nth", 0)): m["reason"] for m in listed}


def run(sample: dict[str, list[Mutant]], seconds: float, *, again: bool) -> None:
    """Try mutants without a result (with `again` also survivors), then show the survivors."""
    results, equivalents = read_results(), read_equivalents()
    mutants = [m for of_folder in sample.values() for m in of_folder]
    to_do = [m for m in mutants if m.key not in equivalents]
    to_do = [m for m in to_do if m.key not in results or (again and not results[m.key])]
    mapped = Map(STORE, ROOT)
    print(f"{len(mutants)} mutants, {len(to_do)} to try", flush=True)
    with RESULTS.open("a", encoding="utf-8") as file, make_workers(STORE) as pool:
        jobs = {}
        for mutant in to_do:
            rounds = mapped.rounds(mutant, seconds)
            times = {test: mapped.seconds[test] for tests in rounds for test in tests}
            jobs[pool.submit(try_mutant, mutant, rounds, times)] = (mutant, len(times))
        for number, job in enumerate(as_completed(jobs), 1):
            mutant, n_tests = jobs[job]
            try:
                noticed_by, why = job.result()
            except RuntimeError as error:  # not caused by the mutant: the next run tries it again
                print(f"{number}/{len(jobs)} {describe(mutant)}\n{error}", flush=True)
                continue
            results[mutant.key] = noticed_by
            row = {"key": mutant.key, "killed_by": noticed_by, "why": why, "n_tests": n_tests}
            file.write(json.dumps(row) + "\n")
            file.flush()
            outcome = f"killed by {why} of {noticed_by}" if why else f"SURVIVED {n_tests} tests"
            where = f"{mutant.path}:{mutant.line} {mutant.mutation}"
            print(f"{number}/{len(jobs)} {where}: {outcome}", flush=True)
        check = pool.submit(
            fail_anyway, [results[m.key] for m in to_do if m.key in results], mapped.seconds
        )
        for test in check.result():
            print(f"Fails without a mutant too, so that its results do not count: {test}")
    for mutant in mutants:
        if results.get(mutant.key) == "" and mutant.key not in equivalents:
            print(describe(mutant))
    print(table(sample))


def fail_anyway(killers: Iterable[str], seconds: dict[str, float]) -> list[str]:
    """Return the tests that killed mutants but also fail on the unchanged project."""
    tests = sorted({test for test in killers if test in seconds}, key=seconds.__getitem__)
    failing = []
    while tests and (failed := run_tests(tests, seconds)[0]):
        failing.append(failed)
        if failed not in tests:
            break
        tests.remove(failed)
    return failing


def describe(mutant: Mutant) -> str:
    """Return the change as a diff, with an entry for the list of equivalents."""
    source = (ROOT / mutant.path).read_text("utf-8")
    old, new = source.splitlines(), mutant.apply(source).splitlines()
    lines = difflib.unified_diff(old, new, mutant.path, mutant.path, lineterm="")
    entry = dict(zip(("file", "line", "mutation", "nth"), mutant.key, strict=True))
    keys = [f"{key} = {json.dumps(value)}" for key, value in entry.items() if value != 0]
    return "\n".join(["", *lines, "", "[[mutant]]", *keys])


def table(sample: dict[str, list[Mutant]], earlier: Path | None = None) -> str:
    """Return a Markdown table of results by folder, here and in an earlier checkout."""
    equivalents = read_equivalents()
    results = {key: test for key, test in read_results().items() if key not in equivalents}
    before = read_results(earlier) if earlier else {}
    before = {key: test for key, test in before.items() if key not in equivalents}
    everything = [m for of_folder in sample.values() for m in of_folder]
    columns = ["folder", "mutants", "equivalent", "killed", "survived", "share killed"]
    columns += ["share killed before"] if earlier else []
    rows = ["| " + " | ".join(columns) + " |", "|---" + "|--:" * (len(columns) - 1) + "|"]
    for name, mutants in [*sample.items(), ("all", everything)]:
        tests = [results[m.key] for m in mutants if m.key in results]
        n_equivalent = sum(m.key in equivalents for m in mutants)
        n_killed = sum(map(bool, tests))
        cells: list[object] = [name, len(tests) + n_equivalent, n_equivalent, n_killed]
        cells += [len(tests) - n_killed, share_killed(tests)]
        if earlier:
            folder = "" if name == "all" else name
            there = [test for key, test in before.items() if key[0].startswith(folder)]
            cells.append(f"{share_killed(there)} of {len(there)}")
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    files = {key[0] for key in equivalents if (ROOT / key[0]).exists()}
    present = {mutant.key for path in files for mutant in mutants_of(ROOT, path)}
    for key in equivalents:
        if key not in present:
            rows.append(f"\nListed as equivalent, but is not in the code: {key}")
    return "\n".join(rows)


def share_killed(tests: Sequence[str]) -> str:
    """Describe the share of mutants that a test noticed."""
    return f"{sum(map(bool, tests)) / len(tests):.1%}" if tests else "–"


def write_table(text: str) -> None:
    """Replace the table in the documentation."""
    before, _, rest = QUALITY.read_text("utf-8").partition(MARKS[0])
    _, _, after = rest.partition(MARKS[1])
    QUALITY.write_text(f"{before}{MARKS[0]}\n\n{text}\n\n{MARKS[1]}{after}", "utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("command", choices=["map", "run", "table"])
    parser.add_argument(
        "tests", nargs="*", help="files or folders of tests to map again; all without"
    )
    parser.add_argument("--sample", type=int, default=240, help="mutants (default: 240)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folders", nargs="+", default=FOLDERS, help="or files")
    parser.add_argument("--seconds", type=float, default=60, help="of tests for each mutant")
    parser.add_argument("--earlier", type=Path, help="results.jsonl of another checkout: table")
    parser.add_argument("--again", action="store_true", help="try the survivors again")
    parser.add_argument("--fresh", action="store_true", help="try all again")
    options = parser.parse_args()
    STORE.mkdir(exist_ok=True)
    if options.command == "map":
        make_map(STORE, options.tests)
        return
    sample = pick_sample(options.folders, options.sample, options.seed)
    if options.command == "run":
        if options.fresh:
            RESULTS.unlink(missing_ok=True)
        run(sample, options.seconds, again=options.again)
    else:
        text = table(sample, options.earlier)
        print(text)
        write_table(text)


if __name__ == "__main__":
    main()
