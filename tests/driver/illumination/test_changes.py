"""What is a change from bright to dark, what is none, and the time to adapt since then."""

from __future__ import annotations

import time

import numpy as np
import pytest

from nvcore.common.errors import ParameterError
from nvcore.subjects.driver.illumination import Light, LightSettings, LightSource
from nvcore.subjects.driver.illumination.clock import changes_of

RATE = 20


def light(*stretches: tuple[float, float], source: LightSource = LightSource.METER) -> Light:
    """So many seconds of so much light, one after another, 20 readings a second."""
    level = np.concatenate([np.full(round(s * RATE), lux, float) for s, lux in stretches])
    return Light(np.arange(len(level)) / RATE, level, source)


def starts(given: Light, **settings: float) -> list[float]:
    return changes_of(given, LightSettings(**settings)).start_s.tolist()


def ends(given: Light, **settings: float) -> list[float]:
    return changes_of(given, LightSettings(**settings)).end_s.tolist()


def test_a_sudden_drop_is_a_change_at_its_moment():
    assert starts(light((10, 1000), (10, 10))) == pytest.approx([10.0])


def test_a_drop_by_less_than_the_factor_is_none():
    assert starts(light((10, 1000), (10, 101))) == []
    assert starts(light((10, 1000), (10, 100))) == pytest.approx([10.0])
    assert starts(light((10, 1000), (10, 101)), drop_factor=9) == pytest.approx([10.0])


def test_a_slow_drop_is_none_and_a_quick_one_counts_when_it_is_dark():
    def fall(seconds: float) -> Light:
        """From 1,000 lx to 10 lx, equal factors in equal times: a tenth after half the time."""
        down = np.geomspace(1000, 10, round(seconds * RATE) + 1)
        level = np.concatenate([np.full(5 * RATE, 1000.0), down, np.full(5 * RATE, 10.0)])
        return Light(np.arange(len(level)) / RATE, level)

    assert starts(fall(20.0)) == []
    assert starts(fall(2.0), smooth_s=0) == pytest.approx([6.0])
    assert starts(fall(4.2), smooth_s=0) == []
    assert starts(fall(4.2), smooth_s=0, within_s=2.2) == pytest.approx([7.1])


def test_it_becoming_bright_is_no_change():
    assert starts(light((10, 10), (10, 1000))) == []


def test_a_tunnel_is_one_change_which_its_end_ends():
    tunnel = light((10, 20_000), (6, 20), (10, 20_000))
    assert starts(tunnel) == pytest.approx([10.0])
    assert ends(tunnel) == pytest.approx([16.0])


def test_two_tunnels_are_two_changes():
    twice = light((10, 20_000), (6, 20), (10, 20_000), (6, 20))
    assert starts(twice) == pytest.approx([10.0, 26.0])
    assert ends(twice)[0] == pytest.approx(16.0)
    assert np.isnan(ends(twice)[1])


def test_a_bridge_is_a_short_change():
    bridge = light((10, 20_000), (1, 500), (10, 20_000))
    assert starts(bridge) == pytest.approx([10.0])
    assert ends(bridge) == pytest.approx([11.0])


def test_a_shadow_shorter_than_half_the_median_is_none():
    assert starts(light((10, 20_000), (0.2, 500), (10, 20_000))) == []


def test_an_oncoming_lamp_is_no_change():
    assert starts(light((10, 1), (2, 40), (10, 1))) == []


def test_a_lamp_that_shines_for_longer_is_what_the_eye_was_adapted_to():
    assert starts(light((10, 1), (5, 40), (10, 1))) == pytest.approx([15.0])
    assert starts(light((10, 1), (2, 40), (10, 1)), bright_for_s=1) == pytest.approx([12.0])


def test_an_oncoming_lamp_does_not_restart_nor_end_the_adaptation():
    night = light((10, 1000), (3, 1), (2, 40), (10, 1))
    assert starts(night) == pytest.approx([10.0])
    assert np.isnan(ends(night)).all()


def test_street_lamps_that_are_passed_are_no_changes():
    street = light((10, 2), *[(1.0, 60), (1.2, 2)] * 10)
    assert starts(street) == []


def test_flicker_is_no_change():
    level = np.where(np.arange(400) % 2, 1000.0, 5.0)
    assert starts(Light(np.arange(400) / RATE, level)) == []
    rng = np.random.default_rng(0)
    noisy = 100 * np.exp(rng.normal(0, 1, 4000))
    assert starts(Light(np.arange(4000) / RATE, noisy)) == []


def test_flicker_around_the_threshold_is_one_change():
    level = np.concatenate([np.full(200, 1000.0), np.where(np.arange(200) % 10 < 5, 90.0, 115.0)])
    assert len(starts(Light(np.arange(400) / RATE, level))) == 1


def test_two_steps_down_are_two_changes_if_the_eye_had_time_between():
    assert starts(light((10, 10_000), (5, 500), (5, 20))) == pytest.approx([10.0, 15.0])
    assert starts(light((10, 10_000), (1, 500), (5, 20))) == pytest.approx([10.0])


