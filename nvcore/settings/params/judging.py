"""Settings for judging boxes, encounters and frames: matched, detected, late, low."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from nvcore.settings.stages import ENCOUNTERS, LOW, MATCH, THRESHOLD, setting, share

Match = Literal["iou", "lateral"]
MatchClass = Literal["any", "same"]


@dataclass(frozen=True)
class JudgingSettings:
    """Settings in `nvcore.settings.params.Params` for thresholds, matching and limits."""

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
        meaning="When a detection matches {a_one}: by overlap of the boxes (iou) or by "
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
        meaning="Largest sideways offset of a match by lateral position; half the {one}'s "
        "width is always allowed.",
        is_advanced=True,
    )
    match_class: MatchClass = setting(
        MATCH,
        "any",
        words={"any": "of any class", "same": "of its own class alone"},
        label="A detection matches {many}",
        meaning="Which {many} a detection can match: of any class (any), or of its own alone "
        "(same). With same, a speed sign whose limit is read wrong is missed, and the detection is "
        "a false alarm. {A_one} whose class is not known is matched by any detection.",
        is_advanced=True,
    )
    coverage: float = share(
        ENCOUNTERS,
        0.5,
        label="Detected if matched in (share)",
        meaning="Share of its frames that count in which an encounter must be matched to count as "
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
        meaning="A first match later than this after the {one} came near enough to count is late.",
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
