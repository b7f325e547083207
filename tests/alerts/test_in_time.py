from __future__ import annotations

from dataclasses import replace
from itertools import chain

import numpy as np
import pandas as pd
import pytest
import scipy
from approach import ALL, PLACE, approach, met
from builders import make_dataset
from places import SAMPLE

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.bootstrap import expanded_tail
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.notes import say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params
from nvcore.subjects.alerts.in_time import (
    NEVER,
    REACTIONS,
    InTime,
    Reaction,
    chance_in_time,
    intervals,
    judge_in_time,
    slack_at_onset,
)
from nvcore.subjects.alerts.notes import doubt_of_kind
from nvcore.subjects.time_left.steps import confirmed_by, is_in_time, time_left_of

EXACTLY = {"own": Reaction(1.2, 0.0)}


@pytest.fixture(scope="module")
def result() -> Result:
    return compare(load(read_session(SAMPLE)))


def onsets(result: Result) -> list[np.ndarray]:
    """An alert as soon as a system is sure of the pedestrian."""
    return [confirmed_by(system)["confirmed_row"].to_numpy() for _, system in result.sides]


@pytest.fixture(scope="module")
def judged(result: Result) -> InTime:
    return judge_in_time(result, onsets(result), reactions={**EXACTLY, **REACTIONS})


def row_of(judged: InTime, kind: str, measure: str, side: str) -> pd.Series:
    return judged.table.set_index(["kind", "measure", "side"]).loc[(kind, measure, side)]


class One:
    """A single encounter."""

    offsets, order, frame_index = np.array([0, 5]), np.arange(5), np.arange(5)

    def __len__(self) -> int:
        return 1


def slack_of_one(ttc_s: np.ndarray, onset: int, *, last: int) -> pd.DataFrame:
    rows, time_s = (np.array([row]) for row in (onset, last)), np.arange(5) / 2
    return slack_at_onset(One(), ttc_s, np.ones(5), time_s, *rows, reaction_s=1.2)


# One pedestrian in frames 0 to 4, 0.5 s apart, known from frame 1 on; braking takes 1.0 s.
TTC = np.array([np.nan, 3.0, 2.4, 2.6, 1.5])


@pytest.mark.parametrize(
    ("onset", "slack", "ttc"),
    [
        pytest.param(1, 2.0, 3.0, id="at the first known frame"),
        pytest.param(3, 1.4, 2.6, id="the least so far counts, not a later one that gives time"),
        pytest.param(4, 0.5, 1.5, id="at the end"),
        pytest.param(0, 2.5, 3.5, id="before: half a second more than when it is first known"),
        pytest.param(-1, NEVER, np.nan, id="no alert"),
    ],
)
def test_the_slack_of_an_alert_by_hand(onset: int, slack: float, ttc: float) -> None:
    found = slack_of_one(TTC, onset, last=-1)
    assert found["slack_s"].tolist() == pytest.approx([slack])
    assert found["ttc_s"].tolist() == pytest.approx([ttc], nan_ok=True)


@pytest.mark.parametrize(
    ("onset", "slack"),
    [(0, 2.2), (1, 1.7), (2, 1.2), (3, 0.8)],
    ids=["1 s before", "", "at", "after"],
)
def test_nobody_has_longer_than_until_the_last_chance_and_the_reaction(onset, slack) -> None:
    # not closing until the last chance, frame 2 at 1 s
    found = slack_of_one(np.array([np.inf, np.inf, np.inf, 1.8, 1.0]), onset, last=2)
    assert found["slack_s"].tolist() == pytest.approx([slack])
    assert found["ttc_s"].tolist() == pytest.approx([slack + 1])


def test_the_mean_and_spread_of_reactions_are_those_of_the_source() -> None:
    normal = np.random.default_rng(1).standard_normal(400_000)
    for reaction in REACTIONS.values():
        times = reaction.times(normal)
        assert times.mean() == pytest.approx(reaction.mean_s, rel=0.01)
        assert times.std() == pytest.approx(reaction.sd_s, rel=0.02)


