"""The simulation that counts false claims, at a small scale."""

from __future__ import annotations

import numpy as np
import pytest
from places import ROOT

from bench.claims import BEGIN, END, SCENARIOS, Row, draw_dataset, simulate, table_text
from nvcore.comparison import compare
from nvcore.params import Params


@pytest.mark.parametrize("number", range(len(SCENARIOS)))
def test_every_scenario_gives_pairs_of_systems_that_can_be_compared(number: int):
    dataset = draw_dataset(SCENARIOS[number], 6, np.random.default_rng(number))
    result = compare(dataset, Params())
    assert len(dataset.recordings) == 6
    assert result.venn.n_near > 30
    assert not result.is_short
    assert result.x.matched.sum() > 0 < result.y.matched.sum()


@pytest.mark.parametrize("n", [2, 6])
def test_no_pair_without_a_difference_is_claimed_from_so_few_recordings(n: int):
    row = simulate((0, n, 3), 2026)
    assert (row.n_pairs, row.n_claiming) == (3, 0)


def test_the_table_has_a_row_for_each_scenario_and_shares_of_verdicts():
    claiming = {(0, 8): 8, (0, 6): 0, (6, 8): 200}
    rows = [Row(*row, 400, n, n_wrong=0, n_encounters=0, seconds=1) for row, n in claiming.items()]
    assert table_text(rows).splitlines() == [
        "| no difference, recordings: | 6 | 8 |",
        "|---|---|---|",
        f"| {SCENARIOS[0].label} | 0.0% | 2.0% |",
        "",
        "| a difference, recordings: | 8 |",
        "|---|---|",
        f"| {SCENARIOS[6].label} | 50.0% |",
    ]


def test_the_documentation_has_a_place_for_the_table():
    page = (ROOT / "docs" / "significance.md").read_text(encoding="utf-8")
    assert page.index(BEGIN) < page.index(END)
