"""Settings of saliency: definition of events, and their weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nvcore.settings.stages import EVENTS, SALIENCY, SALIENT, setting, share

Aggregate = Literal["max", "sum"]
Scope = Literal["recording", "encounter"]
SaliencyOf = Literal["most_salient", "each"]
SaliencyWeight = Literal["time", "risk"]
RecencyUnit = Literal["share", "seconds"]


@dataclass(frozen=True)
class SaliencySettings:
    """Settings in `nvcore.settings.params.Params` for saliency events and their weights."""

    tolerance: float = share(
        SALIENT,
        0.05,
        step=0.01,
        unit="of half the image width",
        label="Least miss for saliency",
        meaning="A miss counts for saliency only when its weighted distance is larger than this.",
        is_advanced=True,
    )
    recency_unit: RecencyUnit = setting(
        EVENTS,
        "share",
        words={"share": "share of the duration", "seconds": "seconds before the end"},
        label="Recency counts in",
        meaning="What recency counts in: the share of the recording that has passed (share), or "
        "the seconds left to its end (seconds), which mean the same in short recordings and long "
        "ones.",
        is_advanced=True,
    )
    recency_midpoint: float = share(
        EVENTS,
        0.5,
        unit="of the duration",
        used_with=("recency_unit", ("share",)),
        label="Remembered half at (of duration)",
        meaning="When in the recording a miss starts to be remembered: it counts half here.",
        is_advanced=True,
    )
    recency_spread: float = setting(
        EVENTS,
        0.1,
        low=0,
        high=10,
        slider_high=0.5,
        step=0.01,
        unit="of the duration",
        is_above_low=True,
        used_with=("recency_unit", ("share",)),
        label="Softness of recency",
        meaning="Softness of that step.",
        is_advanced=True,
    )
    recency_midpoint_s: float = setting(
        EVENTS,
        7.5,
        low=0,
        high=3_600,
        slider_high=60,
        step=0.5,
        unit="s",
        used_with=("recency_unit", ("seconds",)),
        label="Remembered half before the end",
        meaning="Time from the end of a miss to the end of the recording with which it counts "
        "half, for recency in seconds.",
        is_advanced=True,
    )
    recency_spread_s: float = setting(
        EVENTS,
        1.5,
        low=0,
        high=3_600,
        slider_high=30,
        step=0.5,
        unit="s",
        is_above_low=True,
        used_with=("recency_unit", ("seconds",)),
        label="Softness of recency",
        meaning="Softness of that step, for recency in seconds.",
        is_advanced=True,
    )
    saliency_of: SaliencyOf = setting(
        EVENTS,
        "most_salient",
        words={"most_salient": "the most salient miss of a frame", "each": "each missed {one}"},
        label="Events are of",
        meaning="Whose misses make saliency events: of the most salient {one} of each frame "
        "alone (most_salient, the paper), or of each {one} (each), so that two {who} are missed "
        "side by side do not cut each other's events.",
        is_advanced=True,
    )
    saliency_weight: SaliencyWeight = setting(
        EVENTS,
        "time",
        words={"time": "its duration", "risk": "its weighted distance over time"},
        label="An event weighs by",
        meaning="What an event weighs by: its duration (time, the paper), or the sum of its "
        "weighted distance over time (risk), so that a far {one} counts little.",
        is_advanced=True,
    )
    saliency_aggregate: Aggregate = setting(
        SALIENCY,
        "max",
        words={"max": "most salient event", "sum": "sum of all events"},
        label="Saliency of a recording",
        meaning="A recording's saliency: its most salient event (max) or all of them added (sum).",
        is_advanced=True,
    )
    saliency_scope: Scope = setting(
        EVENTS,
        "recording",
        words={"recording": "the recording", "encounter": "the encounter"},
        label="Recency runs over",
        meaning="What recency runs over: the whole recording (a clip) or the {one}'s own "
        "encounter (long drives).",
        is_advanced=True,
    )
