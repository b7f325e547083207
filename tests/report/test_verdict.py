"""What a comparison supports, in sentences."""

from __future__ import annotations

import pandas as pd
import pytest
from builders import NAN, Box, at, make_dataset, result_of
from places import ROOT

from nvcore.comparison import Result
from nvcore.findings import Finding, Severity
from nvcore.report.verdict import CAVEATS, verdict

N_FRAMES = 3


def detecting(
    n: int, by_x: range, by_y: range, alarms_y: int = 0, n_frames: int = N_FRAMES
) -> Result:
    """`n` pedestrians, each alone in `n_frames` frames; each system sees some of them."""

    def boxes(whom: range, **columns: float) -> list[Box]:
        return [
            at(n_frames * i + f, 50, **(columns or {"track": i}))
            for i in whom
            for f in range(n_frames)
        ]

    y = boxes(by_y, score=1.0) + [at(f, 5, score=1.0) for f in range(alarms_y)]
    dataset = make_dataset(boxes(range(n)), boxes(by_x, score=1.0), y, n_frames=n_frames * n)
    return result_of(dataset)


def encounters(result: Result) -> str:
    return verdict(result)[0]


def test_dominance_beyond_chance_is_told_with_its_p():
    assert encounters(detecting(9, range(9), range(3))) == (
        "X detects every encounter that Y detects, and 6 more of 9 (p = 0.031)."
    )


def test_dominance_by_a_few_is_told_to_be_possible_by_chance():
    assert encounters(detecting(9, range(7), range(9))) == (
        "Y detects every encounter that X detects, and 2 more of 9; so few do not show a "
        "difference beyond chance."
    )


def test_an_uneven_split_beyond_chance_names_the_better_without_dominance():
    assert encounters(detecting(12, range(11), range(10, 12))) == (
        "X detects more encounters, but not all that Y detects: of the 11 encounters that only "
        "one system detects, X detects 10 and Y 1 (p = 0.012)."
    )


def test_an_even_split_of_enough_encounters_has_its_p():
    assert encounters(detecting(9, range(6), range(3, 9))).endswith("X detects 3 and Y 3 (p = 1).")


def test_an_even_split_of_few_shows_no_difference_and_has_no_p():
    assert encounters(detecting(6, range(4), range(2, 6))) == (
        "These data do not show which system detects more encounters: of the 4 encounters that "
        "only one system detects, X detects 2 and Y 2 (too few to test)."
    )


def test_the_same_encounters_are_told_with_their_number():
    assert encounters(detecting(4, range(3), range(3))) == (
        "X and Y detect the same 3 of 4 encounters: these data do not tell them apart by whom "
        "they detect."
    )


def test_without_an_encounter_nothing_is_claimed():
    result = result_of(make_dataset(n_frames=3))
    assert encounters(result).startswith("There is no encounter near enough to count")


def test_the_figures_stand_side_by_side_and_are_not_called_significant():
    result = detecting(6, range(6), range(2), alarms_y=3)
    figures = verdict(result)[1]
    assert figures.startswith("X has the higher mean similarity (1.000 to 0.")
    assert "X has fewer false-alert episodes (0 to 1 in 2 s)" in figures
    assert figures.endswith("whether these differences are more than chance is not tested.")


def evidence_of(*rows: tuple[str, float, float, float], unit: str = "recordings") -> pd.DataFrame:
    """Rows of figure, low, high, p_holm."""
    table = pd.DataFrame(rows, columns=["figure", "low", "high", "p_holm"])
    return table.assign(
        n=12, unit=unit, difference=table["low"].fillna(1.0), better="higher", x=1.0, y=2.0
    )


def chance(*rows: tuple[str, float, float, float], **more: str) -> str:
    told = verdict(detecting(6, range(6), range(2)), evidence=evidence_of(*rows, **more))[1]
    return told.split("; ", 1)[1]


def test_what_is_beyond_chance_is_told_with_its_interval_and_what_is_not():
    rows = [("mean_similarity", 0.012, 0.043, 0.012), ("saliency", -1.0, 0.5, 0.6)]
    assert chance(*rows) == (
        "by these 12 recordings, the difference in mean similarity (for X, X - Y 95 % interval "
        "+0.012 to +0.043, p = 0.012) is more than chance; the others are not shown to be."
    )


