"""What a verdict supports at unequal operating points, and where strict pairing disagrees."""

from __future__ import annotations

from builders import result_of
from drives import at_thresholds, turned_by_strict_pairing
from verdict_scenes import said, whole_verdict

from nvcore.common.findings import Finding, Severity
from nvcore.evidence.claims import Basis
from nvcore.evidence.companions import find_companions
from nvcore.evidence.measures import significance_table
from nvcore.evidence.operating_points import find_equal_alarms
from nvcore.notes import Note
from nvcore.report.verdict import verdict


def test_unequal_operating_points_lead_and_the_comparison_is_at_equal_false_alarms():
    result = at_thresholds()
    assert result.venn.x_only > result.venn.y_only
    text = whole_verdict(result)
    untestable = Note("verdict.untestable")
    assert text.headline == Note("verdict.at_equal_alarms", conclusion=untestable)
    as_set, at_equal = said(text, "Operating points")
    assert (as_set.key, at_equal.key) == ("verdict.unequal_numbers", "verdict.equal_claims")
    alarms = as_set["alarms"]
    assert alarms["x"] > alarms["y"]
    assert at_equal["setting"]["moved"] == "x"  # X at Y's operating point is Y
    (detected,) = said(text, "Encounters")
    assert detected["x_only"] > detected["y_only"] == 0
    shown = whole_verdict(find_equal_alarms(result))
    assert shown.headline == text.headline
    assert said(shown, "Operating points") == (Note("verdict.equal_numbers", **at_equal.fields),)
    (detected,) = said(shown, "Encounters")
    assert detected["x_only"] == detected["y_only"] == 0
    assert text.basis is Basis.EQUAL_ALARMS
    assert not text.claims
    assert [sentence.split(" (")[0] for sentence in text.sentences[:3]] == [
        "X and Y are set to different operating points; at equal false alarms, too little data "
        "to tell X and Y apart.",
        f"The numbers are for X and Y as set: X has {alarms['x']:.3g} and Y has "
        f"{alarms['y']:.3g} false boxes per frame.",
        "Claims are about X and Y at equal false alarms",
    ]


def test_without_scores_nothing_is_claimed_at_unequal_operating_points():
    text = whole_verdict(at_thresholds(scores=False))
    assert text.headline == Note("verdict.no_scores")
    (as_set,) = said(text, "Operating points")
    assert as_set.key == "verdict.unequal_comparison"
    (detected,) = said(text, "Encounters")
    assert detected["x_only"] > detected["y_only"] == 0
    assert text.basis is Basis.NONE
    assert not text.claims


def test_until_the_comparison_at_equal_false_alarms_is_known_nothing_is_claimed():
    result = at_thresholds()
    text = verdict(result, evidence=significance_table(result))
    assert text.headline == Note("verdict.not_yet_equal")
    assert not text.claims


def test_where_strict_pairing_disagrees_it_is_said_and_nothing_claimed():
    text = whole_verdict(result_of(turned_by_strict_pairing()))
    by_who = {
        has["system"]: [of["key"] for of in has["qualities"]]
        for has in said(text, "Other measures")
    }
    assert "mean_similarity" in by_who["y"]
    (strict,) = said(text, "Strict pairing")
    assert ("x", "mean_similarity") in {
        (of["winner"], of["measures"][0]["key"]) for of in strict["better"]
    }
    unclaimed = [note for note in said(text, "Chance") if note.key == "verdict.unclaimed"]
    reasons = {of["key"]: note["reason"] for note in unclaimed for of in note["measures"]}
    assert reasons["mean_similarity"] == Note("verdict.turned_strictly")
    assert "mean_similarity" not in {claim.key for claim in text.claims}


def test_the_audit_s_doubt_about_operating_points_ends_at_equal_false_alarms():
    floors = Finding(Severity.WARNING, "score-floors", "x", 1, "", "")
    result = at_thresholds()
    as_set = verdict(result, [floors], evidence=significance_table(result))
    assert as_set.doubt is not None
    assert as_set.doubt["known"] == ["score-floors"]
    equal = find_equal_alarms(result)
    assert verdict(equal, [floors], evidence=significance_table(equal)).doubt is None
    companions = find_companions(result, significance_table(result))
    assert verdict(result, [floors], companions=companions).doubt is None
