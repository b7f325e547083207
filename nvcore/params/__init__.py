"""Every live setting of the comparison, defined once, in its field.

The command line makes its flags from `Params`, the dashboard its sliders, `compare` the keys of
what it need not repeat. Here is all that a new setting takes, but for its use, test and docs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import cache
from typing import Any, Final, Literal

from nvcore.errors import ParameterError
from nvcore.params.metadata import (
    COST,
    ENCOUNTERS,
    EVENTS,
    LOW,
    MATCH,
    NEAREST,
    PROXIMITY,
    SALIENCY,
    SALIENT,
    SIMILARITY,
    THRESHOLD,
    Setting,
    Stage,
    setting,
    share,
)
from nvcore.wording import did_you_mean

Distance = Literal["lateral", "ground"]
Pairing = Literal["nearest", "matched"]
Proximity = Literal["height", "horizon", "distance", "none"]
Match = Literal["iou", "lateral"]
Aggregate = Literal["max", "sum"]
Scope = Literal["recording", "encounter"]
SaliencyOf = Literal["most_salient", "each"]
SaliencyWeight = Literal["time", "risk"]
RecencyUnit = Literal["share", "seconds"]

MIDPOINT_SHARE: Final = 0.10
"""Default midpoint of the height sigmoid as a share of the image height."""
SPREAD_SHARE: Final = 0.02
"""Default spread of the height sigmoid as a share of the image height."""


@dataclass(frozen=True)
class Params:
    """Settings of one comparison, checked when made.

    The metadata of each field is a `Setting`. None means: taken from the data (`edge_weight`,
    `midpoint`, `spread`, `horizon`) or not applied (thresholds).

    Raises
    ------
    ParameterError
        If a value is outside its range.

    References
    ----------
    Paper 11-0360; the defaults marked as choices are argued in ``docs/metrics.md``.
    """

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
        meaning="How far a detection is from a pedestrian: sideways only (lateral) or between foot "
        "points in the picture (ground).",
        is_advanced=True,
    )
    pairing: Pairing = setting(
        NEAREST,
        "nearest",
        words={"nearest": "the nearest box", "matched": "its own match (strict)"},
        label="Distances are measured to",
        meaning="What the distance of a box is measured to: the nearest box of the other set "
        "(nearest, the paper), so that a false alarm beside a missed pedestrian raises similarity; "
        "or the box that matches it (matched, strict), where it cannot.",
        is_advanced=True,
    )
    edge_weight: float | None = share(
        COST,
        None,
        slider_format="urban %0.2f rural",
        unset="as the recordings say",
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
        meaning="What tells how near a pedestrian is: the box's height, its foot point below the "
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
        meaning="Height (or depth below the horizon) at which a pedestrian counts half. Default: "
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
        meaning="Distance at which a pedestrian counts half, for proximity by distance.",
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
    threshold_x: float | None = setting(
        THRESHOLD,
        None,
        label="Score threshold of X",
        meaning="Detections of X with a lower score are left out. Default: every detection counts.",
    )
    threshold_y: float | None = setting(
        THRESHOLD,
        None,
        label="Score threshold of Y",
        meaning="Detections of Y with a lower score are left out. Default: every detection counts.",
    )
    match: Match = setting(
        MATCH,
        "iou",
        words={"iou": "overlap of the boxes", "lateral": "sideways position"},
        label="A detection matches by",
        meaning="When a detection matches a pedestrian: by overlap of the boxes (iou) or by "
        "sideways position alone (lateral).",
        is_advanced=True,
    )
    iou: float = share(
        MATCH,
        0.5,
        is_above_low=True,
        label="Smallest overlap (IoU)",
        meaning="Smallest overlap (intersection over union) of a match.",
        is_advanced=True,
    )
    lateral_tolerance: float = share(
        MATCH,
        0.02,
        step=0.005,
        unit="of image width",
        used_with=("match", ("lateral",)),
        label="Largest sideways offset (of width)",
        meaning="Largest sideways offset of a match by lateral position; half the pedestrian's "
        "width is always allowed.",
        is_advanced=True,
    )
    coverage: float = share(
        ENCOUNTERS,
        0.5,
        label="Detected if matched in (share)",
        meaning="Share of its relevant frames in which an encounter must be matched to count as "
        "detected.",
        is_advanced=True,
    )
    lag_s: float = setting(
        ENCOUNTERS,
        0.5,
        low=0,
        high=60,
        slider_high=5,
        step=0.1,
        unit="s",
        label="Late after",
        meaning="A first match later than this after the pedestrian became relevant is late.",
        is_advanced=True,
    )
    gap_s: float = setting(
        ENCOUNTERS,
        0.5,
        low=0,
        high=60,
        slider_high=5,
        step=0.1,
        unit="s",
        label="Dropout after",
        meaning="A longer gap between two matches is a dropout; a longer one after the last match "
        "is an early loss.",
        is_advanced=True,
    )
    low: float = share(
        LOW,
        0.9,
        step=0.01,
        label="Low similarity below",
        meaning="Frames with a similarity below this are low.",
        is_advanced=True,
    )
    window: float = setting(
        LOW,
        1.0,
        low=0,
        high=600,
        slider_high=10,
        step=0.1,
        unit="s",
        label="Moving mean",
        meaning="Width of the moving mean of similarity.",
        is_advanced=True,
    )
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
        "the seconds left to its end (seconds), which say the same of short and of long ones.",
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
        words={
            "most_salient": "the most salient miss of a frame",
            "each": "each missed pedestrian",
        },
        label="Events are of",
        meaning="Whose misses make saliency events: of the most salient pedestrian of each frame "
        "alone (most_salient, the paper), or of each pedestrian (each), so that two who are missed "
        "side by side do not cut each other's events.",
        is_advanced=True,
    )
    saliency_weight: SaliencyWeight = setting(
        EVENTS,
        "time",
        words={"time": "its duration", "risk": "its weighted distance over time"},
        label="An event weighs by",
        meaning="What an event weighs by: its duration (time, the paper), or the sum of its "
        "weighted distance over time (risk), so that a far pedestrian counts little.",
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
        label="Recency measured in",
        meaning="What recency is measured in: the whole recording (a clip) or the pedestrian's own "
        "encounter (long drives).",
        is_advanced=True,
    )

    def __post_init__(self) -> None:
        for name, known in SETTINGS.items():
            known.check(name, getattr(self, name))

    def given(self) -> dict[str, float | str]:
        """Settings by name, those that are None left out (for TOML and JSON)."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def values_for(self, *stages: Stage) -> tuple[Any, ...]:
        """Values of the settings that the results of these stages depend on."""
        return tuple(getattr(self, name) for name in settings_for(*stages))

    def only_for(self, *stages: Stage) -> Params:
        """The settings that the results of these stages depend on, all others by default."""
        return Params(**dict(zip(settings_for(*stages), self.values_for(*stages), strict=True)))


SETTINGS: Final[dict[str, Setting]] = {
    spec.name: spec.metadata["setting"] for spec in fields(Params)
}
"""What is known of every setting, by name, in the order in which they are shown."""


@cache
def settings_for(*stages: Stage) -> tuple[str, ...]:
    """Names of the settings that the results of these stages depend on.

    Those of the stages and of all that come before them; a threshold only if `THRESHOLD` is one of
    them.
    """
    before: frozenset[Stage] = frozenset().union(*(stage.before for stage in stages))
    return tuple(name for name, known in SETTINGS.items() if known.stage in before)


def params_from(values: Mapping[str, object]) -> Params:
    """`Params` from a mapping by name, such as a session file's ``[parameters]``.

    Raises
    ------
    ParameterError
        If a name is unknown or a value is outside its range.
    """
    for name in values:
        if name not in SETTINGS:
            hint = did_you_mean(name, SETTINGS, f"the parameters are {', '.join(sorted(SETTINGS))}")
            raise ParameterError(f"there is no parameter {name!r}; {hint}")
    return Params(**values)  # type: ignore[arg-type]
