"""What a verdict supports at unequal operating points, and where strict pairing disagrees."""

from __future__ import annotations

from builders import result_of
from drives import at_thresholds, turned_by_strict_pairing
from verdict_scenes import said, whole_verdict

from nvcore.evidence.claims import Basis
from nvcore.evidence.measures import significance_table
from nvcore.evidence.operating_points import find_equal_alarms
from nvcore.report.verdict import verdict
from nvcore.sentences.facts import AtEqualAlarms, Headline, Unclaimed, WithheldReason


def test_unequal_operating_points_lead_and_the_comparison_is_at_equal_false_alarms():
    result = at_thresholds()
    assert result.venn.x_only > result.venn.y_only
    text = whole_verdict(result)
    assert (text.headline.kind, text.headline.conclusion.kind) == ("equal", "untestable")
    as_set, at_equal = said(text, "Operating points")
    assert (as_set.kind, at_equal.kind) == ("numbers", "claims")
    assert as_set.x > as_set.y
    assert at_equal.setting.moved == "x"  # X at Y's operating point is Y
    (split,) = said(text, "Encounters")
    assert (split.kind, split.test) == ("x", None)
    shown = whole_verdict(find_equal_alarms(result))
    assert shown.headline == text.headline
    assert said(shown, "Operating points") == (AtEqualAlarms("numbers", at_equal.setting),)
    assert said(shown, "Encounters")[0].kind == "same"
    assert text.basis is Basis.EQUAL_ALARMS
    assert not text.claims
    assert [sentence.split(" (")[0] for sentence in text.sentences[:3]] == [
        "X and Y are set to different operating points; at equal false alarms, too little data "
        "to tell X and Y apart.",
        f"The numbers are as set, X has {as_set.x:.3g} and Y {as_set.y:.3g} false boxes per frame.",
        "Claims are about X and Y at equal false alarms",
    ]


def test_without_scores_nothing_is_claimed_at_unequal_operating_points():
    text = whole_verdict(at_thresholds(scores=False))
    assert text.headline == Headline("scores")
    (as_set,) = said(text, "Operating points")
    assert as_set.kind == "comparison"
    (split,) = said(text, "Encounters")
    assert (split.kind, split.test) == ("x", None)
    assert text.basis is Basis.NONE
    assert not text.claims


def test_until_the_comparison_at_equal_false_alarms_is_known_nothing_is_claimed():
    result = at_thresholds()
    text = verdict(result, evidence=significance_table(result))
    assert text.headline == Headline("pending")
    assert not text.claims


def test_where_strict_pairing_disagrees_it_is_said_and_nothing_claimed():
    text = whole_verdict(result_of(turned_by_strict_pairing()))
    by_who = {has.system: [of.key for of in has.measured] for has in said(text, "Other measures")}
    assert "mean_similarity" in by_who["y"]
    (strict,) = said(text, "Strict pairing")
    assert ("x", "mean_similarity") in {(of.winner, of.won[0].key) for of in strict.better}
    unclaimed = [fact for fact in said(text, "Chance") if type(fact) is Unclaimed]
    reasons = {named.key: fact.reason for fact in unclaimed for named in fact.measures}
    assert reasons["mean_similarity"] == WithheldReason("strict")
    assert "mean_similarity" not in {claim.key for claim in text.claims}
