"""The clock of a recording: its light, the time to adapt, and a change that never was."""

from __future__ import annotations

import numpy as np
import pytest

from nvcore.driver.clock import adaptation_clock, period_after, unknown_clock, with_change
from nvcore.driver.illumination import Light, LightSource

FPS = 10.0
FRAMES = np.arange(100)


def light(dark_from_s: float = 5.0) -> Light:
    times = np.arange(-50, 80) / FPS
    return Light(times, np.where(times < dark_from_s - 1e-9, 1000.0, 10.0))


def test_the_period_runs_to_the_end_of_each_frame():
    clock = adaptation_clock(light(), FRAMES, FPS)
    assert clock.change_s == pytest.approx([5.0])
    assert np.isnan(clock.period_s[:49]).all()
    assert clock.period_s[[49, 50, 60]] == pytest.approx([0.0, 0.1, 1.1])
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
    assert clock.period_s[[19, 20, 48, 50]] == pytest.approx([0.0, 0.1, 2.9, 0.1])
    later = with_change(adaptation_clock(light(), FRAMES, FPS), FPS, 6.0)
    assert later.period_s[[58, 61]] == pytest.approx([0.9, 0.2])


def test_where_nothing_is_known_of_the_light_only_the_simulated_change_is():
    clock = with_change(unknown_clock(FRAMES, FPS), FPS, 3.0)
    assert np.isnan(clock.level).all()
    assert np.isnan(clock.period_s[:29]).all()
    assert clock.period_s[99] == pytest.approx(7.0)


def test_frames_that_end_before_the_change_keep_their_period():
    period_s, is_simulated = period_after(
        np.array([np.nan, 4.0, 4.1]), np.array([1.0, 2.0, 2.1]), 2.0
    )
    assert is_simulated.tolist() == [False, True, True]
    np.testing.assert_allclose(period_s, [np.nan, 0.0, 0.1])
