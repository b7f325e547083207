"""What a comparison supports, in sentences; their wording is pinned here and nowhere else."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Box, Place, at, make_dataset, result_of
from places import ROOT

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.measures import significance_table
from nvcore.findings import Finding, Severity
from nvcore.report.verdict import CAVEATS, Verdict, verdict

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


def row_of(
    figure: str,
    p_holm: float,
    low: float = NAN,
    high: float = NAN,
    *,
    difference: float = 1.0,
    better: str = "higher",
    unit: str = "recordings",
    n: int = 12,
    doubt: str = "",
) -> dict[str, object]:
    """A row of the table of evidence."""
    return {
        "figure": figure, "p_holm": p_holm, "low": low, "high": high, "x": 1.0, "y": 2.0,
        "difference": difference, "better": better, "unit": unit, "n": n, "doubt": doubt,
        "least_p": 2 / 2**n,
    }  # fmt: skip


BY_UNIT = "encounters_detected_by_unit"


def judged(result: Result, *rows: dict[str, object], companions: bool = True) -> Verdict:
    """The verdict by this evidence, which holds at equal false alarms as well."""
    table = pd.DataFrame([row_of(BY_UNIT, NAN), *rows])
    table = table.drop_duplicates("figure", keep="last").reset_index(drop=True)
    both = Companions(result, "", (table,), result) if companions else None
    return verdict(result, evidence=table, companions=both)


def encounters_sentence(text: Verdict) -> str:
    return text.sentences[0]


def side_by_side(text: Verdict) -> str:
    return next(sentence for sentence in text.sentences if "mean similarity (" in sentence)


SPLIT = "of the 11 encounters that only one system detects, X detects 10 and Y 1"
NOT_SHOWN = "These data do not show which system detects more encounters: "


@pytest.mark.parametrize(
    ("scene", "p", "sentence"),
    [
        ((9, range(9), range(3)), 0.031,
         "X detects every encounter that Y detects, and 6 more of 9 (by 12 recordings, "
         "p = 0.031)."),
        ((9, range(9), range(3)), 0.2,
         "X detects every encounter that Y detects, and 6 more of 9; that is not shown to be more "
         "than chance (by 12 recordings, p = 0.2)."),
        ((12, range(11), range(10, 12)), 0.012,
         "X detects more encounters, but not all that Y detects: of the 11 encounters that only "
         "one system detects, X detects 10 and Y 1 (by 12 recordings, p = 0.012)."),
        ((12, range(11), range(10, 12)), 0.3, f"{NOT_SHOWN}{SPLIT} (by 12 recordings, p = 0.3)."),
        ((12, range(11), range(10, 12)), NAN,
         f"{NOT_SHOWN}{SPLIT} (too few recordings tell the two apart to test it)."),
        ((4, range(3), range(3)), NAN,
         "X and Y detect the same 3 of 4 encounters: these data do not tell them apart by whom "
         "they detect."),
        ((0, range(0), range(0)), NAN, "There is no encounter near enough to count: these data do "
         "not show which system detects more."),
    ],
    ids=["dominance", "dominance by chance", "uneven split", "even split", "untested", "the same",
         "nobody"],
)  # fmt: skip
def test_who_detects_more_encounters(scene: tuple[int, range, range], p: float, sentence: str):
    text = judged(detecting(*scene), row_of(BY_UNIT, p))
    assert encounters_sentence(text) == sentence
    assert [claim.key for claim in text.claims] == ([BY_UNIT] if p <= 0.05 else [])


@pytest.mark.parametrize("scene", [(12, range(11), range(10, 12)), (9, range(9), range(3))])
def test_few_recordings_say_nothing_of_others(scene: tuple[int, range, range]):
    result = detecting(*scene)
    assert result.exclusivity.mcnemar_p < 0.05
    evidence = significance_table(result)
    text = verdict(result, evidence=evidence, companions=find_companions(result, evidence))
    first = encounters_sentence(text)
    assert first.startswith(("Of the 11 encounters ", "X detects every encounter that Y detects"))
    assert "one recording does not show whether others would agree (6 are needed)" in first
    assert "so few recordings do not show whether these differences are more than chance" in (
        side_by_side(text)
    )
    assert not text.claims
    assert "is more than chance" not in " ".join(text.sentences)


def test_what_is_not_tested_says_so(better_x: Result):
    text = verdict(better_x)
    assert encounters_sentence(text).endswith("; whether that is more than chance is not tested.")
    assert side_by_side(text).endswith(
        "whether these differences are more than chance is not tested."
    )
    assert not text.claims


def test_nothing_is_claimed_before_the_companions_are_known(better_x: Result):
    rows = row_of(BY_UNIT, 0.01), row_of("mean_similarity", 0.01)
    text = judged(better_x, *rows, companions=False)
    assert not text.claims
    assert "(whether it holds at equal false alarms is not known yet)" in encounters_sentence(text)
    assert "as for mean similarity, whether it holds at equal false alarms is not known yet" in (
        side_by_side(text)
    )


def test_what_failures_weigh_and_the_worst_of_them(better_x: Result):
    # proximity "none": 0.1 s of each frame in full; four pedestrians of three frames
    assert judged(better_x).sentences[1] == (
        "The 4 that only X detects weigh 1.2 s of missed pedestrian; the worst single failure is "
        "Y's: pedestrian 2 in r0, 0.3 s."
    )
    both_ways = judged(detecting(9, range(6), range(3, 9))).sentences[1]
    assert both_ways.startswith(
        "The 3 that only X detects weigh 0.9 s of missed pedestrian, the 3 that only Y detects "
        "0.9 s; the worst single failure is"
    )


def test_the_measures_stand_side_by_side(better_x: Result):
    text = side_by_side(judged(better_x, row_of("log_average_miss_rate", NAN)))
    assert text.startswith("X has the higher mean similarity (1.000 to 0.")
    assert "X has the lower severity per encounter (0.00 to 0.20 s)" in text
    assert "X has fewer false-alert episodes (0 to 1 in 2 s)" in text
    assert "X has the lower log-average miss rate (100.0% to 200.0%)" in text


def test_measures_that_look_the_same_are_not_called_better_and_undefined_ones_left_out(
    alike: Result,
):
    assert side_by_side(judged(alike)).startswith(
        "Both have the same mean similarity (1.000), both have the same severity per encounter "
        "(0.00 s), both have the same saliency (0.00 s), and both have the same false-alert "
        "episodes (0 in 1 s);"
    )


BY_RECORDINGS = "by these 12 recordings, "


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        (
            [row_of("mean_similarity", 0.012, 0.012, 0.043), row_of("saliency", 0.6, -1.0, 0.5)],
            f"{BY_RECORDINGS}the difference in mean similarity (for X, X - Y 95 % interval "
            "+0.012 to +0.043, p = 0.012) is more than chance; the others are not shown to be.",
        ),
        (
            [row_of("mean_similarity", 0.01, 0.1, 0.2), row_of("saliency", 0.02)],
            f"{BY_RECORDINGS}the differences in mean similarity (for X, X - Y 95 % interval "
            "+0.1 to +0.2, p = 0.01) and saliency per recording (for X, p = 0.02) are more than "
            "chance.",
        ),
        (
            [row_of("mean_similarity", 0.5), row_of("saliency", 0.5)],
            f"{BY_RECORDINGS}none of these differences is shown to be more than chance.",
        ),
        ([row_of("mean_similarity", NAN)],
         "there are too few data to test these differences for chance."),
        ([row_of("mean_similarity", 0.01, doubt="X ends early"), row_of("saliency", 0.5)],
         f"{BY_RECORDINGS}none of these differences is shown to be more than chance."),
    ],
    ids=["one", "two", "none", "too few", "doubtful"],
)  # fmt: skip
def test_what_is_beyond_chance(better_x: Result, rows: list[dict], text: str):
    assert side_by_side(judged(better_x, *rows)).split("; ", 1)[1] == text


def test_a_difference_is_told_for_whom_it_speaks_with_its_unit_and_no_exponent(better_x: Result):
    episodes = row_of("false_alert_episodes_per_hour", 0.01, -358.2, -1.2e4, better="lower")
    saliency = row_of("saliency", 0.01, 0.5, 2.0, better="lower")
    text = side_by_side(judged(better_x, episodes | {"difference": -1.0}, saliency))
    assert "(for X, X - Y 95 % interval -358 to -12,000 per hour, p = 0.01)" in text
    assert "saliency per recording (for Y, X - Y 95 % interval +0.5 to +2 s, p = 0.01)" in text


@pytest.mark.parametrize(
    ("p", "words"),
    [
        (0.01, "mean similarity (for X, X - Y 95 % interval +0.1 to +0.2, p = 0.01) is more than "),
        (0.4, "the difference in mean similarity is not shown to be more than "),
    ],
)
def test_measures_of_time_are_not_judged_where_encounters_are_single_frames(p: float, words: str):
    rows = row_of("mean_similarity", p, 0.1, 0.2), row_of("saliency", 0.001, 1.0, 2.0)
    result = detecting(12, range(10), range(2), n_frames=1)
    text = judged(result, *rows)
    more = f"{words}chance; saliency, severity and episodes mean little here and are not judged."
    assert more in side_by_side(text)
    assert "p = 0.001" not in " ".join(text.sentences)
    assert "saliency" not in {claim.key for claim in text.claims}


def test_too_few_recordings_for_any_claim_say_so(better_x: Result):
    keys = (BY_UNIT, "mean_similarity", "share_low", "severity_s_per_encounter", "saliency",
            "false_alert_episodes_per_hour", "log_average_miss_rate")  # fmt: skip
    eight = judged(better_x, *(row_of(key, 0.055, n=8) for key in keys))
    assert (
        "With 8 recordings and 7 measures no difference can be shown to be more than chance, "
        "however large: the least p is 0.055 after correction."
    ) in eight.sentences
    nine = judged(better_x, *(row_of(key, 0.055, n=9) for key in keys))
    assert not any("no difference can be shown" in sentence for sentence in nine.sentences)


# operating points


def at_thresholds(scores: bool = True, n: int = 8) -> Result:
    """One detector twice: X with all its boxes, Y with those of a score of 0.5 or more."""
    rng = np.random.default_rng(5)
    truth, boxes = [], []
    for number in range(n):
        for frame in range(20):
            for track, centre in enumerate((20, 40, 60, 80)):
                truth.append(at(frame, centre, track=track, recording=number))
                if rng.random() < 0.9:
                    boxes.append(at(frame, centre, recording=number, score=rng.random()))
            if rng.random() < 0.5:
                boxes.append(at(frame, 5, recording=number, score=0.6 * rng.random()))
    strict = [box for box in boxes if box.score >= 0.5]
    if not scores:
        boxes, strict = ([box._replace(score=NAN) for box in some] for some in (boxes, strict))
    return result_of(make_dataset(truth, boxes, strict, places=[Place(range(20))] * n))


def whole_verdict(result: Result) -> Verdict:
    evidence = significance_table(result)
    return verdict(result, evidence=evidence, companions=find_companions(result, evidence))


def test_unequal_operating_points_lead_and_the_comparison_is_at_equal_false_alarms():
    result = at_thresholds()
    assert result.venn.x_only > result.venn.y_only
    text = whole_verdict(result)
    assert text.sentences[0].startswith("X and Y are set to different operating points (0.")
    assert text.sentences[0].endswith("nothing is claimed from the comparison as set.")
    # X at Y's operating point is Y
    assert text.sentences[1].startswith("At equal false alarms (X with scores of 0.")
    assert "X and Y detect the same" in text.sentences[1]
    assert text.basis is Basis.EQUAL_ALARMS
    assert not text.claims


def test_without_scores_nothing_is_claimed_at_unequal_operating_points():
    text = whole_verdict(at_thresholds(scores=False))
    assert "without scores they cannot be set alike: nothing is claimed." in text.sentences[0]
    assert text.sentences[1].startswith("As set, X detects every encounter")
    assert text.basis is Basis.NONE
    assert not text.claims


def test_until_the_comparison_at_equal_false_alarms_is_known_nothing_is_claimed():
    result = at_thresholds()
    text = verdict(result, evidence=significance_table(result))
    assert text.sentences[0].endswith(
        "nothing is claimed before they are compared at equal false alarms."
    )
    assert not text.claims


def test_where_strict_pairing_disagrees_it_is_said_and_nothing_claimed():
    # Y misses the pedestrian and has a false alarm beside him, X finds him a little off
    truth, x, y = [], [], []
    for number in range(12):
        for frame in range(4):
            truth.append(at(frame, 50, track=1, recording=number))
            x.append(at(frame, 50 if frame else 46, recording=number, score=0.9))
            y.append(at(frame, 52, w=3, recording=number, score=0.9))
    dataset = make_dataset(truth, x, y, places=[Place(range(4))] * 12)
    result = result_of(dataset)
    text = whole_verdict(result)
    strict = find_companions(result, significance_table(result)).strict
    assert result.x.summary.mean < result.y.summary.mean or strict is not None
    if strict.x.summary.mean > strict.y.summary.mean:
        assert any(sentence.startswith("Paired strictly") for sentence in text.sentences)
    assert "mean_similarity" not in {claim.key for claim in text.claims if claim.winner == "y"}


# the audit


def finding(code: str, severity: Severity = Severity.WARNING) -> Finding:
    return Finding(severity, code, "truth", 1, "Odd.", "Look.")


def test_the_verdict_says_which_findings_it_depends_on(alike: Result):
    grave = [finding("mixed-weighting"), finding("mixed-weighting"), finding("ids-odd")]
    text = verdict(alike, grave)
    assert text.caveat == text.sentences[-1]
    assert text.caveat == (
        "This depends on what the audit found: X and Y are weighted by different rules; 1 other "
        "finding that it lists."
    )
    assert verdict(alike, [finding("mixed-weighting", Severity.NOTE)]) == verdict(alike)


def test_every_caveat_is_about_a_finding_that_the_audit_has():
    audit = ROOT / "nvcore" / "auditing"
    source = "".join(path.read_text(encoding="utf-8") for path in audit.glob("*.py"))
    assert [code for code in CAVEATS if f'"{code}"' not in source] == []


def test_equal_boxes_are_no_comparison(better_x: Result):
    text = verdict(better_x, [finding("same-boxes")])
    assert text.sentences[0] == (
        "Two of the inputs have the same boxes: this is no comparison of two systems."
    )
    assert not text.claims


def test_systems_whose_every_detection_counts_are_told(alike: Result):
    assert "Every detection of X and Y counts, however low its score." in verdict(alike).sentences
    limited = result_of(alike.dataset, threshold_x=0.5)
    assert "Every detection of Y counts, however low its score." in verdict(limited).sentences
