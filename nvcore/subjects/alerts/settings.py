"""Settings of alerts: the policy that turns detections into alerts, or a system's own log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal

from nvcore.settings.stages import MATCH, PROXIMITY, Stage, SubjectSettings, setting
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.time_left.settings import URGENCY

ALERTS: Final = Stage("alerts", "Alerts", (MATCH, PROXIMITY, URGENCY, DRIVER), "alerts")

IN_TIME: Final = Stage("in time for the driver", "Alerts", (ALERTS,))

SPEEDING: Final = Stage("speed alerts", "Alerts", (MATCH,))

Asked = Literal["off", "policy", "log"]
Oracle = Literal["off", "on"]
LimitUnit = Literal["kmh", "mph"]
KMH_OF: Final[dict[LimitUnit, float]] = {"kmh": 1.0, "mph": 1.609344}
"""Units of limits in km/h."""
_USED: Final = ("alerts", ("policy", "log"))


def _has_alerts(dataset: Any) -> bool:
    return dataset.of("alerts") is not None


def _has_speeds(dataset: Any) -> bool:
    return bool(dataset.frames["speed_kmh"].notna().any())


def _setting(default: float | str | None, *, stage: Stage = ALERTS, **known: Any) -> Any:
    known = {"used_with": _USED, "is_advanced": True, "applies": _has_alerts} | known
    return setting(stage, default, **known)


def _duration(default: float | None, label: str, meaning: str, **more: Any) -> Any:
    known: dict[str, Any] = {"low": 0, "high": 600, "slider_high": 10, "step": 0.1, "unit": "s"}
    return _setting(default, label=label, meaning=meaning, **known | more)


_SPEEDING: Final[dict[str, Any]] = {"stage": SPEEDING, "used_with": None, "applies": _has_speeds}


@dataclass(frozen=True)
class AlertSettings(SubjectSettings):
    """Settings in `params.Params` that determine when a system alerts the driver."""

    alerts: Asked = _setting(
        "off",
        used_with=None,
        words={"off": "not asked for", "policy": "by the policy", "log": "by its own log"},
        label="Alerts",
        meaning="How detections become alerts: by the policy that the next settings make, or by "
        "the system's own log where the data have one, else by the policy (log). Off: alerts are "
        "not judged.",
    )
    alert_k: float = _setting(
        0.5,
        low=0,
        high=1,
        step=0.05,
        label="Alert from (proximity weight)",
        meaning="Least proximity weight of a box that can alert the driver.",
    )
    alert_distance_m: float | None = _setting(
        None,
        low=0,
        high=1000,
        slider_high=200,
        unit="m",
        label="Alert within",
        meaning="Largest distance of a box that can alert the driver, where it is reported; "
        "the proximity weight decides on the others. Default: it decides on all.",
        unset="no distance set",
    )
    alert_corridor: float = _setting(
        0.75,
        low=0,
        high=1,
        step=0.05,
        unit="of half the image width",
        label="Alert corridor (of half the width)",
        meaning="A box farther from the middle of the picture than this does not alert the driver. "
        "1: the whole picture counts.",
    )
    alert_score: float | None = _setting(
        None,
        label="Alert from (score)",
        meaning="Least score of a box that can alert the driver, of both systems, beyond the "
        "threshold of each. Default: that threshold alone.",
        unset="no score set",
    )
    alert_on_s: float = _duration(
        0.2,
        "Alert on after",
        "How long a track has to meet all of these conditions before its alert begins.",
    )
    alert_off_s: float = _duration(
        0.4, "Alert off after", "How long it may fail to meet them before the alert ends."
    )
    alert_least_s: float = _duration(
        0.8, "Shortest alert", "How long an alert lasts at least, whatever its track does."
    )
    alert_pause_s: float = _duration(
        2.0,
        "Pause after an alert",
        "How long the same track gives no other alert after one has ended.",
    )
    alert_oracle: Oracle = _setting(
        "off",
        words={"off": "alert anyway", "on": "keep still (an oracle)"},
        label="If the driver has seen the {one}",
        meaning="Whether a box of {a_one} {whom} the driver has seen gives no alert any more (on): "
        "what a perfect driver monitor would bring, an oracle, as no system knows it. False alarms "
        "alert anyway. Of no effect where no detectability is known.",
    )

    own_reaction_s: float | None = _duration(
        None,
        "Own reaction time (mean)",
        "Mean time of your own drivers from the onset of an alert to their first movement. "
        "Default: only the times of the source, by kind of alert.",
        stage=IN_TIME,
        low=0.05,
        unset="not given",
    )
    own_reaction_sd_s: float = _duration(
        0.0,
        "Own reaction time (SD)",
        "Standard deviation of these times; 0: all drivers alike.",
        stage=IN_TIME,
    )
    foot_s: float = _duration(
        0.0, "Movement of the foot", "From the reaction to the foot on the brake.", stage=IN_TIME
    )
    brakes_s: float = _duration(
        0.0, "Build-up of the brakes", "From the foot on the brake to braking.", stage=IN_TIME
    )

    speeding_after_s: float = _duration(
        2.0,
        "Speed alert after",
        "How long the car has to be above the limit that was read last before the driver "
        "is alerted. Of effect where speed signs are compared and the car's speed is known.",
        **_SPEEDING,
        high=60,
        step=0.5,
    )
    limit_unit: LimitUnit = _setting(
        "kmh",
        **_SPEEDING,
        words={"kmh": "km/h", "mph": "miles per hour"},
        label="Unit of limits",
        meaning="Unit of the limits that signs show. Of effect as the setting before.",
    )
