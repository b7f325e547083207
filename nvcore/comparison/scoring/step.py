"""Steps of a comparison, and the reuse of their results."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any, Literal

import numpy as np

from nvcore.common.subject import subjects
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.encounters import Encounters
from nvcore.metrics.linking import TruthTracks
from nvcore.settings.params import Params
from nvcore.settings.stages import Stage


@dataclass(frozen=True, eq=False)
class Inputs:
    """Inputs that every step may use.

    Attributes
    ----------
    dataset, params
        Dataset and settings of the comparison.
    tracks
        Tracks of the truth, and the recordings in which linking created them.
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
    """Inputs for the steps of one system, including its name and threshold."""

    name: str
    threshold: float | None

    @property
    def detections(self) -> BoxColumns:
        """Boxes of the system, including those below the threshold."""
        return self.dataset.system(self.name)


@dataclass(frozen=True, eq=False)
class ScoringStep:
    """Step of a comparison.

    Attributes
    ----------
    name
        Name of its result.
    make
        Function that computes the result from the inputs and the results of `needs`, in that order.
    settings
        Stages whose settings change the result. With equal settings, the result of an earlier
        comparison is reused.
    needs
        Names of the steps it depends on. A ``both`` step gets the results of ``system`` steps as
        (x, y).
    of
        ``truth``: the same for all systems, computed from `Inputs`; ``system``: computed for X and
        for Y from `SystemInputs`; ``both``: computed from X and Y together.
    """

    name: str
    make: Callable[..., Any]
    settings: tuple[Stage, ...] = ()
    needs: tuple[str, ...] = ()
    of: Literal["truth", "system", "both"] = "system"


class Memo:
    """Cache of step results by the settings they depend on.

    A new setting only repeats the steps that it changes.
    """

    def __init__(self, params: Params, previous: Mapping[tuple[Any, ...], Any]):
        self._params = params
        self._previous = previous
        self.used: dict[tuple[Any, ...], Any] = {}

    def get(self, key: tuple[Any, ...], make: Callable[[], Any], settings: Sequence[Stage]) -> Any:
        """Return the previous result if no setting of its stages has changed, else a new one."""
        key = (*key, *self._params.values_for(*settings))
        value = self._previous[key] if key in self._previous else make()
        self.used[key] = value
        return value


class Made(Mapping[str, Any]):
    """Results of steps by name, each computed on first access.

    Parameters
    ----------
    owner
        Key of the system and its threshold, or of both systems; empty for the truth.
    before
        Lookup for results of steps that are not in `steps`.
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
    """Return the core's own steps of a kind, followed by those of subjects."""
    every = chain(own, *(subject.scores().steps for subject in subjects()))
    return tuple(step for step in every if step.of == kind)


@dataclass(frozen=True)
class MissWeights:
    """Factor by which a subject multiplies the weight of missing each pedestrian.

    Attributes
    ----------
    label
        The factor as written in a formula: ``(1 - detectability)``.
    weigh
        Function that returns the factors, float64, shape (n_truth,), 0 to 1; None: 1 for all boxes.
    """

    label: str
    weigh: Callable[[Dataset, Params], np.ndarray | None]


def miss_factors(dataset: Dataset, params: Params) -> dict[str, np.ndarray]:
    """Return the subjects' factors for the weight of missing each pedestrian.

    The keys are `MissWeights.label`.
    """
    every = chain(*(subject.scores().miss_weights for subject in subjects()))
    factors = {of.label: of.weigh(dataset, params) for of in every}
    return {label: weights for label, weights in factors.items() if weights is not None}


def weigh_misses(k: np.ndarray, dataset: Dataset, params: Params, *, rows: Any = ...) -> np.ndarray:
    """Weigh the miss of each pedestrian for similarity, saliency and severity, 0 to 1.

    The weight is ``k`` times the `miss_factors` of subjects. Only ``k`` decides which frames count
    (``k >= 0.5``).

    Parameters
    ----------
    k
        Proximity weight of each truth box; float64, shape (n,).
    rows
        Truth rows of these boxes, by default all.

    Returns
    -------
    float64, shape (n,).
    """
    for weights in miss_factors(dataset, params).values():
        k = k * weights[rows]
    return k
