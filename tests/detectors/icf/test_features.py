"""Features: drawn within the window, summed as a plain loop does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.icf import IcfSettings
from nvcore.subjects.detectors.icf.channels import integral_images
from nvcore.subjects.detectors.icf.features import corner_offsets, draw_features, values_at

SETTINGS = IcfSettings(
    window_width=20, window_height=30, object_width=18.0, object_height=28.0, features=3000
)


@pytest.mark.parametrize("share", [0.0, 0.4])
def test_rectangles_lie_in_the_window_and_are_large_enough(share):
    settings = replace(SETTINGS, difference_share=share)
    features = draw_features(settings, 7, seed=2)
    assert len(features) == 3000
    n_second = np.count_nonzero(features[:, 5] >= 0)
    assert n_second == round(share * 3000)
    for first in (features[:, :5], features[features[:, 5] >= 0, 5:]):
        channel, left, top, right, bottom = first.T
        assert ((channel >= 0) & (channel < 7)).all()
        assert ((left >= 0) & (left < right) & (right <= 20)).all()
        assert ((top >= 0) & (top < bottom) & (bottom <= 30)).all()
        assert ((right - left) * (bottom - top) >= 25).all()


def test_both_rectangles_of_a_difference_are_of_one_size():
    features = draw_features(replace(SETTINGS, difference_share=1.0), 7, seed=2)
    np.testing.assert_array_equal(
        features[:, 3:5] - features[:, 1:3], features[:, 8:10] - features[:, 6:8]
    )


def test_channels_are_drawn_evenly_and_the_whole_window_is_covered():
    features = draw_features(SETTINGS, 5, seed=0)
    assert np.bincount(features[:, 0]).min() > 500
    assert (features[:, 1].min(), features[:, 3].max()) == (0, 20)
    assert (features[:, 2].min(), features[:, 4].max()) == (0, 30)


def test_the_seed_decides():
    first, same, other = (draw_features(SETTINGS, 5, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, same)
    assert (first != other).any()


def test_values_are_the_sums_over_the_rectangles():
    rng = np.random.default_rng(1)
    planes = rng.integers(0, 256, (4, 50, 60), dtype=np.uint8)
    features = draw_features(replace(SETTINGS, features=40, difference_share=0.5), 4, seed=3)
    places = [(0, 0), (7, 12), (20, 40)]
    base = np.array([y * 61 + x for y, x in places], np.int64)
    values = values_at(integral_images(planes), base, features)

    def loop(rectangle: np.ndarray, y: int, x: int) -> int:
        channel, left, top, right, bottom = rectangle
        if channel < 0:
            return 0
        return int(planes[channel, y + top : y + bottom, x + left : x + right].sum(dtype=int))

    expected = [[loop(f[:5], *at) - loop(f[5:], *at) for f in features] for at in places]
    np.testing.assert_array_equal(values, expected)


def test_sums_are_exact_where_the_integral_overflows():
    planes = np.full((1, 3000, 4000), 255, np.uint8)  # 3.06e9 in all, beyond 2^31
    features = np.array([[0, 0, 0, 20, 30, -1, -1, -1, -1, -1]], np.int32)
    base = np.array([(3000 - 30) * 4001 + 4000 - 20], np.int64)
    assert values_at(integral_images(planes), base, features)[0, 0] == 255 * 600


def test_offsets_of_more_than_32_bits_are_refused():
    features = np.array([[9, 0, 0, 8, 8, *[-1] * 5]], np.int32)
    assert corner_offsets(features, 20_000, 20_000).max() < 2**32
    with pytest.raises(DetectorError, match="too large for 10 channels"):
        corner_offsets(features, 21_000, 21_000)
