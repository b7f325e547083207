"""Criteria for a change of the light from bright to dark. All of them are our choice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from nvcore.driver.shapes import check_ranges
from nvcore.errors import ParameterError
from nvcore.records import decode

_RANGES: Final = {
    "drop_factor": (1.1, 1e6),
    "picture_drop_factor": (1.1, 1e6),
    "within_s": (0.0, 60.0),
    "bright_for_s": (0.0, 600.0),
    "smooth_s": (0.0, 10.0),
    "least_lux": (1e-6, 1e5),
}


@dataclass(frozen=True, kw_only=True)
class LightSettings:
    """Criteria for a change of the light from bright to dark.

    Attributes
    ----------
    drop_factor
        By so much the light of a light meter falls at least: 1,000 lx to 100 lx with 10. (In the
        paper's experiment it falls from 1,000 lx to 10 lx.)
    picture_drop_factor
        By so much the mean luminance of the picture falls, where it stands in for a light meter;
        less, as the camera's exposure follows the light.
    within_s
        In so many seconds, or from one reading to the next where these are further apart.
    bright_for_s
        So long the light must have been there before: what passes sooner, such as an oncoming
        lamp, is not what the eye was adapted to. After a change, the light must be back for as
        long to end the adaptation.
    smooth_s
        Width of the running median that flicker and single shadows are taken out with.
    least_lux
        What a light meter reads below that counts as that.
    """

    drop_factor: float = 10.0
    picture_drop_factor: float = 3.0
    within_s: float = 2.0
    bright_for_s: float = 3.0
    smooth_s: float = 0.5
    least_lux: float = 0.1

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES)


def light_settings(content: Mapping[str, object]) -> LightSettings:
    """Parse settings from a record, where they stand as `dataclasses.asdict` gives them.

    Raises
    ------
    ParameterError
        If one is missing, unknown, no number or outside its range.
    """
    try:
        return decode(LightSettings, content, "settings of the light", complete=True)
    except ValueError as error:
        raise ParameterError(str(error)) from error
