"""Grey levels for display."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from nvcore.common.errors import ParameterError
from nvcore.pictures import jpeg, png, stretch


def test_8_bit_pictures_stay_as_they_are_unless_asked():
    picture = np.array([[7, 100], [50, 131]], np.uint8)
    assert stretch(picture).tolist() == picture.tolist()


def test_percentiles_spread_a_dim_picture():
    picture = np.arange(101, dtype=np.uint8).reshape(1, 101)
    spread = stretch(picture, 10, 60)
    assert spread[0, [0, 10, 30, 60, 100]].tolist() == [0, 0, 102, 255, 255]


def test_16_bit_pictures_are_spread_from_least_to_greatest():
    picture = np.array([[6743, 6910], [7077, 6743]], np.uint16)
    assert stretch(picture).tolist() == [[0, 128], [255, 0]]


@pytest.mark.parametrize("border", [0, 65535])
@pytest.mark.parametrize("lo_hi", [(0, 100), (0.5, 99.8)])
def test_a_border_without_measurements_takes_no_contrast(border: int, lo_hi: tuple[float, float]):
    picture = np.tile(np.linspace(6743, 7077, 60).astype(np.uint16), (40, 1))
    masked = picture.copy()
    masked[:8] = border
    assert (stretch(masked, *lo_hi)[8:] == stretch(picture, *lo_hi)[8:]).all()
    assert (stretch(masked, *lo_hi)[:8] == (border and 255)).all()


@pytest.mark.parametrize("far", [0, 3000])
def test_a_pedestrian_or_a_background_of_one_grey_level_stays_part_of_the_contrast(far: int):
    picture = np.tile(np.linspace(1000, 1010, 60).astype(np.uint16), (40, 1))
    (picture[10:20, 20:25] if far else picture[:, 10:])[:] = far
    assert np.ptp(stretch(picture)[picture != far].astype(int)) < 5


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_picture_of_one_grey_level_is_mid_grey(dtype: type):
    assert set(stretch(np.full((4, 4), 77, dtype), 1, 99).ravel().tolist()) == {128}


def test_outliers_do_not_darken_the_rest():
    picture = np.arange(10_000, dtype=np.uint16).reshape(100, 100)
    picture[0, 0] = 65535
    assert stretch(picture, 0, 99)[50, 50] == pytest.approx(255 * 5050 / 9900, abs=2)


def test_colours_are_spread_together():
    picture = np.array([[[0, 20, 100], [100, 20, 0]]], np.uint8)
    assert stretch(picture, 0, 99.999).tolist() == [[[0, 51, 255], [255, 51, 0]]]


def test_a_large_picture_is_sampled_to_nearly_the_same_levels():
    picture = np.random.default_rng(0).integers(0, 4096, (2000, 3000)).astype(np.uint16)
    levels = np.percentile(picture, (1, 99))
    middle = stretch(picture, 1, 99)[picture == 2048]
    assert middle[0] == pytest.approx(255 * (2048 - levels[0]) / (levels[1] - levels[0]), abs=2)


@pytest.mark.parametrize(("lo", "hi"), [(50, 50), (60, 40), (-1, 99), (1, 101), (float("nan"), 9)])
def test_percentiles_out_of_order_are_refused(lo: float, hi: float):
    with pytest.raises(ParameterError, match="stretch: expected 0 <= low < high <= 100"):
        stretch(np.zeros((2, 2), np.uint8), lo, hi)


def test_jpeg_and_png_keep_red_red():
    picture = np.full((16, 16, 3), (250, 10, 20), np.uint8)
    for content in (jpeg(picture), png(picture)):
        decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        assert np.abs(decoded[8, 8].astype(int) - (20, 10, 250)).max() <= 4


def test_jpeg_of_16_bit_grey_is_stretched():
    picture = np.tile(np.array([6000, 7000], np.uint16).repeat(16), (32, 1))
    decoded = cv2.imdecode(np.frombuffer(jpeg(picture), np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded.ndim == 2
    assert decoded[16, [4, 28]].tolist() == pytest.approx([0, 255], abs=6)
