"""The clock of a recording: its light, the time to adapt, and a change that never was."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nvcore.dataset.tables import frames_table
from nvcore.subjects.driver.illumination import Light, LightSettings, LightSource
from nvcore.subjects.driver.illumination.clock import (
    AdaptationClock,
    adaptation_clock,
    period_after,
    with_change,
)

FPS = 10.0
FRAMES = np.arange(100)


def light(dark_from_s: float = 5.0) -> Light:
    times = np.arange(-50, 80) / FPS
    return Light(times, np.where(times < dark_from_s - 1e-9, 1000.0, 10.0))


def test_the_period_runs_to_the_end_of_each_frame():
    clock = adaptation_clock(light(), FRAMES, FPS)
    assert clock.change_s == pytest.approx([5.0])
    assert np.isnan(clock.period_s[:50]).all()
    assert clock.period_s[[50, 60]] == pytest.approx([0.1, 1.1])
    assert clock.level[[49, 50]].tolist() == [1000.0, 10.0]
    assert clock.source is LightSource.METER


def test_after_the_last_reading_nothing_is_known():
    clock = adaptation_clock(light(), FRAMES, FPS)
    assert np.isfinite(clock.period_s[89])
    assert np.isnan(clock.period_s[90:]).all()
    assert np.isnan(clock.level[90:]).all()


def test_a_simulated_change_restarts_the_clock_until_a_real_one():
    clock = with_change(adaptation_clock(light(), FRAMES, FPS), FPS, 2.0)
    assert clock.change_s == pytest.approx([2.0, 5.0])
    assert clock.simulated_s == 2.0
    assert np.isnan(clock.period_s[19])
    assert clock.period_s[[20, 49, 50]] == pytest.approx([0.1, 3.0, 0.1])
    later = with_change(adaptation_clock(light(), FRAMES, FPS), FPS, 6.0)
    assert later.period_s[[59, 60, 61]] == pytest.approx([1.0, 0.1, 0.2])


def test_a_simulated_change_does_not_come_back_after_a_real_one_is_over():
    times = np.arange(-100, 300) / 20
    is_dark = (times > 4.99) & (times < 6.99)
    clock = adaptation_clock(Light(times, np.where(is_dark, 10.0, 1000.0)), FRAMES, FPS)
    assert np.isnan(clock.period_s[75:85]).all()
    simulated = with_change(clock, FPS, 2.0)
    assert simulated.period_s[[49, 50]] == pytest.approx([3.0, 0.1])
    assert np.isnan(simulated.period_s[75:85]).all()
    assert simulated.is_simulated is not None
    assert not simulated.is_simulated[50:].any()
    sparse = np.r_[0:50, 75:85]  # no row in the dark
    periods = period_after(clock.period_s[sparse], (sparse + 1) / FPS, 2.0, real_s=clock.change_s)[
        0
    ]
    np.testing.assert_array_equal(periods[50:], np.nan)


def test_where_nothing_is_known_of_the_light_only_the_simulated_change_is():
    clock = with_change(adaptation_clock(None, FRAMES, FPS), FPS, 3.0)
    assert np.isnan(clock.level).all()
    assert np.isnan(clock.period_s[:30]).all()
    assert clock.period_s[99] == pytest.approx(7.0)


def test_frames_that_end_before_or_at_the_change_keep_their_period():
    period_s, is_simulated = period_after(
        np.array([np.nan, 4.0, 4.1]), np.array([1.0, 2.0, 2.1]), 2.0
    )
    assert is_simulated.tolist() == [False, False, True]
    np.testing.assert_allclose(period_s, [np.nan, 4.0, 0.1])


@pytest.mark.parametrize("fps", [10.0, 20.0, 25.0, 29.97])
def test_of_a_change_at_any_frame_that_frame_is_the_first_after_it(fps: float):
    frames = np.arange(300)
    nothing = np.full(300, np.nan)
    by_hand = [period_after(nothing, (frames + 1) / fps, k / fps)[1].argmax() for k in frames]
    assert by_hand == frames.tolist()
    by_added_time = [
        period_after(nothing, frames / fps + 1 / fps, k / fps)[1].argmax() for k in frames
    ]
    assert by_added_time == frames.tolist()


@pytest.mark.parametrize("fps", [10.0, 20.0, 25.0, 29.97])
@pytest.mark.parametrize("source", LightSource)
def test_a_drop_at_a_frame_leaves_the_frame_before_in_the_light(fps: float, source: LightSource):
    frames = np.arange(300)
    for dark_from in range(140, 180):
        level = np.where(frames < dark_from, 1000.0, 10.0)
        clock = adaptation_clock(Light(frames / fps, level, source), frames, fps)
        assert np.isnan(clock.period_s[:dark_from]).all()
        assert clock.period_s[dark_from] == pytest.approx(1 / fps)


@pytest.mark.parametrize("first", [0, 1, 600])
def test_times_are_those_of_the_dataset_which_begin_with_the_first_frame(first: int):
    """Frames of 20 a second; by the light's own time it is dark from 5 s after the first on."""
    frames = np.arange(first, first + 200)
    begin_s = first / 20
    times = np.arange(-100, 300) / 20 + begin_s
    readings = Light(times, np.where(times < begin_s + 5 - 1e-9, 1000.0, 10.0))
    clock = adaptation_clock(readings, frames, 20.0)
    listed = frames_table([frames], [20.0])["time_s"].to_numpy()
    assert clock.time_s.tolist() == listed.tolist()
    assert clock.change_s == pytest.approx([5.0])
    assert clock.level[[99, 100]].tolist() == [1000.0, 10.0]
    assert np.isnan(clock.period_s[99])
    assert clock.period_s[100] == pytest.approx(0.05)
    assert adaptation_clock(None, frames, 20.0).time_s.tolist() == listed.tolist()
    simulated = with_change(clock, 20.0, float(listed[40]))
    assert np.isnan(simulated.period_s[39])
    assert simulated.period_s[[40, 99, 100]] == pytest.approx([0.05, 3.0, 0.05])


