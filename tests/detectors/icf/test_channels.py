"""Channels: colours by their formulas, gradients by hand, exact sums."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from nvcore.pictures import stretch
from nvcore.pictures.stretch import STRETCH
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.classifier import to_grey
from nvcore.subjects.detectors.icf import IcfSettings
from nvcore.subjects.detectors.icf.channels import (
    blurred,
    channel_planes,
    check_picture,
    equalised,
    has_colour,
    integral_images,
    plane_names,
    resized,
)

PLAIN = IcfSettings(blur=False)
TO_XYZ = np.array(
    [[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]]
)


def only(*channels, **more) -> IcfSettings:
    return replace(PLAIN, channels=channels, **more)


def luv(rgb: np.ndarray) -> np.ndarray:
    """The specification's formula, of values 0..1."""
    x, y, z = np.moveaxis(rgb @ TO_XYZ.T, -1, 0)
    whole = np.maximum(x + 15 * y + 3 * z, 1e-12)
    lightness = np.where(y > (6 / 29) ** 3, 116 * np.cbrt(y) - 16, (29 / 3) ** 3 * y)
    u, v = 4 * x / whole, 9 * y / whole
    return np.stack([lightness, 13 * lightness * (u - 0.198), 13 * lightness * (v - 0.468)])


def test_luv_is_that_of_the_formula(rng):
    picture = rng.integers(0, 256, (60, 70, 3), dtype=np.uint8)
    lightness, u, v = luv(picture / 255)
    expected = np.stack([lightness / 100, (u + 134) / 354, (v + 140) / 262])
    assert np.abs(channel_planes(picture, only("luv")) - 255 * expected).max() < 1


def test_channels_have_names_in_their_order():
    assert plane_names(only("luv", "magnitude", "orientations", orientation_bins=2), True) == (
        "L", "U", "V", "gradient", "gradient 0° to 90°", "gradient 90° to 180°",
    )  # fmt: skip
    assert plane_names(only("grey", "rgb", "hsv"), True) == ("grey", *"RGB", *"HSV")


def test_a_grey_picture_has_grey_once_in_place_of_colours(rng):
    picture = rng.integers(0, 256, (20, 30), dtype=np.uint8)
    settings = only("luv", "rgb", "magnitude")
    planes = channel_planes(picture, settings)
    assert plane_names(settings, False) == ("grey", "gradient")
    np.testing.assert_array_equal(planes[0], picture)


def test_rgb_and_grey_are_the_picture_itself(rng):
    picture = rng.integers(0, 256, (20, 30, 3), dtype=np.uint8)
    planes = channel_planes(picture, only("rgb", "grey"))
    np.testing.assert_array_equal(planes[:3], np.moveaxis(picture, -1, 0))
    np.testing.assert_array_equal(planes[3], cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))


@pytest.mark.parametrize(
    ("magnitude", "largest"), [("euclidean", 255 * np.sqrt(2)), ("sum", 2 * 255)]
)
def test_gradients_are_differences_of_neighbours(magnitude, largest):
    picture = np.zeros((5, 5), np.uint8)
    picture[2, 2], picture[1, 3] = 100, 40
    (plane,) = channel_planes(picture, only("magnitude", magnitude=magnitude))
    assert plane[2, 1] == round(100 / largest * 255)  # the bright pixel is its right neighbour
    both = np.hypot(100, 40) if magnitude == "euclidean" else 140
    assert plane[2, 3] == round(both / largest * 255)
    assert plane[2, 2] == 0
    assert plane[4, 0] == 0


@pytest.mark.parametrize(("full_circle", "bins"), [(False, [0, 0, 2, 2]), (True, [0, 2, 1, 3])])
def test_a_pixel_counts_in_the_bin_of_its_orientation(full_circle, bins):
    # four pictures that get brighter to the right, left, bottom, top
    ramp = np.tile(np.arange(0, 90, 10, dtype=np.uint8), (9, 1))
    settings = only("magnitude", "orientations", orientation_bins=4, full_circle=full_circle)
    for picture, expected in zip((ramp, ramp[:, ::-1], ramp.T, ramp.T[::-1]), bins, strict=True):
        whole, *parts = channel_planes(np.ascontiguousarray(picture), settings)
        assert int(np.argmax([part.sum() for part in parts])) == expected
        np.testing.assert_array_equal(np.sum(parts, axis=0), whole)


