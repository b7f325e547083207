"""What a verdict supports at unequal operating points, and where strict pairing disagrees."""

from __future__ import annotations

from dataclasses import replace

from builders import result_of
from drives import at_thresholds, turned_by_strict_pairing
from verdict_scenes import topic, whole_verdict

from nvcore.evidence.claims import Basis
from nvcore.evidence.companions import find_companions
from nvcore.evidence.measures import significance_table
from nvcore.report.verdict import verdict

UNEQUAL = "X and Y are set to different operating points: "


def test_unequal_operating_points_lead_and_the_comparison_is_at_equal_false_alarms():
    result = at_thresholds()
    assert result.venn.x_only > result.venn.y_only
    text = whole_verdict(result)
    assert text.headline.startswith(
        "X and Y are set to different operating points; at equal false alarms, nothing is claimed: "
    )
    as_set, at_equal = text.points[0].sentences
    assert as_set.startswith("As set, X has 0.")
    # X at Y's operating point is Y
    assert at_equal.startswith("What follows is at equal false alarms (X with scores of 0.")
    assert at_equal.endswith("nothing is claimed from the comparison as set.")
    assert topic(text, "Encounters").startswith("X and Y detect the same")
    assert text.basis is Basis.EQUAL_ALARMS
    assert not text.claims


def test_without_scores_nothing_is_claimed_at_unequal_operating_points():
    text = whole_verdict(at_thresholds(scores=False))
    assert text.headline == (
        f"{UNEQUAL}nothing is claimed, as without scores they cannot be set alike."
    )
    assert text.points[0].sentences[1] == "What follows is as set."
    assert topic(text, "Encounters").startswith("X detects every encounter")
    assert "p =" not in " ".join(text.sentences)
    assert text.basis is Basis.NONE
    assert not text.claims


def test_until_the_comparison_at_equal_false_alarms_is_known_nothing_is_claimed():
    result = at_thresholds()
    text = verdict(result, evidence=significance_table(result))
    assert text.headline == (
        f"{UNEQUAL}nothing is claimed before they are compared at equal false alarms."
    )
    assert not text.claims


def test_the_p_beside_a_comparison_at_equal_false_alarms_is_the_larger_of_both_ends():
    result = at_thresholds()
    companions = find_companions(result, significance_table(result))
    first = companions.evidence[0]
    ends = [first.assign(p_holm=p) for p in (0.2, 0.6)]
    both = replace(companions, evidence=tuple(ends))
    assert (both.weaker_evidence["p_holm"] == 0.6).all()


def test_where_strict_pairing_disagrees_it_is_said_and_nothing_claimed():
    text = whole_verdict(result_of(turned_by_strict_pairing()))
    assert "Y has the higher mean similarity" in topic(text, "Other measures")
    assert topic(text, "Strict pairing").startswith(
        "Paired strictly, so that false alarms cannot stand in for matches, it is the other way "
        "round: X is better in mean similarity (X 0."
    )
    assert "Not claimed: mean similarity" in topic(text, "Chance")
    assert "mean_similarity" not in {claim.key for claim in text.claims}
