"""Check the power of planned studies: how many fresh studies of that size find the difference.

    python -m bench.plans --keep ROWS.jsonl [--studies 1000] [--processes 2] [--write]

The module plans a study of the primary measure with 80 % power, from a pilot of 1,000 recordings by
`bench.claims` and the true difference, known from 20,000 more. Then it draws fresh studies of that
size, and counts those whose verdict claims the measure for the better system. The same is done for
the sample: a plan for its observed difference, and studies that draw its ten recordings with
replacement, as the plan assumes. Rows are kept as in `bench.claims`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, Final

import numpy as np

from bench.claims import (
    ROOT,
    SCENARIOS,
    SEED,
    Scenario,
    Systems,
    draw_dataset,
    fewer_misses,
    judge,
    run_studies,
    study_parser,
    write_block,
)
from nvcore.common.arguments.plan import PlanArguments
from nvcore.comparison.compare import compare
from nvcore.comparison.measures.table import measure_of
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.claims import values_of, winner_of
from nvcore.evidence.operating_points import at_operating_point
from nvcore.evidence.planning import plan_recordings
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.metrics.shares import share_of
from nvcore.settings.primary import DEFAULT

BEGIN: Final = "<!-- plans: written by `python -m bench.plans --write` -->"
END: Final = "<!-- end of plans -->"
SAMPLE: Final = "sample"
PLANS: Final = {
    "half": "Y misses half as much",
    "third": "Y misses a third less",
    "two thresholds": "Y misses half as much, X and Y at thresholds of their own",
    SAMPLE: "the sample's own recordings",
}
N_PILOT: Final = 1_000
N_TRUE: Final = 20_000
CHUNK: Final = 10


def two_thresholds(rng: np.random.Generator, n: int) -> Systems:
    """Draw Y with half as many misses as X, each with the same threshold in all studies."""
    x, y = fewer_misses(1 / 2)(rng, n)
    return replace(x, threshold=0.1), replace(y, threshold=0.35)


SYSTEMS: Final = {**SCENARIOS, "two thresholds": Scenario("", two_thresholds)}


@cache
def sample() -> Dataset:
    return load(read_session(ROOT / "sample_data" / "session.toml"))


@cache
def planned(name: str) -> tuple[int, str]:
    """Return the number of recordings that a plan asks for, and the better system."""

    def drawn(n: int, number: int) -> Any:
        rng = np.random.default_rng([SEED, sorted(PLANS).index(name), number])
        dataset = sample() if name == SAMPLE else draw_dataset(SYSTEMS[name], n, rng)
        return at_operating_point(compare(dataset), "equal-alarms")

    difference = float(np.subtract(*values_of(DEFAULT, drawn(N_TRUE, 0))))
    size = None if name == SAMPLE else abs(difference)
    asked = PlanArguments(measure=DEFAULT, difference=size)
    n = plan_recordings(drawn(N_PILOT, 1), asked).sizes[0].n_recordings
    assert n is not None
    return n, winner_of(difference, measure_of(DEFAULT).better)


def draw_study(name: str, n: int, rng: np.random.Generator) -> Dataset:
    """Draw a fresh study of n recordings."""
    if name != SAMPLE:
        return draw_dataset(SYSTEMS[name], n, rng)
    return draw_recordings(sample(), rng.integers(0, len(sample().recordings), n))


def draw_recordings(dataset: Dataset, drawn: np.ndarray) -> Dataset:
    """Return the dataset of these recordings (rows, with repetition), each its own unit."""
    frames, boxes = dataset.frame_columns, dataset.boxes
    place = boxes["frame_index"].to_numpy()
    order = np.argsort(frames.recording[place], kind="stable")
    first = np.searchsorted(frames.recording[place][order], np.arange(len(dataset.recordings) + 1))
    rows = np.concatenate([order[first[row] : first[row + 1]] for row in drawn])
    start = np.concatenate([[0], np.cumsum(np.diff(frames.first)[drawn])[:-1]])
    moved = np.repeat(start - frames.first[drawn], np.diff(first)[drawn])
    names = [f"study {number:05}" for number in range(len(drawn))]
    return dataset_from_tables(
        dataset.recordings.iloc[drawn].assign(name=names, unit=names),
        [frames.frame[frames.rows_of(row)] for row in drawn],
        boxes.iloc[rows].assign(frame_index=place[rows] + moved),
        dataset.systems,
        fingerprint="",
    ).with_settings(dataset.settings)


def make_rows(task: tuple[str, int, int]) -> list[dict[str, Any]]:
    """Return the outcomes of a range of studies."""
    name, first, end = task
    n, better = planned(name)
    rows = []
    for study in range(first, end):
        rng = np.random.default_rng([SEED, sorted(PLANS).index(name), 2, study])
        conclusion, _ = judge(draw_study(name, n, rng))
        is_shown = any((of.key, of.winner) == (DEFAULT, better) for of in conclusion.claims)
        rows.append({"plan": name, "n": n, "study": study, "is_shown": is_shown})
    return rows


def table_text(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the table for docs/significance.md."""
    shown = defaultdict(list)
    for row in rows:
        shown[row["plan"], row["n"]].append(row["is_shown"])
    lines = ["| planted difference | recordings | studies | claim it |", "|---|---|---|---|"]
    for (name, n), of_plan in shown.items():
        share = share_of(sum(of_plan), len(of_plan))
        ends = f"{100 * share.low:.1f} to {100 * share.high:.1f}"
        lines.append(f"| {PLANS[name]} | {n:,} | {len(of_plan):,} | {share.share:.1%} ({ends}) |")
    return "\n".join(lines)


def main() -> None:
    parser = study_parser(__doc__)
    parser.add_argument("--studies", type=int, default=1000)
    parser.add_argument("--plans", nargs="*", choices=PLANS, default=list(PLANS))
    options = parser.parse_args()

    def find_tasks(done: set[tuple[str, int]]) -> list[tuple[str, int, int]]:
        return [
            (name, first, min(first + CHUNK, options.studies))
            for name in options.plans
            for first in range(0, options.studies, CHUNK)
            if (name, first) not in done
        ]

    text = table_text(run_studies(options, ("plan", "study"), make_rows, find_tasks))
    print(text)
    if options.write:
        write_block(BEGIN, END, text)


if __name__ == "__main__":
    main()
