"""Measure how often the verdict claims a difference where there is none, and where there is one.

    python -m bench.claims --keep ROWS.jsonl [--null 1000] [--power 300] [--processes 2] [--write]

The module draws pairs of systems, compares each through the whole library (dataset, comparison,
evidence, comparison at equal false alarms, strict pairing, verdict) and records the claims of the
verdict. Every verdict is a line of ROWS.jsonl. Existing lines are not computed again. `--write`
puts the table of shares, with 95 % Wilson intervals, into docs/significance.md. The same seeds draw
the same pairs, so that two versions of the rule can be compared verdict by verdict.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from bench.drives import Kind, draw_drives
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.evidence.table import judge_both
from nvcore.metrics.shares import share_of
from nvcore.report.verdict import Verdict, verdict

ROOT: Final = Path(__file__).resolve().parent.parent
PAGE: Final = ROOT / "docs" / "significance.md"
BEGIN: Final = "<!-- claims: written by `python -m bench.claims --write` -->"
END: Final = "<!-- end of claims -->"

SIZES: Final = (6, 8, 12, 20, 30)
SEED: Final = 2026
CHUNK: Final = 20
"""Number of verdicts per task. At most this many are lost when a run is stopped."""

N_FRAMES: Final = 30
TRACKS_PER_FRAME: Final = 0.2
TRACK_FRAMES: Final = 10
WIDTH: Final = 640.0

SKEWED_MEAN: Final = 0.1753
"""Miss rate at which a uniform system misses as much on average as a system with 0.2 times a
lognormal variable (sigma 1, mean 1), at most 0.95, after both vary by pedestrian (`_detections`).
Computed by quadrature.
"""

Systems = tuple["Detector", "Detector"]


@dataclass(frozen=True)
class Detector:
    """Properties of a simulated system.

    Attributes
    ----------
    miss
        Mean share of pedestrians' frames missed, by recording, shape (n_recordings,).
    clumped
        Whether a pedestrian is missed either throughout or not at all.
    alarms
        Mean number of false alarms per frame, by recording, shape (n_recordings,).
    threshold
        Score below which detections are omitted from the file.
    """

    miss: np.ndarray
    alarms: np.ndarray
    clumped: bool = False
    threshold: float = 0.0


@dataclass(frozen=True)
class Scenario:
    """Kind of simulated pairs of systems.

    Attributes
    ----------
    label
        Description of the difference between the systems.
    draw
        Draws X and Y for a number of recordings. Alternatively the kind of drives of the second
        generator.
    has_scores
        Whether detections have scores.
    is_same
        Whether Y has X's detections, cut at its own threshold.
    has_lengths
        Whether recordings differ in length, up to tenfold.
    has_groups
        Whether pedestrians walk in groups of one to four, who are found or missed together.
    is_null
        Whether the systems are equally good.
    """

    label: str
    draw: Callable[[np.random.Generator, int], Systems] | Kind
    has_scores: bool = True
    is_same: bool = False
    has_lengths: bool = False
    has_groups: bool = False
    is_null: bool = True


def logistic(values: np.ndarray) -> np.ndarray:
    shares: np.ndarray = 1 / (1 + np.exp(-values))
    return shares


def varying(rng: np.random.Generator, n: int) -> Systems:
    """Draw systems that are good in some recordings and bad in others, equally often."""
    hard = rng.normal(-1.2, 0.6, n)
    x, y = (
        Detector(logistic(hard + rng.normal(0, 0.8, n)), rng.gamma(2, 0.1, n)) for _ in range(2)
    )
    return x, y


def clustered(rng: np.random.Generator, n: int) -> Systems:
    """Draw systems as `varying`, with each pedestrian missed either throughout or not at all."""
    x, y = varying(rng, n)
    return replace(x, clumped=True), replace(y, clumped=True)


def heavy_misses(rng: np.random.Generator, n: int) -> Systems:
    """Draw systems as `varying`, with an occasional recording much harder for one of them."""
    x, y = (
        replace(of, miss=logistic(rng.normal(-1.6, 0.4, n) + rng.standard_t(2, n)))
        for of in varying(rng, n)
    )
    return x, y


def heavy_alarms(rng: np.random.Generator, n: int) -> Systems:
    """Draw systems as `varying`, with most of the false alarms in a few recordings."""
    x, y = (
        replace(of, alarms=np.minimum(rng.lognormal(-2.5, 1.3, n), 5.0)) for of in varying(rng, n)
    )
    return x, y


def skewed(rng: np.random.Generator, n: int) -> Systems:
    """Draw X with few misses everywhere, and Y with many misses in few recordings: equal means."""
    order = rng.permutation(2)
    excess = rng.lognormal(0, 1, n) / np.exp(0.5)
    misses = (np.full(n, SKEWED_MEAN), np.minimum(0.2 * excess, 0.95))
    pair = [Detector(miss, np.full(n, 0.2)) for miss in misses]
    return pair[order[0]], pair[order[1]]


def two_thresholds(rng: np.random.Generator, n: int) -> Systems:
    """Draw two systems that are equally good, with different thresholds."""
    x, y = varying(rng, n)
    low = rng.uniform(0.0, 0.3)
    cuts = rng.permutation([low, low + rng.uniform(0.15, 0.4)])
    return replace(x, threshold=cuts[0]), replace(y, threshold=cuts[1])


def few_alarms(rng: np.random.Generator, n: int) -> Systems:
    """Draw systems as `two_thresholds`, with a tenth of the false alarms."""
    x, y = two_thresholds(rng, n)
    return replace(x, alarms=0.1 * x.alarms), replace(y, alarms=0.1 * y.alarms)


def fewer_misses(
    share: float, of: Callable[[np.random.Generator, int], Systems] = varying
) -> Callable[[np.random.Generator, int], Systems]:
    """Return a generator in which Y misses this share of what it would miss if as good as X."""

    def draw(rng: np.random.Generator, n: int) -> Systems:
        x, y = of(rng, n)
        return x, replace(y, miss=share * y.miss)

    return draw


SCENARIOS: Final[Mapping[str, Scenario]] = {
    "equal": Scenario("equal, each better in some recordings", varying),
    "heavy misses": Scenario("the same, misses heavy-tailed", heavy_misses),
    "heavy alarms": Scenario("the same, false alarms heavy-tailed", heavy_alarms),
    "lengths": Scenario("the same, recordings of unequal length", varying, has_lengths=True),
    "~groups": Scenario(
        "the same, unequal lengths, people in groups", varying, has_lengths=True, has_groups=True
    ),
    "clustered": Scenario(
        "the same, encounters missed as a whole, no scores", clustered, has_scores=False
    ),
    "points": Scenario("two equal detectors at two thresholds", two_thresholds),
    "one detector": Scenario("one detector at two thresholds", two_thresholds, is_same=True),
    "skewed": Scenario("equal means, rare disasters against frequent trifles", skewed),
    "~groups skewed": Scenario(
        "rare disasters, unequal lengths, people in groups",
        skewed,
        has_lengths=True,
        has_groups=True,
    ),
    "half": Scenario("Y misses half as much", fewer_misses(1 / 2), is_null=False),
    "third": Scenario("Y misses a third less", fewer_misses(2 / 3), is_null=False),
    "fifth": Scenario("Y misses a fifth less", fewer_misses(4 / 5), is_null=False),
    "half points": Scenario(
        "Y misses half as much, at two thresholds",
        fewer_misses(1 / 2, two_thresholds),
        is_null=False,
    ),
    "~groups half": Scenario(
        "Y misses half as much, unequal lengths, people in groups",
        fewer_misses(1 / 2),
        has_lengths=True,
        has_groups=True,
        is_null=False,
    ),
    # new names must sort last, because seeds are numbered by sorted name
    "thresholds": Scenario("two equal detectors at two thresholds, few false alarms", few_alarms),
    "written apart: equal": Scenario("second generator, equal systems", "equal", has_lengths=True),
    "written apart: half": Scenario(
        "second generator, Y misses half as much", "half", has_lengths=True, is_null=False
    ),
    "written apart: thresholds": Scenario(
        "second generator, two thresholds", "thresholds", has_lengths=True
    ),
}


def draw_dataset(scenario: Scenario, n: int, rng: np.random.Generator) -> Dataset:
    """Draw recordings of 30 frames with six pedestrians in ten frames each, and a pair of systems.

    Scenarios of the second generator use `bench.drives` instead.
    """
    if isinstance(scenario.draw, str):
        return draw_drives(scenario.draw, n, rng)
    return place_systems(scenario, scenario.draw(rng, n), rng)


def place_systems(scenario: Scenario, detectors: Systems, rng: np.random.Generator) -> Dataset:
    """Draw recordings with pedestrians and what these two systems make of them."""
    n = len(detectors[0].miss)
    lengths = np.full(n, N_FRAMES)
    if scenario.has_lengths:
        lengths = np.round(N_FRAMES * np.geomspace(0.4, 4, n)).astype(int)[rng.permutation(n)]
    first = np.cumsum(lengths) - lengths
    n_tracks = np.round(TRACKS_PER_FRAME * lengths).astype(int)
    recording_of_track = np.repeat(np.arange(n), n_tracks)
    number = np.arange(len(recording_of_track)) - np.repeat(
        np.cumsum(n_tracks) - n_tracks, n_tracks
    )
    latest = lengths[recording_of_track] - TRACK_FRAMES + 1
    begin = rng.integers(0, latest)
    group = _groups(recording_of_track, rng) if scenario.has_groups else np.arange(len(begin))
    start = first[recording_of_track] + begin[group]
    frame_index = np.repeat(start, TRACK_FRAMES) + np.tile(np.arange(TRACK_FRAMES), len(start))
    recording = np.repeat(recording_of_track, TRACK_FRAMES)
    centre = np.repeat(rng.uniform(40, WIDTH - 40, len(start)), TRACK_FRAMES)
    truth = _boxes(0, frame_index, centre, np.nan).assign(
        track=np.repeat(number, TRACK_FRAMES),
        h=np.repeat(rng.uniform(60, 160, len(start)), TRACK_FRAMES),
    )
    tables, shared = [truth], None
    for source, detector in enumerate(detectors, start=1):
        if shared is None or not scenario.is_same:
            shared = _detections(detector, truth, recording, lengths, group, rng)
        passing = shared[shared["score"] >= detector.threshold].assign(source=source)
        tables.append(passing if scenario.has_scores else passing.assign(score=np.nan))
    boxes = pd.concat(tables, ignore_index=True)
    boxes["track"] = boxes["track"].fillna(-1).astype(np.int64)
    recordings = pd.DataFrame(
        {"name": [f"r{i:02}" for i in range(n)], "width": WIDTH, "height": 480.0, "fps": 10.0}
    )
    frames = [np.arange(length) for length in lengths]
    return dataset_from_tables(recordings, frames, boxes, ["x", "y"], fingerprint="")


def _groups(recording_of_track: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the first pedestrian of each one's group, of one to four in the same recording."""
    number = np.arange(len(recording_of_track))
    begins = rng.random(len(number)) < 0.4
    begins |= np.diff(recording_of_track, prepend=-1) > 0
    first = np.maximum.accumulate(np.where(begins, number, 0))
    of_four: np.ndarray = number - (number - first) % 4
    return of_four


