"""Definition of a setting, and the stages of the comparison that settings belong to."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from itertools import chain
from typing import Any, Final

from nvcore.common.errors import ParameterError
from nvcore.common.subject import subjects


@dataclass(frozen=True, eq=False)
class Stage:
    """Step of the comparison that reads settings.

    Attributes
    ----------
    name
        Name of its result.
    group
        Heading under which its settings are shown.
    after
        Stages that it starts from. Their settings change its result, too.
    result
        Reader's name for its result; empty if it is not shown by itself.
    """

    name: str
    group: str
    after: tuple[Stage, ...] = ()
    result: str = ""

    @cached_property
    def before(self) -> frozenset[Stage]:
        """The stage itself and all earlier ones."""
        return frozenset({self}.union(*(stage.before for stage in self.after)))


THRESHOLD: Final = Stage("detections that count", "Thresholds and matching")
"""Not before `MATCH`, because each system has a threshold of its own and depends on only one."""
MATCH: Final = Stage("matches", "Thresholds and matching", result="matches and false alarms")
PROXIMITY: Final = Stage("weights of nearness", "Proximity")
NEAREST: Final = Stage("nearest of the other set", "Similarity", (MATCH,))
MISS_WEIGHTS: Final = Stage("weights of a miss", "Similarity", (PROXIMITY,))
COST: Final = Stage("cost of a missed pedestrian", "Similarity", (MISS_WEIGHTS,))
DISTANCES: Final = Stage("distances of the sets", "Similarity", (NEAREST, COST))
SIMILARITY: Final = Stage("similarity of frames", "Similarity", (DISTANCES,), "similarity")
LOW: Final = Stage("low frames and moving mean", "Similarity", (SIMILARITY,), "low similarity")
ENCOUNTERS: Final = Stage("encounters, judged", "Encounters", (MATCH, PROXIMITY), "encounters")
SEVERITY: Final = Stage("severity of encounters", "Encounters", (MATCH, COST), "severity")
SALIENT: Final = Stage("most salient miss of frames", "Saliency", (DISTANCES,))
EVENTS: Final = Stage("saliency events", "Saliency", (SALIENT,))
SALIENCY: Final = Stage("saliency of recordings", "Saliency", (EVENTS,), "saliency")


@cache
def shown_results() -> tuple[Stage, ...]:
    """Return the stages whose results are shown, in the order in which they are named."""
    own = (MATCH, SIMILARITY, LOW, ENCOUNTERS, SEVERITY, SALIENCY)
    return (*own, *chain(*(subject.settings().shown for subject in subjects())))


AUDITED: Final = (THRESHOLD, MATCH, PROXIMITY)
"""Stages whose settings affect findings of the audit."""


@dataclass(frozen=True, eq=False)
class Setting:
    """Definition of a live setting for command line, sidebar, reports and docs.

    Attributes
    ----------
    stage
        First stage of the comparison that it changes.
    default
        Default value; None: taken from the data, or not applied.
    label
        Label of its widget, without the unit that `label_with_unit` adds. This and the next two are
        templates with words of the objects (`nvcore.common.wording.objects`).
    meaning
        Description in full sentences, for help texts.
    words
        Texts of a choice by value; None for a number.
    low, high, step, unit
        Range, step and unit of a number.
    is_above_low
        True if the lower end is outside the range.
    is_whole
        True for a whole number.
    slider_high
        End of its slider, if the whole range is more than anyone needs.
    slider_format
        Format of the value at its slider, if not a plain number.
    height_share
        Default as a share of the picture's height.
    used_with
        Another setting, and the values of that setting with which it is used; None: always used.
    unset
        Text of the switch above its slider for having no value; empty: no switch.
    is_advanced
        True if it is rarely changed, so that its widget is folded away.
    is_audited
        True if findings of the audit depend on it although its stage is not in `AUDITED`.
    heading
        Heading under which it is shown, if other than its stage's.
    applies
        Returns True if the setting applies to a dataset; None: it applies to all.
    """

    stage: Stage
    default: float | str | None
    label: str
    meaning: str
    words: Mapping[str, str] | None = None
    low: float = -math.inf
    high: float = math.inf
    step: float = 1.0
    unit: str = ""
    is_above_low: bool = False
    is_whole: bool = False
    slider_high: float | None = None
    slider_format: str | None = None
    height_share: float | None = None
    used_with: tuple[str, tuple[str, ...]] | None = None
    unset: str = ""
    is_advanced: bool = False
    is_audited: bool = False
    heading: str = ""
    applies: Callable[[Any], bool] | None = None

    @property
    def group(self) -> str:
        """Heading under which it is shown."""
        return self.heading or self.stage.group

    @property
    def label_with_unit(self) -> str:
        """Label of its widget, such as "Late after (s)"."""
        is_symbol = self.unit in ("px", "m", "s")
        return f"{self.label} ({self.unit})" if is_symbol else self.label

    @property
    def acts_on(self) -> str:
        """Results that it changes, in words, such as "similarity, low similarity"."""
        return ", ".join(stage.result for stage in shown_results() if self.moves([stage]))

    def moves(self, stages: Iterable[Stage]) -> bool:
        """Whether the result of any of these stages depends on it."""
        before: frozenset[Stage] = frozenset().union(*(stage.before for stage in stages))
        return (MATCH if self.stage is THRESHOLD else self.stage) in before

    @property
    def range_text(self) -> str:
        """Possible values: "0 to 1", "more than 0 to 10", "any", or the choices."""
        if self.words is not None:
            return ", ".join(self.words)
        if math.isinf(self.high):
            return "any"
        return f"{'more than ' if self.is_above_low else ''}{self.low:g} to {self.high:g}"

    def check(self, name: str, value: object) -> None:
        """Refuse an invalid value.

        Raises
        ------
        ParameterError
            If the value is invalid, with the name and the possible values.
        """
        if self.words is not None:
            if value not in tuple(self.words):
                raise ParameterError(f"{name}: expected one of {self.range_text}, got {value!r}")
            return
        if value is None and self.default is None:
            return
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value):
            raise ParameterError(f"{name}: expected a number, got {value!r}")
        if not self.low <= value <= self.high or (self.is_above_low and value == self.low):
            raise ParameterError(f"{name}: expected {self.range_text}, got {value:g}")
        if self.is_whole and not float(value).is_integer():
            raise ParameterError(f"{name}: expected a whole number, got {value:g}")


class SubjectSettings:
    """Base of the classes of settings that subjects add to `Params`."""

    def check_together(self) -> None:
        """Refuse values that contradict each other, by a ParameterError."""


def setting(stage: Stage, default: float | str | None, **known: Any) -> Any:
    """Create a field of `Params`. `known` has further fields of `Setting`."""
    return field(default=default, metadata={"setting": Setting(stage, default, **known)})


def share(stage: Stage, default: float | None, *, step: float = 0.05, **known: Any) -> Any:
    """Create a field of `Params` from 0 to 1. `known` has further fields of `Setting`."""
    return setting(stage, default, low=0, high=1, step=step, **known)
