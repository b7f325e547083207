"""What a comparison supports, in sentences; their wording is pinned here and nowhere else."""

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


@pytest.fixture(scope="module")
def better_x() -> Result:
    """X detects all of six pedestrians, Y two of them; Y has an episode of three frames."""
    return detecting(6, range(6), range(2), alarms_y=3)


@pytest.fixture(scope="module")
def alike() -> Result:
    return detecting(4, range(4), range(4))


NOT_SHOWN = "These data do not show which system detects more encounters: "


@pytest.mark.parametrize(
    ("scene", "sentence"),
    [
        ((9, range(9), range(3)),
         "X detects every encounter that Y detects, and 6 more of 9 (p = 0.031)."),
        ((9, range(7), range(9)),
         "Y detects every encounter that X detects, and 2 more of 9; so few do not show a "
         "difference beyond chance."),
        ((12, range(11), range(10, 12)),
         "X detects more encounters, but not all that Y detects: of the 11 encounters that only "
         "one system detects, X detects 10 and Y 1 (p = 0.012)."),
        ((9, range(6), range(3, 9)), f"{NOT_SHOWN}of the 6 encounters that only one system "
         "detects, X detects 3 and Y 3 (p = 1)."),
        ((6, range(4), range(2, 6)), f"{NOT_SHOWN}of the 4 encounters that only one system "
         "detects, X detects 2 and Y 2 (too few to test)."),
        ((4, range(3), range(3)),
         "X and Y detect the same 3 of 4 encounters: these data do not tell them apart by whom "
         "they detect."),
        ((0, range(0), range(0)), "There is no encounter near enough to count: these data do not "
         "show which system detects more."),
        # no test of single encounters where these are single frames
        ((9, range(9), range(3), 0, 1),
         "X detects every encounter that Y detects, and 6 more of 9."),
        ((12, range(11), range(10, 12), 0, 1),
         "Of the 11 encounters that only one system detects, X detects 10 and Y 1."),
    ],
    ids=["dominance", "by a few", "uneven split", "even split", "even split of few", "the same",
         "nobody", "dominance in single frames", "split of single frames"],
)  # fmt: skip
def test_who_detects_more_encounters(scene: tuple[int, range, range], sentence: str):
    assert verdict(detecting(*scene))[0] == sentence


def test_the_figures_stand_side_by_side_and_are_not_called_significant(better_x: Result):
    figures = verdict(better_x)[1]
    assert figures.startswith("X has the higher mean similarity (1.000 to 0.")
    assert "X has fewer false-alert episodes (0 to 1 in 2 s)" in figures
    assert figures.endswith("whether these differences are more than chance is not tested.")


def test_figures_that_look_the_same_are_not_called_better_and_undefined_ones_left_out(
    alike: Result,
):
    assert verdict(alike)[1].startswith(
        "Both have the same mean similarity (1.000), both have the same saliency (0.00 s), and "
        "both have the same false-alert episodes (0 in 1 s);"
    )
    assert len(verdict(result_of(make_dataset(n_frames=0)))) == 1


def evidence_of(*rows: tuple[str, float, float, float], unit: str = "recordings") -> pd.DataFrame:
    """Rows of figure, low, high, p_holm."""
    table = pd.DataFrame(rows, columns=["figure", "low", "high", "p_holm"])
    return table.assign(
        n=12, unit=unit, difference=table["low"].fillna(1.0), better="higher", x=1.0, y=2.0
    )


BY_RECORDINGS = "by these 12 recordings, "


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        (
            [("mean_similarity", 0.012, 0.043, 0.012), ("saliency", -1.0, 0.5, 0.6)],
            f"{BY_RECORDINGS}the difference in mean similarity (for X, X - Y 95 % interval "
            "+0.012 to +0.043, p = 0.012) is more than chance; the others are not shown to be.",
        ),
        (
            [("mean_similarity", 0.1, 0.2, 0.01), ("saliency", NAN, NAN, 0.02)],
            f"{BY_RECORDINGS}the differences in mean similarity (for X, X - Y 95 % interval "
            "+0.1 to +0.2, p = 0.01) and saliency per recording (for X, p = 0.02) are more than "
            "chance.",
        ),
        (
            [("mean_similarity", -1.0, 1.0, 0.5), ("saliency", -1.0, 1.0, 0.5)],
            f"{BY_RECORDINGS}none of these differences is shown to be more than chance.",
        ),
        (
            [("mean_similarity", NAN, NAN, NAN)],
            "there are too few data to test these differences for chance.",
        ),
    ],
    ids=["one", "two", "none", "too few"],
)
def test_what_is_beyond_chance(better_x: Result, rows: list[tuple], text: str):
    assert verdict(better_x, evidence=evidence_of(*rows))[1].split("; ", 1)[1] == text


def test_blocks_of_time_say_nothing_of_other_recordings(better_x: Result):
    rows = evidence_of(("mean_similarity", -1.0, 1.0, 0.5), ("saliency", 0, 1, 0.5), unit="blocks")
    text = verdict(better_x, evidence=rows)[1]
    assert "by these 12 blocks of time, which say nothing of other recordings, none" in text


