"""Plans that can be counted by hand."""

from collections import Counter
from itertools import pairwise

import pytest

from nvcore.common.errors import InputError
from nvcore.subjects.driver.study.plan import duration_s, plan_trials
from nvcore.subjects.driver.study.settings import ADAPTATION_S, Timing

PAIRS = {(0.0, 4.0), (1.0, 5.5), (2.5, 7.0)}


def plan(n, participant=0, design="latin", timing=None):
    return plan_trials(n, participant, design=design, timing=timing or Timing())


def runs_of(trials):
    runs = {}
    for trial in trials:
        runs.setdefault(trial.run, []).append(trial)
    return list(runs.values())


@pytest.mark.parametrize("n", [2, 3, 51])
def test_with_all_every_picture_is_shown_at_every_time_two_in_each_run(n):
    trials = plan(n, design="all")
    assert Counter((t.picture, t.adaptation_s) for t in trials) == Counter(
        (picture, time_s) for picture in range(n) for time_s in ADAPTATION_S
    )
    assert len(runs_of(trials)) == 3 * n  # of the paper's 51 pictures: 153
    for first, second in runs_of(trials):
        assert first.picture != second.picture
        assert (first.adaptation_s, second.adaptation_s) in PAIRS
        assert (first.position, second.position) == (1, 2)


def test_in_a_latin_square_every_picture_is_shown_once_and_at_every_time_over_six():
    plans = [plan(12, participant) for participant in range(6)]
    for trials in plans:
        assert sorted(t.picture for t in trials) == list(range(12))
        assert Counter(t.adaptation_s for t in trials) == dict.fromkeys(ADAPTATION_S, 2)
        assert all(tuple(t.adaptation_s for t in run) in PAIRS for run in runs_of(trials))
        assert len(runs_of(trials)) == 6
    over_all = Counter((t.picture, t.adaptation_s) for trials in plans for t in trials)
    assert set(over_all.values()) == {1}
    assert len(over_all) == 12 * 6


@pytest.mark.parametrize("n", [1, 2, 5, 51])
@pytest.mark.parametrize("participant", range(6))
def test_pictures_that_fill_no_run_are_shown_alone(n, participant):
    trials = plan(n, participant)
    assert sorted(t.picture for t in trials) == list(range(n))
    sizes = Counter(len(run) for run in runs_of(trials))
    assert set(sizes) <= {1, 2}
    assert sizes[1] <= 2
    assert all(run[0].position == 1 for run in runs_of(trials))


def test_trials_and_runs_count_from_1_in_order():
    trials = plan(51, design="all")
    assert [t.order for t in trials] == list(range(1, 307))
    assert [t.run for t in trials] == [1 + i // 2 for i in range(306)]


def test_a_plan_is_the_same_again_and_another_for_the_next():
    assert plan(12, 3) == plan(12, 3)
    assert [t.picture for t in plan(12, 3)] != [t.picture for t in plan(12, 9)]  # same square


def test_with_many_pictures_none_comes_in_two_runs_in_a_row():
    for participant in range(4):
        runs = [{t.picture for t in run} for run in runs_of(plan(51, participant, design="all"))]
        assert not any(a & b for a, b in pairwise(runs))


def test_too_few_pictures_are_refused():
    with pytest.raises(InputError, match="needs 2 pictures"):
        plan(1, design="all")
    with pytest.raises(InputError, match="needs 1 pictures"):
        plan(0)


def test_more_trials_than_a_participant_can_see_are_refused():
    times = Timing(adaptation_s=range(24), answer_s=0)
    assert len(plan(125, design="all", timing=times)) == 3000
    with pytest.raises(InputError, match="would see 3,024 pictures, and 3,000 are the most"):
        plan(126, design="all", timing=times)
    assert len(plan(126, timing=times)) == 126


def test_the_length_of_a_study_is_that_of_its_parts():
    timing = Timing(adaptation_s=(1, 5), bright_s=10, preview_s=2, cross_s=1, answer_s=3)
    trials = plan(2, timing=timing)
    # bright, two previews, cross, second picture after 5 s, picture, answer, going on
    assert duration_s(trials, timing) == pytest.approx(10 + 4 + 1 + 5 + 0.5 + 3 + 2)
    hours = duration_s(plan(51, design="all"), Timing()) / 3600
    assert hours == pytest.approx(1.955, abs=0.001)  # the paper's study, for each of its subjects
