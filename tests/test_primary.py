"""The primary measure: chosen, kept, and changed after a verdict."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from drives import drives

import nvcore as nv
from nvcore.common.errors import ParameterError
from nvcore.comparison.compare import compare
from nvcore.comparison.measures.table import CLAIMABLE, choose_primary, claimable_key
from nvcore.evidence.claims import CLAIMED as CLAIMED_KEYS
from nvcore.evidence.table import judge_both
from nvcore.notes import Note
from nvcore.report.verdict import Verdict, verdict
from nvcore.settings.primary import DEFAULT, Primary, primary_from

AT = "2026-11-26T17:40:12+00:00"


def test_names_and_keys_mean_the_measures_that_may_be_claimed():
    assert set(CLAIMABLE.values()) == set(CLAIMED_KEYS)
    assert DEFAULT in CLAIMED_KEYS
    assert claimable_key("encounters_detected") == "encounters_detected_by_unit"
    assert claimable_key("encounters_detected_by_unit") == "encounters_detected_by_unit"
    with pytest.raises(ParameterError, match="no verdict can rest on 'recal': the measures are "):
        claimable_key("recal")


def test_it_is_changed_once_there_was_a_verdict_and_not_on_other_data():
    first = Primary().choose("saliency", fixed_at=AT)
    assert first == Primary("saliency", AT)
    assert first.choose("saliency", fixed_at="later") is first
    seen = replace(first, fingerprint="data")
    changed = seen.choose("mean_similarity", fixed_at=AT)
    assert changed == Primary("mean_similarity", AT, "data", is_changed=True)
    assert changed.choose("saliency", fixed_at=AT).is_changed  # back again is no way back
    assert changed.of_data("data") is changed
    assert changed.of_data("other") == Primary("mean_similarity", AT)


def test_a_name_and_its_key_are_the_same_measure():
    named = Primary("encounters_detected", AT, "data")
    assert choose_primary(named, "encounters_detected_by_unit") == replace(
        named, key="encounters_detected_by_unit"
    )
    assert choose_primary(named, None).key == "encounters_detected_by_unit"


def test_a_session_file_names_it_as_it_is():
    changed = Primary("mean_similarity", AT, "data", is_changed=True)
    assert primary_from(changed.given()) == changed
    assert Primary().given() == {}
    assert primary_from({}) == Primary()


def verdict_with(primary: Primary) -> Verdict:
    dataset = drives(8)
    settings = replace(dataset.settings, primary=primary)
    result = compare(dataset.with_settings(settings))
    evidence, companions = judge_both(result)
    return verdict(result, evidence=evidence, companions=companions)


@pytest.mark.parametrize(
    ("primary", "kind"),
    [
        (Primary(), "default"),
        (Primary("mean_similarity", AT), "chosen"),
        (Primary("mean_similarity"), "chosen"),
        (Primary("mean_similarity", AT, is_changed=True), "changed"),
        (Primary("useful_alerts"), "untested"),
    ],
)
def test_the_verdict_says_which_it_is(primary: Primary, kind: str):
    (question,) = verdict_with(primary).points[0].notes
    named = Note("verdict.measure", key=claimable_key(primary.key))
    assert (question.key, question["primary"]) == (f"verdict.primary_{kind}", named)


def test_where_it_shows_nothing_nothing_is_claimed():
    assert verdict_with(Primary()).claims[0].key == DEFAULT
    key = "false_alert_episodes_per_hour"
    nothing = verdict_with(Primary(key))
    assert nothing.claims == ()
    named = Note("verdict.measure", key=key)
    expected = Note("verdict.not_shown", n=8, noun="recording", primary=named)
    assert nothing.headline["conclusion"] == expected


def test_a_report_keeps_it_with_the_data_and_a_later_flag_changes_it(tmp_path: Path):
    sample = Path(__file__).parents[1] / "sample_data" / "session.toml"
    nv.compare(sample).write(tmp_path)
    session = nv.load(tmp_path / "session.toml")
    assert session.settings.primary.fingerprint == session.fingerprint
    assert not session.primary.is_changed
    assert nv.load(tmp_path / "session.toml", primary="saliency").primary.is_changed
    chosen = nv.load(sample, primary="encounters_detected").primary
    assert (chosen.key, chosen.is_changed) == ("encounters_detected_by_unit", False)
    assert chosen.fixed_at
    with pytest.raises(ParameterError, match="no verdict can rest on 'recal'"):
        nv.load(sample, primary="recal")
