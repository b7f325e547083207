"""How often does the verdict claim a difference that is none, and one that is?

    python -m bench.claims [--pairs 400] [--seed 2026] [--processes 2] [--write]

Draws pairs of systems, compares each through the whole library (dataset, comparison, evidence,
comparison at equal false alarms, strict pairing, verdict) and counts the verdicts that claim
anything. `--write` puts the table into docs/significance.md. 400 pairs take under an hour on two
free cores.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.companions import find_companions
from nvcore.evidence.table import evidence_table
from nvcore.params import Params
from nvcore.report.verdict import Verdict, verdict

ROOT: Final = Path(__file__).resolve().parent.parent
PAGE: Final = ROOT / "docs" / "significance.md"
BEGIN: Final = "<!-- claims: written by `python -m bench.claims --write` -->"
END: Final = "<!-- end of claims -->"

SIZES: Final = (1, 2, 4, 6, 8, 16, 50)
POWER_SIZES: Final = (8, 16, 50)
BOUND_99: Final = 32
"""Of 400 verdicts that claim in 5 % of the cases, more than so many come in one of 200 runs."""

N_FRAMES: Final = 30
N_TRACKS: Final = 6
TRACK_FRAMES: Final = 10
WIDTH: Final = 640.0


@dataclass(frozen=True)
class Detector:
    """What a simulated system is like.

    Attributes
    ----------
    miss
        Mean share of pedestrians' frames missed, by recording, shape (n_recordings,).
    clumped
        Whether a pedestrian is missed throughout or not at all.
    alarms
        Mean number of false alarms per frame, by recording, shape (n_recordings,).
    threshold
        Scores below it are left out of the file.
    """

    miss: np.ndarray
    alarms: np.ndarray
    clumped: bool = False
    threshold: float = 0.0


@dataclass(frozen=True)
class Scenario:
    """Pairs of systems of one kind.

    Attributes
    ----------
    label
        How they differ, or do not.
    draw
        X and Y for so many recordings.
    sizes
        Numbers of recordings.
    has_scores
        Whether detections have scores.
    is_same
        Whether Y's detections are X's, cut at its own threshold.
    is_null
        Whether there is no difference.
    """

    label: str
    draw: Callable[[np.random.Generator, int], tuple[Detector, Detector]]
    sizes: Sequence[int] = SIZES
    has_scores: bool = False
    is_same: bool = False
    is_null: bool = True


def logistic(values: np.ndarray) -> np.ndarray:
    shares: np.ndarray = 1 / (1 + np.exp(-values))
    return shares


def varying(rng: np.random.Generator, n: int) -> tuple[Detector, Detector]:
    """Each system is good in some recordings and bad in others, equally often."""
    hard = rng.normal(-1.2, 0.6, n)
    x, y = (
        Detector(logistic(hard + rng.normal(0, 0.8, n)), rng.gamma(2, 0.1, n)) for _ in range(2)
    )
    return x, y


def clustered(rng: np.random.Generator, n: int) -> tuple[Detector, Detector]:
    """The same, and a pedestrian is missed throughout or not at all."""
    x, y = varying(rng, n)
    return replace(x, clumped=True), replace(y, clumped=True)


def skewed(rng: np.random.Generator, n: int) -> tuple[Detector, Detector]:
    """X misses a little everywhere, Y little in most recordings and much in few: equal means."""
    order = rng.permutation(2)
    excess = rng.lognormal(0, 1, n) / np.exp(0.5)
    misses = (np.full(n, 0.2), np.minimum(0.2 * excess, 0.95))
    pair = [Detector(miss, np.full(n, 0.2)) for miss in misses]
    return pair[order[0]], pair[order[1]]


def two_thresholds(rng: np.random.Generator, n: int) -> tuple[Detector, Detector]:
    """Two systems that are equally good, at thresholds of their own."""
    x, y = varying(rng, n)
    low = rng.uniform(0.0, 0.3)
    cuts = rng.permutation([low, low + rng.uniform(0.15, 0.4)])
    return replace(x, threshold=cuts[0]), replace(y, threshold=cuts[1])


def better_y(rng: np.random.Generator, n: int) -> tuple[Detector, Detector]:
    """Y misses about half as much as X."""
    x, y = varying(rng, n)
    return x, replace(y, miss=0.5 * y.miss)


SCENARIOS: Final = (
    Scenario("equal, each better in some recordings", varying, has_scores=True),
    Scenario("the same, encounters missed as a whole, no scores", clustered),
    Scenario("equal means, rare disasters against frequent trifles", skewed),
    Scenario("one detector at two thresholds", two_thresholds, has_scores=True, is_same=True),
    Scenario("the same, without scores", two_thresholds, is_same=True),
    Scenario("two equal detectors at two thresholds", two_thresholds, has_scores=True),
    Scenario("Y misses half as much", better_y, POWER_SIZES, has_scores=True, is_null=False),
)


def draw_dataset(scenario: Scenario, n: int, rng: np.random.Generator) -> Dataset:
    """Recordings of 30 frames with six pedestrians in ten frames each, and a pair of systems."""
    detectors = scenario.draw(rng, n)
    track = np.tile(np.repeat(np.arange(N_TRACKS), TRACK_FRAMES), n)
    recording = np.repeat(np.arange(n), N_TRACKS * TRACK_FRAMES)
    start = rng.integers(0, N_FRAMES - TRACK_FRAMES + 1, n * N_TRACKS)
    frame = np.repeat(start, TRACK_FRAMES) + np.tile(np.arange(TRACK_FRAMES), n * N_TRACKS)
    centre = np.repeat(rng.uniform(40, WIDTH - 40, n * N_TRACKS), TRACK_FRAMES)
    truth = _boxes(0, recording * N_FRAMES + frame, centre, np.nan).assign(
        track=track, h=np.repeat(rng.uniform(60, 160, n * N_TRACKS), TRACK_FRAMES)
    )
    tables, shared = [truth], None
    for source, detector in enumerate(detectors, start=1):
        if shared is None or not scenario.is_same:
            shared = _detections(detector, truth, recording, n, rng)
        passing = shared[shared["score"] >= detector.threshold].assign(source=source)
        tables.append(passing if scenario.has_scores else passing.assign(score=np.nan))
    boxes = pd.concat(tables, ignore_index=True)
    boxes["track"] = boxes["track"].fillna(-1).astype(np.int64)
    recordings = pd.DataFrame(
        {"name": [f"r{i:02}" for i in range(n)], "width": WIDTH, "height": 480.0, "fps": 10.0}
    )
    frames = [np.arange(N_FRAMES)] * n
    return dataset_from_tables(recordings, frames, boxes, ["x", "y"], fingerprint="")


def _boxes(
    source: int, frame_index: np.ndarray, centre: np.ndarray, score: np.ndarray | float
) -> pd.DataFrame:
    columns = {"source": source, "frame_index": frame_index, "x": centre - 20, "y": 200.0}
    return pd.DataFrame({**columns, "w": 40.0, "h": 100.0, "score": score})


def _detections(
    detector: Detector,
    truth: pd.DataFrame,
    recording: np.ndarray,
    n: int,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Of the pedestrians that are not missed, with noise, and false alarms with lower scores."""
    n_encounters = n * N_TRACKS
    miss = detector.miss[recording]
    if detector.clumped:
        drawn = np.repeat(rng.random(n_encounters), TRACK_FRAMES)
    else:  # half of it is the pedestrian's, half the frame's
        drawn = rng.random(len(truth))
        of_track = np.repeat(rng.normal(0, 1, n_encounters), TRACK_FRAMES)
        miss = logistic(np.log(miss / (1 - miss)) + of_track)
    hits = truth[drawn >= miss]
    hits = hits.assign(
        x=hits["x"] + rng.normal(0, 2, len(hits)), score=rng.beta(4, 2, len(hits)), track=-1
    )
    n_alarms = rng.poisson(np.repeat(detector.alarms, N_FRAMES))
    at = np.repeat(np.arange(n * N_FRAMES), n_alarms)
    centre = rng.uniform(20, WIDTH - 20, len(at))
    alarms = _boxes(1, at, centre, rng.beta(2, 3, len(at))).assign(track=-1)
    return pd.concat([hits, alarms], ignore_index=True)


