"""What a comparison supports, by topic; the wording is pinned here and nowhere else."""

from __future__ import annotations

import pandas as pd
import pytest
from builders import NAN, Place, at, make_dataset, result_of
from places import ROOT
from verdict_scenes import BY_UNIT, detecting, row_of, topic, verdict_by, whole_verdict

from nvcore.comparison import Result
from nvcore.evidence.companions import Companions
from nvcore.evidence.operating_points import EqualAlarms
from nvcore.findings import Finding, Severity
from nvcore.report.verdict import CAVEATS, verdict


@pytest.fixture(scope="module")
def better_x() -> Result:
    """X detects all of six pedestrians, Y two of them; Y has an episode of three frames."""
    return detecting(6, range(6), range(2), alarms_y=3)


@pytest.fixture(scope="module")
def alike() -> Result:
    return detecting(4, range(4), range(4))


SPLIT = "Of the 11 encounters that only one system detects, X detects 10 and Y 1"
DOMINANCE = "X detects every encounter that Y detects, and 6 more of 9"
NO_DIFFERENCE = (
    "Nothing is claimed: by 12 recordings, no difference is shown to be more than chance."
)
BETTER = (
    "X is better in encounters detected (100.0% to 200.0%): more than chance, by 12 recordings."
)
TOO_FEW = "Nothing is claimed: there are too few data to test a difference."


@pytest.mark.parametrize(
    ("scene", "p", "headline", "sentence"),
    [
        ((9, range(9), range(3)), 0.031, BETTER, f"{DOMINANCE} (by 12 recordings, p = 0.031)."),
        ((9, range(9), range(3)), 0.2, NO_DIFFERENCE,
         f"{DOMINANCE} (by 12 recordings, p = 0.2)."),
        ((12, range(11), range(10, 12)), 0.012, BETTER, f"{SPLIT} (by 12 recordings, p = 0.012)."),
        ((12, range(11), range(10, 12)), 0.3, NO_DIFFERENCE,
         f"{SPLIT} (by 12 recordings, p = 0.3)."),
        ((12, range(11), range(10, 12)), NAN, TOO_FEW,
         f"{SPLIT} (too few recordings tell the two apart to test it)."),
        ((4, range(3), range(3)), NAN, TOO_FEW, "X and Y detect the same 3 of 4 encounters."),
        ((0, range(0), range(0)), NAN, TOO_FEW, "There is no encounter near enough to count."),
    ],
    ids=["dominance", "dominance by chance", "uneven split", "even split", "untested", "the same",
         "nobody"],
)  # fmt: skip
def test_who_detects_more_encounters(
    scene: tuple[int, range, range], p: float, headline: str, sentence: str
):
    text = verdict_by(detecting(*scene), row_of(BY_UNIT, p))
    assert text.headline == headline
    assert topic(text, "Encounters") == sentence
    assert [claim.key for claim in text.claims] == ([BY_UNIT] if p <= 0.05 else [])


def test_p_stands_by_itself_and_corrected(better_x: Result):
    text = verdict_by(better_x, row_of(BY_UNIT, 1.0) | {"p": 0.18}, row_of("mean_similarity", 1.0))
    assert topic(text, "Encounters").endswith(
        "(by 12 recordings, p = 0.18; 1 after correction for 2 tests)."
    )


@pytest.mark.parametrize("scene", [(12, range(11), range(10, 12)), (9, range(9), range(3))])
def test_few_recordings_say_nothing_of_others(scene: tuple[int, range, range]):
    result = detecting(*scene)
    assert result.exclusivity.mcnemar_p < 0.05
    text = whole_verdict(result)
    assert text.headline == (
        "Nothing is claimed: one recording does not show what others would (6 are needed)."
    )
    assert topic(text, "Encounters") in (f"{SPLIT}.", f"{DOMINANCE}.")
    assert not text.claims
    assert not topic(text, "Chance")


def test_what_is_not_tested_says_so(better_x: Result):
    text = verdict(better_x)
    assert text.headline == "Nothing is claimed: the differences are not tested."
    assert not text.claims


def test_nothing_is_claimed_before_the_companions_are_known(better_x: Result):
    rows = row_of(BY_UNIT, 0.01), row_of("mean_similarity", 0.01)
    text = verdict_by(better_x, *rows, companions=False)
    assert not text.claims
    assert text.headline == (
        "Nothing is claimed before X and Y are compared at equal false alarms."
    )
    assert topic(text, "Chance") == (
        "Not claimed: encounters detected and mean similarity (not yet compared at equal false "
        "alarms)."
    )
    assert "p =" not in topic(text, "Encounters")  # it is withheld


