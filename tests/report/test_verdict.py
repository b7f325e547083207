"""What a comparison supports, as facts; one golden text pins how they are said."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Place, at, make_dataset, result_of
from places import ROOT
from verdict_scenes import BY_UNIT, detecting, row_of, said, verdict_by, whole_verdict

from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import Result
from nvcore.evidence.companions import Companions
from nvcore.notes import Note
from nvcore.notes.caveats import CAVEATS
from nvcore.report.verdict import Verdict, verdict

DETECTED = Note("verdict.measure", key=BY_UNIT)
SIMILAR = Note("verdict.measure", key="mean_similarity")


def more_than_chance(*shown: tuple[str, str, float, float, str | None]) -> Note:
    names = ("key", "winner", "p", "p_corrected", "interval")
    of_each = [Note("verdict.shown", **dict(zip(names, of, strict=True))) for of in shown]
    return Note("verdict.more_than_chance", shown=of_each)


@pytest.fixture(scope="module")
def better_x() -> Result:
    """X detects all of six pedestrians, Y two of them; Y has an episode of three frames."""
    return detecting(6, range(6), range(2), alarms_y=3)


@pytest.fixture(scope="module")
def alike() -> Result:
    return detecting(4, range(4), range(4))


def conclusion_of(text: Verdict) -> Note:
    return text.headline["conclusion"]


@pytest.mark.parametrize(
    ("scene", "p", "kind", "of"),
    [
        ((9, range(9), range(3)), 0.031, "claimed", (9, 3, 6, 0)),
        ((9, range(9), range(3)), 0.2, "not_shown", (9, 3, 6, 0)),
        ((12, range(11), range(10, 12)), 0.012, "claimed", (12, 1, 10, 1)),
        ((12, range(11), range(10, 12)), 0.3, "not_shown", (12, 1, 10, 1)),
        ((12, range(11), range(10, 12)), NAN, "untestable", (12, 1, 10, 1)),
        ((4, range(3), range(3)), NAN, "untestable", (4, 3, 0, 0)),
        ((0, range(0), range(0)), NAN, "untestable", (0, 0, 0, 0)),
    ],
    ids=["dominance", "dominance by chance", "uneven split", "even split", "untested", "the same",
         "nobody"],
)  # fmt: skip
def test_who_detects_more_encounters(
    scene: tuple[int, range, range], p: float, kind: str, of: tuple[int, int, int, int]
):
    text = verdict_by(detecting(*scene), row_of(BY_UNIT, p))
    tested = Note("verdict.tested", n=12, noun="recording", p=p / 2, p_corrected=p)
    test = Note("verdict.too_few_differ", noun="recording") if np.isnan(p) else tested
    counts = dict(zip(("n", "both", "x_only", "y_only"), of, strict=True))
    assert said(text, "Encounters") == (Note("verdict.detected", **counts, test=test),)
    assert conclusion_of(text).key == f"verdict.{kind}"
    assert [claim.key for claim in text.claims] == ([BY_UNIT] if kind == "claimed" else [])


def test_the_reason_repeats_no_measure_of_the_headline(better_x: Result):
    text = verdict_by(better_x, row_of(BY_UNIT, 0.03), row_of("mean_similarity", 0.04))
    assert text.in_short.startswith("X is better on encounters detected")
    assert text.reason == "What is claimed is more than chance across 12 recordings."


def test_p_stands_by_itself_and_corrected(better_x: Result):
    text = verdict_by(better_x, row_of(BY_UNIT, 1.0) | {"p": 0.18}, row_of("mean_similarity", 1.0))
    (detected,) = said(text, "Encounters")
    test = detected["test"]
    assert (test["p"], test["p_corrected"]) == (0.18, 1.0)


@pytest.mark.parametrize("scene", [(12, range(11), range(10, 12)), (9, range(9), range(3))])
def test_few_recordings_say_nothing_of_others(scene: tuple[int, range, range]):
    result = detecting(*scene)
    assert result.exclusivity.mcnemar_p < 0.05
    text = whole_verdict(result)
    assert conclusion_of(text) == Note("verdict.few", n=1, noun="recording", n_needed=6)
    (detected,) = said(text, "Encounters")
    assert detected["test"] == ""
    assert not text.claims
    assert not said(text, "Chance")


def test_what_is_not_tested_says_so(better_x: Result):
    text = verdict(better_x)
    assert conclusion_of(text) == Note("verdict.untested")
    assert not text.claims


def test_nothing_is_claimed_before_the_companions_are_known(better_x: Result):
    rows = row_of(BY_UNIT, 0.01), row_of("mean_similarity", 0.01)
    text = verdict_by(better_x, *rows, companions=False)
    assert not text.claims
    assert conclusion_of(text) == Note("verdict.pending", is_delivered=False)
    reason = Note("verdict.not_yet_compared", is_delivered=False)
    unclaimed = Note("verdict.unclaimed", measures=[DETECTED, SIMILAR], reason=reason)
    assert said(text, "Chance") == (unclaimed,)
    assert said(text, "Encounters")[0]["test"] == ""  # its p is withheld


def test_what_failures_weigh_and_the_worst_of_them(better_x: Result):
    # proximity "none": 0.1 s of each frame in full; four pedestrians of three frames
    weights, worst = said(verdict_by(better_x), "Severity")
    cost = Note("verdict.cost", finder="x", loser="y", n=4, seconds=pytest.approx(1.2))
    assert weights == Note("verdict.costs", costs=[cost])
    place = {"track": "2", "recording": "r0", "seconds": pytest.approx(0.3)}
    assert worst == Note("verdict.worst_failure", system="y", **place)
    both_ways = said(verdict_by(detecting(9, range(6), range(3, 9))), "Severity")[0]
    assert [(of["finder"], of["loser"], of["n"]) for of in both_ways["costs"]] == [
        ("x", "y", 3),
        ("y", "x", 3),
    ]


def test_the_measures_stand_side_by_side(better_x: Result):
    text = verdict_by(better_x, row_of("log_average_miss_rate", NAN))
    (has,) = said(text, "Other measures")
    assert has["system"] == "x"
    qualities = [(of["key"], of["better"], of.fields.get("extent")) for of in has["qualities"]]
    assert qualities == [
        ("mean_similarity", 1, None),
        ("severity_s_per_encounter", 0, None),
        ("saliency", 0, None),
        ("false_alert_episodes", 0, " in 1.8 s"),
        ("log_average_miss_rate", 1, None),
    ]


def test_episodes_of_sampled_frames_are_said_to_be_of_these():
    frames = range(0, 120, 10)
    truth = [at(frame, 50, track=1) for frame in frames]
    y = [*truth, at(0, 10)]
    result = result_of(make_dataset(truth, truth, y, places=[Place(frames)]))
    qualities = said(verdict_by(result), "Other measures")[0]["qualities"]
    assert qualities[-1]["extent"] == " in 12 s, every 10th frame"


@pytest.mark.parametrize(
    ("n_far", "shares"), [(30, {"x": 0.0, "y": pytest.approx(25 / 55, abs=0.01)}), (5, {})]
)
def test_saliency_of_people_too_far_away_is_called_that(n_far: int, shares: dict[str, float]):
    """X misses somebody far away, Y somebody who comes near as well."""
    truth = [at(f, 50, track=1, h=9 if f < n_far else 50) for f in range(n_far + 25)]
    x = truth[n_far:] if shares else []
    result = result_of(make_dataset(truth, x, [], n_frames=len(truth)), proximity="height")
    notes = said(verdict_by(result), "Other measures")
    far = [note["shares"] for note in notes if note.key == "verdict.far_away"]
    assert [{of["system"]: of["share"] for of in each} for each in far] == [shares] * bool(shares)


def test_measures_that_look_the_same_are_not_called_better_and_undefined_ones_left_out(
    alike: Result,
):
    (has,) = said(verdict_by(alike), "Other measures")
    assert has["system"] == "both"
    assert [of["key"] for of in has["qualities"]] == [
        *("mean_similarity", "severity_s_per_encounter", "saliency", "false_alert_episodes")
    ]


@pytest.mark.parametrize(
    ("rows", "kind", "winners", "chance"),
    [
        (
            [row_of("mean_similarity", 0.012, 0.012, 0.043), row_of("saliency", 0.6, -1.0, 0.5)],
            "claimed",
            {"x": ["mean_similarity"]},
            (
                more_than_chance(
                    ("mean_similarity", "x", 0.006, 0.012, "+0.0120 to +0.0430")
                ),
                Note("verdict.others_not_shown"),
            ),
        ),
        (
            [row_of("mean_similarity", 0.01), row_of("saliency", 0.02, better="lower")],
            "claimed",
            {"x": ["mean_similarity"], "y": ["saliency"]},
            (
                more_than_chance(
                    ("mean_similarity", "x", 0.005, 0.01, None), ("saliency", "y", 0.01, 0.02, None)
                ),
            ),
        ),
        ([row_of("mean_similarity", 0.5), row_of("saliency", 0.5)], "not_shown", {}, ()),
        ([row_of("mean_similarity", NAN)], "untestable", {}, ()),
        (
            [row_of("log_average_miss_rate", 0.01, doubt="X ends early"), row_of("saliency", 0.5)],
            "withheld",
            {},
            (
                Note(
                    "verdict.unclaimed",
                    measures=[Note("verdict.measure", key="log_average_miss_rate")],
                    reason=Note("verdict.doubted", doubt="X ends early"),
                ),
                Note("verdict.others_not_shown"),
            ),
        ),
    ],
    ids=["one", "two", "none", "too few", "doubtful"],
)  # fmt: skip
def test_what_is_beyond_chance(
    better_x: Result,
    rows: list[dict],
    kind: str,
    winners: dict[str, list[str]],
    chance: tuple[Note, ...],
):
    text = verdict_by(better_x, *rows)
    conclusion = conclusion_of(text)
    assert conclusion.key == f"verdict.{kind}"
    assert won_in(conclusion) == winners
    assert said(text, "Chance") == chance


def won_in(conclusion: Note) -> dict[str, list[str]]:
    better = conclusion.fields.get("better", [])
    return {of["winner"]: [measure["key"] for measure in of["measures"]] for of in better}


def test_the_headline_begins_with_the_strongest_difference(better_x: Result):
    rows = row_of("mean_similarity", 0.04), row_of("saliency", 0.01, better="lower")
    y, x = conclusion_of(verdict_by(better_x, *rows, row_of(BY_UNIT, 0.03)))["better"]
    values = {"better": 2.0, "other": 1.0, "form": ".2f", "unit": " s"}
    first = Note("verdict.measure", key="saliency", **values)
    assert y == Note("verdict.better", winner="y", measures=[first])
    assert x == Note("verdict.better", winner="x", measures=[DETECTED, SIMILAR])


def of_stretches(figure: str, low: float, high: float, **more: object) -> dict[str, object]:
    middle = (low + high) / 2
    return row_of(figure, NAN, low, high, difference=middle, unit="blocks", **more)


ALARMS = of_stretches("false_alert_episodes_per_hour", 1.0, 3.0, better="lower")


SIMILARITY = of_stretches("mean_similarity", 0.4, 0.5)


@pytest.mark.parametrize(
    ("rows", "winners"),
    [
        # widened for two intervals of 12 blocks by 2.593 / 2.201: 2 - 1.18 * 1 > 0,
        # 0.5 - 1.18 * 0.45 < 0
        ([ALARMS, of_stretches("mean_similarity", 0.05, 0.95)],
         {"y": ["false_alert_episodes_per_hour"]}),
        ([ALARMS, SIMILARITY],
         {"x": ["mean_similarity"], "y": ["false_alert_episodes_per_hour"]}),
        ([ALARMS | {"doubt": "odd"}, of_stretches("mean_similarity", -0.1, 0.5)], {}),
        ([of_stretches("mean_similarity", 0.05, 0.95)], {"x": ["mean_similarity"]}),
    ],
    ids=["one", "both sides", "none", "not widened for one"],
)  # fmt: skip
def test_within_one_recording_clear_differences_are_said_and_nothing_of_others(
    better_x: Result, rows: list[dict], winners: dict[str, list[str]]
):
    text = verdict_by(better_x, of_stretches(BY_UNIT, NAN, NAN), *rows)
    assert not text.claims
    conclusion = conclusion_of(text)
    kind = "verdict.within" if winners else "verdict.few"
    assert (conclusion.key, won_in(conclusion)) == (kind, winners)
    better = conclusion.fields.get("better", [])
    assert all("other" in measure.fields for of in better for measure in of["measures"])


def test_within_one_recording_nothing_is_said_that_the_companions_do_not_bear_out():
    better = detecting(6, range(6), range(2), alarms_y=3)
    table = pd.DataFrame([of_stretches(BY_UNIT, NAN, NAN), SIMILARITY])

    def winners_by(companions: Companions | None, table: pd.DataFrame = table) -> dict:
        return won_in(conclusion_of(verdict(better, evidence=table, companions=companions)))

    def alone(strict: Result) -> Companions:
        return Companions(None, None, strict)

    assert winners_by(alone(better)) == {"x": ["mean_similarity"]}
    assert winners_by(None) == {}
    # the strict comparison is for Y
    turned = detecting(6, range(2), range(6))
    assert winners_by(alone(turned)) == {}
    # similarity of Y, which has 3 false alarms where X has none
    other_way = SIMILARITY | {"difference": -0.45, "low": -0.5, "high": -0.4}
    of_y = pd.DataFrame([of_stretches(BY_UNIT, NAN, NAN), other_way])
    assert winners_by(alone(better), of_y) == {}
    # nor what turns at equal false alarms
    assert winners_by(Companions(turned, of_y, better)) == {}


def test_a_difference_says_for_whom_it_speaks_with_its_unit_and_no_exponent(better_x: Result):
    episodes = row_of("false_alert_episodes_per_hour", 0.01, -358.2, -1.2e4, better="lower")
    saliency = row_of("saliency", 0.01, 0.5, 2.0, better="lower")
    miss_rate = row_of("log_average_miss_rate", 0.01, -0.12, -0.02, difference=-1.0, better="lower")
    (chance,) = said(
        verdict_by(better_x, episodes | {"difference": -1.0}, saliency, miss_rate), "Chance"
    )
    assert {(of["key"], of["winner"], of["interval"]) for of in chance["shown"]} == {
        ("false_alert_episodes_per_hour", "x", "-0.2 to -6.0 in 1.8 s"),
        ("saliency", "y", "+0.50 to +2.00 s"),
        ("log_average_miss_rate", "x", "-12.0 pp to -2.0 pp"),
    }


@pytest.mark.parametrize(("p", "keys"), [(0.01, {"mean_similarity"}), (0.4, set())])
def test_measures_of_time_are_not_judged_where_encounters_are_single_frames(
    p: float, keys: set[str]
):
    rows = row_of("mean_similarity", p, 0.1, 0.2), row_of("saliency", 0.001, 1.0, 2.0)
    result = detecting(12, range(10), range(2), n_frames=1)
    text = verdict_by(result, *rows)
    assert said(text, "Chance")[-1] == Note("verdict.short_encounters")
    assert {claim.key for claim in text.claims} == keys


def test_a_verdict_in_words(better_x: Result):
    """The golden text: what every medium takes."""
    rows = row_of(BY_UNIT, 0.012, 0.2, 0.9), row_of("saliency", 0.5, better="lower")
    table = pd.DataFrame([*rows, row_of("mean_similarity", 0.01, doubt="X ends early")])
    companions = Companions(better_x, table, better_x)
    grave = [finding("kitti-size"), finding("ids-odd")]
    text = verdict(
        better_x, grave, evidence=table, companions=companions, plan=(Note("plan.fresh"),)
    )
    assert text.sentences == (
        "X is better on encounters detected (100.0 % vs 200.0 %), by more than chance across 12 "
        "recordings.",
        "Severity of missed pedestrians, the primary measure, has no p here. The other measures "
        "are corrected for multiple testing.",
        "Of 6 encounters, X detects all that Y detects and 4 more (12 recordings, p = 0.006; "
        "0.012 after correction).",
        "Weighted by severity, the 4 encounters that only X detects cost Y 1.2 s.",
        "The worst single failure is Y's: pedestrian 2 in r0, 0.3 s.",
        "X has a higher mean similarity (1.000 vs 0.398), a lower severity per encounter (0.00 vs "
        "0.20 s), a lower saliency (0.00 vs 0.30 s) and fewer false-alert episodes (0 vs 1 in "
        "1.8 s).",
        "More than chance: encounters detected (X better, 95 % confidence interval of X - Y: "
        "+20.0 pp to +90.0 pp, p = 0.006; 0.012 after correction).",
        "Not claimed: mean similarity (X ends early).",
        "The other differences are not shown to be more than chance.",
        "This is the size of a separate study whose end is set before it begins. Adding "
        "recordings until p is small enough shows differences that are not there.",
        "Every detection of X and Y counts, however low its score.",
        "This depends on what the audit found: the truth contradicts the picture size of some "
        "recordings; 1 other finding.",
    )
    assert [topic for topic, _ in text.topics] == [
        *("Question", "Encounters", "Severity", "Other measures", "Chance", "More recordings"),
        "Thresholds",
        "Audit",
    ]
    assert " ".join(words for _, words in text.topics) == " ".join(text.sentences[1:])


def finding(code: str, severity: Severity = Severity.WARNING) -> Finding:
    return Finding(severity, code, "truth", 1, "Odd.", "Look.")


def test_the_verdict_names_the_findings_it_depends_on_and_counts_others(alike: Result):
    grave = [finding("mixed-weighting"), finding("mixed-weighting"), finding("ids-odd")]
    assert verdict(alike, grave).doubt == Note(
        "verdict.doubt", known=["mixed-weighting"], n_others=1
    )
    assert verdict(alike, [finding("mixed-weighting", Severity.NOTE)]) == verdict(alike)
    lesser = [finding("kitti-size"), finding("duplicate-box")]
    known = ["kitti-size", "duplicate-box"]
    assert verdict(alike, lesser).doubt == Note("verdict.doubt", known=known, n_others=0)


def test_every_caveat_is_about_a_finding_that_the_audit_has():
    audit = ROOT / "nvcore" / "auditing"
    source = "".join(path.read_text(encoding="utf-8") for path in audit.glob("*.py"))
    assert [code for code in CAVEATS.warned if f'"{code}"' not in source] == []


@pytest.mark.parametrize(
    ("severity", "code", "kind"),
    [
        (Severity.WARNING, "same-boxes", "same_boxes"),
        (Severity.ERROR, "box-layout", "wrong_inputs"),
    ],
)
def test_inputs_that_are_no_comparison_give_no_points(
    better_x: Result, severity: Severity, code: str, kind: str
):
    text = verdict(better_x, [finding(code, severity)])
    assert text.headline == Note(f"verdict.{kind}")
    assert (text.points, text.claims) == ((), ())


def test_systems_whose_every_detection_counts_are_named(alike: Result):
    assert said(verdict(alike), "Thresholds") == (Note("verdict.unfiltered", systems=["x", "y"]),)
    limited = result_of(alike.dataset, threshold_x=0.5)
    assert said(verdict(limited), "Thresholds") == (Note("verdict.unfiltered", systems=["y"]),)
