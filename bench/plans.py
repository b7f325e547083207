"""Check plans from small pilots: do their ranges hold, and the power that they promise?

    python -m bench.plans --keep ROWS.jsonl [--pilots 30] [--studies 4] [--processes 2] [--write]

Pilots of 8, 12 and 20 recordings by `bench.claims`, of unequal length and with people in groups,
plan a study of the primary measure with 80 % power. The difference to be shown is the true one,
known from 20,000 recordings. Of each plan, fresh studies of the planned size and of the range's
upper end are drawn, and those counted whose verdict claims the measure for the better system. Rows
are kept as in `bench.claims`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, Final

import numpy as np

from bench.claims import (
    SEED,
    Scenario,
    draw_dataset,
    fewer_misses,
    judge,
    run_studies,
    study_parser,
    write_block,
)
from nvcore.common.arguments.plan import PlanArguments
from nvcore.comparison.compare import compare
from nvcore.evidence.claims import values_of
from nvcore.evidence.operating_points import at_operating_point
from nvcore.evidence.planning import plan_recordings
from nvcore.metrics.shares import share_of
from nvcore.settings.primary import DEFAULT

BEGIN: Final = "<!-- plans: written by `python -m bench.plans --write` -->"
END: Final = "<!-- end of plans -->"
SHARES: Final = {
    "Y misses half as much": 1 / 2,
    "Y misses a third less": 2 / 3,
    "Y misses a fifth less": 4 / 5,
}
PLANS: Final = {
    name: Scenario(name, fewer_misses(share), has_lengths=True, has_groups=True, is_null=False)
    for name, share in SHARES.items()
}
SIZES: Final = (8, 12, 20)
N_TRUE: Final = 20_000
HEAD: Final = (
    "true difference",
    "pilot",
    "plan given",
    "recordings planned",
    "upper end",
    "other pilots in range",
    "middle plan in range",
    "claimed as planned",
    "claimed at the upper end",
)


def generator(name: str, *numbers: int) -> np.random.Generator:
    return np.random.default_rng([SEED, list(PLANS).index(name), *numbers])


@cache
def true_difference(name: str) -> float:
    """Return the size of X - Y at equal false alarms."""
    result = compare(draw_dataset(PLANS[name], N_TRUE, generator(name, 0)))
    return abs(float(np.subtract(*values_of(DEFAULT, at_operating_point(result, "equal-alarms")))))


def make_rows(task: tuple[str, int, int, int]) -> list[dict[str, Any]]:
    """Return the plan of a pilot, and the numbers of fresh studies that show what it promises."""
    name, n, pilot, n_studies = task
    result = compare(draw_dataset(PLANS[name], n, generator(name, 1, n, pilot)))
    asked = PlanArguments(measure=DEFAULT, difference=true_difference(name))
    size, *_ = plan_recordings(at_operating_point(result, "equal-alarms"), asked).sizes
    sizes = {"size": size.n_recordings, "least": size.least_recordings}
    row: dict[str, Any] = {"plan": name, "n": n, "pilot": pilot, "studies": n_studies, **sizes}
    row["most"] = size.most_recordings
    for number, end in enumerate(("size", "most")):
        is_shown = []
        for study in range(n_studies if row[end] else 0):
            rng = generator(name, 2, n, pilot, number, study)
            conclusion, _ = judge(draw_dataset(PLANS[name], row[end], rng))
            is_shown.append(any((of.key, of.winner) == (DEFAULT, "y") for of in conclusion.claims))
        row[f"shown_{end}"] = sum(is_shown)
    return [row]


def table_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the table for docs/significance.md."""
    lines = [f"| {' | '.join(HEAD)} |", "|---" * len(HEAD) + "|"]
    for name in PLANS:
        for n in SIZES:
            pilots = [row for row in rows if (row["plan"], row["n"]) == (name, n)]
            if pilots:
                lines.append(f"| {name} | {n} | {' | '.join(_cells(pilots))} |")
    given, *_, as_planned, at_the_end = _cells(rows)
    cells = ("all", "–", given, *["–"] * 4, as_planned, at_the_end)
    return "\n".join([*lines, f"| {' | '.join(cells)} |"])


def _cells(pilots: Sequence[Mapping[str, Any]]) -> list[str]:
    given = [row for row in pilots if row["size"]]
    cells = [_share(len(given), len(pilots))]
    if not given:
        return [*cells, *["–"] * (len(HEAD) - 3)]
    sizes = np.array([row["size"] for row in given])
    low, middle, high = np.quantile(sizes, [0.1, 0.5, 0.9], method="inverted_cdf")
    ranges = [(row["least"], row["most"]) for row in given]
    others = [
        least <= size <= most
        for number, (least, most) in enumerate(ranges)
        for size in np.delete(sizes, number)
    ]
    n_holding = sum(least <= middle <= most for least, most in ranges)
    n_studies = sum(row["studies"] for row in given)
    return [
        *cells,
        f"{middle:,} ({low:,} to {high:,})",
        f"{np.median([most for _, most in ranges]):,.0f}",
        f"{np.mean(others):.0%}" if others else "–",
        _share(n_holding, len(given)),
        *(_share(sum(row[f"shown_{end}"] for row in given), n_studies) for end in ("size", "most")),
    ]


def _share(n: int, of: int) -> str:
    share = share_of(n, of)
    return f"{n:,} of {of:,}, {share.share:.0%} ({100 * share.low:.0f} to {100 * share.high:.0f})"


def main() -> None:
    parser = study_parser(__doc__)
    parser.add_argument("--pilots", type=int, default=30)
    parser.add_argument("--studies", type=int, default=4, help="fresh studies of a plan's size")
    options = parser.parse_args()

    def find_tasks(done: set[tuple[str, int, int]]) -> list[tuple[str, int, int, int]]:
        return [
            (*key, options.studies)
            for pilot in range(options.pilots)
            for name in PLANS
            for n in SIZES
            if (key := (name, n, pilot)) not in done
        ]

    text = table_text(run_studies(options, ("plan", "n", "pilot"), make_rows, find_tasks))
    print(text)
    if options.write:
        write_block(BEGIN, END, text)


if __name__ == "__main__":
    main()
