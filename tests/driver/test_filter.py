"""The picture as the driver sees it: contrast and acuity that come back after a change of light."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nvcore.common.errors import ParameterError
from nvcore.subjects.driver.filter import (
    FilterSettings,
    as_the_driver_sees,
    blur_px,
    contrast_threshold,
)

CONTRAST_ONLY = FilterSettings(blur_arcmin=0, threshold=0.22, gamma=2.2, veil_level=0)
"""At the change, contrasts of grey levels below 0.1 disappear."""
PERIODS_S = (0, 0.5, 1.5, 3.0, 4.5, 7.5)


def grating(amplitude: float, period_px: int = 8, mean: float = 100) -> np.ndarray:
    """Grey bars as a sine, px; 128 x 128."""
    wave = mean + amplitude * np.sin(2 * np.pi * np.arange(128) / period_px)
    return np.tile(np.round(wave).astype(np.uint8), (128, 1))


def amplitude_of(picture: np.ndarray) -> float:
    """Half of what the middle of the picture spans."""
    return float(np.ptp(picture[32:96, 32:96].astype(float))) / 2


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(1).integers(0, 256, shape).astype(np.uint8)


@pytest.mark.parametrize("period_s", [math.inf, math.nan, 60.0])
@pytest.mark.parametrize("shape", [(61, 83), (61, 83, 3)])
def test_adapted_eyes_see_the_picture_as_it_is(period_s: float, shape: tuple[int, ...]):
    picture = noise(*shape)
    np.testing.assert_array_equal(as_the_driver_sees(picture, period_s), picture)


def test_a_grating_below_the_threshold_disappears_and_stays_above_it():
    assert amplitude_of(as_the_driver_sees(grating(8), 0, CONTRAST_ONLY)) <= 1
    assert 30 < amplitude_of(as_the_driver_sees(grating(60), 0, CONTRAST_ONLY)) < 58


def test_the_threshold_is_that_of_the_contrast_not_of_the_difference():
    dark, bright = grating(10, mean=40), grating(10, mean=200)
    assert amplitude_of(as_the_driver_sees(dark, 0, CONTRAST_ONLY)) > 2
    assert amplitude_of(as_the_driver_sees(bright, 0, CONTRAST_ONLY)) <= 1


def test_fine_bars_blur_and_wide_ones_stay():
    blurred = FilterSettings(threshold=0, blur_arcmin=12, width_degrees=6.4)  # sigma of 2 px
    assert blur_px(0, 128, blurred) == pytest.approx(2)
    # exp(-2 (pi sigma / period)^2): 0.007 of bars of 4 px, 0.926 of those of 32 px
    assert amplitude_of(as_the_driver_sees(grating(60, 4), 0, blurred)) <= 1
    left = amplitude_of(as_the_driver_sees(grating(60, 32), 0, blurred)) / 60
    assert left == pytest.approx(math.exp(-2 * (math.pi * 2 / 32) ** 2), abs=0.03)


def test_a_scene_blurs_alike_in_pictures_of_any_size():
    blurred = FilterSettings(threshold=0, blur_arcmin=300)
    small = grating(60, 32)
    large = small.repeat(2, axis=0).repeat(2, axis=1)
    assert blur_px(0, 1920) == 2 * blur_px(0, 960) == 5.0
    left = [amplitude_of(as_the_driver_sees(small, 0, blurred))]
    left.append(float(np.ptp(as_the_driver_sees(large, 0, blurred)[64:192, 64:192])) / 2)
    assert left[0] < 50
    assert left[1] == pytest.approx(left[0], abs=1)


def test_contrast_and_acuity_come_back_as_exponentials():
    settings = FilterSettings(threshold=0.5, threshold_decay_s=2, blur_arcmin=6, blur_decay_s=3)
    assert contrast_threshold(0, settings) == 0.5
    assert contrast_threshold(2 * math.log(2), settings) == pytest.approx(0.25)
    assert blur_px(3 * math.log(2), 99, settings) == pytest.approx(blur_px(0, 99, settings) / 2)
    assert contrast_threshold(math.nan, settings) == blur_px(math.inf, 99, settings) == 0


@pytest.mark.parametrize("shape", [(15, 20), (15, 20, 3)])
def test_the_more_time_has_passed_the_more_is_seen(shape: tuple[int, ...]):
    picture = (noise(*shape) // 3 + 60).repeat(8, axis=0).repeat(8, axis=1)
    spreads = [float(as_the_driver_sees(picture, period).std()) for period in PERIODS_S]
    assert spreads == sorted(spreads)
    assert spreads[0] < 0.5 * spreads[-1]


def test_an_even_picture_stays_even_and_as_bright():
    picture = np.full((50, 70, 3), (90, 90, 90), np.uint8)
    np.testing.assert_array_equal(as_the_driver_sees(picture, 0), picture)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9, 3), (2, 3), (3, 2, 3)])
def test_pictures_of_a_few_pixels_keep_their_shape(shape: tuple[int, ...]):
    assert as_the_driver_sees(noise(*shape), 0).shape == shape


def test_a_period_before_the_change_is_refused():
    with pytest.raises(ParameterError, match="seconds after the change, found -1"):
        as_the_driver_sees(noise(4, 4), -1)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"width_degrees": 0}, "width_degrees: expected 1 to 360, found 0"),
        ({"threshold": math.nan}, "threshold: expected 0 to 100, found nan"),
        ({"threshold": -1}, "threshold: expected 0 to 100, found -1"),
        ({"threshold": 1e300}, r"threshold: expected 0 to 100, found 1e\+300"),
        ({"blur_arcmin": 1e7}, r"blur_arcmin: expected 0 to 600, found 1e\+07"),
        ({"gamma": 1e-300}, "gamma: expected 0.1 to 10, found 1e-300"),
        ({"blur_decay_s": 0}, "blur_decay_s: expected 0.01 to 3600, found 0"),
        ({"threshold_decay_s": math.inf}, "threshold_decay_s: expected 0.01 to 3600, found inf"),
        ({"veil_level": 256}, "veil_level: expected 0 to 255, found 256"),
    ],
)
def test_settings_that_mean_nothing_are_refused(given: dict[str, float], words: str):
    with pytest.raises(ParameterError, match=f"^{words}$"):
        FilterSettings(**given)


def test_no_loss_is_a_setting():
    assert FilterSettings(threshold=0, blur_arcmin=0, veil_level=0).threshold == 0


def test_the_blur_is_never_wider_than_a_hundred_pixels():
    widest = FilterSettings(blur_arcmin=600, width_degrees=1)
    assert blur_px(0, 1920, widest) == 100
    assert as_the_driver_sees(noise(40, 1920), 0, widest).shape == (40, 1920)


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((0, 5), np.uint8),
        np.zeros((4, 5, 1), np.uint8),
        np.zeros((4, 5, 4), np.uint8),
        np.zeros((4, 5)),
    ],
)
def test_what_is_no_picture_is_refused(picture: np.ndarray):
    with pytest.raises(ParameterError, match=r"^picture: expected uint8 of the shape \(h, w\)"):
        as_the_driver_sees(picture, 0)