def test_what_came_before_the_readings_is_not_guessed():
    assert starts(light((2, 1000), (10, 10))) == []
    earlier = light((4, 1000), (10, 10))
    shifted = Light(earlier.time_s - 2, earlier.level)
    assert starts(shifted) == pytest.approx([2.0])


def test_light_below_the_least_counts_as_that():
    assert starts(light((10, 0.5), (10, 0.0))) == []
    assert starts(light((10, 0.5), (10, 0.0)), least_lux=0.01) == pytest.approx([10.0])


def test_pictures_have_a_factor_of_their_own():
    pictures = light((10, 0.3), (10, 0.05), source=LightSource.PICTURE)
    assert starts(pictures) == pytest.approx([10.0])
    assert starts(pictures, picture_drop_factor=10) == []


def test_readings_at_uneven_times_are_taken_by_their_times():
    times = np.array([0, 1, 2.5, 3.5, 4, 5, 6.5, 7, 9.0])
    lux = np.array([1000, 1000, 1000, 1000, 10, 10, 10, 10, 10.0])
    assert starts(Light(times, lux)) == [4.0]


def test_the_period_runs_from_the_change_and_ends_with_the_dark():
    changes = changes_of(light((10, 20_000), (6, 20), (10, 20_000)), LightSettings())
    period_s = changes.period_s(np.array([0, 9.9, 10, 10.5, 15.9, 16, 16.1, 20]))
    expected = [np.nan, np.nan, np.nan, 0.5, 5.9, 6, np.nan, np.nan]
    np.testing.assert_allclose(period_s, expected, atol=1e-9)


def test_without_readings_no_period_is_known():
    nothing = changes_of(Light(np.empty(0), np.empty(0)), LightSettings())
    assert len(nothing) == 0
    assert np.isnan(nothing.period_s(np.array([0.0, 5.0]))).all()


def test_a_million_readings_take_seconds():
    level = np.tile(np.repeat([1000.0, 10.0], 1000), 500)
    starts(light((10, 1000), (10, 10)))  # compiled by now
    began_s = time.process_time()
    assert len(starts(Light(np.arange(1_000_000) / 100, level))) == 500
    assert time.process_time() - began_s < 20


@pytest.mark.parametrize(
    "given",
    [{"drop_factor": 1.0}, {"within_s": -1.0}, {"smooth_s": float("nan")}, {"least_lux": 0.0}],
)
def test_settings_outside_their_range_are_refused(given: dict[str, float]):
    with pytest.raises(ParameterError, match=f"{next(iter(given))}: expected"):
        LightSettings(**given)


def without(given: Light, from_s: float, to_s: float) -> Light:
    """The readings but for those in between."""
    stays = (given.time_s < from_s) | (given.time_s >= to_s)
    return Light(given.time_s[stays], given.level[stays], given.source)


def test_across_a_gap_nothing_is_compared():
    drop = without(light((10, 1000), (20, 10)), 8, 12)
    assert starts(drop) == []
    assert starts(drop, smooth_s=10, bright_for_s=20, within_s=60) == []


@pytest.mark.parametrize("source", LightSource)
def test_after_a_gap_it_takes_as_long_as_at_the_beginning_to_know_a_change(source: LightSource):
    early = without(light((11, 1000), (3.9, 1000), (10, 10), source=source), 8, 12)
    assert starts(early) == []
    late = without(light((11, 1000), (4.1, 1000), (10, 10), source=source), 8, 12)
    assert starts(late) == pytest.approx([15.1])


def test_light_that_is_back_after_a_gap_does_not_say_when():
    tunnel = without(light((10, 1000), (6, 10), (10, 1000)), 12, 20)
    assert starts(tunnel) == pytest.approx([10.0])
    assert np.isnan(ends(tunnel)).all()
    seen_again = without(light((10, 1000), (4, 10), (10, 1000)), 15, 20)  # a second of it is seen
    assert np.isnan(ends(seen_again)).all()


@pytest.mark.parametrize("within_s", [0.0, 0.01])
def test_the_reading_before_is_looked_at_however_short_the_setting(within_s: float):
    given = light((10, 1000), (10, 10))
    assert starts(given, within_s=within_s) == pytest.approx([10.0])
    assert starts(given, within_s=within_s, smooth_s=0) == pytest.approx([10.0])


@pytest.mark.parametrize("step_s", [2.0, 2.5, 5.0])
def test_a_drop_between_readings_that_are_far_apart_as_a_rule_is_found(step_s: float):
    times = np.arange(20) * step_s
    given = Light(times, np.where(times < 10 * step_s, 1000.0, 10.0))
    assert starts(given) == pytest.approx([10 * step_s])


def test_many_gaps_take_seconds_as_well():
    steps = np.where(np.arange(400_000) % 2, 10.0, 0.1)
    steps[:3] = 0.1
    given = Light(np.cumsum(steps), np.tile([1000.0, 10.0], 200_000))
    began_s = time.process_time()
    assert starts(given) == []
    assert len(given.gaps_s) > 199_000
    assert time.process_time() - began_s < 20
