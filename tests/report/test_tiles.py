"""The comparison in four tiles: values, intervals and chips in words."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from drives import at_thresholds
from places import SAMPLE
from verdict_scenes import detecting

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.operating_points import count_alarms, find_equal_alarms
from nvcore.evidence.table import evidence_table
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.notes import Note
from nvcore.report.tiles import Tile, tiles
from nvcore.report.verdict import verdict

FOUND, MISSED, ALERTS, WORST = range(4)


@pytest.fixture(scope="module")
def sample() -> tuple[Result, pd.DataFrame, Companions]:
    result = compare(load(read_session(SAMPLE)))
    evidence = evidence_table(result)
    return result, evidence, find_companions(result, evidence)


def tile_of(sample: tuple[Result, pd.DataFrame, Companions], key: str, **row: object) -> Tile:
    """The tile after a change of its row of evidence."""
    result, evidence, _ = sample
    is_row = evidence["figure"] == key
    changed = evidence.assign(**{
        name: np.where(is_row, value, evidence[name]) for name, value in row.items()
    })  # fmt: skip
    companions = Companions(result, changed, result)
    return next(tile for tile in tiles(result, changed, companions) if tile.key in key)


def test_the_values_are_those_of_the_scorecard(sample: tuple[Result, pd.DataFrame, Companions]):
    four = tiles(*sample)
    assert [tile.title for tile in four] == [
        "Pedestrians found", "Time missed", "False-alert episodes", "Worst miss"
    ]  # fmt: skip
    detected, _, _, worst = four
    assert (detected.x, detected.y, detected.difference, detected.better) == ("30", "27", "+3", "x")
    assert detected.unit == "encounters detected, of 38"
    assert (worst.interval, worst.bar, worst.chip) == (
        Note("verdict.no_interval"),
        None,
        Note("verdict.chip_single"),
    )


def test_the_interval_of_encounters_counts_them_and_its_bar_is_right_where_x_is_better(
    sample: tuple[Result, pd.DataFrame, Companions],
):
    tile = tile_of(sample, "encounters_detected_by_unit", low=-0.1, difference=0.1, high=0.3)
    assert tile.interval == Note("verdict.interval", ends="−3.8 to +11.4")
    low, middle, high = tile.bar
    assert low < 0.5 < middle < high < 1
    missed = tile_of(sample, "severity_s_per_encounter", low=0.1, difference=0.2, high=0.4)
    low, middle, high = missed.bar
    assert 0 < low < middle < high < 0.5  # X misses more


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [
        (0.01, 0.42, "+0.01 to +0.42"),
        (0.001, 0.012, "+0.001 to +0.012"),  # not from +0.00
        (-0.001, 0.012, "0.00 to +0.01"),
        (0.1231, 0.1242, "+0.123 to +0.124"),
        (0.25, 0.25, "+0.25000 to +0.25000"),
    ],
)
def test_ends_of_an_interval_do_not_read_alike_or_as_0(
    sample: tuple[Result, pd.DataFrame, Companions], low: float, high: float, text: str
):
    tile = tile_of(
        sample, "severity_s_per_encounter", low=low, difference=(low + high) / 2, high=high
    )
    assert tile.interval == Note("verdict.interval", ends=text)


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ({"n": 7, "unit": "recordings"}, {"n": 7, "noun": "recording", "n_needed": 8}),
        ({"n": 5, "unit": "blocks"}, {"n": 5, "noun": "time block", "n_needed": 8}),
        ({"n": 8, "difference": 0.0}, {"is_same": True}),
        ({"n": 8}, {"is_same": False}),
    ],
)
def test_a_tile_says_why_it_has_no_interval(
    sample: tuple[Result, pd.DataFrame, Companions], row: dict[str, Any], why: dict[str, Any]
):
    tile = tile_of(sample, "severity_s_per_encounter", low=np.nan, high=np.nan, **row)
    assert (tile.interval, tile.bar) == (Note("verdict.no_interval", **why), None)


WHOLE = {"unit": "recordings"}
X_BETTER = Note("verdict.chip_better", winner="x")


@pytest.mark.parametrize(
    ("row", "chip", "winner"),
    [
        (WHOLE | {"p_corrected": 0.01, "difference": 0.1}, X_BETTER, "x"),
        (WHOLE | {"p_corrected": 0.01, "difference": -0.1},
         Note("verdict.chip_better", winner="y"), "y"),
        (WHOLE | {"p_corrected": 0.2}, Note("verdict.chip_not_shown"), ""),
        (WHOLE | {"p_corrected": 0.01, "doubt": "odd"},
         Note("verdict.chip_withheld", reason=Note("verdict.doubted", doubt="odd")), ""),
        ({"p_corrected": np.nan, "unit": "blocks"},
         Note("verdict.chip_few", n=10, noun="recording", n_needed=6), ""),
        (WHOLE | {"x": 0.5, "y": 0.5, "p_corrected": 1.0}, Note("verdict.chip_same"), ""),
    ],
)  # fmt: skip
def test_the_chip_claims_no_more_than_the_verdict(
    sample: tuple[Result, pd.DataFrame, Companions], row: dict, chip: Note, winner: str
):
    tile = tile_of(sample, "encounters_detected_by_unit", **row)
    assert (tile.chip, tile.winner) == (chip, winner)


def test_numbers_at_unequal_false_alarms_bear_no_claim_and_those_at_equal_ones_may():
    result = at_thresholds()
    evidence = evidence_table(result)
    for companions in (None, find_companions(result, evidence)):
        as_set = tiles(result, evidence, companions)
        assert {tile.chip for tile in as_set} == {Note("verdict.chip_unequal")}
        assert int(as_set[FOUND].x) == int(result.x.encounters["is_detected"].sum())
    equal = find_equal_alarms(result)
    evidence = evidence_table(equal)
    at_equal = tiles(equal, evidence, find_companions(equal, evidence))
    assert Note("verdict.chip_unequal") not in {tile.chip for tile in at_equal}
    assert int(at_equal[FOUND].x) == int(equal.x.encounters["is_detected"].sum())


def test_at_equal_false_alarms_each_tile_but_the_single_miss_has_an_interval(
    sample: tuple[Result, pd.DataFrame, Companions],
):
    params = replace(sample[0].params, threshold_x=0.1, threshold_y=0.3)
    result = find_equal_alarms(compare(sample[0].dataset, params))
    evidence = evidence_table(result)
    *judged, worst = tiles(result, evidence, find_companions(result, evidence))
    for tile in judged:
        assert tile.interval.key == "verdict.interval"
        low, middle, high = tile.bar
        assert 0 < low < middle < high < 1
    assert worst.bar is None


def test_few_false_alarms_are_why_a_tile_is_not_tested(
    sample: tuple[Result, pd.DataFrame, Companions],
):
    params = replace(sample[0].params, threshold_x=0.3, threshold_y=0.7)
    result = find_equal_alarms(compare(sample[0].dataset, params))
    assert (count_alarms(result.x), count_alarms(result.y)) == (13, 13)
    evidence = evidence_table(result)
    companions = find_companions(result, evidence)
    detected, missed, *_ = tiles(result, evidence, companions)
    assert (detected.interval, detected.chip) == (
        Note("verdict.no_interval"),
        Note("verdict.chip_unsure"),
    )
    assert (missed.interval, missed.chip) == (
        Note("verdict.no_interval"),
        Note("verdict.chip_unsure"),
    )
    conclusion = verdict(result, evidence=evidence, companions=companions)
    assert conclusion.headline["conclusion"] == Note("verdict.unsure")


def test_what_is_not_tested_yet_says_so(sample: tuple[Result, pd.DataFrame, Companions]):
    four = tiles(sample[0], None, None, is_being_tested=True)
    assert [tile.chip for tile in four[:3]] == [Note("verdict.chip_testing")] * 3


def test_what_is_0_for_both_comes_last():
    four = tiles(detecting(6, range(6), range(2)), None, None)
    values = [(tile.title, tile.x, tile.y) for tile in four]
    assert values[0] == ("Pedestrians found", "6", "2")
    assert values[-1] == ("False-alert episodes", "0", "0")
