"""Check the probability that a system misses fewer encounters against simulated studies.

    python -m bench.graded --keep ROWS.jsonl [--studies 2000] [--processes 2] [--write]

In each study the true difference is drawn from N(0, 0.7), in logits of the miss rate. Of the
statements of 70 to 90 in 100, for example, 70 to 90 % should be right. As a test, a statement of at
least 97.5 in 100 would be a claim if the severity as set points the same way. Every study is a line
of ROWS.jsonl. `--write` puts the tables, with 95 % Wilson intervals, into docs/significance.md.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bench.claims import (
    SCENARIOS,
    SEED,
    draw_dataset,
    logistic,
    place_systems,
    run_studies,
    share_text,
    study_parser,
    varying,
    write_block,
)
from bench.drives import draw_drives
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.evidence.claims import values_of
from nvcore.evidence.companions import grade_systems
from nvcore.metrics.shares import share_of

BEGIN: Final = "<!-- graded: written by `python -m bench.graded --write` -->"
END: Final = "<!-- end of graded -->"
SIZES: Final = (4, 6, 8, 12, 20)
TESTED: Final = (12, 20, 30)
BANDS: Final = ((0.5, 0.7), (0.7, 0.9), (0.9, 0.975), (0.975, 1.0))
CLAIM: Final = 0.975
EFFECT_SD: Final = 0.7
CHUNK: Final = 50


def _first(scenario: str) -> Callable[[int, float, np.random.Generator], Dataset]:
    def draw(n: int, effect: float, rng: np.random.Generator) -> Dataset:
        x, y = varying(rng, n)
        odds = np.log(y.miss / (1 - y.miss)) - effect
        return place_systems(SCENARIOS[scenario], (x, replace(y, miss=logistic(odds))), rng)

    return draw


def _second(n: int, effect: float, rng: np.random.Generator) -> Dataset:
    return draw_drives("equal", n, rng, effect=effect)


GENERATORS: Final[Mapping[str, tuple[str, Callable[..., Dataset]]]] = {
    "equal": ("first generator", _first("equal")),
    "~groups": ("the same, unequal lengths, people in groups", _first("~groups")),
    "written apart": ("second generator", _second),
}
TESTS: Final = (
    "equal",
    "skewed",
    "written apart: equal",
    "~groups",
    "~groups skewed",
    "half",
    "written apart: half",
    "~groups half",
)
"""Scenarios of `bench.claims` for the test."""


def make_rows(task: tuple[str, str, int, int, int]) -> list[dict[str, Any]]:
    """Grade studies of one kind and size."""
    kind, name, n, first, end = task
    rows = []
    for study in range(first, end):
        rng = np.random.default_rng([SEED, *f"{kind} {name}".encode(), n, study])
        effect = 0.0
        if kind == "graded":
            effect = float(rng.normal(0, EFFECT_SD))
            dataset = GENERATORS[name][1](n, effect, rng)
        else:
            dataset = draw_dataset(SCENARIOS[name], n, rng)
        result = compare(dataset)
        graded = grade_systems(result)
        severity_x, severity_y = values_of("severity_s_per_encounter", result)
        rows.append(
            {
                "kind": kind,
                "name": name,
                "n": n,
                "study": study,
                "effect": round(effect, 5),
                "y_better": None if graded.reason else round(graded.y_better, 5),
                "reason": graded.reason,
                "y_severity_better": bool(severity_y < severity_x),
            }
        )
    return rows


def tasks(n_studies: int, done: set[tuple[str, str, int, int]]) -> Iterator[Any]:
    """Yield the missing tasks, the first studies of every size before the next ones."""
    cells = [("graded", name, n) for n in SIZES for name in GENERATORS]
    cells += [("test", name, n) for n in TESTED for name in TESTS]
    for first in range(0, n_studies, CHUNK):
        for kind, name, n in cells:
            end = min(first + CHUNK, n_studies)
            if any((kind, name, n, study) not in done for study in range(first, end)):
                yield kind, name, n, first, end


def table_text(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the tables for docs/significance.md."""
    rows = list(rows)
    lines = [
        f"| statement, recordings: | {' | '.join(map(str, SIZES))} |",
        "|---|" + "---|" * len(SIZES),
    ]
    for name, (label, _) in GENERATORS.items():
        for low, high in BANDS:
            cells = [_band_text(rows, name, n, low, high) for n in SIZES]
            lines.append(f"| {label}: {100 * low:g} to {100 * high:g} | {' | '.join(cells)} |")
        cells = [_unsaid_text(rows, name, n) for n in SIZES]
        lines.append(f"| {label}: not said | {' | '.join(cells)} |")
    lines += [
        "",
        f"| as a test, recordings: | {' | '.join(map(str, TESTED))} |",
        "|---|" + "---|" * len(TESTED),
    ]
    for name in TESTS:
        scenario = SCENARIOS[name]
        cells = [_test_text(rows, name, n, is_null=scenario.is_null) for n in TESTED]
        lines.append(f"| {scenario.label} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _of(rows: Iterable[Mapping[str, Any]], kind: str, name: str, n: int) -> list[Mapping[str, Any]]:
    return [row for row in rows if (row["kind"], row["name"], row["n"]) == (kind, name, n)]


def _band_text(rows: list[Mapping[str, Any]], name: str, n: int, low: float, high: float) -> str:
    """Return the share of statements in the band that are right, an asterisk if too few or many."""
    of_band = [
        (row["y_better"] > 0.5) == (row["effect"] > 0)
        for row in _of(rows, "graded", name, n)
        if row["y_better"] is not None
        and low <= max(row["y_better"], 1 - row["y_better"]) < (high if high < 1 else 2)
    ]
    if not of_band:
        return "–"
    share = share_of(sum(of_band), len(of_band))
    is_held = share.low <= high + 0.04 and share.high >= low - 0.04
    mark = "" if is_held else " *"
    return (
        f"{share.share:.0%} ({100 * share.low:.0f} to {100 * share.high:.0f}; {len(of_band)}){mark}"
    )


def _unsaid_text(rows: list[Mapping[str, Any]], name: str, n: int) -> str:
    of_cell = _of(rows, "graded", name, n)
    unsaid = sum(row["y_better"] is None for row in of_cell)
    return f"{unsaid / len(of_cell):.0%}" if of_cell else "–"


def _test_text(rows: list[Mapping[str, Any]], name: str, n: int, *, is_null: bool) -> str:
    claims = []
    for row in _of(rows, "test", name, n):
        share = 0.5 if row["y_better"] is None else row["y_better"]
        is_y, is_x = share >= CLAIM and row["y_severity_better"], share <= 1 - CLAIM
        claims.append(is_y or (is_x and not row["y_severity_better"]) if is_null else is_y)
    if not claims:
        return "–"
    return share_text(claims)


def main() -> None:
    parser = study_parser(__doc__)
    parser.add_argument("--studies", type=int, default=2000, help="studies of each kind and size")
    options = parser.parse_args()
    key = ("kind", "name", "n", "study")
    rows = run_studies(options, key, make_rows, lambda done: tasks(options.studies, done))
    text = table_text(rows)
    print(text)
    if options.write:
        of_cell = Counter((row["kind"], row["name"], row["n"]) for row in rows).values()
        note = f"{min(of_cell):,} to {max(of_cell):,} studies of each kind and size."
        write_block(BEGIN, END, f"{note}\n\n{text}")


if __name__ == "__main__":
    main()