def test_several_differences_beyond_chance_are_listed():
    rows = [("mean_similarity", 0.1, 0.2, 0.01), ("saliency", NAN, NAN, 0.02)]
    assert chance(*rows) == (
        "by these 12 recordings, the differences in mean similarity (for X, X - Y 95 % interval "
        "+0.1 to +0.2, p = 0.01) and saliency per recording (for X, p = 0.02) are more than chance."
    )


def test_a_difference_is_told_for_whom_it_speaks():
    rows = evidence_of(("saliency", -0.9, -0.2, 0.01)).assign(better="lower")
    assert (
        "saliency per recording (for X, "
        in verdict(detecting(6, range(6), range(2)), evidence=rows)[1]
    )


def test_intervals_have_their_unit_and_no_exponent():
    rows = [("false_alert_episodes_per_hour", -358.2, -1.2e4, 0.01), ("saliency", 0.5, 2.0, 0.01)]
    told = chance(*rows)
    assert "X - Y 95 % interval -358 to -12,000 per hour, p = 0.01" in told
    assert "X - Y 95 % interval +0.5 to +2 s, p = 0.01" in told


@pytest.mark.parametrize(
    ("p", "words"),
    [
        (0.01, "mean similarity (for X, X - Y 95 % interval +0.1 to +0.2, p = 0.01) is more than "),
        (0.4, "the difference in mean similarity is not shown to be more than "),
    ],
)
def test_figures_of_time_are_not_judged_where_encounters_are_single_frames(p: float, words: str):
    rows = evidence_of(("mean_similarity", 0.1, 0.2, p), ("saliency", 1.0, 2.0, 0.001))
    told = verdict(detecting(12, range(10), range(2), n_frames=1), evidence=rows)[1]
    assert f"{words}chance; saliency and episodes mean little here and are not judged." in told
    assert "p = 0.001" not in told


def test_encounters_that_cannot_be_tested_by_units_are_said_to_be_so():
    rows = evidence_of(("encounters_detected_by_unit", 0.05, 0.5, NAN), unit="blocks")
    assert verdict(detecting(12, range(10), range(2)), evidence=rows)[0].endswith(
        "Judged by 12 blocks of time instead of single encounters, that cannot be tested: too few "
        "of them tell X and Y apart."
    )
    assert verdict(detecting(12, range(10), range(2)), evidence=rows.assign(n=1))[0].endswith(
        "Judged by 1 block of time instead of single encounters, that cannot be tested: there are "
        "too few of them."
    )


def with_corrected(p_holm: float, result: Result) -> str:
    return verdict(result, evidence=evidence_of(("encounters_detected", -0.1, 0.5, p_holm)))[0]


def test_the_claim_goes_by_the_p_that_is_corrected_for_all_figures():
    split = detecting(12, range(11), range(10, 12))
    assert with_corrected(0.04, split).startswith("X detects more encounters")
    assert with_corrected(0.08, split) == (
        "These data do not show which system detects more encounters: of the 11 encounters that "
        "only one system detects, X detects 10 and Y 1 (p = 0.012, corrected for all figures 0.08)."
    )
    assert with_corrected(0.2, detecting(9, range(9), range(3))) == (
        "X detects every encounter that Y detects, and 6 more of 9; that is not shown to be more "
        "than chance (p = 0.031, corrected for all figures 0.2)."
    )


@pytest.mark.parametrize(("p", "is_doubted"), [(0.01, False), (0.3, True), (NAN, True)])
def test_encounters_of_few_recordings_are_doubted(p: float, is_doubted: bool):
    result = detecting(12, range(10), range(2))
    assert result.exclusivity.mcnemar_p < 0.05
    rows = evidence_of(("encounters_detected_by_unit", -0.1, 0.5, p))
    first = verdict(result, evidence=rows)[0]
    assert first.startswith(verdict(result)[0])
    assert ("Judged by 12 recordings instead" in first) == is_doubted


