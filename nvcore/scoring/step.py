"""Steps of a comparison: what each makes of the inputs and of other steps, kept where it can be."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Literal

import numpy as np

from nvcore.columns import BoxColumns, FrameColumns
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import Encounters
from nvcore.metrics.linking import TruthTracks
from nvcore.params import Params
from nvcore.stages import Stage
from nvcore.subjects import contributed


@dataclass(frozen=True, eq=False)
class Inputs:
    """What every step may use.

    Attributes
    ----------
    dataset, params
        What is compared, and how.
    tracks
        Tracks of the truth, and where linking made them.
    encounters
        The encounters of the truth.
    """

    dataset: Dataset
    params: Params
    tracks: TruthTracks
    encounters: Encounters

    @property
    def truth(self) -> BoxColumns:
        """Boxes of the truth."""
        return self.dataset.truth

    @property
    def frames(self) -> FrameColumns:
        """All frames."""
        return self.dataset.frame_columns


@dataclass(frozen=True, eq=False)
class SystemInputs(Inputs):
    """What the steps of one system may use: the system and its threshold, too."""

    name: str
    threshold: float | None

    @property
    def detections(self) -> BoxColumns:
        """Boxes of the system, those below the threshold as well."""
        return self.dataset.system(self.name)


@dataclass(frozen=True, eq=False)
class ScoringStep:
    """One step.

    Attributes
    ----------
    name
        Name of its result.
    make
        Its result from the inputs and the results that it `needs`, in their order.
    settings
        The stages whose settings its result depends on; with the same settings the result of an
        earlier comparison is taken.
    needs
        Names of other steps. A step of both systems may need those of each system: as (x, y).
    of
        ``truth``: the same for all systems, made of `Inputs`; ``system``: made for X and for Y, of
        `SystemInputs`; ``both``: made of X and Y together.
    """

    name: str
    make: Callable[..., Any]
    settings: tuple[Stage, ...] = ()
    needs: tuple[str, ...] = ()
    of: Literal["truth", "system", "both"] = "system"


class Memo:
    """Results of steps by what they depend on: a new setting repeats only what it changes."""

    def __init__(self, params: Params, previous: Mapping[tuple[Any, ...], Any]):
        self._params = params
        self._previous = previous
        self.used: dict[tuple[Any, ...], Any] = {}

    def get(self, key: tuple[Any, ...], make: Callable[[], Any], settings: Sequence[Stage]) -> Any:
        """The previous result if none of the settings of its stages has changed, else a new one."""
        key = (*key, *self._params.values_for(*settings))
        value = self._previous[key] if key in self._previous else make()
        self.used[key] = value
        return value


class Made(Mapping[str, Any]):
    """Results of steps by name, each made when it is first asked for.

    Parameters
    ----------
    owner
        The system and threshold that the results are about, or both of them; empty: the truth.
    before
        Finds the results of steps that are not among these.
    """

    def __init__(
        self,
        steps: Sequence[ScoringStep],
        inputs: Inputs,
        memo: Memo,
        *,
        owner: tuple[Any, ...] = (),
        before: Callable[[str], Any] | None = None,
    ):
        self._steps = {step.name: step for step in steps}
        self._inputs, self._memo, self._owner, self._before = inputs, memo, owner, before
        self._values: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name in self._values:
            return self._values[name]
        if name not in self._steps:
            if self._before is None:
                raise KeyError(name)
            return self._before(name)
        step = self._steps[name]
        self._values[name] = self._memo.get(
            (name, *self._owner),
            lambda: step.make(self._inputs, *(self[need] for need in step.needs)),
            step.settings,
        )
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._steps)

    def __len__(self) -> int:
        return len(self._steps)


def steps_of(
    kind: Literal["truth", "system", "both"], own: Sequence[ScoringStep]
) -> tuple[ScoringStep, ...]:
    """The core's own steps of a kind, and then those of subjects."""
    return tuple(step for step in chain(own, *contributed("steps")) if step.of == kind)


@dataclass(frozen=True)
class MissWeights:
    """By what a subject multiplies the weight of missing each pedestrian.

    Attributes
    ----------
    label
        What that is, as a formula has it: ``(1 - detectability)``.
    weigh
        float64, shape (n_truth,), 0 to 1, by the settings; None: 1 for all of them.
    """

    label: str
    weigh: Callable[[Dataset, Params], np.ndarray | None]


def miss_factors(dataset: Dataset, params: Params) -> dict[str, np.ndarray]:
    """By what subjects multiply the weight of missing each pedestrian, by `MissWeights.label`."""
    factors = {of.label: of.weigh(dataset, params) for of in contributed("miss_weights")}
    return {label: weights for label, weights in factors.items() if weights is not None}


def weigh_misses(k: np.ndarray, dataset: Dataset, params: Params, *, rows: Any = ...) -> np.ndarray:
    """What missing each pedestrian weighs in similarity, saliency and severity, 0 to 1.

    ``k``, times the `miss_factors` of subjects. Which frames count (``k >= 0.5``) goes by ``k``
    alone.

    Parameters
    ----------
    k
        Proximity weight of each truth box; float64, shape (n,).
    rows
        Which boxes of the truth these are; all of them unless it is given.

    Returns
    -------
    float64, shape (n,).
    """
    for weights in miss_factors(dataset, params).values():
        k = k * weights[rows]
    return k
