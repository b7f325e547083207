"""All live settings of the comparison, each defined once, in its field.

`Params` defines the command line's flags, the dashboard's sliders, and the cache keys of `compare`.
To add a setting, add a field to its topic (`similarity`, `judging`, `saliency`, or a subject's
own), and its use, test and docs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from functools import cache
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from nvcore.common.errors import ParameterError
from nvcore.common.subject import subjects
from nvcore.common.wording import did_you_mean
from nvcore.settings.params.judging import JudgingSettings, Match, MatchClass
from nvcore.settings.params.saliency import (
    Aggregate,
    RecencyUnit,
    SaliencyOf,
    SaliencySettings,
    SaliencyWeight,
    Scope,
)
from nvcore.settings.params.similarity import (
    MIDPOINT_SHARE,
    SPREAD_SHARE,
    Distance,
    MissingDistance,
    Pairing,
    Proximity,
    SimilaritySettings,
)
from nvcore.settings.stages import AUDITED, Setting, Stage

__all__ = [
    "AUDIT_SETTINGS",
    "MIDPOINT_SHARE",
    "SETTINGS",
    "SPREAD_SHARE",
    "Aggregate",
    "Distance",
    "Match",
    "MatchClass",
    "MissingDistance",
    "Pairing",
    "Params",
    "Proximity",
    "RecencyUnit",
    "SaliencyOf",
    "SaliencyWeight",
    "Scope",
    "params_from",
    "settings_for",
]


_OF_SUBJECTS: Final = tuple(chain(*(subject.settings().fields for subject in subjects())))
if TYPE_CHECKING:
    OfSubjects: Any
else:
    OfSubjects = type("OfSubjects", _OF_SUBJECTS[::-1], {})


@dataclass(frozen=True)
class Params(  # fields of the last base come first
    OfSubjects,  # type: ignore[misc]
    SaliencySettings,
    JudgingSettings,
    SimilaritySettings,
):
    """Settings of one comparison, validated on creation.

    The metadata of each field is a `Setting`. None means that the value is taken from the data
    (`edge_weight`, `midpoint`, `spread`, `horizon`) or not applied (thresholds).

    Raises
    ------
    ParameterError
        If a value is outside its range, or values do not go together.

    References
    ----------
    Paper 11-0360. ``docs/metrics.md`` explains the defaults marked as choices.
    """

    def __post_init__(self) -> None:
        for name, known in SETTINGS.items():
            known.check(name, getattr(self, name))
        for kind in _OF_SUBJECTS:
            kind.check_together(self)

    def given(self) -> dict[str, float | str]:
        """Return the settings by name, without those that are None (for TOML and JSON)."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def stated(self, dataset: object = None) -> dict[str, float | str | None]:
        """Return all settings by name, without unchanged ones that do not apply to the data.

        Or if they were changed.

        Parameters
        ----------
        dataset
            None: unknown.
        """
        return {
            name: value
            for name, value in asdict(self).items()
            if (applies := SETTINGS[name].applies) is None
            or (dataset is not None and applies(dataset))
            or value != SETTINGS[name].default
        }

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Changed settings that have no effect because of the values of others."""
        return tuple(
            name
            for name, known in SETTINGS.items()
            if known.used_with is not None
            and getattr(self, name) != known.default
            and getattr(self, known.used_with[0]) not in known.used_with[1]
        )

    def values_for(self, *stages: Stage) -> tuple[Any, ...]:
        """Return the values of the settings that the results of these stages depend on."""
        return tuple(getattr(self, name) for name in settings_for(*stages))

    def only_for(self, *stages: Stage) -> Params:
        """Return the settings that the results of these stages depend on, others by default."""
        return self._only(settings_for(*stages))

    def only_for_audit(self) -> Params:
        """Return the settings that findings of the audit depend on, others by default."""
        return self._only(AUDIT_SETTINGS)

    def _only(self, names: Iterable[str]) -> Params:
        return Params(**{name: getattr(self, name) for name in names})


SETTINGS: Final[dict[str, Setting]] = {
    spec.name: spec.metadata["setting"] for spec in fields(Params)
}
"""Definition of every setting, by name, in display order."""
AUDIT_SETTINGS: Final = tuple(
    name for name, known in SETTINGS.items() if known.is_audited or known.stage in AUDITED
)
"""Names of the settings that findings of the audit depend on."""


@cache
def settings_for(*stages: Stage) -> tuple[str, ...]:
    """Return the names of the settings that the results of these stages depend on.

    These are the settings of the stages and of all earlier ones. A threshold is only included if
    `THRESHOLD` is one of the stages.
    """
    before: frozenset[Stage] = frozenset().union(*(stage.before for stage in stages))
    return tuple(name for name, known in SETTINGS.items() if known.stage in before)


def params_from(values: Mapping[str, object]) -> Params:
    """Create `Params` from a mapping by name, such as a session file's ``[parameters]``.

    Raises
    ------
    ParameterError
        If a name is unknown or a value is outside its range.
    """
    for name in values:
        if name not in SETTINGS:
            hint = did_you_mean(name, SETTINGS, f"the parameters are {', '.join(sorted(SETTINGS))}")
            raise ParameterError(f"there is no parameter {name!r}; {hint}")
    return Params(**values)  # type: ignore[arg-type]
