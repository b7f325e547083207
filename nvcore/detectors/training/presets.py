"""Settings of a training: a preset by its name, with changes as users write them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, Final

from nvcore.detectors.arguments import Preset
from nvcore.detectors.base import DetectorError
from nvcore.detectors.icf import AS_IN_REPORT, PEDESTRIANS, SIGNS, IcfSettings
from nvcore.detectors.settings import check_names, typed_like
from nvcore.objects import SPEED_SIGN, Objects
from nvcore.wording import did_you_mean, listed

PRESETS: Final[Mapping[str, IcfSettings]] = {
    "pedestrians": PEDESTRIANS,
    "signs": SIGNS,
    "as-in-report": AS_IN_REPORT,
}
"""By the names of `nvcore.detectors.arguments.Preset`."""


def preset_for(objects: Objects | None) -> Preset:
    """The preset for what a session is of, unless the user names one; None: there is no session."""
    return "signs" if objects == SPEED_SIGN else "pedestrians"


def preset_settings(preset: str, given: Mapping[str, Any]) -> IcfSettings:
    """The settings of a preset, some of them changed.

    Parameters
    ----------
    given
        By name; see `typed_like`.

    Raises
    ------
    DetectorError
        If there is no such preset or setting, or a text is not of the setting's type.
    ParameterError
        If a value is not possible.
    """
    if preset not in PRESETS:
        known = f"they are {listed([*PRESETS])}"
        raise DetectorError(
            f"there is no preset {preset!r}; {did_you_mean(preset, PRESETS, known)}"
        )
    check_names(given, [spec.name for spec in fields(IcfSettings)])
    start = PRESETS[preset]
    patience = given.get("patience")
    if isinstance(patience, str):
        try:
            given = {**given, "patience": None if patience == "none" else int(patience)}
        except ValueError as error:
            raise DetectorError(
                f"patience: expected a whole number or none, found {patience!r}"
            ) from error
    return replace(start, **typed_like(start, given))