@pytest.mark.parametrize(
    ("p", "words"),
    [(0.01, "is more than chance (p = 0.01)"), (0.3, "is not shown to be more than chance")],
)
def test_encounters_of_one_frame_are_judged_by_recordings_alone(p: float, words: str):
    rows = evidence_of(("encounters_detected_by_unit", -0.1, 0.5, p))
    first = verdict(detecting(12, range(10), range(10, 12), n_frames=1), evidence=rows)[0]
    assert first == (
        "Of the 12 encounters that only one system detects, X detects 10 and Y 2. Judged by 12 "
        f"recordings instead of single encounters, that {words}."
    )


def test_blocks_of_time_say_nothing_of_other_recordings():
    rows = [("mean_similarity", -1.0, 1.0, 0.5), ("saliency", -1.0, 1.0, 0.5)]
    assert chance(*rows, unit="blocks") == (
        "by these 12 blocks of time, which say nothing of other recordings, none of these "
        "differences is shown to be more than chance."
    )


def test_too_little_to_test_is_said():
    assert chance(("mean_similarity", NAN, NAN, NAN)) == (
        "there are too few data to test these differences for chance."
    )


def test_figures_that_look_the_same_are_not_called_better():
    figures = verdict(detecting(4, range(4), range(4)))[1]
    assert figures.startswith(
        "Both have the same mean similarity (1.000), both have the same saliency (0.00 s), and "
        "both have the same false-alert episodes (0 in 1 s);"
    )


def test_an_undefined_figure_is_left_out():
    figures = verdict(result_of(make_dataset(n_frames=0)))[1]
    assert figures.startswith("Both have the same saliency (0.00 s);")


def finding(code: str, severity: Severity = Severity.WARNING) -> Finding:
    return Finding(severity, code, "truth", 1, "Odd.", "Look.")


def test_the_verdict_says_which_findings_it_depends_on():
    result = detecting(4, range(4), range(4))
    grave = [finding("mixed-weighting"), finding("mixed-weighting"), finding("ids-odd")]
    assert verdict(result, grave)[-1] == (
        "This depends on what the audit found: X and Y are weighted by different rules; 1 other "
        "finding that it lists."
    )


def test_notes_of_the_audit_are_no_caveat():
    result = detecting(4, range(4), range(4))
    assert verdict(result, [finding("mixed-weighting", Severity.NOTE)]) == verdict(result)


def test_every_caveat_is_about_a_finding_that_the_audit_has():
    audit = ROOT / "nvcore" / "auditing"
    source = "".join(path.read_text(encoding="utf-8") for path in audit.glob("*.py"))
    assert [code for code in CAVEATS if f'"{code}"' not in source] == []


def test_equal_boxes_are_no_comparison():
    result = detecting(9, range(9), range(3))
    assert verdict(result, [finding("same-boxes")])[0] == (
        "Two of the inputs have the same boxes: this is no comparison of two systems."
    )


def test_no_p_is_given_where_encounters_are_single_frames():
    assert encounters(detecting(9, range(9), range(3), n_frames=1)) == (
        "X detects every encounter that Y detects, and 6 more of 9."
    )
    assert encounters(detecting(12, range(11), range(10, 12), n_frames=1)) == (
        "Of the 11 encounters that only one system detects, X detects 10 and Y 1."
    )


def test_systems_whose_every_detection_counts_are_told():
    assert "Every detection of X and Y counts, however low its score." in verdict(
        detecting(4, range(4), range(4))
    )


def test_a_threshold_ends_that_remark():
    result = detecting(4, range(4), range(4))
    both = result_of(result.dataset, threshold_x=0.5, threshold_y=0.5)
    assert not [one for one in verdict(both) if one.startswith("Every detection")]


def test_saliency_that_speaks_both_ways_is_told_with_both_figures():
    result = detecting(6, range(6), range(2))
    assert result.x.saliency_s < result.y.saliency_s
    other = evidence_of(("saliency", 0.1, 0.5, 0.3)).assign(x=1.75, y=1.374, difference=0.376)
    figures = verdict(result, evidence=other)[1]
    assert " s), but Y in the mean over recordings (1.37 to 1.75 s)" in figures
    same = other.assign(difference=-0.376)
    assert "mean over recordings" not in verdict(result, evidence=same)[1]
