"""Recordings that are one: copied, cut, shifted, or said to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import Box, Place, at, make_dataset

from nvcore.auditing import audit_inputs
from nvcore.auditing.copies import audit_copies, audit_pieces
from nvcore.common.findings import Severity
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.copies import Copy, units_of
from nvcore.evidence.planning.pilot import make_pilot
from nvcore.evidence.table import judge_both
from nvcore.evidence.units import BLOCKS, RECORDINGS, UNITS, count_whole, find_units, sum_units
from nvcore.report.verdict import verdict


def drive(seed: int, n: int = 40) -> list[Box]:
    """A pedestrian who goes their own way through a recording."""
    rng = np.random.default_rng(seed)
    centre, height = rng.uniform(20, 80), rng.uniform(20, 40)
    return [
        at(frame, centre + rng.normal(0, 3), track=1, h=height + frame / 2) for frame in range(n)
    ]


def dataset_of(*drives: Sequence[Box], shares: tuple[float, float] = (0.75, 0.5)) -> Dataset:
    """X and Y detect these shares of the frames of each; nobody says what is independent."""
    truth = [box._replace(recording=i) for i, boxes in enumerate(drives) for box in boxes]
    x, y = (
        [
            box._replace(score=0.9, x=box.x + aside)
            for box in truth
            if (7 * box.frame) % 40 < 40 * share
        ]
        for share, aside in zip(shares, (0.2, 0.3), strict=True)
    )
    places = [Place(range(60))] * len(drives)
    return make_dataset(truth, x, y, places=places, is_independent=False)


def with_units(dataset: Dataset, *units: str) -> Dataset:
    return replace(dataset, recordings=dataset.recordings.assign(unit=pd.Series(units).array))


def shifted(boxes: Sequence[Box], by: int) -> list[Box]:
    return [box._replace(frame=box.frame + by) for box in boxes]


@pytest.mark.parametrize(
    ("second", "copy"),
    [
        (drive(1), Copy(0, 1, 40, 1.0, 0)),
        (shifted(drive(1), 7), Copy(0, 1, 40, 1.0, 7)),
        (shifted(drive(1)[15:], -15), Copy(0, 1, 25, 1.0, -15)),
        ([*drive(1)[:22], *shifted(drive(9, 18), 22)], Copy(0, 1, 22, 0.55, 0)),
    ],
    ids=["copied", "shifted", "cut and shifted", "half"],
)
def test_the_same_truth_twice_is_an_error_that_names_both(second: list[Box], copy: Copy):
    dataset = dataset_of(drive(1), second, drive(2))
    assert dataset.copies == (copy,)
    (finding,) = audit_copies(dataset)
    assert finding.severity is Severity.ERROR
    assert "r0 and r1 (" in finding.message
    assert finding.code in {finding.code for finding in audit_inputs(dataset)}
    assert units_of(dataset).tolist() == ["r0", "r0", ""]


@pytest.mark.parametrize(
    "second",
    [drive(3), [*drive(1)[:19], *shifted(drive(9, 30), 19)], [drive(1)[0]] * 0],
    ids=["another", "19 boxes", "empty"],
)
def test_others_are_no_copies(second: list[Box]):
    dataset = dataset_of(drive(1), second)
    assert dataset.copies == ()
    assert [*audit_copies(dataset)] == []


def test_somebody_who_stands_still_in_both_is_no_copy():
    still = [at(frame, 50, track=1) for frame in range(40)]
    assert dataset_of(still, still).copies == ()


def test_units_that_are_stated_for_both_settle_it():
    dataset = dataset_of(drive(1), drive(1), drive(2))
    for units, expected in (
        (("a", "a", ""), ["a", "a", ""]),
        (("a", "b", ""), ["a", "b", ""]),
        (("a", "", ""), ["a", "a", ""]),
        (("", "b", "b"), ["b", "b", "b"]),
    ):
        stated = with_units(dataset, *units)
        assert units_of(stated).tolist() == expected
        assert bool([*audit_copies(stated)]) == (not all(units[:2]))


def test_one_recording_copied_ten_times_is_one_unit_and_supports_nothing():
    result = compare(dataset_of(*[drive(1)] * 10))
    units = find_units(result)
    assert units.kind == BLOCKS
    assert count_whole(result.dataset) == (1, "unit")
    assert units.note.startswith("10 recordings, 1 of them independent: intervals over blocks")
    assert units.note.endswith("(6 independent recordings are needed)")
    _, why_not = make_pilot(result, "mean_similarity", units=units)
    assert why_not.startswith(
        "a plan needs a pilot of 6 independent recordings or more, here are 10, 1 of them "
        "independent"
    )
    findings = audit_inputs(result.dataset)
    evidence, companions = judge_both(result)
    assert evidence["p_corrected"].isna().all()
    conclusion = verdict(result, findings, evidence=evidence, companions=companions)
    assert conclusion.headline.key == "verdict.wrong_inputs"
    assert conclusion.claims == ()
    alone = verdict(result, evidence=evidence, companions=companions)
    assert alone.claims == ()


def test_recordings_of_a_unit_count_as_one_in_tests_and_add_up():
    dataset = dataset_of(*map(drive, range(12)))
    plain, units = (
        find_units(compare(of))
        for of in (dataset, with_units(dataset, *(f"drive {i // 2}" for i in range(12))))
    )
    assert (plain.kind, len(plain)) == (RECORDINGS, 12)
    assert (units.kind, len(units), units.n_recordings) == (UNITS, 6, 12)
    result = compare(dataset)
    apart, together = sum_units(result, plain), sum_units(result, units)
    names = dataset.recordings["name"].to_numpy()
    number = {name: int(name[1:]) // 2 for name in names}
    owner = [number[names[row]] for row in plain.recording]
    order = [number[names[row]] for row in units.recording]
    for column in apart.columns.drop("recording"):
        sums = np.bincount(owner, apart[column])[order]
        assert together[column].tolist() == pytest.approx(sums.tolist()), column
    assert together["share_of_recording"].tolist() == [2] * 6
    assert "12 recordings are 6 units" in units.note


def test_a_verdict_by_units_says_so():
    dataset = dataset_of(*map(drive, range(16)), shares=(1.0, 0.4))
    result = compare(with_units(dataset, *(f"drive {i % 8}" for i in range(16))))
    evidence, companions = judge_both(result)
    by_unit = evidence.set_index("figure").loc["severity_s_per_encounter"]
    assert (by_unit["unit"], by_unit["n"]) == (UNITS, 8)
    conclusion = verdict(result, evidence=evidence, companions=companions)
    assert "more than chance across 8 units" in conclusion.say(conclusion.headline)


@pytest.mark.parametrize(
    ("names", "n"),
    [
        (["a_part1", "a_part2", "b"], 2),
        (["set00_000", "set00_001", "set01_000", "set01_001"], 4),
        (["night", "day", "rain"], 0),
        (["r0", "r1", "r2"], 0),  # numbered through: no drives
    ],
)
def test_names_that_look_like_pieces_are_asked_about(names: list[str], n: int):
    dataset = dataset_of(*map(drive, range(len(names))))
    named = replace(dataset, recordings=dataset.recordings.assign(name=names))
    findings = [*audit_pieces(named)]
    assert [(finding.severity, finding.count) for finding in findings] == [(Severity.NOTE, n)] * (
        n > 0
    )
    assert [*audit_pieces(with_units(named, *names))] == []
