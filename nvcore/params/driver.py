"""Settings of the driver: from which detectability on he sees, and what his view weighs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.params.metadata import DRIVER, UNSEEN, setting, share

DriverWeighting = Literal["off", "on"]

NEEDS_DETECTABILITY: Final = ("driver_threshold", "driver_weighting")
"""Settings without effect where no detectability is known."""


@dataclass(frozen=True)
class DriverSettings:
    """The part of `nvcore.params.Params` about what the driver sees by himself."""

    driver_threshold: float = share(
        DRIVER,
        0.5,
        is_above_low=True,
        label="The driver sees from (detectability)",
        meaning="Least detectability with which the driver sees a pedestrian by himself, in a "
        "frame up to the first in which the pedestrian is near enough to count. Of no effect where "
        "no detectability is known.",
        is_advanced=True,
    )
    driver_weighting: DriverWeighting = setting(
        UNSEEN,
        "off",
        words={"off": "in full", "on": "by (1 - detectability)"},
        label="Missed pedestrians weigh",
        meaning="Whether a missed pedestrian weighs in full (off) or, in similarity, saliency and "
        "severity, by (1 - detectability) (on): less, the more drivers would see the pedestrian "
        "anyway. This weighting is ours, not the papers'. In full where no detectability is known.",
        is_advanced=True,
    )
