"""Measure how often any of ten looks at equal systems claims a difference.

    python -m bench.looks --keep ROWS.jsonl [--studies 400] [--processes 2] [--write]

Each study draws twelve recordings and a pair of equal systems by `bench.claims`, then looks at ten
thresholds. A study errs if any look claims something: with each look judged by itself, or corrected
for those before it (`nvcore.evidence.looks`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from bench.claims import (
    SCENARIOS,
    SEED,
    draw_dataset,
    run_studies,
    share_text,
    study_parser,
    write_block,
)
from nvcore.comparison.compare import compare
from nvcore.evidence.claims import find_claims
from nvcore.evidence.looks import correct_for_looks, look_of
from nvcore.evidence.table import judge_both
from nvcore.settings.params import Params

BEGIN: Final = "<!-- looks: written by `python -m bench.looks --write` -->"
END: Final = "<!-- end of looks -->"
N: Final = 12
LOOKS: Final = 10
CHUNK: Final = 10
KINDS: Final = ("equal", "~groups")


def make_rows(task: tuple[str, int, int]) -> list[dict[str, Any]]:
    """Return for each study whether the first look, any, and any corrected one claim something."""
    name, first, end = task
    rows = []
    for study in range(first, end):
        rng = np.random.default_rng([SEED, 10, KINDS.index(name), study])
        dataset = draw_dataset(SCENARIOS[name], N, rng)
        alone, in_family = [], []
        for look in range(LOOKS):
            threshold = 0.05 * look
            result = compare(dataset, Params(threshold_x=threshold, threshold_y=threshold))
            judged = judge_both(result, has_intervals=False)
            alone.append(bool(find_claims(result, *judged).claims))
            corrected = correct_for_looks(*judged, look_of(1 + look, dataset))
            in_family.append(bool(find_claims(result, *corrected).claims))
        rows.append(
            {
                "kind": name,
                "study": study,
                "first": alone[0],
                "alone": any(alone),
                "family": any(in_family),
            }
        )
    return rows


def table_text(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the table for docs/significance.md."""
    by_kind = defaultdict(list)
    for row in rows:
        by_kind[row["kind"]].append(row)
    n = min(map(len, by_kind.values()))
    lines = [
        f"{n:,} studies of {N} recordings in each row, without a difference:",
        "",
        "| any claim | one look | ten looks, each by itself | ten looks, corrected |",
        "|---|---|---|---|",
    ]
    for kind, own in by_kind.items():
        cells = [share_text([row[name] for row in own]) for name in ("first", "alone", "family")]
        lines.append(f"| {SCENARIOS[kind].label} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    parser = study_parser(__doc__)
    parser.add_argument("--studies", type=int, default=400)
    options = parser.parse_args()

    def find_tasks(done: set[tuple[str, int]]) -> list[tuple[str, int, int]]:
        return [
            (name, first, min(first + CHUNK, options.studies))
            for first in range(0, options.studies, CHUNK)
            for name in KINDS
            if (name, first) not in done
        ]

    text = table_text(run_studies(options, ("kind", "study"), make_rows, find_tasks))
    print(text)
    if options.write:
        write_block(BEGIN, END, text)


if __name__ == "__main__":
    main()
