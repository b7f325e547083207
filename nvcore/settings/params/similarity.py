"""Settings of similarity: distances, traffic context, and proximity of boxes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.settings.stages import COST, NEAREST, PROXIMITY, SIMILARITY, setting, share

Distance = Literal["lateral", "ground"]
Pairing = Literal["nearest", "matched"]
Proximity = Literal["height", "horizon", "distance", "none"]
MissingDistance = Literal["height", "borrow"]

MIDPOINT_SHARE: Final = 0.10
"""Default midpoint of the height sigmoid as a share of the image height."""
SPREAD_SHARE: Final = 0.02
"""Default spread of the height sigmoid as a share of the image height."""


@dataclass(frozen=True)
class SimilaritySettings:
    """Settings in `nvcore.settings.params.Params` for the weighted distances of equation 1."""

    alpha: float = share(
        SIMILARITY,
        0.9,
        label="Misses against false alarms (alpha)",
        meaning="Weight of misses against false alarms in similarity: 1 counts misses only, "
        "0 false alarms only.",
    )
    distance: Distance = setting(
        NEAREST,
        "lateral",
        words={"lateral": "sideways position", "ground": "foot points in the picture"},
        label="Distance",
        meaning="How far a detection is from {a_one}: sideways only (lateral) or between foot "
        "points in the picture (ground).",
        is_advanced=True,
        is_audited=True,
    )
    pairing: Pairing = setting(
        NEAREST,
        "nearest",
        words={"nearest": "the nearest box", "matched": "its own match (strict)"},
        label="Distances are measured to",
        meaning="What the distance of a box is measured to: the nearest box of the other set "
        "(nearest, the paper), so that a false alarm beside a missed {one} raises similarity; "
        "or the box that matches it (matched, strict), where it cannot.",
        is_advanced=True,
    )
    edge_weight: float | None = share(
        COST,
        None,
        slider_format="urban %0.2f rural",
        unset="as each recording says",
        label="Traffic context",
        meaning="Traffic context. 0 (urban): a miss far to the side costs little; 1 (rural): a "
        "miss at the road's edge costs as much as one straight ahead. Default: as each recording "
        "says, 0 where it says nothing.",
    )
    proximity: Proximity = setting(
        PROXIMITY,
        "height",
        words={
            "height": "height of the box",
            "horizon": "foot point below the horizon",
            "distance": "distance in metres",
            "none": "nothing: all count the same",
        },
        label="What tells how near",
        meaning="What tells how near {a_one} is: the box's height, its foot point below the "
        "horizon, the distance in metres, or none (all count the same).",
    )
    midpoint: float | None = setting(
        PROXIMITY,
        None,
        low=0,
        high=10_000,
        unit="px",
        height_share=MIDPOINT_SHARE,
        used_with=("proximity", ("height", "horizon")),
        label="Counts half at",
        meaning="Height (or depth below the horizon) at which {a_one} counts half. Default: "
        "10 % of the image height.",
    )
    spread: float | None = setting(
        PROXIMITY,
        None,
        low=0,
        high=10_000,
        unit="px",
        is_above_low=True,
        height_share=SPREAD_SHARE,
        used_with=("proximity", ("height", "horizon")),
        label="Softness",
        meaning="Softness of the step at the midpoint. Default: 2 % of the image height.",
    )
    midpoint_m: float = setting(
        PROXIMITY,
        35.0,
        low=0,
        high=1_000,
        slider_high=150,
        unit="m",
        used_with=("proximity", ("distance",)),
        label="Counts half at",
        meaning="Distance at which {a_one} counts half, for proximity by distance.",
    )
    spread_m: float = setting(
        PROXIMITY,
        7.0,
        low=0,
        high=1_000,
        slider_high=40,
        step=0.5,
        unit="m",
        is_above_low=True,
        used_with=("proximity", ("distance",)),
        label="Softness",
        meaning="Softness of the step at that distance.",
    )
    missing_distance: MissingDistance = setting(
        PROXIMITY,
        "height",
        words={"height": "height", "borrow": "distance of matches"},
        used_with=("proximity", ("distance",)),
        label="Without a distance, weigh by",
        meaning="How to weigh {a_one} without a distance in the ground truth: by height (height), "
        "or by the distance that the systems report, borrowed along the track (borrow).",
    )
    horizon: float | None = setting(
        PROXIMITY,
        None,
        low=-10_000,
        high=10_000,
        unit="px",
        used_with=("proximity", ("horizon",)),
        label="Row of the horizon",
        meaning="Row of the horizon in the picture, for proximity by horizon. Default: the "
        "recording's own.",
    )