def test_integral_images_have_a_border_of_zeros_and_sum_exactly(rng):
    planes = rng.integers(0, 256, (3, 40, 50), dtype=np.uint8)
    sums = integral_images(planes)
    assert sums.shape == (3, 41, 51)
    assert not sums[:, 0].any()
    assert not sums[:, :, 0].any()
    np.testing.assert_array_equal(sums[:, 1:, 1:], planes.astype(int).cumsum(1).cumsum(2))


def test_integral_images_may_be_written_to_memory_that_is_larger(rng):
    planes = rng.integers(0, 256, (2, 4, 5), dtype=np.uint8)
    memory = np.full(1000, 7, np.int32)
    np.testing.assert_array_equal(integral_images(planes, memory), integral_images(planes))


def test_blur_and_equalisation_are_left_out_if_not_asked_for(rng):
    picture = rng.integers(0, 256, (40, 40, 3), dtype=np.uint8)
    assert blurred(picture, PLAIN) is picture
    assert equalised(picture, PLAIN) is picture
    assert blurred(picture, IcfSettings()).std() < picture.std()


def test_equalisation_spreads_the_brightness_of_dim_pictures_and_leaves_hues():
    dim = np.tile(np.linspace(20, 40, 128).astype(np.uint8), (128, 1))
    settings = replace(PLAIN, clahe_clip=4.0)
    assert np.ptp(equalised(dim, settings)) > 2 * np.ptp(dim)
    red = np.stack([dim, dim // 3, dim // 3], axis=-1)
    brighter = equalised(red, settings).astype(int)
    assert (brighter[..., 0] > brighter[..., 1] + 5).all()


def test_a_picture_is_halved_before_it_is_interpolated():
    checks = np.indices((64, 64)).sum(axis=0) % 2 * np.uint8(200)
    assert (resized(checks.astype(np.uint8), 20, 20) == 100).all()


def test_pictures_of_16_bits_are_spread_as_the_dashboard_does():
    picture = np.tile(np.arange(1000, 2000, dtype=np.uint16), (50, 1))
    expected = stretch(picture, *STRETCH)
    np.testing.assert_array_equal(check_picture(picture, False), expected)
    np.testing.assert_array_equal(to_grey(picture), expected)


def test_a_hot_pixel_does_not_darken_a_picture_of_16_bits():
    picture = np.tile(np.arange(1000, 1100, dtype=np.uint16), (100, 1))
    hot = picture.copy()
    hot[50, 50] = 65535
    for prepared in (check_picture(picture, False), check_picture(hot, False), to_grey(hot)):
        assert prepared[0, 0] == 0
        assert prepared[0, 99] == 255
        assert abs(int(prepared[0, 50]) - 128) < 3


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (np.zeros((4, 4), np.float32), "8 or 16 bits"),
        (np.zeros((4, 4, 4), np.uint8), "8 or 16 bits"),
        (np.zeros((0, 4), np.uint8), "8 or 16 bits"),
        (np.zeros((4, 4), np.uint8), "grey picture"),
    ],
)
def test_what_is_no_such_picture_is_refused(picture, words):
    with pytest.raises(DetectorError, match=words):
        check_picture(picture, True)


def test_a_grey_model_works_on_colour_by_its_grey(rng):
    picture = rng.integers(0, 256, (8, 9, 3), dtype=np.uint8)
    grey = check_picture(picture, False)
    np.testing.assert_array_equal(grey, cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))


def test_colour_is_told_from_grey_in_three_channels():
    grey = np.full((3, 3, 3), 9, np.uint8)
    assert not has_colour(grey)
    assert not has_colour(grey[..., 0])
    grey[1, 1, 2] = 8
    assert has_colour(grey)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(3)
