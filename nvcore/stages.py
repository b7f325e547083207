"""What is known of a setting, and the stages of the comparison that settings belong to."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from itertools import chain
from typing import Any, Final

from nvcore.errors import ParameterError
from nvcore.subjects import contributed


@dataclass(frozen=True, eq=False)
class Stage:
    """A step of the comparison that reads settings.

    Attributes
    ----------
    name
        What it makes.
    group
        Heading under which its settings are shown.
    after
        The stages that it starts from: their settings move its result, too.
    result
        What a reader calls what it makes; empty where nobody sees that by itself.
    """

    name: str
    group: str
    after: tuple[Stage, ...] = ()
    result: str = ""

    @cached_property
    def before(self) -> frozenset[Stage]:
        """The stage itself and all that come before it."""
        return frozenset({self}.union(*(stage.before for stage in self.after)))


THRESHOLD: Final = Stage("detections that count", "Thresholds and matching")
"""Not before `MATCH`: each system has its own, so the results of a system depend on one of them."""
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
    """The stages whose results are shown, in the order in which they are named."""
    own = (MATCH, SIMILARITY, LOW, ENCOUNTERS, SEVERITY, SALIENCY)
    return (*own, *chain(*contributed("results")))


AUDITED: Final = (THRESHOLD, MATCH, PROXIMITY)
"""Stages on whose settings findings of the audit depend."""


@dataclass(frozen=True, eq=False)
class Setting:
    """A live setting: what command line, sidebar, reports and docs say of it.

    Attributes
    ----------
    stage
        The first step of the comparison that it changes.
    default
        None: taken from the data, or not applied.
    label
        What a widget calls it, without a unit that `label_with_unit` adds. This and the next two
        are templates with words of the objects (`nvcore.wording.objects`).
    meaning
        In whole sentences, for help texts.
    words
        Of a choice: what a person reads, by value; None: a number.
    low, high, step, unit
        Of a number.
    is_above_low
        Whether the lower end is outside the range.
    is_whole
        Whether it is a whole number.
    slider_high
        Where its slider ends, if the whole range is more than anyone needs.
    slider_format
        How its slider shows the value, if not as a number.
    height_share
        The default as a share of the picture's height.
    used_with
        Another setting, and the values of that with which it is used; None: always used.
    unset
        What holds without a value, for the switch above its slider; empty: no switch.
    is_advanced
        Whether it is rarely moved: its widget is folded away.
    is_audited
        Whether findings of the audit depend on it, though its stage is none of `AUDITED`.
    heading
        The heading under which it is shown, where that is not its stage's.
    applies
        Whether a dataset has what the setting acts on; None: all have.
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
        """The heading under which it is shown."""
        return self.heading or self.stage.group

    @property
    def label_with_unit(self) -> str:
        """What a widget calls it: "Late after (s)"."""
        is_symbol = self.unit in ("px", "m", "s")
        return f"{self.label} ({self.unit})" if is_symbol else self.label

    @property
    def acts_on(self) -> str:
        """The results that it moves, in words: "similarity, low similarity"."""
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
        """Refuse an impossible value.

        Raises
        ------
        ParameterError
            With the name and the possible values.
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


def setting(stage: Stage, default: float | str | None, **known: Any) -> Any:
    """A field of `Params`; `known` as of `Setting`."""
    return field(default=default, metadata={"setting": Setting(stage, default, **known)})


def share(stage: Stage, default: float | None, *, step: float = 0.05, **known: Any) -> Any:
    """A field of `Params` from 0 to 1; `known` as of `Setting`."""
    return setting(stage, default, low=0, high=1, step=step, **known)
