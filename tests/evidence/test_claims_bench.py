"""The simulation that counts false claims, at a small scale."""

from __future__ import annotations

import numpy as np
import pytest
from places import ROOT

from bench.claims import BEGIN, END, SCENARIOS, SIZES, draw_dataset, make_rows, table_text, tasks
from nvcore.comparison.compare import compare
from nvcore.settings.params import Params


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_gives_pairs_of_systems_that_can_be_compared(name: str):
    dataset = draw_dataset(SCENARIOS[name], 6, np.random.default_rng(len(name)))
    result = compare(dataset, Params())
    assert len(dataset.recordings) == 6
    assert result.venn.n_near > 30
    assert not result.is_short
    assert result.x.matched.sum() > 0 < result.y.matched.sum()
    lengths = np.diff(dataset.frame_columns.first)
    assert (len(set(lengths)) > 1) == SCENARIOS[name].has_lengths


def test_the_same_pair_has_the_same_verdict_in_another_chunk():
    rows = make_rows(("half", 8, 0, 3))
    assert [row["pair"] for row in rows] == [0, 1, 2]
    assert make_rows(("half", 8, 2, 3)) == rows[2:]


def test_what_is_there_is_not_made_again():
    done = {("equal", 6, pair) for pair in range(20)}
    waiting = [*tasks(40, 20, done)]
    assert ("equal", 6, 0, 20) not in waiting
    assert {("equal", 6, 20, 40), ("equal", 8, 0, 20), ("half", 6, 0, 20)} <= {*waiting}
    assert ("half", 6, 20, 40) not in waiting


def test_the_table_has_a_row_for_each_scenario_and_shares_of_verdicts():
    def row(scenario: str, *claims: str) -> dict[str, object]:
        return {
            "scenario": scenario,
            "n": 8,
            "claims": {f"m{i}": of for i, of in enumerate(claims)},
        }

    nulls = [row("equal", "x"), *[row("equal")] * 99]
    better = [row("half", "y", "y"), row("half", "x"), row("half", "x", "y"), row("half")]
    lines = table_text([*nulls, *better]).splitlines()
    n = sum(scenario.is_null for scenario in SCENARIOS.values())
    assert lines[0] == f"| no difference, recordings: | {' | '.join(map(str, SIZES))} |"
    assert lines[2] == f"| {SCENARIOS['equal'].label} | – | 1.0% (0.2 to 5.4) | – | – | – |"
    assert lines[n + 5] == f"| {SCENARIOS['half'].label} | – | 50.0% (15.0 to 85.0) | – | – | – |"
    assert len(lines) == len(SCENARIOS) + 5


def test_the_documentation_has_a_place_for_the_table():
    page = (ROOT / "docs" / "significance.md").read_text(encoding="utf-8")
    assert page.index(BEGIN) < page.index(END)