def judge(dataset: Dataset) -> Verdict:
    """The verdict, as page, command line and report give it."""
    result = compare(dataset, Params(), x="x", y="y")
    evidence = evidence_table(result, has_intervals=False)
    return verdict(result, evidence=evidence, companions=find_companions(result, evidence))


@dataclass(frozen=True)
class Row:
    """How many of the verdicts of a scenario claim something."""

    scenario: int
    n_recordings: int
    n_pairs: int
    n_claiming: int
    n_wrong: int
    n_encounters: int
    seconds: float


def simulate(task: tuple[int, int, int], seed: int) -> Row:
    """One row: scenario, recordings, pairs."""
    number, n, n_pairs = task
    scenario = SCENARIOS[number]
    begin, claims = time.perf_counter(), []
    for pair in range(n_pairs):
        rng = np.random.default_rng([seed, number, n, pair])
        claims.append(judge(draw_dataset(scenario, n, rng)).claims)
    return Row(
        *(number, n, n_pairs),
        n_claiming=sum(bool(of_pair) for of_pair in claims),
        n_wrong=sum(any(claim.winner == "x" for claim in of_pair) for of_pair in claims),
        n_encounters=sum(
            any(claim.key == "encounters_detected_by_unit" for claim in of_pair)
            for of_pair in claims
        ),
        seconds=time.perf_counter() - begin,
    )


