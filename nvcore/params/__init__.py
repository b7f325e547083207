"""Every live setting of the comparison, defined once, in its field.

The command line makes its flags from `Params`, the dashboard its sliders, `compare` the keys of
what it need not repeat. A new setting is a field of the topic that it belongs to (`similarity`,
`judging`, `saliency`, or a subject's own); that is all it takes, but for its
use, test and docs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from nvcore.errors import ParameterError
from nvcore.params.judging import JudgingSettings, Match, MatchClass
from nvcore.params.saliency import (
    Aggregate,
    RecencyUnit,
    SaliencyOf,
    SaliencySettings,
    SaliencyWeight,
    Scope,
)
from nvcore.params.similarity import (
    MIDPOINT_SHARE,
    SPREAD_SHARE,
    Distance,
    MissingDistance,
    Pairing,
    Proximity,
    SimilaritySettings,
)
from nvcore.stages import AUDITED, Setting, Stage
from nvcore.subjects import contributed
from nvcore.wording import did_you_mean

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


if TYPE_CHECKING:
    OfSubjects: Any
else:
    OfSubjects = type("OfSubjects", contributed("settings")[::-1], {})


@dataclass(frozen=True)
class Params(  # the last one's fields first
    OfSubjects,  # type: ignore[misc]
    SaliencySettings,
    JudgingSettings,
    SimilaritySettings,
):
    """Settings of one comparison, checked when made.

    The metadata of each field is a `Setting`. None means: taken from the data (`edge_weight`,
    `midpoint`, `spread`, `horizon`) or not applied (thresholds).

    Raises
    ------
    ParameterError
        If a value is outside its range, or values do not go together.

    References
    ----------
    Paper 11-0360; the defaults marked as choices are argued in ``docs/metrics.md``.
    """

    def __post_init__(self) -> None:
        for name, known in SETTINGS.items():
            known.check(name, getattr(self, name))
        for kind in contributed("settings"):
            kind.check_together(self)

    def given(self) -> dict[str, float | str]:
        """Settings by name, those that are None left out (for TOML and JSON)."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def stated(self, dataset: object = None) -> dict[str, float | str | None]:
        """All settings by name; those that act on what not all data have only if these data do.

        Or if they were changed.

        Parameters
        ----------
        dataset
            None: not known.
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
        """Settings that are not at their default, and that the others leave without effect."""
        return tuple(
            name
            for name, known in SETTINGS.items()
            if known.used_with is not None
            and getattr(self, name) != known.default
            and getattr(self, known.used_with[0]) not in known.used_with[1]
        )

    def values_for(self, *stages: Stage) -> tuple[Any, ...]:
        """Values of the settings that the results of these stages depend on."""
        return tuple(getattr(self, name) for name in settings_for(*stages))

    def only_for(self, *stages: Stage) -> Params:
        """The settings that the results of these stages depend on, all others by default."""
        return self._only(settings_for(*stages))

    def only_for_audit(self) -> Params:
        """The settings that findings of the audit depend on, all others by default."""
        return self._only(AUDIT_SETTINGS)

    def _only(self, names: Iterable[str]) -> Params:
        return Params(**{name: getattr(self, name) for name in names})


SETTINGS: Final[dict[str, Setting]] = {
    spec.name: spec.metadata["setting"] for spec in fields(Params)
}
"""What is known of every setting, by name, in the order in which they are shown."""
AUDIT_SETTINGS: Final = tuple(
    name for name, known in SETTINGS.items() if known.is_audited or known.stage in AUDITED
)
"""Names of the settings that findings of the audit depend on."""


@cache
def settings_for(*stages: Stage) -> tuple[str, ...]:
    """Names of the settings that the results of these stages depend on.

    Those of the stages and of all that come before them; a threshold only if `THRESHOLD` is one of
    them.
    """
    before: frozenset[Stage] = frozenset().union(*(stage.before for stage in stages))
    return tuple(name for name, known in SETTINGS.items() if known.stage in before)


def params_from(values: Mapping[str, object]) -> Params:
    """`Params` from a mapping by name, such as a session file's ``[parameters]``.

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
