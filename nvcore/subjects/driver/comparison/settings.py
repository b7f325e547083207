"""Settings about the driver: the detectability threshold and the weighting of misses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal

from nvcore.settings.stages import MISS_WEIGHTS, PROXIMITY, Stage, SubjectSettings, setting, share

DRIVER: Final = Stage(
    "whom the driver sees", "The driver", (PROXIMITY,), "what the driver sees unaided"
)


def _has_detectability(dataset: Any) -> bool:
    return bool(dataset.has_detectability)


@dataclass(frozen=True)
class DriverSettings(SubjectSettings):
    """Fields of `nvcore.settings.params.Params` on what the driver sees unaided."""

    driver_threshold: float = share(
        DRIVER,
        0.5,
        is_above_low=True,
        label="The driver sees from (detectability)",
        meaning="Least detectability with which the driver sees {a_one} unaided, in a "
        "frame up to the first in which the {one} is near enough to count. Of no effect where "
        "no detectability is known.",
        is_advanced=True,
        applies=_has_detectability,
    )
    driver_weighting: Literal["off", "on"] = setting(
        MISS_WEIGHTS,
        "off",
        heading=DRIVER.group,
        words={"off": "in full", "on": "by (1 - detectability)"},
        label="Missed {many} weigh",
        meaning="Whether a missed {one} weighs in full (off) or, in similarity, saliency and "
        "severity, by (1 - detectability) (on): less, the more drivers would see the {one} "
        "anyway. This weighting is ours, not the papers'. In full where no detectability is known.",
        is_advanced=True,
        applies=_has_detectability,
    )
