"""How likely a system misses fewer encounters, counted by hand and on scenes."""

from __future__ import annotations

from math import exp, log
from statistics import NormalDist

import numpy as np
import pytest
from builders import NAN, Place, at, make_dataset, result_of
from places import ROOT

import nvcore as nv
from bench.graded import BEGIN, END, GENERATORS, SIZES, make_rows, table_text
from nvcore.comparison.compare import Result
from nvcore.evidence.companions import find_companions, grade_systems
from nvcore.evidence.graded import probability
from nvcore.evidence.table import evidence_table
from nvcore.report.verdict import HOW_SURE, verdict


def reading(units: list[tuple[int, int]], n_tau: int = 7, n_z: int = 21) -> float:
    """P(d > 0) by loops over the grid of the definition."""
    normal, shares = NormalDist(), {-1: 0.0, 0: 0.0, 1: 0.0}
    for i in range(81):
        d = 1.5 * (-4 + 0.1 * i)
        for j in range(n_tau):
            tau = 2 * normal.inv_cdf(0.5 + 0.5 * (j + 0.5) / n_tau)
            weight = exp(-0.5 * (d / 1.5) ** 2)
            for x_alone, y_alone in units:
                total = 0.0
                for k in range(n_z):
                    p = 1 / (1 + exp(-(d + tau * normal.inv_cdf((k + 0.5) / n_z))))
                    total += exp((x_alone * log(p) + y_alone * log(1 - p)) / 1.5)
                weight *= total / n_z
            shares[int(np.sign(i - 40))] += weight
    return (shares[1] + shares[0] / 2) / sum(shares.values())


@pytest.mark.parametrize(
    ("units", "grid"),
    [
        ([(1, 0)], (7, 21)),
        ([(0, 0), (3, 1)], (7, 21)),
        ([(5, 1), (2, 2), (0, 3), (4, 0)], (7, 21)),
        ([(40, 7), (3, 60)], (15, 81)),
    ],
)
def test_the_probability_is_that_of_the_definition(
    units: list[tuple[int, int]], grid: tuple[int, int]
):
    x_alone, y_alone = np.array(units).T
    found = probability(x_alone, y_alone)
    assert found[0] == pytest.approx(reading(units, *grid), abs=1e-9)
    for left_out in range(len(units)):
        rest = [unit for number, unit in enumerate(units) if number != left_out]
        assert found[1 + left_out] == pytest.approx(reading(rest, *grid), abs=1e-9)
    assert probability(y_alone, x_alone) == pytest.approx(1 - found)


def scene(missed: list[tuple[int, int]], *, scores: bool = True) -> Result:
    """Recordings in which X alone misses the first pedestrians, Y alone the next, and so on.

    Eight pedestrians each, of ten frames. Both have false alarms, more in some recordings.
    """
    truth, x, y = [], [], []
    for number, (x_alone, y_alone) in enumerate(missed):
        for track in range(8):
            for frame in range(10 * track, 10 * track + 10):
                truth.append(at(frame, 50, track=track, recording=number))
                if track >= x_alone:
                    x.append(at(frame, 50, recording=number, score=0.9 - 0.001 * track))
                if not x_alone <= track < x_alone + y_alone:
                    y.append(at(frame, 50, recording=number, score=0.9 - 0.001 * track))
        for frame in range(0, 80, 4):
            x.append(at(frame + (number % 2), 5, recording=number, score=0.2 + 0.001 * frame))
        for frame in range(0, 80, 4 + number % 2):
            y.append(at(frame, 5, recording=number, score=0.2 + 0.001 * frame))
    if not scores:
        x, y = ([box._replace(score=NAN) for box in boxes] for boxes in (x, y))
    places = [Place(range(80))] * len(missed)
    return result_of(make_dataset(truth, x, y, places=places))


def test_few_recordings_are_not_more_than_90_of_100_sure():
    few, enough = [(4, 0)] * 5, [(4, 0)] * 6
    assert grade_systems(scene(few)).y_better == 0.9 < reading(few)
    assert grade_systems(scene(enough)).y_better == pytest.approx(reading(enough), abs=0.01)


def test_x_and_y_change_places():
    """One recording has all of the difference: without it neither is better."""
    for missed in ([(3, 0), (0, 0), (0, 0)], [(0, 3), (0, 0), (0, 0)]):
        assert grade_systems(scene(missed)).reason == "one"


def test_it_says_where_the_better_one_misses_more_in_all():
    assert said(scene([(0, 1)] * 7 + [(8, 0)])).endswith(
        "of 100 that X typically misses fewer encounters at equal false alarms (no claim), "
        "although it misses more in all (8 against 7)."
    )


def test_python_has_its_numbers():
    graded = nv.compare(scene([(3, 0), (2, 1), (1, 0)]).dataset).how_sure
    assert (graded.x_misses, graded.y_misses, graded.noun) == (6, 1, "recording")
    assert 0.5 < graded.y_better < 1


def said(result: Result) -> str:
    evidence = evidence_table(result, has_intervals=False)
    conclusion = verdict(result, evidence=evidence, companions=find_companions(result, evidence))
    return dict(conclusion.topics)[HOW_SURE]


def test_the_verdict_says_it_at_equal_false_alarms():
    missed = [(3, 0), (2, 1), (1, 0), (3, 1), (2, 0)]
    graded = grade_systems(scene(missed))
    assert (graded.x_misses, graded.y_misses, graded.n_units) == (11, 2, 5)
    assert graded.y_better == 0.9 < reading(missed)
    share = round(100 * graded.y_better)
    assert said(scene(missed)) == (
        f"{share} of 100 that Y typically misses fewer encounters at equal false alarms (no claim)."
    )


@pytest.mark.parametrize(
    ("result", "why"),
    [
        (scene([(3, 0)]), "there is only 1 recording."),
        (scene([(3, 0)] * 3, scores=False), "without scores that differ, X and Y cannot be set"),
        (scene([(0, 0)] * 4), "neither misses any that the other detects at equal false alarms."),
        (scene([(3, 0), (0, 2), (0, 0)]), "it turns if a recording is left out (only X misses 3"),
    ],
    ids=["units", "scores", "none", "one"],
)
def test_it_says_why_there_is_none(result: Result, why: str):
    assert said(result).startswith(f"– (no probability that X or Y misses fewer encounters): {why}")


def test_the_bench_counts_right_statements_by_band():
    rows = [row for n in (4, 8) for row in make_rows(("graded", "~groups", n, 0, 3))]
    assert rows[3:] == make_rows(("graded", "~groups", 8, 0, 3))
    row = {"kind": "graded", "name": "equal", "n": 4, "y_better": 0.8, "reason": ""}
    of_band = [row | {"effect": effect} for effect in (1.0, 0.5, 0.2, -0.1)]
    unsaid = row | {"effect": 1.0, "y_better": None}
    lines = table_text([*of_band, unsaid]).splitlines()
    assert lines[3].startswith("| first generator: 70 to 90 | 75% (30 to 95; 4) | –")
    assert lines[6].startswith("| first generator: not said | 20% | –")
    assert len(lines) > 5 * len(GENERATORS)
    assert lines[0].count("|") == len(SIZES) + 2
    page = (ROOT / "docs" / "significance.md").read_text(encoding="utf-8")
    assert page.index(BEGIN) < page.index(END)
