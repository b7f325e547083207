"""Settings of a run over recordings: features, light and fixation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from nvcore.common.errors import ParameterError
from nvcore.common.wording import did_you_mean, listed
from nvcore.subjects.driver.features import FeatureSettings
from nvcore.subjects.driver.illumination import LightSettings
from nvcore.subjects.driver.inputs.fixation import FixedPoint


@dataclass(frozen=True, kw_only=True)
class DriverViewSettings:
    """Settings of the computation of the driver's view.

    Attributes
    ----------
    features, light
        Values that the paper leaves open.
    fixation
        Assumed fixation point in recordings without a gaze file.
    """

    features: FeatureSettings = field(default_factory=FeatureSettings)
    light: LightSettings = field(default_factory=LightSettings)
    fixation: FixedPoint = field(default_factory=FixedPoint)


def settings_from(
    given: Mapping[str, Any], *, features: FeatureSettings | None = None
) -> DriverViewSettings:
    """Create settings from values by name. Missing values have their defaults.

    Parameters
    ----------
    given
        Fields of `FeatureSettings` and `LightSettings`, and ``fixation``: the assumed point as
        shares of the picture's width and height.
    features
        Feature settings for values that are not given, such as an estimator's. None: our defaults.

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