def test_without_spread_and_onset_at_confirmation_it_is_the_time_left(
    result: Result, judged: InTime
) -> None:
    for letter, system in result.sides:
        here = judged.chances[f"own_{letter}"].to_numpy() == 1
        assert np.array_equal(here, is_in_time(system)[judged.chances.index])
        impact = row_of(judged, "own", "impact_kmh", letter)
        assert impact["mean"] == pytest.approx(time_left_of(system)["impact_kmh"].mean())
        assert impact["draws_low"] == impact["draws_high"]


def test_all_kinds_are_judged_on_the_same_encounters(judged: InTime) -> None:
    kinds = ["haptic", "visual", "audio"]  # by their mean reaction
    for letter in "xy":
        chances = judged.chances[[f"{kind}_{letter}" for kind in kinds]].sum().to_numpy()
        shares = [row_of(judged, kind, "share", letter)["mean"] for kind in kinds]
        assert np.all(np.diff(shares) <= 0)
        assert shares == pytest.approx(chances / len(judged.chances), abs=1e-12)


@pytest.mark.parametrize("term", ["movement_s", "brakes_s"])
def test_more_time_before_the_brakes_act_never_brings_more_in_time(
    result: Result, judged: InTime, term: str
) -> None:
    later = judge_in_time(result, onsets(result), **{term: 0.3})
    for kind in REACTIONS:
        for letter in "xy":
            name = f"{kind}_{letter}"
            assert (later.chances[name] <= judged.chances[name]).all()
            assert later.chances[name].sum() < judged.chances[name].sum()


def test_exchanged_systems_are_mirrored(result: Result, judged: InTime) -> None:
    mirrored = judge_in_time(result, onsets(result)[::-1])
    for kind in REACTIONS:
        for measure in ("share", "impact_kmh"):
            before, after = (row_of(of, kind, measure, "difference") for of in (judged, mirrored))
            assert after["mean"] == pytest.approx(-before["mean"])
            assert after["low"] == pytest.approx(-before["high"])
            one, other = row_of(judged, kind, measure, "x"), row_of(mirrored, kind, measure, "y")
            pd.testing.assert_series_equal(one, other, check_names=False)


def test_the_doubt_of_drivers_and_of_recordings_is_kept_apart_and_joined(judged: InTime) -> None:
    for kind in REACTIONS:
        row = row_of(judged, kind, "share", "difference")
        apart = [row[f"{of}_high"] - row[f"{of}_low"] for of in ("draws", "units")]
        # a recording that is drawn twice brings its driver twice
        assert max(apart) < row["high"] - row["low"] < 1.05 * sum(apart)
        mean, study = (
            f"{100 * row[low]:+.0f} to {100 * row[high]:+.0f}"
            for low, high in (("units_low", "units_high"), ("low", "high"))
        )
        text = say(doubt_of_kind(judged, kind), PEDESTRIAN)
        assert f"(95 % interval of the mean over drivers and recordings: {mean})" in text
        assert text.endswith(f"would find {study}.")


def test_a_share_is_the_same_number_in_the_sentence_and_in_the_table_of_a_hundred() -> None:
    result = met((range(9, 40), range(22, 40)))
    judged = judge_in_time(result, onsets(result))
    for kind in REACTIONS:
        of_hundred = judged.of_hundred(kind).loc["all"]
        for letter in "xy":
            share = of_hundred["both"] + of_hundred[f"only_{letter}"]
            assert row_of(judged, kind, "share", letter)["mean"] == pytest.approx(share / 100)


@pytest.mark.parametrize(("n_drives", "ends"), [(1, [0, 1]), (8, [0.125, 0.875])])
def test_one_driver_drives_a_recording_through(n_drives: int, ends: list[float]) -> None:
    # eight urgent encounters with one slack, in which half of all drivers are in time: one driver
    # is in time in all of them or in none
    places = [number % n_drives for number in range(8)]
    boxes = [
        approach(ALL, 5, centre=10 + 10 * n, track=n, recording=of) for n, of in enumerate(places)
    ]
    result = compare(make_dataset([*chain(*boxes)], places=[PLACE] * n_drives))
    onset = result.encounters.recording * len(ALL) + 25
    row = row_of(judge_in_time(result, [onset] * 2), "visual", "share", "x")
    assert [row["draws_low"], row["draws_high"]] == ends