def test_what_failures_weigh_and_the_worst_of_them(better_x: Result):
    # proximity "none": 0.1 s of each frame in full; four pedestrians of three frames
    assert topic(verdict_by(better_x), "Severity") == (
        "The 4 that only X detects weigh 1.2 s of missed pedestrian. The worst single failure is "
        "Y's: pedestrian 2 in r0, 0.3 s."
    )
    both_ways = topic(verdict_by(detecting(9, range(6), range(3, 9))), "Severity")
    assert both_ways.startswith(
        "The 3 that only X detects weigh 0.9 s of missed pedestrian, the 3 that only Y detects "
        "0.9 s. The worst single failure is"
    )
    assert topic(verdict_by(detecting(3, range(1), range(0))), "Severity").startswith(
        "The 1 that only X detects weighs 0.3 s of missed pedestrian. "
    )


def test_the_measures_stand_side_by_side(better_x: Result):
    text = topic(verdict_by(better_x, row_of("log_average_miss_rate", NAN)), "Other measures")
    assert text.startswith("X has the higher mean similarity (1.000 to 0.")
    assert ", the lower severity per encounter (0.00 to 0.20 s), the lower saliency (" in text
    assert text.endswith(
        "fewer false-alert episodes (0 to 1 in 2 s) and the lower log-average miss rate (100.0% "
        "to 200.0%)."
    )


def test_episodes_of_sampled_frames_are_said_to_be_of_these():
    frames = range(0, 120, 10)
    truth = [at(frame, 50, track=1) for frame in frames]
    y = [*truth, at(0, 10)]
    result = result_of(make_dataset(truth, truth, y, places=[Place(frames)]))
    text = topic(verdict_by(result), "Other measures")
    assert "fewer false-alert episodes (0 to 1 in 12 s, every 10th frame)" in text


@pytest.mark.parametrize(("n_far", "words"), [(30, "0% of X's and 45% of Y's"), (5, "")])
def test_saliency_of_people_too_far_away_is_called_that(n_far: int, words: str):
    """X misses somebody far away, Y somebody who comes near as well."""
    truth = [at(f, 50, track=1, h=9 if f < n_far else 50) for f in range(n_far + 25)]
    x = truth[n_far:] if words else []
    result = result_of(make_dataset(truth, x, [], n_frames=len(truth)), proximity="height")
    text = topic(verdict_by(result), "Other measures")
    said = f"Of the time of the saliency events, {words} is of pedestrians that count; the rest is"
    assert (said in text) == bool(words)
    assert ("too far away" in text) == bool(words)


def test_measures_that_look_the_same_are_not_called_better_and_undefined_ones_left_out(
    alike: Result,
):
    assert topic(verdict_by(alike), "Other measures") == (
        "Both have the same mean similarity (1.000), the same severity per encounter (0.00 s), "
        "the same saliency (0.00 s) and the same false-alert episodes (0 in 1 s)."
    )


@pytest.mark.parametrize(
    ("rows", "headline", "chance"),
    [
        (
            [row_of("mean_similarity", 0.012, 0.012, 0.043), row_of("saliency", 0.6, -1.0, 0.5)],
            "X is better in mean similarity (1.0000 to 2.0000): more than chance, by 12 "
            "recordings.",
            "More than chance: mean similarity (for X, X - Y 95 % interval +0.0120 to +0.0430, "
            "p = 0.006; 0.012 after correction for 2 tests). The other differences are "
            "not shown to be more than chance.",
        ),
        (
            [row_of("mean_similarity", 0.01, 0.1, 0.2), row_of("saliency", 0.02, better="lower")],
            "X is better in mean similarity (1.0000 to 2.0000), Y in saliency per recording: more "
            "than chance, by 12 recordings.",
            "More than chance: mean similarity (for X, X - Y 95 % interval +0.1000 to +0.2000, "
            "p = 0.005; 0.01 after correction for 2 tests) and saliency per recording (for Y, p = "
            "0.01; 0.02 after correction for 2 tests).",
        ),
        ([row_of("mean_similarity", 0.5), row_of("saliency", 0.5)], NO_DIFFERENCE, ""),
        ([row_of("mean_similarity", NAN)], TOO_FEW, ""),
        (
            [row_of("log_average_miss_rate", 0.01, doubt="X ends early"), row_of("saliency", 0.5)],
            "Nothing is claimed: each difference that is more than chance fails another check.",
            "Not claimed: log-average miss rate (X ends early). The other differences are not "
            "shown to be more than chance.",
        ),
    ],
    ids=["one", "two", "none", "too few", "doubtful"],
)  # fmt: skip
def test_what_is_beyond_chance(better_x: Result, rows: list[dict], headline: str, chance: str):
    text = verdict_by(better_x, *rows)
    assert (text.headline, topic(text, "Chance")) == (headline, chance)