def test_without_frames_there_is_an_empty_clock():
    assert not len(adaptation_clock(light(), np.empty(0, np.int64), FPS).time_s)


def test_adapted_eyes_are_told_from_what_is_not_known():
    clock = adaptation_clock(light(), FRAMES - 40, FPS)  # from 4 s before frame 0 on
    assert not clock.is_known[:20].any()  # readings begin 5 s before it, and 3 s are needed
    assert clock.is_known[20:].all()
    assert np.isnan(clock.seen_s[:20]).all()
    assert np.isposinf(clock.seen_s[20:90]).all()
    assert clock.seen_s[90] == pytest.approx(0.1)
    after = adaptation_clock(light(), FRAMES, FPS)  # readings end at 7.9 s, and hold a second
    assert after.is_known[:90].all()
    assert np.isnan(after.seen_s[90:]).all()
    assert not after.is_known[90:].any()


def test_only_frames_from_the_simulated_change_to_a_real_one_are_simulated():
    clock = with_change(adaptation_clock(light(), FRAMES, FPS), FPS, 2.0)
    assert clock.is_simulated is not None
    assert np.flatnonzero(clock.is_simulated[:90]).tolist() == list(range(20, 50))
    nothing = with_change(adaptation_clock(None, FRAMES, FPS), FPS, 3.0)
    assert nothing.is_known.tolist() == (FRAMES >= 30).tolist()
    assert np.isnan(nothing.seen_s[:30]).all()


def readings(*spans_s: tuple[float, float], dark_from_s: float = 5.0, step_s: float = 0.1) -> Light:
    """Readings within these spans only."""
    times = np.concatenate([np.arange(round((b - a) / step_s)) * step_s + a for a, b in spans_s])
    return Light(times, np.where(times < dark_from_s - 1e-9, 1000.0, 10.0))


def frames_at(clock: AdaptationClock, from_s: float, to_s: float) -> np.ndarray:
    begin_s = clock.time_s + 1e-9
    return (begin_s >= from_s) & (begin_s < to_s)


def test_in_a_gap_of_the_readings_the_light_is_not_known():
    """It becomes dark at 5 s; there is no reading after 4.4 s until 9 s."""
    clock = adaptation_clock(readings((-5, 4.5), (9, 20)), np.arange(150), FPS)
    assert len(clock.change_s) == 0
    np.testing.assert_array_equal(np.isnan(clock.level), frames_at(clock, 5.5, 9))
    np.testing.assert_array_equal(clock.is_known, ~frames_at(clock, 5.5, 12))
    assert np.isnan(clock.seen_s[frames_at(clock, 5.5, 12)]).all()
    assert np.isposinf(clock.seen_s[clock.is_known]).all()