def test_few_units_have_no_interval_and_no_encounters_no_share() -> None:
    few = intervals(np.array([[1.0, 2.0], [0.0, 2.0]]), np.array([2, 2]))
    assert few["mean"] == pytest.approx(0.625)
    assert np.isnan([few["units_low"], few["low"]]).all()
    assert np.isnan(intervals(np.zeros((5, 0)), np.zeros(0, int))["mean"])


def test_the_ends_over_few_units_are_those_of_the_other_measures() -> None:
    # 8 units of one encounter, half of them in time whoever drives: binomial, of 8
    of_units = intervals(np.tile([1.0, 0.0], (4000, 4)), np.ones(8, int))
    ends = scipy.stats.binom.ppf([expanded_tail(8), 1 - expanded_tail(8)], 8, 0.5) / 8
    assert [of_units["units_low"], of_units["units_high"]] == ends.tolist() == [0.125, 0.875]
    assert of_units["draws_low"] == of_units["draws_high"] == 0.5


@pytest.mark.parametrize(
    ("n_urgent", "units", "has_interval"),
    [
        (8, [""] * 10, True),
        (7, [""] * 10, False),  # in three recordings nobody is met
        (9, ["a", "a", "b", "b", *[""] * 6], False),  # seven units
    ],
)
def test_an_interval_is_over_units_in_which_somebody_is_urgent(n_urgent, units, has_interval):
    drives = [approach(ALL, 5, centre=30 + row, recording=row) for row in range(n_urgent)]
    boxes = [box for drive in drives for box in drive]
    dataset = make_dataset(boxes, places=[PLACE] * 10)
    dataset = replace(dataset, recordings=dataset.recordings.assign(unit=units))
    judged = judge_in_time(
        compare(dataset), [9 + len(ALL) * np.arange(n_urgent), np.full(n_urgent, -1)]
    )
    ends = row_of(judged, "haptic", "share", "x")[["units_low", "units_high", "low", "high"]]
    assert ends.notna().tolist() == [has_interval] * 4
    assert judged.what_varies == ("units" if "a" in units else "recordings")


def test_of_a_hundred_encounters_everyone_is_counted_once(judged: InTime) -> None:
    chances = judged.chances.head(4).assign(
        is_known=[True, True, True, False],
        is_seen=[True, False, False, False],
        haptic_x=[1.0, 0.8, 0.0, 0.5],
        haptic_y=[1.0, 0.5, 0.2, 0.0],
        haptic_both=[1.0, 0.5, 0.0, 0.0],
    )
    table = replace(judged, chances=chances).of_hundred("haptic")
    assert table.to_numpy() == pytest.approx(
        np.array(
            [
                [25, 25, 0, 0, 0],
                [50, 12.5, 7.5, 5, 25],
                [25, 0, 12.5, 0, 12.5],
                [100, 37.5, 20, 5, 37.5],
            ]
        )
    )
    assert table.index.tolist() == ["sees", "does_not", "not_known", "all"]


def test_of_a_hundred_encounters_nobody_is_said_to_be_unseen_if_nothing_is_known(
    judged: InTime,
) -> None:
    chances = judged.chances.assign(is_known=False, is_seen=False)
    table = replace(judged, chances=chances).of_hundred("haptic")
    assert table.index.tolist() == ["sees", "does_not", "all"]
    assert table.loc[["sees", "does_not"]].isna().all(axis=None)
    assert table.loc["all", "encounters"] == 100


def test_a_chance_is_what_the_lognormal_says() -> None:
    haptic = REACTIONS["haptic"]
    median = haptic.mean_s / np.sqrt(1 + (haptic.sd_s / haptic.mean_s) ** 2)
    slack = np.array([NEVER, 0.0, median, median + 0.4, np.inf])
    assert chance_in_time(slack, haptic, 0.0)[[0, 1, 2, 4]] == pytest.approx([0, 0, 0.5, 1])
    assert chance_in_time(slack, haptic, 0.4)[3] == pytest.approx(0.5)


def test_nobody_urgent_is_no_share(result: Result) -> None:
    slow = compare(result.dataset, Params(speed_kmh=0.001, reaction_s=0))
    judged = judge_in_time(slow, onsets(slow))
    assert judged.chances.empty
    assert judged.table["mean"].isna().all()