def test_the_headline_begins_with_the_strongest_difference(better_x: Result):
    rows = row_of("mean_similarity", 0.04), row_of("saliency", 0.01, better="lower")
    assert verdict_by(better_x, *rows, row_of(BY_UNIT, 0.03)).headline == (
        "Y is better in saliency per recording (2.00 to 1.00 s), X in encounters detected and mean "
        "similarity: more than chance, by 12 recordings."
    )


def of_stretches(figure: str, low: float, high: float, **more: object) -> dict[str, object]:
    middle = (low + high) / 2
    return row_of(figure, NAN, low, high, difference=middle, unit="blocks", **more)


ALARMS = of_stretches("false_alert_episodes_per_hour", 1.0, 3.0, better="lower")


SIMILARITY = of_stretches("mean_similarity", 0.4, 0.5)
FEW = "one recording does not show what others would (6 are needed)."
X_SIMILAR = "X is better in mean similarity (1.0000 to 2.0000)"


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        # widened for two intervals of 12 blocks by 2.593 / 2.201: 2 - 1.18 * 1 > 0,
        # 0.5 - 1.18 * 0.45 < 0
        ([ALARMS, of_stretches("mean_similarity", 0.05, 0.95)],
         "Y is better in false-alert episodes (2.0 to 1.0 per hour)"),
        ([ALARMS, SIMILARITY], f"{X_SIMILAR}, Y in false-alert episodes (2.0 to 1.0 per hour)"),
        ([ALARMS | {"doubt": "odd"}, of_stretches("mean_similarity", -0.1, 0.5)], ""),
        ([of_stretches("mean_similarity", 0.05, 0.95)], X_SIMILAR),
    ],
    ids=["one", "both sides", "none", "not widened for one"],
)  # fmt: skip
def test_within_one_recording_clear_differences_are_said_and_nothing_of_others(
    better_x: Result, rows: list[dict], words: str
):
    text = verdict_by(better_x, of_stretches(BY_UNIT, NAN, NAN), *rows)
    assert not text.claims
    assert text.headline == (
        f"Within this recording {words}; nothing is claimed of others: {FEW}"
        if words
        else f"Nothing is claimed: {FEW}"
    )


def test_within_one_recording_nothing_is_said_that_the_companions_do_not_bear_out():
    better = detecting(6, range(6), range(2), alarms_y=3)

    def headline_by(companions: Companions | None) -> str:
        table = pd.DataFrame([of_stretches(BY_UNIT, NAN, NAN), SIMILARITY])
        return verdict(better, evidence=table, companions=companions).headline

    def alone(strict: Result) -> Companions:
        return Companions(None, (), strict)

    assert X_SIMILAR in headline_by(alone(better))
    assert "X is better" not in headline_by(None)
    # the strict comparison is for Y
    turned = detecting(6, range(2), range(6))
    assert headline_by(alone(turned)) == f"Nothing is claimed: {FEW}"
    # similarity of Y, which has 3 false alarms where X has none
    other_way = SIMILARITY | {"difference": -0.45, "low": -0.5, "high": -0.4}
    table = pd.DataFrame([of_stretches(BY_UNIT, NAN, NAN), other_way])
    text = verdict(better, evidence=table, companions=alone(better))
    assert text.headline == f"Nothing is claimed: {FEW}"
    # nor what turns at equal false alarms
    at_equal = Companions(EqualAlarms(turned, "x"), (table,), better)
    assert headline_by(at_equal) == f"Nothing is claimed: {FEW}"