def test_an_adaptation_that_runs_into_a_gap_is_not_known_to_go_on():
    clock = adaptation_clock(readings((-5, 6.1), (9, 20)), np.arange(150), FPS)
    assert clock.change_s == pytest.approx([5.0])
    np.testing.assert_array_equal(np.isfinite(clock.period_s), frames_at(clock, 5, 7.1))
    np.testing.assert_array_equal(clock.is_known, ~frames_at(clock, 7.1, 12))


def test_a_change_after_a_gap_is_known():
    clock = adaptation_clock(readings((-5, 1), (3, 20), dark_from_s=8), np.arange(150), FPS)
    assert clock.change_s == pytest.approx([8.0])
    assert clock.period_s[80] == pytest.approx(0.1)
    assert clock.is_known[60:].all()


@pytest.mark.parametrize("step_s", [2.0, 5.0])
def test_readings_that_are_far_apart_as_a_rule_have_no_gap(step_s: float):
    given = readings((-50, 50), step_s=step_s)
    assert not len(given.gaps_s)
    one_lost = np.delete(np.arange(len(given.time_s)), 6)
    late = Light(given.time_s[one_lost], given.level[one_lost])
    assert not len(late.gaps_s)
    clock = adaptation_clock(late, np.arange(150), FPS)
    assert clock.is_known.all()
    two_lost = np.delete(np.arange(len(given.time_s)), [6, 7])
    assert len(Light(given.time_s[two_lost], given.level[two_lost]).gaps_s) == 1


def test_readings_a_second_apart_are_next_to_each_other_where_others_are_closer():
    assert not len(readings((0, 5), (5.9, 9)).gaps_s)
    np.testing.assert_allclose(readings((0, 5), (6, 9)).gaps_s, [[4.9, 6.0]])


def test_pictures_that_are_missing_leave_a_gap_as_readings_do():
    given = readings((0, 4.5), (9, 15))
    pictures = Light(given.time_s, given.level / 1000, LightSource.PICTURE)
    clock = adaptation_clock(pictures, np.arange(150), FPS)
    np.testing.assert_array_equal(
        clock.is_known, frames_at(clock, 3, 5.5) | frames_at(clock, 12, 16)
    )


@given(
    steps=st.lists(st.integers(1, 40), min_size=20, max_size=120),
    levels=st.lists(st.sampled_from([0.05, 1.0, 9.0, 100.0, 2000.0]), min_size=120, max_size=120),
)
def test_what_is_known_has_readings_without_a_gap_behind_it(steps: list[int], levels: list[float]):
    given_light = Light(np.cumsum(steps) / 20, np.array(levels[: len(steps)]))
    clock = adaptation_clock(given_light, np.arange(400), FPS)
    begin_s = np.arange(400) / FPS
    longest = max(1.0, 2 * float(np.median(np.diff(given_light.time_s)))) + 1e-5
    for number in np.flatnonzero(clock.is_known):
        within = given_light.time_s <= begin_s[number] + 1e-9
        behind = given_light.time_s[within & (given_light.time_s > begin_s[number] - 3 - longest)]
        assert begin_s[number] - behind[0] >= 3 - 1e-5
        assert np.diff(np.append(behind, begin_s[number])).max() <= longest
    assert clock.is_known[~np.isnan(clock.period_s)].all()
    assert (clock.period_s[~np.isnan(clock.period_s)] > 0).all()


@given(
    factor=st.sampled_from([0.25, 0.5, 2.0, 4.0]),
    levels=st.lists(st.sampled_from([1.0, 9.0, 100.0, 2000.0]), min_size=30, max_size=60),
)
def test_in_a_film_that_runs_slower_everything_takes_as_much_longer(
    factor: float, levels: list[float]
):
    """Times and settings in seconds times a factor; steps stay above the second that holds."""
    times = np.arange(len(levels)) * 8.0
    settings = {"within_s": 12.0, "bright_for_s": 24.0, "smooth_s": 1.0}
    slower = {name: value * factor for name, value in settings.items()}
    frames = np.arange(len(levels) * 8)
    clock = adaptation_clock(Light(times, np.array(levels)), frames, 1.0, LightSettings(**settings))
    other = adaptation_clock(
        Light(times * factor, np.array(levels)), frames, 1 / factor, LightSettings(**slower)
    )
    np.testing.assert_allclose(other.period_s, clock.period_s * factor)
    np.testing.assert_allclose(other.change_s, clock.change_s * factor)
    np.testing.assert_array_equal(other.is_known, clock.is_known)
    np.testing.assert_array_equal(other.level, clock.level)