def _boxes(
    source: int, frame_index: np.ndarray, centre: np.ndarray, score: np.ndarray | float
) -> pd.DataFrame:
    columns = {"source": source, "frame_index": frame_index, "x": centre - 20, "y": 200.0}
    return pd.DataFrame({**columns, "w": 40.0, "h": 100.0, "score": score})


def _detections(
    detector: Detector,
    truth: pd.DataFrame,
    recording: np.ndarray,
    lengths: np.ndarray,
    group: np.ndarray,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """Return noisy detections of pedestrians not missed, and false alarms of lower score."""
    n_encounters = len(truth) // TRACK_FRAMES
    miss = detector.miss[recording]
    if detector.clumped:
        drawn = np.repeat(rng.random(n_encounters)[group], TRACK_FRAMES)
    else:  # half of the variation is the pedestrian's, half the frame's
        drawn = rng.random(len(truth))
        of_track = np.repeat(rng.normal(0, 1, n_encounters)[group], TRACK_FRAMES)
        miss = logistic(np.log(miss / (1 - miss)) + of_track)
    hits = truth[drawn >= miss]
    hits = hits.assign(
        x=hits["x"] + rng.normal(0, 2, len(hits)), score=rng.beta(4, 2, len(hits)), track=-1
    )
    n_alarms = rng.poisson(np.repeat(detector.alarms, lengths))
    at = np.repeat(np.arange(lengths.sum()), n_alarms)
    centre = rng.uniform(20, WIDTH - 20, len(at))
    alarms = _boxes(1, at, centre, rng.beta(2, 3, len(at))).assign(track=-1)
    return pd.concat([hits, alarms], ignore_index=True)


def judge(dataset: Dataset) -> tuple[Verdict, pd.DataFrame]:
    """Return the verdict, as in page, command line and report, and the evidence."""
    result = compare(dataset)
    evidence, companions = judge_both(result, has_intervals=False)
    return verdict(result, evidence=evidence, companions=companions), evidence


def make_rows(task: tuple[str, int, int, int]) -> list[dict[str, Any]]:
    """Compute the verdicts of a scenario for a range of pairs."""
    name, n, first, end = task
    rows = []
    for pair in range(first, end):
        rng = np.random.default_rng([SEED, sorted(SCENARIOS).index(name), n, pair])
        conclusion, evidence = judge(draw_dataset(SCENARIOS[name], n, rng))
        rows.append(
            {
                "scenario": name,
                "n": n,
                "pair": pair,
                "claims": {claim.key: claim.winner for claim in conclusion.claims},
                "p": dict(zip(evidence["figure"], map(_defined, evidence["p"]), strict=True)),
            }
        )
    return rows


def _defined(p: float) -> float | None:
    return None if np.isnan(p) else round(float(p), 5)


def tasks(n_null: int, n_power: int, done: set[tuple[str, int, int]]) -> Iterator[Any]:
    """Yield the missing tasks, with the first pairs of all rows before the next ones."""
    for first in range(0, max(n_null, n_power), CHUNK):
        for n in SIZES:
            for name, scenario in SCENARIOS.items():
                end = min(first + CHUNK, n_null if scenario.is_null else n_power)
                if any((name, n, pair) not in done for pair in range(first, end)):
                    yield name, n, first, end


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Read the verdicts of earlier runs."""
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def table_text(rows: Iterable[Mapping[str, Any]]) -> str:
    """Return the tables for docs/significance.md."""
    of_cell = defaultdict(list)
    for row in rows:
        of_cell[row["scenario"], row["n"]].append(row["claims"])
    lines = []
    for is_null in (True, False):
        head = "no difference" if is_null else "a difference"
        lines += [
            f"| {head}, recordings: | {' | '.join(map(str, SIZES))} |",
            "|---|" + "---|" * len(SIZES),
        ]
        for name, scenario in SCENARIOS.items():
            if scenario.is_null == is_null:
                cells = [_share_text(of_cell[name, n], is_null=is_null) for n in SIZES]
                lines.append(f"| {scenario.label} | {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines).strip()


def _n_text(rows: Iterable[Mapping[str, Any]], *, is_null: bool) -> str:
    """Return the number of verdicts per cell, as a number or range."""
    of_cell = Counter(
        (row["scenario"], row["n"]) for row in rows if SCENARIOS[row["scenario"]].is_null == is_null
    )
    least, most = min(of_cell.values()), max(of_cell.values())
    return f"{least:,}" if least == most else f"{least:,} to {most:,}"


def _share_text(claims: list[dict[str, str]], *, is_null: bool) -> str:
    """Return the share of verdicts that claim any difference, or one for Y, with its interval."""
    if not claims:
        return "–"
    is_claimed = [bool(of) if is_null else "y" in of.values() for of in claims]
    return share_text(is_claimed)


def share_text(outcomes: Sequence[bool]) -> str:
    """Return the share of outcomes that are true, with its interval."""
    share = share_of(sum(outcomes), len(outcomes))
    return f"{share.share:.1%} ({100 * share.low:.1f} to {100 * share.high:.1f})"


def study_parser(doc: str | None) -> argparse.ArgumentParser:
    """Return a parser with the options of all simulated studies."""
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--keep", type=Path, required=True)
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument("--write", action="store_true")
    return parser


def run_studies(
    options: argparse.Namespace,
    key: tuple[str, ...],
    make: Callable[[Any], list[dict[str, Any]]],
    find_tasks: Callable[[set[Any]], Iterable[Any]],
) -> list[dict[str, Any]]:
    """Make the rows of the missing tasks in processes, keep each in the file, return all rows.

    Parameters
    ----------
    key
        Fields by which a row is known. Rows that are there already are not kept twice.
    find_tasks
        Function that returns the missing tasks, given the keys of the rows that are there.
    """

    def key_of(row: Mapping[str, Any]) -> tuple[Any, ...]:
        return tuple(row[name] for name in key)

    rows = read_rows(options.keep)
    done = {key_of(row) for row in rows}
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # for the child processes, which share the processors
    with (
        options.keep.open("a", encoding="utf-8") as file,
        ProcessPoolExecutor(options.processes, get_context("spawn")) as pool,
    ):
        waiting = [pool.submit(make, task) for task in find_tasks(done)]
        for number, future in enumerate(as_completed(waiting), start=1):
            made = [row for row in future.result() if key_of(row) not in done]
            rows += made
            file.writelines(json.dumps(row) + "\n" for row in made)
            file.flush()
            print(f"\r{number} of {len(waiting)}", end="", file=sys.stderr, flush=True)
    return rows


def write_block(begin: str, end: str, text: str) -> None:
    """Replace the text between two lines of docs/significance.md."""
    before, rest = PAGE.read_text(encoding="utf-8").split(begin)
    _, after = rest.split(end)
    PAGE.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")


def main() -> None:
    parser = study_parser(__doc__)
    parser.add_argument("--null", type=int, default=1000, help="verdicts without a difference")
    parser.add_argument("--power", type=int, default=300, help="verdicts with one")
    options = parser.parse_args()
    rows = run_studies(
        options,
        ("scenario", "n", "pair"),
        make_rows,
        lambda done: tasks(options.null, options.power, done),
    )
    text = table_text(rows)
    print(text)
    if options.write:
        null, power = (_n_text(rows, is_null=is_null) for is_null in (True, False))
        note = (
            f"{null} verdicts in each cell without a difference, {power} in each with one: share "
            "that claim any, or one for Y, with its 95 % interval."
        )
        write_block(BEGIN, END, f"{note}\n\n{text}")


if __name__ == "__main__":
    main()
