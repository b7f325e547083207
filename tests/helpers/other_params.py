"""Another value than the default for every live parameter."""

from __future__ import annotations

from typing import Any, Final

from nvcore.settings.params import SETTINGS
from nvcore.settings.stages import Setting

OF_UNIT: Final = {"s": 1.5, "px": 90.0, "m": 30.0, "": 0.5}
"""For numbers without a default."""


def other_value(setting: Setting) -> Any:
    """The last choice; the low end of a range if there is another value than the default."""
    if setting.words is not None:
        return list(setting.words)[-1]
    if setting.default is None:
        return OF_UNIT[setting.unit]
    if setting.low < setting.default and not setting.is_above_low:
        return type(setting.default)(setting.low)
    return (setting.default + (setting.slider_high or setting.high)) / 2


OTHER: Final[dict[str, Any]] = {
    **{name: other_value(setting) for name, setting in SETTINGS.items()},
    "confirm_m": 3,  # at least confirm_n
}
WITH: Final[dict[str, dict[str, Any]]] = {
    "midpoint_m": {"proximity": "distance"},
    "spread_m": {"proximity": "distance"},
    "missing_distance": {"proximity": "distance"},
    "horizon": {"proximity": "horizon"},
    "lateral_tolerance": {"match": "lateral", "lateral_tolerance": 0.5},
    "saliency_scope": {"saliency_aggregate": "sum"},
    "recency_midpoint_s": {"recency_unit": "seconds"},
    "recency_spread_s": {"recency_unit": "seconds"},
    **{name: {"alerts": "policy"} for name in SETTINGS if name.startswith("alert_")},
    **{name: {"alerts": "policy"} for name in ("own_reaction_s", "foot_s", "brakes_s")},
    "own_reaction_sd_s": {"alerts": "policy", "own_reaction_s": 1.0},
    "limit_unit": {"speeding_after_s": 0.0},
    "alert_off_s": {"alerts": "policy", "alert_least_s": 0.0},
    "alert_least_s": {"alerts": "policy", "alert_off_s": 0.0},
}
"""Where a parameter has an effect at all."""
