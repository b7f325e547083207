"""Streets for the recordings: rows of trees, lamps, houses and posts, placed by seed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from tools.sample.scene import Road, Thing

TOWN: Final = Road(left=-5.1, right=1.7, parking_left=2.1, parking_right=2.1, pavement=2.6)
COUNTRY: Final = Road(left=-5.2, right=1.75)


def town_things(
    seed: int, length_m: float = 240.0, *, left: float = -12.5, right: float = 9.5
) -> tuple[Thing, ...]:
    """Return houses on both sides with gaps, lamps and a few trees."""
    return tuple(_town(np.random.default_rng([7, seed]), length_m, left, right))


def country_things(seed: int, length_m: float = 420.0) -> tuple[Thing, ...]:
    """Return trees and bushes on both sides, marker posts every 50 m and a line of poles."""
    return tuple(_country(np.random.default_rng([8, seed]), length_m))


def _town(
    generator: np.random.Generator, length_m: float, left: float, right: float
) -> Iterator[Thing]:
    for side, x in ((-1, left), (1, right)):
        z = float(generator.uniform(-8, 4))
        while z < length_m:
            depth = float(generator.uniform(11, 19))
            height = float(generator.uniform(5.6, 9.0))
            if generator.random() < 0.8:
                yield Thing("house", x + side * 4.5, z, height, width_m=9.0, depth_m=depth)
            else:
                yield Thing("tree", x + side * 3.0, z + depth / 2, height * 0.95)
            z += depth + float(generator.uniform(1.5, 6.0))
        for z in np.arange(22.0 + 14 * (side > 0), length_m, 29.0):
            yield Thing("lamp", side * (8.0 if side < 0 else 4.4), float(z), 6.4, heat=0.9)
        for z in np.arange(12.0 + 9 * (side < 0), length_m, 33.0):
            if generator.random() < 0.6:
                yield Thing(
                    "tree", -9.9 if side < 0 else 6.5, float(z + generator.uniform(-3, 3)), 5.6
                )


def _country(generator: np.random.Generator, length_m: float) -> Iterator[Thing]:
    for side, edge in ((-1, -5.2), (1, 1.75)):
        z = float(generator.uniform(5, 20))
        while z < length_m:
            away = float(generator.gamma(2.0, 3.5)) + 6.5
            if generator.random() < 0.62:
                yield Thing("tree", edge + side * away, z, float(generator.uniform(5.5, 11.0)))
            else:
                size = float(generator.uniform(1.2, 2.6))
                yield Thing("bush", edge + side * away, z, size, width_m=size * 1.5)
            z += float(generator.uniform(4.0, 15.0))
        for z in np.arange(25.0, length_m, 50.0):
            yield Thing("post", edge + side * 0.7, float(z), 1.05, width_m=0.14)
    for z in np.arange(14.0, length_m, 46.0):
        yield Thing("pole", 8.8, float(z), 7.8, width_m=0.24)
