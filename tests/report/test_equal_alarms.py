"""The comparison at equal false alarms: where the one as set is marked, it can be looked up."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from drives import at_thresholds, drives

from nvcore.comparison import Result, compare
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.evidence.table import evidence_table
from nvcore.measures.table import MEASURES
from nvcore.report.equal_alarms import at_equal_alarms, short_rows
from nvcore.report.files import export_files, summary_json
from nvcore.report.verdict import verdict
from nvcore.sentences.texts import AS_SET
from nvcore.settings import Settings


@pytest.fixture(scope="module")
def unequal() -> Result:
    return at_thresholds()


@pytest.fixture(scope="module")
def companions(unequal: Result) -> Companions:
    return find_companions(unequal, evidence_table(unequal))


def test_the_summary_has_every_number_of_the_verdict(unequal: Result, companions: Companions):
    content = json.loads(summary_json(unequal))["at_equal_false_alarms"]
    assert companions.equal is not None
    text = verdict(unequal, evidence=evidence_table(unequal), companions=companions)
    shown = re.search(r"X with scores of ([\d.]+) or more, ([\d.]+) per frame", str(text.sentences))
    assert shown is not None
    assert content["moved"] == "x"
    assert content["x"]["threshold"] == pytest.approx(float(shown[1]))
    assert content["x"]["false_alarms_per_frame"] == pytest.approx(float(shown[2]), rel=0.01)
    keys = {measure.key for measure in MEASURES}
    assert {"mean_similarity", "saliency", "severity_s"} <= keys & set(content["x"])
    assert content["venn"] == {
        kind: n for kind, n in companions.equal.result.venn.counts().items() if kind != "distant"
    }
    for letter in "xy":
        parts_s = [content["venn_severity_s"][f"{kind}_{letter}"] for kind in content["venn"]]
        assert sum(parts_s) == pytest.approx(content[letter]["severity_s"])
    assert set(content["evidence"]) == set(companions.evidence["figure"])
    assert content["evidence"]["log_average_miss_rate"]["p"] < 1
    severity = content["evidence"]["severity_s_per_encounter"]
    assert severity["x"] == pytest.approx(content["x"]["severity_s_per_encounter"])
    rate = content["evidence"]["log_average_miss_rate"]
    assert rate["low"] < rate["difference"] < rate["high"]


def test_the_file_and_the_printed_summary_are_the_same(unequal: Result):
    assert export_files(unequal, Settings())["summary.json"]().decode() == summary_json(unequal)


def test_at_equal_operating_points_there_is_no_other_comparison():
    assert json.loads(summary_json(compare(drives(2))))["at_equal_false_alarms"] is None
    assert at_equal_alarms(None) is None


def test_measures_as_set_have_a_note_and_those_over_all_thresholds_none(unequal: Result):
    notes = evidence_table(unequal).set_index("figure")["note"]
    assert AS_SET in notes["mean_similarity"]
    assert AS_SET not in notes["log_average_miss_rate"]
    groups = subgroup_table(unequal, ["encounters_detected"])
    assert all(AS_SET in note for note in groups["note"])
    assert not evidence_table(compare(drives(2)))["note"].str.contains(AS_SET).any()


def test_the_short_scorecard_names_every_measure_in_full(companions: Companions):
    assert companions.equal is not None
    rows = short_rows(companions.equal.result)
    assert len(rows) == 8
    assert not any(row.level for row in rows)
    assert all(np.isfinite(row.x) for row in rows)
