"""How many recordings would show a difference, and whether a system is worse by a margin."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from drives import by_figure, drives, quiet_drives
from scipy.stats import f, nct, norm, t

from nvcore.api.comparison import Comparison
from nvcore.common.arguments.plan import PlanArguments
from nvcore.common.errors import ParameterError
from nvcore.comparison.compare import Result, compare
from nvcore.evidence.bootstrap import ratio, studentised_tests
from nvcore.evidence.claims import values_of
from nvcore.evidence.companions import shifts_at_equal_alarms
from nvcore.evidence.measures import Evidence, unit_measures
from nvcore.evidence.operating_points import are_unequal, count_alarms, find_equal_alarms
from nvcore.evidence.paired_tests import swap_test
from nvcore.evidence.planning import (
    PLAN_KEYS,
    Pilot,
    judge_noninferiority,
    make_pilot,
    notes_for_verdict,
    notes_of_plan,
    plan_recordings,
)
from nvcore.evidence.planning.power import (
    MOST_RECORDINGS,
    _count_claims,
    count_differences_shown,
    count_noninferior,
    exchange_p,
    find_length,
    rough_length,
    studentised_tail,
)
from nvcore.evidence.planning.repeated_pilots import find_range
from nvcore.evidence.planning.thresholds import (
    Curve,
    Thresholds,
    parts_at_equal_alarms,
    vary_thresholds,
)
from nvcore.evidence.units import find_units
from nvcore.notes import Note
from nvcore.report.plan import plan_json


def normal_pilot(n: int = 60, difference: float = 0.5, seed: int = 5) -> Pilot:
    """Recordings of weight 1 whose differences are normal with a standard deviation of 1."""
    drawn = np.random.default_rng(seed).normal(size=n)
    parts = difference + (drawn - drawn.mean()) / drawn.std(ddof=1)
    return Pilot(difference, parts, np.ones(n), np.ones(n, dtype=bool), 4.0, 60.0)


def t_test_power(effect: float, n: int) -> float:
    """Closed form of the paired t-test at 5 %, two-sided."""
    limit, shift = t.isf(0.025, n - 1), effect * math.sqrt(n)
    return float(nct.sf(limit, n - 1, shift) + nct.cdf(-limit, n - 1, shift))


@pytest.mark.parametrize("n", [12, 30, 50])
def test_the_power_of_a_normal_pilot_is_that_of_the_paired_t_test(n: int):
    n_studies = 1000
    power = count_differences_shown(normal_pilot(), 0.5, n, n_studies, level=0.05) / n_studies
    expected = t_test_power(0.5, n)
    # 3 standard errors of the simulation, and 4 points for two tests that both have to reject
    assert power == pytest.approx(expected, abs=3 * math.sqrt(0.25 / n_studies) + 0.04)


def test_without_a_difference_studies_show_one_in_5_percent():
    for n in (12, 60):
        shown = count_differences_shown(normal_pilot(), 0.0, n, 1000, level=0.05)
        assert 20 <= shown <= 72  # 50 less or more 3 standard errors; two tests are stricter


def test_longer_studies_larger_differences_and_laxer_levels_have_more_power():
    pilot, n_studies = normal_pilot(20), 600

    def shown(difference: float, n: int, level: float = 0.05) -> int:
        return count_differences_shown(pilot, difference, n, n_studies, level=level)

    assert shown(0.5, 6) < shown(0.5, 12) < shown(0.5, 25) < shown(0.5, 50) < shown(0.5, 100)
    assert shown(0.2, 25) < shown(0.5, 25) < shown(0.8, 25)
    assert shown(0.5, 25, 0.01) < shown(0.5, 25)
    assert shown(0.5, 5) == 0  # too few for a test


def test_a_simulated_study_rejects_where_the_tests_of_the_table_do():
    """The pilot drawn once each is the data themselves: the simulation against `swap_test`."""
    rng = np.random.default_rng(0)
    pilot = normal_pilot(12, 0.6)
    n_shown = 0
    for _ in range(150):
        parts = pilot.parts_for(0.6)[rng.integers(0, 12, 15)]
        x, y = np.column_stack([parts, np.ones(15)]), np.column_stack([0 * parts, np.ones(15)])
        p = swap_test(x, y, ratio, n_permutations=399).p
        (skewed,) = studentised_tests(parts[:, np.newaxis], n_resamples=399)
        n_shown += max(p, skewed.p) <= 0.05
    simulated = count_differences_shown(pilot, 0.6, 15, 1000, level=0.05) / 1000
    assert simulated == pytest.approx(n_shown / 150, abs=3 * math.sqrt(0.25 / 150))


def test_the_expansion_of_the_studentised_bootstrap_is_close_to_it():
    rng = np.random.default_rng(1)
    parts = rng.lognormal(size=60) - 1.2
    mean = float(parts.mean())
    values = (np.sign(mean) * (parts - mean))[np.newaxis]
    drawn = np.ones((1, 60), dtype=int)
    (tail,) = studentised_tail(drawn, values, np.array([abs(mean)]))
    (test,) = studentised_tests(parts[:, np.newaxis])
    assert 2 * tail == pytest.approx(test.p, abs=0.02)


def test_the_expansion_of_the_exchange_is_close_to_it():
    rng = np.random.default_rng(2)
    for parts in (rng.normal(0.2, 1, 60), rng.lognormal(size=80) - 1.3):
        x, y = np.column_stack([parts, 0 * parts + 1]), np.column_stack([0 * parts, 0 * parts + 1])
        p, is_close = exchange_p(np.ones((1, len(parts)), dtype=int), parts)
        assert is_close[0] == (len(parts) == 60)  # of the other, few parts make up most
        assert p[0] == pytest.approx(swap_test(x, y, ratio).p, abs=0.012)


def test_the_size_has_the_power_and_is_near_the_formula_s():
    pilot = normal_pilot()
    length = find_length(
        lambda n, n_studies: count_differences_shown(pilot, 0.5, n, n_studies, level=0.05),
        guess=10,  # far too few
        least=6,
        target=0.8,
    )
    assert length.n_recordings is not None
    formula = next(n for n in range(6, 200) if t_test_power(0.5, n) >= 0.8)
    assert length.n_recordings == pytest.approx(formula, rel=0.15)
    (point,) = [point for point in length.points if point.n_recordings == length.n_recordings]
    assert point.low <= 0.8 <= point.high


@pytest.mark.parametrize("seed", range(8))
def test_the_size_is_the_first_of_the_curve_that_has_the_power(seed: int):
    rng = np.random.default_rng(seed)

    def count(n: int, n_studies: int) -> int:
        return int(rng.binomial(n_studies, min(0.8 * np.sqrt(n / 60), 1)))

    length = find_length(count, guess=60, least=6, target=0.8)
    reaching = [point.n_recordings for point in length.points if point.power >= 0.8]
    assert length.n_recordings == min(reaching)
    assert length.n_recordings == pytest.approx(60, rel=0.2)


def test_what_no_study_shows_has_no_size():
    length = find_length(lambda *_: 0, guess=100, least=6, target=0.8)
    assert length.n_recordings is None
    assert length.points[-1].n_recordings == MOST_RECORDINGS
    easy = find_length(lambda _, n_studies: n_studies, guess=100, least=6, target=0.8)
    assert easy.n_recordings == 6


@pytest.mark.parametrize("difference", [0.25, 0.5, 1.0])
def test_the_rough_size_is_near_the_size(difference: float):
    pilot, asked = normal_pilot(20), {"guess": 100, "least": 6, "target": 0.8}
    count = partial(count_differences_shown, pilot, difference, level=0.05)
    length = find_length(count, **asked)
    roughly = partial(count, is_rough=True)
    rough = rough_length(roughly, **asked, level=0.05, most=MOST_RECORDINGS)
    assert rough == pytest.approx(length.n_recordings, rel=0.25)
    assert rough_length(lambda *_: 0, **asked, level=0.05, most=MOST_RECORDINGS) == math.inf


def size_range(pilot: Pilot, n_recordings: int, difference: float = 0.5) -> tuple[int, int] | None:
    """Range of sizes for a difference at 80 % power."""
    return find_range(
        lambda of: partial(count_differences_shown, of, difference, level=0.05, is_rough=True),
        pilot,
        n_recordings,
        least=6,
        level=0.05,
        target=0.8,
    )


def test_the_range_is_at_least_the_one_of_normal_differences_and_narrows_with_the_pilot():
    few, many = size_range(normal_pilot(12), 1000), size_range(normal_pilot(200), 1000)
    for (low, high), n in ((few, 12), (many, 200)):
        least = f.ppf(0.9, n - 1, n - 1)  # ratio of the variances of two pilots
        assert low <= 1000 / least
        assert least * 1000 <= high < 1.4 * least * 1000
    assert size_range(normal_pilot(12), 1000) == few  # the seed is fixed


def test_a_pilot_that_rests_on_a_single_recording_has_no_range():
    parts = np.zeros(12)
    parts[3] = 6.0
    pilot = Pilot(0.5, parts, np.ones(12), parts != 0, 4.0, 60.0)
    assert size_range(pilot, 1000) is None  # a third of repeated pilots does not draw it
    assert size_range(normal_pilot(12), 1000) is not None
    assert size_range(normal_pilot(12), 1000, difference=1e-9) is None  # no size shows that


@pytest.mark.parametrize("clumped", [False, True])
def test_uncertain_false_alarms_leave_no_range(clumped: bool):
    """Y has as many false alarms as X as set, and may find more or less at equal ones."""
    pilot = normal_pilot(12)
    of_y = np.where(np.arange(12) == 3, 120.0, 0.0) if clumped else np.full(12, 10.0)
    of_x = np.full(12, 10.0)
    x, y = (
        Curve(np.outer([0.5, 1, 2], alarms), np.outer([-8, 0, 8], np.ones(12)) + parts)
        for alarms, parts in ((of_x, pilot.parts), (of_y, np.zeros(12)))
    )
    as_set = tuple(Curve(of.alarms[1:2], of.parts[1:2]) for of in (x, y))
    at_thresholds = replace(pilot, thresholds=Thresholds(as_set, (x, y)))
    assert (size_range(at_thresholds, 1000) is None) == clumped


def test_repeated_pilots_have_these_recordings_and_their_difference():
    pilot = normal_pilot(12)
    others = list(pilot.repeated(np.random.default_rng(0), 400))
    for other in others[:5]:
        assert len(other) == 12
        assert set(other.parts) < set(pilot.parts)
        assert other.difference == pytest.approx(other.parts.mean())
    spread = np.std([other.difference for other in others])
    assert spread == pytest.approx(pilot.parts.std() / math.sqrt(12), rel=0.1)


def test_too_few_recordings_to_plan_from_give_no_number():
    truth = [at(f, 50, track=1, recording=r) for r in range(8) for f in range(6)]
    x = [box for box in truth if box.recording]  # X misses one pedestrian of eight, Y none
    plan = plan_recordings(result_of(make_dataset(truth, x, truth, places=[Place(range(6))] * 8)))
    (size,) = plan.sizes
    assert (size.n_recordings, size.most_recordings, size.points) == (None, None, ())
    assert size.reason.startswith("too few recordings to plan from: ")
    first, *_ = notes_for_verdict(plan)
    assert (first.key, first["reason"]) == ("plan.no_size", size.reason)


@pytest.mark.parametrize(("lucky", "n_recordings"), [(200, 205), (MOST_RECORDINGS, None)])
def test_a_size_that_reached_the_target_by_luck_alone_is_passed_by(
    lucky: int, n_recordings: int | None
):
    def count(n: int, n_studies: int) -> int:
        """Power that reaches 80 % at `lucky`, but with more studies there, only behind it."""
        power = float(norm.cdf(norm.ppf(0.8) + 0.2 * (math.sqrt(n) - math.sqrt(lucky - 0.5))))
        return round((0.79 if n == lucky and n_studies > 300 else power) * n_studies)

    length = find_length(count, guess=lucky / 2, least=6, target=0.8)
    assert {point.n_recordings: point.power for point in length.points}[lucky] == 0.79
    assert length.n_recordings == n_recordings


def test_noninferiority_of_equal_systems_takes_what_a_one_sided_t_test_does():
    pilot, n_studies = normal_pilot(), 4000
    for n in (10, 30):
        shown = count_noninferior(pilot, 0.0, n, n_studies, margin=0.5, sign=1) / n_studies
        expected = float(nct.sf(t.isf(0.025, n - 1), n - 1, 0.5 * math.sqrt(n)))
        assert shown == pytest.approx(expected, abs=0.05)
    at_the_margin = count_noninferior(pilot, -0.5, 30, n_studies, margin=0.5, sign=1)
    assert at_the_margin / n_studies == pytest.approx(0.025, abs=0.012)


def evidence(**changes: object) -> Evidence:
    row = Evidence(
        figure="encounters_detected_by_unit",
        label="share of encounters detected, by recordings",
        better="higher",
        x=0.8,
        y=0.78,
        difference=0.02,
        low=-0.01,
        high=0.05,
        n=20,
        unit="recordings",
        note="",
    )
    return replace(row, **changes)


def test_a_system_is_shown_not_to_be_worse_where_the_interval_is_beyond_the_margin():
    # X - Y is -0.01 to 0.05: Y is at worst 0.05 worse than X, X at worst 0.01 worse than Y
    assert judge_noninferiority(evidence(), "y", 0.06).is_shown is True
    assert judge_noninferiority(evidence(), "y", 0.05).is_shown is False
    assert judge_noninferiority(evidence(), "x", 0.02).is_shown is True
    y = judge_noninferiority(evidence(), "y", 0.06)
    assert (y.worse, y.worse_at_most) == (0.02, 0.05)
    # of a measure of which less is better it is the other end
    lower = evidence(better="lower")
    assert judge_noninferiority(lower, "y", 0.02).is_shown is True
    assert judge_noninferiority(lower, "x", 0.05).is_shown is False
    assert judge_noninferiority(lower, "x", 0.05).worse == 0.02


def test_blocks_of_time_and_few_recordings_show_no_noninferiority():
    blocks = judge_noninferiority(evidence(unit="blocks"), "y", 0.06)
    assert blocks.is_shown is None
    assert "nothing of other recordings" in blocks.reason
    assert math.isnan(blocks.worse_at_most)
    few = evidence(
        low=math.nan,
        high=math.nan,
        note="too few recordings for an interval: 7, at least 8 are needed",
    )
    answer = judge_noninferiority(few, "y", 0.06)
    assert (answer.is_shown, answer.reason) == (None, few.note)


def test_unequal_operating_points_show_no_noninferiority():
    answer = judge_noninferiority(evidence(), "y", 0.06, is_undecided=True)
    assert (answer.is_shown, answer.reason) == (
        None,
        "X and Y are set to different operating points",
    )
    assert math.isnan(answer.worse_at_most)
    truth = [at(f, 50, track=1, recording=r) for r in range(8) for f in range(6)]
    x = [box for box in truth if box.frame or box.recording % 3]
    y = truth + [at(f, 5, recording=r) for r in range(8) for f in range(6)]
    result = result_of(make_dataset(truth, x, y, places=[Place(range(6))] * 8))
    plan = plan_recordings(result, PlanArguments("mean_similarity", margin=0.5))
    notes = notes_of_plan(plan)
    assert Note("plan.unequal") in notes
    (answered,) = (note for note in notes if note.key == "plan.not_worse")
    assert "end" not in answered.fields
    assert (answered["candidate"], answered["margin"]) == ("y", 0.5)


def test_the_pilot_is_what_each_recording_adds_to_the_measure():
    result = result_of(drives(12))
    rows = by_figure(result)
    for name, key in PLAN_KEYS.items():
        if key == "log_average_miss_rate" or key not in rows.index:  # nobody is urgent
            continue
        pilot, why_not = make_pilot(result, key)
        assert why_not == ""
        assert pilot is not None
        assert pilot.difference == pytest.approx(rows.loc[key, "difference"]), name
        assert pilot.parts.sum() / pilot.weights.sum() == pytest.approx(pilot.difference)
        # of another difference, with the variance of a pilot of independent recordings
        other = pilot.parts_for(0.3)
        assert other.sum() / pilot.weights.sum() == pytest.approx(0.3)
        rest = other - 0.3 * pilot.weights
        assert (rest**2).mean() == pytest.approx((pilot.residuals**2).sum() / 11)
    pilot, _ = make_pilot(result, "encounters_detected_by_unit")
    assert (len(pilot), pilot.n_encounters) == (12, 5)


def asking(**asked: Any) -> PlanArguments:
    """A plan for encounters detected."""
    return PlanArguments("encounters_detected", **asked)


def test_no_number_of_recordings_shows_what_may_be_owed_to_more_false_alarms():
    (size,) = plan_recordings(result_of(drives(12))).sizes
    assert size.n_recordings is None
    assert "also has more false alarms" in size.reason
    assert plan_recordings(result_of(quiet_drives(12))).sizes[0].n_recordings is not None


def test_a_plan_says_recordings_encounters_and_time():
    result = result_of(quiet_drives(12))
    plan = plan_recordings(result, asking(difference=0.2))
    named, as_found = plan.sizes
    assert (named.assumption, as_found.assumption) == ("as named", "as found")
    assert named.difference == 0.2  # X detects more, as found
    assert named.n_encounters == 5 * named.n_recordings
    assert named.least_recordings < named.n_recordings < named.most_recordings
    assert as_found.n_recordings < named.n_recordings  # the difference is larger
    assert set(plan.curve["assumption"]) == {"as named", "as found"}
    key, n = plan.evidence.figure, named.n_recordings
    assert plan.evidence.low > 0  # 0 is excluded, by this measure alone
    _, ends, size, _, _, *advice = notes_of_plan(plan)
    assert (ends.key, ends["n"], ends["low"]) == ("plan.excluded", 12, plan.evidence.low)
    assert size["sought"] == Note("plan.as_named", key=key, difference=0.2)
    extent = {"n_recordings": n, "n_encounters": 5 * n, "duration_s": named.duration_s}
    assert size["extent"] == Note("plan.extent", **extent)
    assert advice == [Note("plan.fresh")]
    again = plan_recordings(result, asking(difference=0.2))
    assert again.sizes == plan.sizes  # the seed is fixed


def test_tests_of_several_measures_and_more_power_take_more_recordings():
    result = result_of(quiet_drives(12))

    def n_needed(**asked: Any) -> int:
        return plan_recordings(result, asking(**asked)).sizes[0].n_recordings

    by_itself = n_needed(difference=0.1)
    assert n_needed(difference=0.1, n_tests=2) > by_itself
    assert n_needed(difference=0.1, power=0.95) > by_itself
    assert n_needed(difference=0.05) > 2 * by_itself


def test_a_plan_for_noninferiority_takes_both_for_equal_and_for_different_as_found():
    result = result_of(drives(12))  # Y detects far less
    plan = plan_recordings(result, asking(margin=0.1, candidate="y"))
    assert plan.noninferiority.is_shown is False
    equal, as_found = plan.sizes
    assert equal.n_recordings is not None
    assert as_found.n_recordings is None
    assert "worse by the margin or more" in as_found.reason
    better = plan_recordings(result, asking(margin=0.1, candidate="x"))
    assert better.noninferiority.is_shown is True
    assert better.sizes[1].n_recordings == 8  # the least with an interval
    (answered,) = (note for note in notes_of_plan(better) if note.key == "plan.not_worse")
    assert answered["is_shown"]
    assert answered["end"] < 0
    assumed = [size["assumed"].key for size in notes_of_plan(better)[3:5]]
    assert assumed == ["plan.if_equal", "plan.if_as_found"]


def test_the_miss_rate_can_be_planned_for():
    dataset = drives(12)
    score = np.random.default_rng(3).random(len(dataset.boxes))
    scored = replace(dataset, boxes=dataset.boxes.assign(score=score))
    plan = plan_recordings(result_of(scored), PlanArguments("log_average_miss_rate"))
    (size,) = plan.sizes
    assert plan.evidence.difference < 0  # X misses less
    assert size.difference == pytest.approx(plan.evidence.difference)
    assert size.n_recordings >= 6
    assert size.n_encounters == 5 * size.n_recordings
    assert size.power > 0.75


def equal_drives(n: int = 8):
    """Both systems detect the pedestrian of every recording."""
    truth = [at(frame, 50, track=1, recording=r) for r in range(n) for frame in range(6)]
    boxes = [at(frame, 50, recording=r) for r in range(n) for frame in range(6)]
    return result_of(make_dataset(truth, boxes, boxes, places=[Place(range(6))] * n))


def test_without_recordings_variation_or_difference_there_is_a_reason_and_no_size():
    few = plan_recordings(result_of(drives(5)))
    assert few.sizes[0].n_recordings is None
    assert "a pilot of 6 recordings or more, here are 5" in few.sizes[0].reason
    assert Note("plan.blocks") in notes_of_plan(few)
    assert notes_for_verdict(few) == ()
    equal = plan_recordings(equal_drives())
    assert "X and Y are the same in every recording" in equal.sizes[0].reason
    assert notes_of_plan(equal)[-1].key == "plan.no_size"


def test_a_plan_in_words():
    plan = plan_recordings(result_of(quiet_drives(12)), asking(difference=0.2))
    first, exclude, named, found, level, fresh = plan.sentences
    assert first.startswith("Share of encounters detected, by recordings: X ")
    assert " in 12 recordings with 60 encounters; p = " in first
    assert exclude.startswith(
        "By the 95 % interval of these 12 recordings, a difference X - Y below +"
    )
    assert " would show a difference of 20.0 pp in 80 % of studies (simulated: " in named
    most = plan.sizes[0].most_recordings
    assert f" recordings: plan for {most} to keep the 80 %" in named
    assert " would show a difference as large as found here (+" in found
    assert level.startswith("A study shows this if p of this measure alone")
    assert fresh.startswith("This is the size of a separate study")


@pytest.mark.parametrize(
    ("n_unseen", "reason"),
    [
        (1, "too few recordings to plan from: 1 of 10 has encounters that count for it, at least "),
        (
            5,
            "too few recordings to plan from: 5 of 10 have encounters that count for it, at least ",
        ),
        (6, "X and Y differ by the same in every recording that has encounters that count for it:"),
        (10, "X and Y differ by the same in every recording: there is no variation to plan from"),
    ],
)
def test_recordings_without_an_encounter_of_the_measure_do_not_differ(n_unseen: int, reason: str):
    truth = [
        at(0, 50, track=1, recording=i, detectability=0.1 if i < n_unseen else 0.9)
        for i in range(10)
    ]
    x = [box._replace(score=1.0) for box in truth]
    result = result_of(make_dataset(truth, x, places=[Place(range(3))] * 10))
    pilot, why_not = make_pilot(result, "useful_alerts_by_unit")
    assert pilot is None
    assert why_not.startswith(reason)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"measure": "recal"}, "no study can be planned for 'recal'"),
        ({"difference": 3.0}, "expected a share below 1, such as 0.03 for 3 percentage points"),
        ({"margin": -0.1}, "expected a number above 0"),
        ({"margin": 0.1, "difference": 0.1}, "give one of the two"),
        ({"power": 80}, "expected a share from 0.5 to 0.99"),
        ({"candidate": "z", "margin": 0.1}, "expected x or y"),
        ({"n_tests": 0}, "expected 1 or more"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments, words):
    with pytest.raises(ParameterError, match=words):
        plan_recordings(
            equal_drives(), PlanArguments(**{"measure": "encounters_detected"} | arguments)
        )


def scored(n: int = 30, share_y: float = 0.7, alarms_y: int = 2) -> Result:
    """X detects nine pedestrians of ten, Y fewer; a false alarm of X a frame, of Y `alarms_y`."""
    rng = np.random.default_rng(7)
    truth, x, y = [], [], []
    for number in range(n):
        ease = 0.2 * rng.random()
        for frame in range(20):
            for track, centre in enumerate((30, 50, 70)):
                truth.append(at(frame, centre, track=track, recording=number))
                for boxes, share in ((x, 0.9), (y, share_y)):
                    if rng.random() < share - ease:
                        score = 0.3 + 0.7 * rng.random()
                        boxes.append(at(frame, centre, recording=number, score=score))
            for boxes, n_alarms in ((x, 1), (y, alarms_y)):
                for _ in range(rng.poisson(n_alarms / 2)):
                    boxes.append(at(frame, 5, recording=number, score=0.8 * rng.random()))
    return result_of(make_dataset(truth, x, y, places=[Place(range(20))] * n))


def test_a_curve_is_read_between_its_thresholds_by_the_alarms_of_a_study() -> None:
    curve = Curve(np.array([[1.0, 0], [2, 2], [4, 6]]), np.array([[5.0, 5], [6, 7], [8, 11]]))
    drawn = np.array([[1, 1], [2, 0], [0, 2], [1, 1]])
    # totals of these studies: 1 4 10, 2 4 8, 0 4 12
    alarms, parts = curve.at(drawn, np.array([7.0, 3.0, 12.0, 99.0]))
    assert alarms.tolist() == [[3, 4], [1.5, 1], [4, 6], [4, 6]]
    assert parts.tolist() == [[7, 9], [5.5, 6], [8, 11], [8, 11]]


@pytest.mark.parametrize("alarms_y", [1, 2])
def test_the_pilot_as_a_study_finds_what_the_comparison_at_equal_alarms_does(alarms_y: int) -> None:
    result = scored(alarms_y=alarms_y)
    equal = find_equal_alarms(result)
    units, key = find_units(equal), "severity_s_per_encounter"
    measure = next(of for of in unit_measures(equal, units) if of.key == key)
    thresholds = vary_thresholds(result, units)[key]
    once = np.ones((1, len(units)), dtype=int)
    (parts,), (is_unequal,), (more,) = parts_at_equal_alarms(thresholds, once)
    assert (is_unequal, more) == (
        are_unequal(result),
        np.sign(count_alarms(result.x) - count_alarms(result.y)),
    )
    difference = np.subtract(*values_of(key, equal))
    assert parts.sum() / measure.x[:, 1].sum() == pytest.approx(difference, rel=0.05)
    weights = measure.x[:, 1]
    shifted = measure.x[:, 0] - measure.y[:, 0]
    shift = shifts_at_equal_alarms(equal, units).get(key, np.zeros(len(units)))
    shifted -= shift * weights.sum() / len(units)
    assert np.corrcoef(parts, shifted)[0, 1] > 0.97
    assert parts.std() == pytest.approx(shifted.std(), rel=0.1)


def test_a_study_that_claims_for_the_other_system_does_not_count() -> None:
    pilot = normal_pilot()
    better = np.array([1.0, -1.0, 0.0, 1.0])
    assert [_count_claims(better, difference) for difference in (0.1, -0.1, 0.0)] == [2, 1, 3]
    shown = [count_differences_shown(pilot, d, 60, 200, level=0.05) for d in (1.0, -1.0)]
    assert min(shown) > 150


@pytest.mark.parametrize(("scale", "is_alike"), [(1.0, True), (0.1, False)])
def test_a_threshold_that_cannot_give_the_alarms_sets_nothing_alike(
    scale: float, is_alike: bool
) -> None:
    rng = np.random.default_rng(3)
    alarms, parts = rng.poisson(4, (1, 30)).astype(float), rng.normal(1, 0.1, (1, 30))
    laxer = Curve(scale * np.concatenate([0 * alarms, alarms]), np.concatenate([parts, parts + 1]))
    thresholds = Thresholds((Curve(alarms, parts), Curve(alarms / 2, parts)), (None, laxer))
    own_parts, *_ = parts_at_equal_alarms(thresholds, np.ones((1, 30), dtype=int))
    assert np.isfinite(own_parts).all() == is_alike


def test_exchanged_systems_have_the_parts_with_the_other_sign() -> None:
    result = scored()
    swapped = compare(result.dataset, x="y", y="x")
    drawn = np.random.default_rng(1).multinomial(40, np.full(30, 1 / 30), size=50)
    there, back = (
        parts_at_equal_alarms(vary_thresholds(of, find_units(of))["mean_similarity"], drawn)
        for of in (result, swapped)
    )
    assert there[0].ravel().tolist() == pytest.approx((-back[0]).ravel().tolist(), rel=1e-6)
    assert there[1].tolist() == back[1].tolist()
    assert there[2].tolist() == (-back[2]).tolist()


def test_a_plan_at_thresholds_of_their_own_is_about_equal_false_alarms() -> None:
    equal = find_equal_alarms(scored(share_y=0.85))
    asked = PlanArguments("mean_similarity")
    plan = plan_recordings(equal, asked)
    assert plan.evidence.difference == pytest.approx(
        np.subtract(*values_of("mean_similarity", equal))
    )
    (size,) = plan.sizes
    assert 0.75 < size.power < 0.9
    assert Comparison(equal.as_set).plan(measure="mean_similarity").sizes == plan.sizes


def test_a_plan_is_json_whatever_kind_of_integers_it_holds():
    plan = plan_recordings(result_of(quiet_drives(12)))
    numbers = replace(plan, n_encounters=np.int64(plan.n_encounters))
    assert json.loads(plan_json(numbers)) == json.loads(plan_json(plan))
