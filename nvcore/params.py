"""Every live setting of the analysis: default, range, step, unit and help text, once.

The command line makes its flags from `Params`, the web its sliders.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import Field, asdict, dataclass, field, fields
from typing import Any, Final, Literal, get_args

from nvcore.errors import ParameterError

Distance = Literal["lateral", "ground"]
Proximity = Literal["height", "horizon", "distance", "none"]
Match = Literal["iou", "lateral"]
Aggregate = Literal["max", "sum"]
Scope = Literal["recording", "encounter"]

# groups in which the settings are shown
SIMILARITY: Final = "Similarity"
PROXIMITY: Final = "Proximity"
MATCHING: Final = "Thresholds and matching"
ENCOUNTERS: Final = "Encounters"
SALIENCY: Final = "Saliency"

MIDPOINT_SHARE: Final = 0.10
"""Default midpoint of the height sigmoid as a share of the image height."""
SPREAD_SHARE: Final = 0.02
"""Default spread of the height sigmoid as a share of the image height."""


def _number(
    group: str,
    default: float | None,
    *,
    low: float,
    high: float,
    step: float,
    unit: str,
    text: str,
    above_low: bool = False,
) -> Any:
    """A numeric setting; `above_low` excludes the lower end of the range."""
    metadata = {
        "group": group,
        "low": low,
        "high": high,
        "step": step,
        "unit": unit,
        "help": text,
        "above_low": above_low,
        "choices": None,
    }
    return field(default=default, metadata=metadata)


def _choice(group: str, default: str, *, kind: Any, text: str) -> Any:
    metadata = {"group": group, "choices": get_args(kind), "unit": "", "help": text}
    return field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Params:
    """Settings of one analysis, checked when made.

    Groups, ranges, steps, units and help texts stand in the metadata of the fields. None means:
    taken from the data (`midpoint`, `spread`, `horizon`) or not applied (thresholds).

    Raises
    ------
    ParameterError
        If a value is outside its range.

    References
    ----------
    Paper 11-0360; the defaults marked as choices are argued in ``docs/metrics.md``.
    """

    alpha: float = _number(
        SIMILARITY, 0.9, low=0, high=1, step=0.05, unit="",
        text="Weight of misses against false alarms in similarity: 1 counts misses only, "
        "0 false alarms only.",
    )  # fmt: skip
    distance: Distance = _choice(
        SIMILARITY, "lateral", kind=Distance,
        text="How far a detection is from a pedestrian: sideways only (lateral) or between foot "
        "points in the picture (ground).",
    )  # fmt: skip
    edge_weight: float = _number(
        SIMILARITY, 0.0, low=0, high=1, step=0.05, unit="",
        text="Traffic context. 0 (urban): a miss far to the side costs little; 1 (rural): a miss "
        "at the road's edge costs as much as one straight ahead.",
    )  # fmt: skip
    proximity: Proximity = _choice(
        PROXIMITY, "height", kind=Proximity,
        text="What tells how near a pedestrian is: the box's height, its foot point below the "
        "horizon, the distance in metres, or none (all count the same).",
    )  # fmt: skip
    midpoint: float | None = _number(
        PROXIMITY, None, low=0, high=10_000, step=1, unit="px",
        text="Height (or depth below the horizon) at which a pedestrian counts half. Default: "
        "10 % of the image height.",
    )  # fmt: skip
    spread: float | None = _number(
        PROXIMITY, None, low=0, high=10_000, step=1, unit="px", above_low=True,
        text="Softness of the step at the midpoint. Default: 2 % of the image height.",
    )  # fmt: skip
    midpoint_m: float = _number(
        PROXIMITY, 35.0, low=0, high=1_000, step=1, unit="m",
        text="Distance at which a pedestrian counts half, for proximity by distance.",
    )  # fmt: skip
    spread_m: float = _number(
        PROXIMITY, 7.0, low=0, high=1_000, step=0.5, unit="m", above_low=True,
        text="Softness of the step at that distance.",
    )  # fmt: skip
    horizon: float | None = _number(
        PROXIMITY, None, low=-10_000, high=10_000, step=1, unit="px",
        text="Row of the horizon in the picture, for proximity by horizon. Default: the "
        "recording's own.",
    )  # fmt: skip
    threshold_x: float | None = _number(
        MATCHING, None, low=-math.inf, high=math.inf, step=0.01, unit="",
        text="Detections of X with a lower score are left out. Default: every detection counts.",
    )  # fmt: skip
    threshold_y: float | None = _number(
        MATCHING, None, low=-math.inf, high=math.inf, step=0.01, unit="",
        text="Detections of Y with a lower score are left out. Default: every detection counts.",
    )  # fmt: skip
    match: Match = _choice(
        MATCHING, "iou", kind=Match,
        text="When a detection matches a pedestrian: by overlap of the boxes (iou) or by sideways "
        "position alone (lateral).",
    )  # fmt: skip
    iou: float = _number(
        MATCHING, 0.5, low=0, high=1, step=0.05, unit="", above_low=True,
        text="Smallest overlap (intersection over union) of a match.",
    )  # fmt: skip
    lateral_tolerance: float = _number(
        MATCHING, 0.02, low=0, high=1, step=0.005, unit="of image width",
        text="Largest sideways offset of a match by lateral position; half the pedestrian's width "
        "is always allowed.",
    )  # fmt: skip
    coverage: float = _number(
        ENCOUNTERS, 0.5, low=0, high=1, step=0.05, unit="",
        text="Share of its relevant frames in which an encounter must be matched to count as "
        "detected.",
    )  # fmt: skip
    lag_s: float = _number(
        ENCOUNTERS, 0.5, low=0, high=60, step=0.1, unit="s",
        text="A first match later than this after the pedestrian became relevant is late.",
    )  # fmt: skip
    gap_s: float = _number(
        ENCOUNTERS, 0.5, low=0, high=60, step=0.1, unit="s",
        text="A longer gap between two matches is a dropout; a longer one after the last match is "
        "an early loss.",
    )  # fmt: skip
    low: float = _number(
        SIMILARITY, 0.9, low=0, high=1, step=0.01, unit="",
        text="Frames with a similarity below this are low.",
    )  # fmt: skip
    window: float = _number(
        SIMILARITY, 1.0, low=0, high=600, step=0.1, unit="s",
        text="Width of the moving mean of similarity.",
    )  # fmt: skip
    tolerance: float = _number(
        SALIENCY, 0.05, low=0, high=1, step=0.01, unit="of half the image width",
        text="A miss counts for saliency only when its weighted distance is larger than this.",
    )  # fmt: skip
    recency_midpoint: float = _number(
        SALIENCY, 0.5, low=0, high=1, step=0.05, unit="of the duration",
        text="When in the recording a miss starts to be remembered: it counts half here.",
    )  # fmt: skip
    recency_spread: float = _number(
        SALIENCY, 0.1, low=0, high=10, step=0.01, unit="of the duration", above_low=True,
        text="Softness of that step.",
    )  # fmt: skip
    saliency_aggregate: Aggregate = _choice(
        SALIENCY, "max", kind=Aggregate,
        text="A recording's saliency: its most salient event (max) or all of them added (sum).",
    )  # fmt: skip
    saliency_scope: Scope = _choice(
        SALIENCY, "recording", kind=Scope,
        text="What recency is measured in: the whole recording (a clip) or the pedestrian's own "
        "encounter (long drives).",
    )  # fmt: skip

    def __post_init__(self) -> None:
        for spec in fields(self):
            _check(spec, getattr(self, spec.name))

    def given(self) -> dict[str, float | str]:
        """Settings by name, those that are None left out (for TOML and JSON)."""
        return {name: value for name, value in asdict(self).items() if value is not None}


def _check(spec: Field[Any], value: object) -> None:
    flag = spec.name
    choices = spec.metadata["choices"]
    if choices is not None:
        if value not in choices:
            raise ParameterError(f"{flag}: expected one of {', '.join(choices)}, got {value!r}")
        return
    if value is None and spec.default is None:
        return
    if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
        raise ParameterError(f"{flag}: expected a number, got {value!r}")
    low, high = spec.metadata["low"], spec.metadata["high"]
    if not low <= value <= high or (spec.metadata["above_low"] and value == low):
        least = f"more than {low:g}" if spec.metadata["above_low"] else f"{low:g}"
        raise ParameterError(f"{flag}: expected {least} to {high:g}, got {value:g}")


def params_from(values: Mapping[str, object]) -> Params:
    """`Params` from a mapping by name, such as a session file's ``[parameters]``.

    Raises
    ------
    ParameterError
        If a name is unknown or a value is outside its range.
    """
    known = {spec.name for spec in fields(Params)}
    for name in values:
        if name not in known:
            raise ParameterError(
                f"there is no parameter {name!r}; the parameters are {', '.join(sorted(known))}"
            )
    return Params(**values)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Preset:
    """A named choice of traffic context and of the height at which a pedestrian is near.

    Attributes
    ----------
    name
        As shown.
    text
        What it is for, in a sentence.
    edge_weight
        See `Params.edge_weight`.
    midpoint_share, spread_share
        Midpoint and spread of the height sigmoid, as shares of the picture's height.
    """

    name: str
    text: str
    edge_weight: float
    midpoint_share: float
    spread_share: float

    def values(self, height: float | None) -> dict[str, float | str | None]:
        """All parameters but the thresholds, for pictures of this height in px.

        Midpoint and spread are None, taken from each recording, where they are the default
        shares or the height is unknown.
        """
        defaults = {
            name: value
            for name, value in asdict(Params()).items()
            if not name.startswith("threshold")
        }
        is_default = (self.midpoint_share, self.spread_share) == (MIDPOINT_SHARE, SPREAD_SHARE)
        changes: dict[str, float | str | None] = {"edge_weight": self.edge_weight}
        if not is_default and height is not None:
            changes["midpoint"] = self.midpoint_share * height
            changes["spread"] = self.spread_share * height
        return defaults | changes


PRESETS: Final = (
    Preset(
        "Paper",
        "All settings but the thresholds as by default: the paper's where it gives them. A miss "
        "far to the side costs little.",
        edge_weight=0.0,
        midpoint_share=MIDPOINT_SHARE,
        spread_share=SPREAD_SHARE,
    ),
    Preset(
        "Urban",
        "Low speed: a pedestrian counts half at 15 % of the tallest picture's height, a "
        "miss on the far sidewalk costs little.",
        edge_weight=0.0,
        midpoint_share=0.15,
        spread_share=0.03,
    ),
    Preset(
        "Rural",
        "High speed: a pedestrian counts half at 6 % of the tallest picture's height, and a miss "
        "at the road's edge costs as much as one straight ahead.",
        edge_weight=1.0,
        midpoint_share=0.06,
        spread_share=0.012,
    ),
)
"""All presets; the first is the default."""