def test_a_difference_says_for_whom_it_speaks_with_its_unit_and_no_exponent(better_x: Result):
    episodes = row_of("false_alert_episodes_per_hour", 0.01, -358.2, -1.2e4, better="lower")
    saliency = row_of("saliency", 0.01, 0.5, 2.0, better="lower")
    miss_rate = row_of("log_average_miss_rate", 0.01, -0.12, -0.02, difference=-1.0, better="lower")
    chance = topic(
        verdict_by(better_x, episodes | {"difference": -1.0}, saliency, miss_rate), "Chance"
    )
    assert (
        "(for X, X - Y 95 % interval -358.2 to -12,000.0 per hour, p = 0.005; 0.01 after" in chance
    )
    assert "saliency per recording (for Y, X - Y 95 % interval +0.50 to +2.00 s, p =" in chance
    assert (
        "miss rate (for X, X - Y 95 % interval -12.0 pp to -2.0 pp, p = 0.005; 0.01 after" in chance
    )


@pytest.mark.parametrize(("p", "keys"), [(0.01, {"mean_similarity"}), (0.4, set())])
def test_measures_of_time_are_not_judged_where_encounters_are_single_frames(
    p: float, keys: set[str]
):
    rows = row_of("mean_similarity", p, 0.1, 0.2), row_of("saliency", 0.001, 1.0, 2.0)
    result = detecting(12, range(10), range(2), n_frames=1)
    text = verdict_by(result, *rows)
    assert topic(text, "Chance").endswith(
        "saliency, severity and episodes mean little here and are not judged."
    )
    assert "p = 0.0005" not in " ".join(text.sentences)
    assert {claim.key for claim in text.claims} == keys


def test_too_few_recordings_for_any_claim_say_so(better_x: Result):
    keys = (BY_UNIT, "mean_similarity", "share_low", "severity_s_per_encounter", "saliency",
            "false_alert_episodes_per_hour", "log_average_miss_rate")  # fmt: skip
    eight = verdict_by(better_x, *(row_of(key, 0.055, n=8) for key in keys))
    assert eight.headline == (
        "Nothing is claimed: by 8 recordings and in 7 measures no difference can be shown to be "
        "more than chance, however large (the least possible p = 0.0078; 0.055 after "
        "correction for 7 tests)."
    )
    nine = verdict_by(better_x, *(row_of(key, 0.055, n=9) for key in keys))
    assert nine.headline == NO_DIFFERENCE.replace("12", "9")


def test_sentences_are_headline_points_and_caveat_in_order(better_x: Result):
    text = verdict(better_x, [finding("ids-odd")], plan="More would show more.")
    topics = [point.topic for point in text.points]
    assert topics == ["Encounters", "Severity", "Other measures", "More recordings", "Thresholds"]
    assert text.sentences[0] == text.headline
    assert text.sentences[-1] == text.caveat
    assert " ".join(text.sentences[1:-1]) == " ".join(point.text for point in text.points)
    assert all(sentence.endswith(".") for sentence in text.sentences)


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


def test_a_finding_that_the_verdict_depends_on_is_named_not_counted(alike: Result):
    text = verdict(alike, [finding("kitti-size"), finding("duplicate-box")])
    assert text.caveat == (
        "This depends on what the audit found: the truth contradicts the picture size of some "
        "recordings; boxes are repeated."
    )


def test_every_caveat_is_about_a_finding_that_the_audit_has():
    audit = ROOT / "nvcore" / "auditing"
    source = "".join(path.read_text(encoding="utf-8") for path in audit.glob("*.py"))
    assert [code for code in CAVEATS.warned if f'"{code}"' not in source] == []


def test_equal_boxes_are_no_comparison(better_x: Result):
    text = verdict(better_x, [finding("same-boxes")])
    assert text.headline == (
        "Two of the inputs have the same boxes: this is no comparison of two systems."
    )
    assert not text.points
    assert not text.claims


def test_systems_whose_every_detection_counts_are_named(alike: Result):
    assert "Every detection of X and Y counts, however low its score." in verdict(alike).sentences
    limited = result_of(alike.dataset, threshold_x=0.5)
    assert "Every detection of Y counts, however low its score." in verdict(limited).sentences


def test_nothing_is_claimed_from_inputs_with_errors(better_x: Result):
    error = Finding(Severity.ERROR, "box-layout", "x", 1, "Corners.", "Read them so.")
    conclusion = verdict(better_x, [error])
    assert conclusion.headline.startswith("Nothing is claimed: the audit found errors")
    assert conclusion.claims == ()
    assert conclusion.points == ()
