"""Stability maps, which show whether the verdict depends on the settings."""

from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import (
    EqualAlarms,
    StabilityMap,
    equal_alarm_thresholds,
    map_stability,
)
from nvcore.evidence.stability.notes import (
    describe_chance,
    describe_equal_alarms,
    describe_stability,
)
from nvcore.evidence.stability.scores import Criterion
from nvcore.evidence.stability.survey import survey_stability, survey_table

__all__ = [
    "Criterion",
    "EqualAlarms",
    "Plane",
    "StabilityMap",
    "describe_chance",
    "describe_equal_alarms",
    "describe_stability",
    "equal_alarm_thresholds",
    "map_stability",
    "survey_stability",
    "survey_table",
]
