"""What a run over recordings is told about features, light and fixation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from nvcore.driver.features import FeatureSettings
from nvcore.driver.fixation import FixedPoint
from nvcore.driver.illumination import LightSettings
from nvcore.errors import ParameterError
from nvcore.wording import did_you_mean, listed


@dataclass(frozen=True, kw_only=True)
class DriverViewSettings:
    """How the driver's view is computed.

    Attributes
    ----------
    features, light
        What the paper leaves open.
    fixation
        Where the driver is assumed to look in recordings without a gaze file.
    """

    features: FeatureSettings = field(default_factory=FeatureSettings)
    light: LightSettings = field(default_factory=LightSettings)
    fixation: FixedPoint = field(default_factory=FixedPoint)


def settings_from(
    given: Mapping[str, Any], *, features: FeatureSettings | None = None
) -> DriverViewSettings:
    """Settings by their names; what is not given has its default.

    Parameters
    ----------
    given
        Fields of `FeatureSettings` and `LightSettings`, and ``fixation``: the assumed point, as
        shares of the picture's width and height.
    features
        Of the features where they are not given, as an estimator's are; None: our defaults.

    Raises
    ------
    ParameterError
        If there is no such setting, or a value is outside its range.
    """
    kinds = {spec.name: kind for kind in (FeatureSettings, LightSettings) for spec in fields(kind)}
    values: dict[Any, dict[str, Any]] = {FeatureSettings: {}, LightSettings: {}}
    fixation = FixedPoint()
    for name, value in given.items():
        if name == "fixation":
            fixation = FixedPoint(*value)
        elif name in kinds:
            values[kinds[name]][name] = value
        else:
            known = [*kinds, "fixation"]
            hint = did_you_mean(name, known, f"there are {listed(known)}")
            raise ParameterError(f"there is no setting {name!r}; {hint}")
    return DriverViewSettings(
        features=replace(features or FeatureSettings(), **values[FeatureSettings]),
        light=LightSettings(**values[LightSettings]),
        fixation=fixation,
    )
