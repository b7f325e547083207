"""Numbers as set and at equal false alarms: summary, notes and groups."""

from __future__ import annotations

import json

import pytest
from drives import at_thresholds, drives

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.operating_points import AS_SET, find_equal_alarms
from nvcore.evidence.subgroups import ALL
from nvcore.evidence.subgroups.table import GIVEN_THRESHOLD, subgroup_table
from nvcore.evidence.table import evidence_table
from nvcore.report.files import export_files, summary_json
from nvcore.settings.defaults import Settings


@pytest.fixture(scope="module")
def unequal() -> Result:
    return at_thresholds()


def test_the_summary_says_at_which_operating_point_its_numbers_are(unequal: Result):
    as_set, equal = (
        json.loads(summary_json(result)) for result in (unequal, find_equal_alarms(unequal))
    )
    assert (as_set["operating_point"], equal["operating_point"]) == ("as-set", "equal-alarms")
    for letter in "xy":
        threshold = as_set[letter]["threshold"]
        assert as_set["as_set"][f"threshold_{letter}"] == threshold
        assert equal["as_set"][f"threshold_{letter}"] == threshold
    assert equal["x"]["threshold"] != as_set["x"]["threshold"]
    assert equal["x"]["false_alarms_per_frame"] == equal["y"]["false_alarms_per_frame"]


def test_the_file_and_the_printed_summary_are_the_same(unequal: Result):
    assert export_files(unequal, Settings())["summary.json"]().decode() == summary_json(unequal)


def test_measures_as_set_have_a_note_and_those_over_all_thresholds_none(unequal: Result):
    notes = evidence_table(unequal).set_index("figure")["note"]
    assert AS_SET in notes["mean_similarity"]
    assert AS_SET not in notes["log_average_miss_rate"]
    groups = subgroup_table(unequal, ["encounters_detected"])
    assert all(AS_SET in note for note in groups["note"])
    assert not evidence_table(compare(drives(2)))["note"].str.contains(AS_SET).any()


def test_all_encounters_among_the_groups_are_as_in_the_evidence(unequal: Result):
    equal = find_equal_alarms(unequal)
    evidence, groups = evidence_table(equal), subgroup_table(equal)
    of_all = groups[groups["factor"] == ALL].set_index("figure")
    for row in evidence.to_dict("records"):
        for name in ("x", "y", "difference", "low", "high", "p"):
            assert of_all.loc[row["figure"], name] == pytest.approx(row[name], nan_ok=True)
    others = groups[(groups["factor"] != ALL) & groups["figure"].eq("encounters_detected_by_unit")]
    assert others["note"].str.contains(GIVEN_THRESHOLD).all()