def table_text(rows: Iterable[Row]) -> str:
    """The tables for docs/significance.md."""
    rows = sorted(rows, key=lambda row: (row.scenario, row.n_recordings))
    lines = []
    for is_null in (True, False):
        of_kind = [row for row in rows if SCENARIOS[row.scenario].is_null == is_null]
        if not of_kind:
            continue
        sizes = sorted({row.n_recordings for row in of_kind})
        head = "no difference" if is_null else "a difference"
        lines += [
            f"| {head}, recordings: | {' | '.join(map(str, sizes))} |",
            "|---|" + "---|" * len(sizes),
        ]
        for number in sorted({row.scenario for row in of_kind}):
            shares = {
                row.n_recordings: f"{row.n_claiming / row.n_pairs:.1%}"
                for row in of_kind
                if row.scenario == number
            }
            cells = [shares.get(size, "–") for size in sizes]
            lines.append(f"| {SCENARIOS[number].label} | {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines).strip()


def read_rows(path: Path | None) -> list[Row]:
    """Rows of an earlier run."""
    if path is None or not path.exists():
        return []
    return [Row(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def parse_options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pairs", type=int, default=400)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument("--only", type=int, nargs="+", help="numbers of scenarios")
    parser.add_argument("--sizes", type=int, nargs="+", help="numbers of recordings")
    parser.add_argument("--keep", type=Path, help="rows are added here, and not made again")
    parser.add_argument("--write", action="store_true")
    return parser.parse_args()


def tasks_of(options: argparse.Namespace, rows: Iterable[Row]) -> list[tuple[int, int, int]]:
    """Scenario, number of recordings and of pairs for each row to be made, the quick ones first."""
    done = {(row.scenario, row.n_recordings, row.n_pairs) for row in rows}
    tasks = [
        (number, n, options.pairs)
        for number, scenario in enumerate(SCENARIOS)
        for n in scenario.sizes
        if (not options.only or number in options.only)
        and (not options.sizes or n in options.sizes)
    ]
    return [task for task in sorted(tasks, key=lambda task: task[1]) if task not in done]


def simulate_all(tasks: Iterable[tuple[int, int, int]], options: argparse.Namespace) -> list[Row]:
    """The rows of all tasks, each kept and told as soon as it is there."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # of the new processes: they share the processors
    rows = []
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for future in as_completed([pool.submit(simulate, task, options.seed) for task in tasks]):
            row = future.result()
            rows.append(row)
            if options.keep:
                with options.keep.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(row)) + "\n")
            label = SCENARIOS[row.scenario].label
            print(
                f"{label}, {row.n_recordings} recordings: {row.n_claiming} of {row.n_pairs} claim "
                f"({row.n_encounters} of encounters, {row.n_wrong} for X), {row.seconds:.0f} s",
                file=sys.stderr,
                flush=True,
            )
    return rows


def write_page(text: str, n_pairs: int) -> None:
    """The table in its place on the page."""
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    _, after = rest.split(END)
    note = f"{n_pairs} pairs in each cell: share of verdicts that claim anything."
    PAGE.write_text(f"{before}{BEGIN}\n{note}\n\n{text}\n{END}{after}", encoding="utf-8")


def main() -> None:
    options = parse_options()
    begin = time.perf_counter()
    rows = read_rows(options.keep)
    rows += simulate_all(tasks_of(options, rows), options)
    text = table_text(rows)
    print(text)
    print(f"{(time.perf_counter() - begin) / 60:.0f} minutes", file=sys.stderr)
    if options.write:
        write_page(text, options.pairs)
    null = [row for row in rows if SCENARIOS[row.scenario].is_null]
    if options.pairs == 400 and any(row.n_claiming > BOUND_99 for row in null):
        sys.exit(f"more than {BOUND_99} of 400 verdicts claim a difference that is none")


if __name__ == "__main__":
    main()
