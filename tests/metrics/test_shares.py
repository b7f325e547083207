"""A share with Wilson's interval."""

from __future__ import annotations

import math

import pytest

from nvcore.metrics.shares import share_of


@pytest.mark.parametrize(("n_right", "n"), [(0, 4), (1, 4), (2, 4), (4, 4), (81, 263)])
def test_the_interval_is_wilson_s(n_right: int, n: int):
    z, p = 1.959963984540054, n_right / n
    middle = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z * math.sqrt(p * (1 - p) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
    share = share_of(n_right, n)
    assert (share.n_right, share.n, share.share) == (n_right, n, p)
    assert (share.low, share.high) == pytest.approx((middle - half, middle + half))


def test_a_published_interval():
    """Newcombe, Statistics in Medicine 17 (1998), table I, method 3: 81 of 263."""
    share = share_of(81, 263)
    assert (share.low, share.high) == pytest.approx((0.2553, 0.3662), abs=5e-5)


def test_of_none_there_is_no_share():
    share = share_of(0, 0)
    assert share.n == 0
    assert math.isnan(share.share)
    assert math.isnan(share.low)
