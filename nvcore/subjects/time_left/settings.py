"""Settings of time left: time to contact, time that a driver needs, confirmation of pedestrians."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from nvcore.common.errors import ParameterError
from nvcore.settings.stages import MATCH, Stage, SubjectSettings, setting, share

CONTACT: Final = Stage("time to contact", "Time left")
URGENCY: Final = Stage("urgent encounters", "Time left", (CONTACT,))
CONFIRMED: Final = Stage("pedestrians confirmed", "Time left", (MATCH,))
TIME_LEFT: Final = Stage("time left", "Time left", (URGENCY, CONFIRMED), "time left")


@dataclass(frozen=True)
class TimeLeftSettings(SubjectSettings):
    """Settings in `nvcore.settings.params.Params` that time left depends on."""

    speed_kmh: float = setting(
        URGENCY,
        50.0,
        low=0,
        high=300,
        slider_high=130,
        step=5,
        unit="km/h",
        slider_format="%0.0f",
        is_above_low=True,
        label="Assumed speed (km/h)",
        meaning="Speed of the car in recordings that do not state their own. The faster, the "
        "earlier a warning has to come for the car to stop in time.",
        is_advanced=True,
        is_audited=True,
    )
    reaction_s: float = setting(
        URGENCY,
        1.2,
        low=0,
        high=10,
        slider_high=3,
        step=0.1,
        unit="s",
        label="Reaction time",
        meaning="Time from the warning until the brakes act.",
        is_advanced=True,
    )
    deceleration: float = setting(
        URGENCY,
        7.0,
        low=0,
        high=20,
        slider_high=12,
        step=0.5,
        unit="m/s²",
        is_above_low=True,
        label="Deceleration (m/s²)",
        meaning="How hard the car brakes. 7 m/s²: from 50 km/h it stops in 2 s.",
        is_advanced=True,
    )
    ttc_window: float = setting(
        CONTACT,
        1.0,
        low=0,
        high=10,
        slider_high=3,
        step=0.1,
        unit="s",
        is_above_low=True,
        label="Window of time to contact",
        meaning="Span of the frames, centred on each one, from which the time until the car "
        "reaches {a_one} is estimated.",
        is_advanced=True,
    )
    corridor: float = share(
        URGENCY,
        1.0,
        unit="of half the image width",
        label="Corridor (of half the width)",
        meaning="{A_one} farther from the middle of the picture than this when the last "
        "chance to brake comes is outside and does not count. 1: the whole picture counts.",
        is_advanced=True,
    )
    confirm_n: int = setting(
        CONFIRMED,
        3,
        low=1,
        high=100,
        slider_high=10,
        unit="frames",
        is_whole=True,
        slider_format="%0.0f",
        label="Confirmed if matched in (frames)",
        meaning="A system confirms {a_one}, and can warn, once it matches the {one} in this many "
        "of the most recent frames. The next setting is how many frames those are.",
        is_advanced=True,
    )
    confirm_m: int = setting(
        CONFIRMED,
        5,
        low=1,
        high=100,
        slider_high=10,
        unit="frames",
        is_whole=True,
        slider_format="%0.0f",
        label="Confirmed within the last (frames)",
        meaning="Number of most recent frames in which matches of {a_one} count towards "
        "confirmation. There are fewer at the start of a track.",
        is_advanced=True,
    )

    def check_together(self) -> None:
        """Check that values do not contradict one another.

        Raises
        ------
        ParameterError
            If `confirm_n` is more than `confirm_m`.
        """
        if self.confirm_n > self.confirm_m:
            raise ParameterError(
                f"confirm_n: expected at most confirm_m, which is {self.confirm_m:g}, got "
                f"{self.confirm_n:g}: nobody would ever be confirmed"
            )
