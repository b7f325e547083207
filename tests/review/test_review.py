"""Cases, decisions on them, and what the numbers are without what is wrong."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import at, make_dataset, result_of
from places import ROOT

from nvcore.auditing import audit
from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result, compare
from nvcore.evidence.measures import judge
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.review.cases import CaseKind, CaseList, find_cases, shots
from nvcore.subjects.review.decisions import (
    DISPUTED,
    compare_without,
    decided,
    empty_decisions,
    make_decision,
    read_decisions,
    reviewed_measures,
    write_decisions,
)
from nvcore.subjects.review.robust import find_robustness

SEVERITY = "severity_s_per_encounter"


@pytest.fixture(scope="module")
def result() -> Result:
    return compare(load(read_session(ROOT / "sample_data" / "session.toml")))


@pytest.fixture(scope="module")
def cases(result: Result) -> CaseList:
    return find_cases(result, audit(result.dataset))


def on(case: str, decision: str, reviewer: str = "Ann", note: str = "") -> pd.DataFrame:
    return make_decision(case, decision, reviewer=reviewer, note=note)


def test_each_miss_and_each_false_alert_episode_is_a_case(result: Result, cases: CaseList) -> None:
    counts = cases.table["kind"].value_counts()
    worst = np.fmax(*(of.failures["severity_s"].to_numpy() for of in (result.x, result.y)))
    assert counts[CaseKind.MISS] == np.count_nonzero(worst > 0)
    episodes = len(result.x.episodes) + len(result.y.episodes)
    assert counts[CaseKind.FALSE_ALARM] == episodes
    assert cases.table["case"].is_unique
    own = result.dataset.boxes.iloc[cases.boxes[0]]
    assert (own["source"] == 0).all()
    assert cases.table["severity_s"][0] == worst.max()


def test_without_a_case_nothing_is_decided() -> None:
    dataset = make_dataset(truth=[at(3, 50)], x=[at(3, 50)], y=[at(3, 50)], n_frames=9)
    none = find_cases(result_of(dataset))
    assert decided(none, empty_decisions()).empty
    assert decided(none, make_decision("c1", "ask")).empty


def test_a_case_keeps_its_name_at_other_thresholds(result: Result, cases: CaseList) -> None:
    params = result.params.__class__(**{**vars(result.params), "threshold_x": 0.9})
    other = find_cases(compare(result.dataset, params))
    both = cases.table.merge(other.table, on="case", suffixes=("", "_other"))
    assert len(both) >= (cases.table["kind"] == CaseKind.MISS).sum()
    assert (both["encounter"] == both["encounter_other"]).all()


def test_decisions_of_two_reviewers_stand_beside_each_other(cases: CaseList) -> None:
    first, second = cases.table["case"][:2]
    decisions = pd.concat(
        [
            on(first, "real miss"),
            on(first, "wrong truth", "Bob", "a pole"),
            on(second, "irrelevant"),
            on(second, ""),
        ]
    )
    table = decided(cases, decisions)
    assert table["decision"].tolist() == [DISPUTED, *[""] * (len(cases) - 1)]
    assert not table["is_done"].any()
    settled = decided(cases, pd.concat([decisions, on(first, "wrong truth")]))
    assert settled["decision"][0] == "wrong truth"
    assert settled["is_done"][0]


def test_wrong_truth_is_neither_missed_nor_counted(result: Result, cases: CaseList) -> None:
    miss = int(np.flatnonzero(cases.table["kind"] == CaseKind.MISS)[0])
    alarm = int(np.flatnonzero(cases.table["kind"] == CaseKind.FALSE_ALARM)[0])
    after = compare_without(result, cases, [miss, alarm])
    assert after.venn.n_near == result.venn.n_near - 1
    letter = cases.table["systems"][alarm]
    assert len(after.system(letter).episodes) == len(result.system(letter).episodes) - 1
    lost = cases.table["severity_s"][miss]
    severity = max(
        before.failures["severity_s"].sum() - now.failures["severity_s"].sum()
        for (_, before), (_, now) in zip(result.sides, after.sides, strict=True)
    )
    assert severity == pytest.approx(lost)


def test_measures_are_the_same_until_something_is_wrong(result: Result, cases: CaseList) -> None:
    case = cases.table["case"][0]
    same = reviewed_measures(result, cases, on(case, "real miss"))
    assert np.array_equal(same["x"], same["x_reviewed"], equal_nan=True)
    table = reviewed_measures(result, cases, on(case, "wrong truth")).set_index("measure")
    assert table["x_reviewed"][SEVERITY] != table["x"][SEVERITY]


def test_decisions_outlive_a_file(cases: CaseList, tmp_path: Path) -> None:
    decisions = pd.concat(
        [on(cases.table["case"][0], "ask", note='a "pole", or\ntwo'), on("x", "false alarm")],
        ignore_index=True,
    )
    for name in ("review.csv", "review.json"):
        write_decisions(decisions, tmp_path / name)
        pd.testing.assert_frame_equal(read_decisions(tmp_path / name), decisions, check_dtype=False)
    write_decisions(empty_decisions(), tmp_path / "none.csv")
    assert read_decisions(tmp_path / "none.csv").empty


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("case,decision\na,ask\n", "no column reviewer"),
        (
            "case,reviewer,decision,note,is_done,at\na,A,maybe,,true,2026-01-01\n",
            "decision 1: no dec",
        ),
        ("case,reviewer,decision,note,is_done,at\na,A,ask,,true,noon\n", "decision 1: Invalid"),
    ],
)
def test_other_files_are_refused_with_their_line(text: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "review.csv").write_text(text)
    with pytest.raises(InputError, match=told):
        read_decisions(tmp_path / "review.csv")


def leads(result: Result) -> np.ndarray:
    """X's severity less Y's, for each encounter."""
    x, y = (of.failures["severity_s"].to_numpy() * result.is_near for _, of in result.sides)
    return np.asarray(x - y)


def test_the_fewest_cases_that_turn_the_sign_are_found(result: Result, cases: CaseList) -> None:
    is_open = (np.arange(len(cases)) < 16) & (cases.table["kind"] == CaseKind.MISS).to_numpy()
    found = find_robustness(result, cases, is_open, SEVERITY)
    assert found is not None
    assert found.turns_sign is not None
    total, by_case = leads(result).sum(), leads(result)[cases.table["encounter"][is_open]]
    assert total < 0 <= leads(compare_without(result, cases, found.turns_sign)).sum()
    fewer = combinations(by_case, len(found.turns_sign) - 1)
    assert all(total - sum(chosen) < 0 for chosen in fewer)


def test_cases_left_out_already_no_longer_count(result: Result, cases: CaseList) -> None:
    is_left_out = np.isin(np.arange(len(cases)), [0, 1])
    found = find_robustness(result, cases, ~is_left_out, SEVERITY, is_left_out=is_left_out)
    assert found is not None
    assert found.turns_sign is not None
    without = [0, 1, *found.turns_sign]
    assert leads(compare_without(result, cases, without[:-1])).sum() < 0
    assert leads(compare_without(result, cases, without)).sum() >= 0


def test_the_frames_played_of_a_case_show_its_boxes(result: Result, cases: CaseList) -> None:
    frames, boxes = result.dataset.frame_columns, result.dataset.boxes
    for case, own, shot in zip(
        cases.table.to_dict("records"), cases.boxes, shots(result.dataset, cases), strict=True
    ):
        rows = frames.first[shot.recording] + np.array(shot.rows)
        assert frames.frame[rows[shot.at]] == case["frame"]
        assert shot.boxes[shot.at] == pytest.approx([case[side] for side in "xywh"], abs=0.06)
        assert len(rows) <= 10
        assert np.isin(rows, boxes["frame_index"].to_numpy()[own]).all()


def test_a_claim_turns_where_p_passes_its_limit(result: Result, cases: CaseList) -> None:
    found = find_robustness(result, cases, np.ones(len(cases), bool), SEVERITY)
    (evidence,) = judge(result, [SEVERITY])
    assert found is not None
    assert evidence.p > 0.05
    assert found.turns_claim == ()


def test_nothing_open_turns_nothing(result: Result, cases: CaseList) -> None:
    found = find_robustness(result, cases, np.zeros(len(cases), bool), SEVERITY)
    assert found is not None
    assert found.turns_sign is None
    assert find_robustness(result, cases, np.ones(len(cases), bool), "mean_similarity") is None