def test_a_difference_is_told_for_whom_it_speaks_with_its_unit_and_no_exponent(better_x: Result):
    rows = evidence_of(
        ("false_alert_episodes_per_hour", -358.2, -1.2e4, 0.01), ("saliency", 0.5, 2.0, 0.01)
    ).assign(better="lower")
    text = verdict(better_x, evidence=rows)[1]
    assert "(for X, X - Y 95 % interval -358 to -12,000 per hour, p = 0.01)" in text
    assert "saliency per recording (for Y, X - Y 95 % interval +0.5 to +2 s, p = 0.01)" in text


@pytest.mark.parametrize(
    ("p", "words"),
    [
        (0.01, "mean similarity (for X, X - Y 95 % interval +0.1 to +0.2, p = 0.01) is more than "),
        (0.4, "the difference in mean similarity is not shown to be more than "),
    ],
)
def test_figures_of_time_are_not_judged_where_encounters_are_single_frames(p: float, words: str):
    rows = evidence_of(("mean_similarity", 0.1, 0.2, p), ("saliency", 1.0, 2.0, 0.001))
    text = verdict(detecting(12, range(10), range(2), n_frames=1), evidence=rows)[1]
    assert f"{words}chance; saliency and episodes mean little here and are not judged." in text
    assert "p = 0.001" not in text


@pytest.mark.parametrize(
    ("scene", "p_holm", "sentence"),
    [
        ((12, range(11), range(10, 12)), 0.04,
         "X detects more encounters, but not all that Y detects: of the 11 encounters that only "
         "one system detects, X detects 10 and Y 1 (p = 0.012; corrected for all measures, "
         "p = 0.04)."),
        ((12, range(11), range(10, 12)), 0.08, f"{NOT_SHOWN}of the 11 encounters that only one "
         "system detects, X detects 10 and Y 1 (p = 0.012; corrected for all measures, p = 0.08)."),
        ((9, range(9), range(3)), 0.2,
         "X detects every encounter that Y detects, and 6 more of 9; that is not shown to be more "
         "than chance (p = 0.031; corrected for all measures, p = 0.2)."),
    ],
)  # fmt: skip
def test_the_claim_goes_by_the_p_that_is_corrected_for_all_measures(
    scene: tuple[int, range, range], p_holm: float, sentence: str
):
    rows = evidence_of(("encounters_detected", -0.1, 0.5, p_holm))
    assert verdict(detecting(*scene), evidence=rows)[0] == sentence


BY_UNIT = "encounters_detected_by_unit"


@pytest.mark.parametrize(
    ("p", "more", "text"),
    [
        (0.01, {}, ""),
        (0.3, {}, " Judged by 12 recordings instead of single encounters, that is not shown to be "
         "more than chance."),
        (NAN, {"unit": "blocks"}, " Judged by 12 blocks of time instead of single encounters, that "
         "cannot be tested: too few of them tell X and Y apart."),
        (NAN, {"unit": "blocks", "n": 1}, " Judged by 1 block of time instead of single "
         "encounters, that cannot be tested: there are too few of them."),
    ],
)  # fmt: skip
def test_encounters_of_few_recordings_are_doubted(p: float, more: dict[str, object], text: str):
    result = detecting(12, range(10), range(2))
    assert result.exclusivity.mcnemar_p < 0.05
    rows = evidence_of((BY_UNIT, -0.1, 0.5, p)).assign(**more)
    assert verdict(result, evidence=rows)[0] == verdict(result)[0] + text


@pytest.mark.parametrize(
    ("p", "words"),
    [(0.01, "is more than chance (p = 0.01)"), (0.3, "is not shown to be more than chance")],
)
def test_encounters_of_one_frame_are_judged_by_recordings_alone(p: float, words: str):
    rows = evidence_of((BY_UNIT, -0.1, 0.5, p))
    first = verdict(detecting(12, range(10), range(10, 12), n_frames=1), evidence=rows)[0]
    assert first == (
        "Of the 12 encounters that only one system detects, X detects 10 and Y 2. Judged by 12 "
        f"recordings instead of single encounters, that {words}."
    )


def finding(code: str, severity: Severity = Severity.WARNING) -> Finding:
    return Finding(severity, code, "truth", 1, "Odd.", "Look.")


def test_the_verdict_says_which_findings_it_depends_on(alike: Result):
    grave = [finding("mixed-weighting"), finding("mixed-weighting"), finding("ids-odd")]
    assert verdict(alike, grave)[-1] == (
        "This depends on what the audit found: X and Y are weighted by different rules; 1 other "
        "finding that it lists."
    )
    assert verdict(alike, [finding("mixed-weighting", Severity.NOTE)]) == verdict(alike)


def test_every_caveat_is_about_a_finding_that_the_audit_has():
    audit = ROOT / "nvcore" / "auditing"
    source = "".join(path.read_text(encoding="utf-8") for path in audit.glob("*.py"))
    assert [code for code in CAVEATS if f'"{code}"' not in source] == []


def test_equal_boxes_are_no_comparison(better_x: Result):
    assert verdict(better_x, [finding("same-boxes")])[0] == (
        "Two of the inputs have the same boxes: this is no comparison of two systems."
    )


def test_systems_whose_every_detection_counts_are_told(alike: Result):
    assert "Every detection of X and Y counts, however low its score." in verdict(alike)
    limited = result_of(alike.dataset, threshold_x=0.5)
    assert "Every detection of Y counts, however low its score." in verdict(limited)
