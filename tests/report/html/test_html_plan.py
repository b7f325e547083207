"""The report's section on how many recordings would show a difference."""

from __future__ import annotations

import pytest
from builders import result_of
from drives import drives, quiet_drives
from places import SAMPLE

from nvcore.common.progress import no_progress
from nvcore.comparison.compare import Result, compare
from nvcore.evidence.table import evidence_table
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.report.plan import verdict_plan
from nvcore.report.section import Paragraphs, Table
from nvcore.report.sections.evidence import plan_measures, plan_section
from nvcore.settings.protocols import PROTOCOLS


@pytest.fixture(scope="module")
def sample() -> Result:
    return compare(load(read_session(SAMPLE)))


def test_each_difference_that_is_not_shown_has_its_size_and_what_is_excluded(sample: Result):
    evidence = evidence_table(sample)
    plans = plan_measures(sample, evidence, PROTOCOLS["all"], progress=no_progress)
    plan, sentences = plan_section(sample, evidence, plans).worded(sample.objects).blocks
    assert isinstance(plan, Table)
    assert isinstance(sentences, Paragraphs)
    rows = {row[0]: row[1:] for row in plan.rows}
    assert len(rows) == 9  # lost similarity is mean similarity in other words
    difference, below, above, n, span, n_encounters, _ = rows[
        "share of encounters detected, by recordings"
    ]
    assert (difference, below, above) == ("+7.9 pp", "-29.7 pp", "+29.1 pp")
    assert (n, span, n_encounters) == ("–", "–", "–")
    (reason,) = plan.notes  # the same for all that have no number
    assert reason.startswith("Share of encounters detected, by recordings; ")
    assert "too few recordings to plan from" in reason
    notes = verdict_plan(sample, evidence, None)
    primary = plans["severity_s_per_encounter"].sizes[0]
    assert notes[0]["reason"] == primary.reason
    assert verdict_plan(sample, evidence, None, plans=plans) == notes


def test_a_size_stands_beside_the_range_to_plan_for():
    result = result_of(quiet_drives(12))
    evidence = evidence_table(result).assign(p_corrected=0.5)
    plans = plan_measures(result, evidence, PROTOCOLS["all"], progress=no_progress)
    plan, _ = plan_section(result, evidence, plans).worded(result.objects).blocks
    assert isinstance(plan, Table)
    label = "share of encounters detected, by recordings"
    (row,) = (row for row in plan.rows if row[0] == label)
    _, _, _, n, span, n_encounters, _ = row[1:]
    assert int(n_encounters) == 5 * int(n)
    low, high = map(int, span.split(" to "))
    assert low <= int(n) <= high


def test_blocks_of_time_and_what_is_shown_have_words_instead():
    few = result_of(drives(4))
    section = plan_section(few, evidence_table(few), {}).worded(few.objects)
    assert "a pilot of 6 recordings or more" in section.blocks[0].texts[0]
    assert verdict_plan(few, evidence_table(few), None) == ()
    clear = result_of(drives(30))
    evidence = evidence_table(clear)
    assert verdict_plan(clear, evidence, None) == ()
    evidence["p_corrected"] = 0.001
    plans = plan_measures(clear, evidence, PROTOCOLS["all"], progress=no_progress)
    section = plan_section(clear, evidence, plans).worded(clear.objects)
    assert section.blocks[0].texts == ("No p is above 0.05 after correction: nothing to plan for.",)
