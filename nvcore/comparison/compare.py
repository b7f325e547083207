"""The library's central function, ``compare(dataset, params) -> Result``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final, TypeVar

import numpy as np

from nvcore.common.errors import InputError
from nvcore.common.palette import Scheme, Shade, scheme_for
from nvcore.common.subject import subjects
from nvcore.comparison.scoring import (
    Inputs,
    Made,
    Memo,
    ScoringStep,
    SystemInputs,
    SystemResult,
    score_system,
    steps_of,
    weigh_misses,
)
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import Category, DetectionState
from nvcore.metrics.encounters import Encounters, encounters_of, mostly_one_frame
from nvcore.metrics.fusion import fuse
from nvcore.metrics.linking import TruthTracks
from nvcore.metrics.matching import count_per_frame
from nvcore.metrics.proximity import Weights, in_use, weigh_proximity
from nvcore.metrics.proximity.borrowing import Borrowed, borrowed_distances, borrows, weighing_truth
from nvcore.metrics.saliency import saliency_by_recording
from nvcore.metrics.severity import cost_of_miss
from nvcore.metrics.venn import (
    MIN_DISCORDANT,
    BoxVenn,
    Exclusivity,
    Venn,
    categorise,
    count_boxes,
    count_categories,
    measure_exclusivity,
)
from nvcore.settings.objects import Objects
from nvcore.settings.params import Params
from nvcore.settings.stages import COST, ENCOUNTERS, MATCH, MISS_WEIGHTS, PROXIMITY

T = TypeVar("T")
LEAST_FOR_THREADS: Final = 5_000
"""Minimum number of boxes for scoring in threads. Below it, starting threads takes longer."""


TRUTH_STEPS: Final[tuple[ScoringStep, ...]] = (
    ScoringStep("n_truth", lambda at: count_per_frame(at.truth, ~at.truth.ignore), of="truth"),
    ScoringStep(
        "k_truth",
        lambda at: weigh_proximity(
            weighing_truth(at.dataset, at.params), ~at.truth.ignore, at.frames, at.params
        ),
        (PROXIMITY,),
        of="truth",
    ),
    ScoringStep(
        "k_miss",
        lambda at, k_truth: weigh_misses(k_truth.k, at.dataset, at.params),
        (MISS_WEIGHTS,),
        ("k_truth",),
        of="truth",
    ),
    ScoringStep(
        "cost",
        lambda at, k_miss: cost_of_miss(
            at.truth, k_miss, at.frames, in_use(at.params, "edge_weight", at.frames)
        ),
        (COST,),
        ("k_miss",),
        of="truth",
    ),
)
BOTH_STEPS: Final[tuple[ScoringStep, ...]] = (
    ScoringStep(
        "category",
        lambda _, outcomes: categorise(
            outcomes[0]["n_relevant"].to_numpy() == 0,
            *(table["is_detected"].to_numpy() for table in outcomes),
        ),
        (ENCOUNTERS,),
        ("encounters",),
        of="both",
    ),
    ScoringStep(
        "venn", lambda _, category: count_categories(category), (ENCOUNTERS,), ("category",), "both"
    ),
    ScoringStep(
        "exclusivity", lambda _, venn: measure_exclusivity(venn), (ENCOUNTERS,), ("venn",), "both"
    ),
    ScoringStep(
        "boxes",
        lambda at, matches: count_boxes(~at.truth.ignore, *(of.is_matched for of in matches)),
        (MATCH,),
        ("matches",),
        of="both",
    ),
)
"""Steps of the core. `nvcore.comparison.scoring` has those of subjects and of each system."""


@dataclass(frozen=True, eq=False)
class Result:
    """Comparison of two systems. `nvcore.tables.result` makes tables of it.

    Attributes
    ----------
    dataset, params
        Data and settings of the comparison.
    x, y
        The two systems.
    tracks
        Tracks of the truth, and which ones were linked.
    encounters
        The encounters of the ground truth.
    k_truth
        Proximity weight of every truth box.
    k_miss
        Weight of missing each truth box: its proximity weight, adjusted by subjects
        (`nvcore.comparison.scoring.weigh_misses`).
    cost
        Cost of missing each truth box (`nvcore.metrics.severity.cost_of_miss`).
    category
        Venn category of every encounter; object, shape (n_encounters,).
    venn, exclusivity, boxes
        Counts of encounters, exclusivity of the misses, counts of boxes.
    duration_s
        Recording time of all recordings.
    made
        Results of the steps on the truth and on both systems, including those of subjects, by the
        step's name. Results of the steps on one system are in `SystemResult.made`.
    stages
        Stages that `compare` can reuse if only some settings change.
    as_set
        The comparison as X and Y are set if this is its replacement at equal false alarms
        (`nvcore.evidence.operating_points.find_equal_alarms`), else None.
    """

    dataset: Dataset
    params: Params
    x: SystemResult
    y: SystemResult
    tracks: TruthTracks
    encounters: Encounters
    k_truth: Weights
    k_miss: np.ndarray
    cost: np.ndarray
    n_truth: np.ndarray
    category: np.ndarray
    venn: Venn
    exclusivity: Exclusivity
    boxes: BoxVenn
    duration_s: float
    made: Mapping[str, Any] = field(repr=False)
    stages: Mapping[tuple[Any, ...], Any] = field(repr=False)
    as_set: Result | None = field(default=None, repr=False)
    _kept: dict[str, Any] = field(init=False, repr=False, default_factory=dict)

    def of(self, subject: str) -> Any:
        """Return a subject's view of the comparison, such as ``result.of("time_left")``.

        Its type is the subject's `view`. Each subject has a typed function for this call.
        """
        known = {of.name: of for of in subjects()}[subject]
        return self.keep(subject, lambda: known.scores().view(self))

    def keep(self, name: str, make: Callable[[], T]) -> T:
        """Return a value that depends only on this comparison, computing it on the first call."""
        if name not in self._kept:
            self._kept[name] = make()
        value: T = self._kept[name]
        return value

    def forget(self) -> None:
        """Drop the values cached by `keep`. They may hold references to this comparison."""
        self._kept.clear()

    @property
    def sides(self) -> tuple[tuple[str, SystemResult], tuple[str, SystemResult]]:
        """Systems X and Y, each after the letter that ends the names of its columns."""
        return ("x", self.x), ("y", self.y)

    @property
    def names(self) -> tuple[str, str]:
        """Names of X and Y."""
        return self.x.name, self.y.name

    def system(self, letter: str) -> SystemResult:
        """Return system ``x`` or ``y``."""
        return dict(self.sides)[letter]

    @property
    def objects(self) -> Objects:
        """Kind of objects that the boxes show."""
        return self.dataset.objects

    def scheme(self, shade: Shade) -> Scheme:
        """Return colours and line styles of the session's systems for a light or dark page."""
        return scheme_for(shade, self.dataset.systems, self.x.name, self.y.name)

    @property
    def is_near(self) -> np.ndarray:
        """Encounters that count because they are not distant, bool, shape (n_encounters,)."""
        is_near: np.ndarray = self.category != Category.DISTANT.value
        return is_near

    @property
    def is_short(self) -> bool:
        """True if most of the encounters that count last a single frame."""
        return mostly_one_frame(self.encounters.n_frames[self.is_near])

    @property
    def mcnemar_p(self) -> float:
        """Exact McNemar p-value for the difference in detected encounters, within these drives.

        NaN if it is withheld: most encounters are one frame long, or fewer than
        `nvcore.metrics.venn.MIN_DISCORDANT` are discordant.
        """
        n_split = self.venn.x_only + self.venn.y_only
        is_withheld = self.is_short or n_split < MIN_DISCORDANT
        return np.nan if is_withheld else self.exclusivity.mcnemar_p

    @property
    def borrowed(self) -> Borrowed | None:
        """Distances that pedestrians without one take from their matches, or None if disabled."""
        return borrowed_distances(self.dataset) if borrows(self.params) else None

    @property
    def weighed_truth(self) -> BoxColumns:
        """Truth boxes with the distances used for their weights, including borrowed ones."""
        return weighing_truth(self.dataset, self.params)

    def saliency_of_recordings(self, system: SystemResult) -> np.ndarray:
        """Return each recording's saliency, s, 0 is best, float64, shape (n_recordings,)."""
        return saliency_by_recording(
            system.events, len(self.dataset.recordings), aggregate=self.params.saliency_aggregate
        )

    @property
    def lead_time_s(self) -> np.ndarray:
        """Time by which X matches each encounter before Y, seconds. NaN unless both match."""
        lead: np.ndarray = (self.y.encounters["lag_s"] - self.x.encounters["lag_s"]).to_numpy()
        return lead

    def severity_of(self, system: SystemResult) -> dict[Category, float]:
        """Sum the severity of a system's failures in each Venn category, seconds, 0 is best."""
        severity_s = system.failures["severity_s"].to_numpy()
        return {kind: float(severity_s[self.category == kind.value].sum()) for kind in Category}

    @cached_property
    def fusion(self) -> Result:
        """Comparison of two fused systems: `x` is ``X or Y``, `y` is ``X and Y``."""
        fused = fuse(
            self.dataset,
            self.x.name,
            self.y.name,
            self.x.matches.state != DetectionState.BELOW,
            self.y.matches.state != DetectionState.BELOW,
            iou=self.params.iou,
        )
        return compare(fused, replace(self.params, threshold_x=None, threshold_y=None))


def compare(
    dataset: Dataset,
    params: Params | None = None,
    *,
    x: str | None = None,
    y: str | None = None,
    previous: Result | None = None,
    stages: Mapping[tuple[Any, ...], Any] | None = None,
) -> Result:
    """Compare two systems of a dataset.

    Parameters
    ----------
    dataset
        Recordings, ground truth, systems.
    params
        Settings. None: those of the dataset, with the thresholds of its systems.
    x, y
        Names of the systems. None: those of the dataset, else its first system that is not the
        other one.
    previous
        A result of the same dataset, possibly with other names. Stages with the same settings are
        reused, so that changing alpha or the sigmoid costs little. No number depends on it.
    stages
        Results of steps computed elsewhere on these data, by the key in `Result.stages`.

    Raises
    ------
    InputError
        If there are fewer than two systems, or none of a given name.
    ParameterError
        If proximity by horizon lacks the horizon.

    Examples
    --------
    >>> result = compare(dataset, Params(alpha=0.8))  # doctest: +SKIP
    >>> result.venn.dominant  # doctest: +SKIP
    """
    names = _pick(dataset, x, y)
    params = dataset.params_of(*names) if params is None else params
    is_same = previous is not None and _same_numbers(previous.dataset, dataset)
    known = previous.stages if previous is not None and is_same else {}
    memo = Memo(params, {**known, **(stages or {})})
    tracks, encounters = encounters_of(dataset)
    at = Inputs(dataset, params, tracks, encounters)
    truth = Made(steps_of("truth", TRUTH_STEPS), at, memo)
    made = dict(truth)  # compute it now, as X and Y need it at the same time
    # by number, since a renamed system is still the same
    owners = [
        (dataset.systems.index(name), threshold)
        for name, threshold in zip(names, (params.threshold_x, params.threshold_y), strict=True)
    ]

    def score(name: str, owner: tuple[int, float | None]) -> SystemResult:
        inputs = SystemInputs(dataset, params, tracks, encounters, name, owner[1])
        return score_system(inputs, truth, memo, owner)

    if len(dataset.boxes) < LEAST_FOR_THREADS:
        result_x, result_y = map(score, names, owners)
    else:  # numpy and the kernels release the lock: the two systems run side by side
        with ThreadPoolExecutor(2) as pool:
            result_x, result_y = pool.map(score, names, owners)

    def of_systems(name: str) -> Any:
        return made[name] if name in made else (result_x.made[name], result_y.made[name])

    both = dict(
        Made(steps_of("both", BOTH_STEPS), at, memo, owner=tuple(owners), before=of_systems)
    )
    return Result(
        dataset=dataset,
        params=params,
        x=result_x,
        y=result_y,
        tracks=tracks,
        encounters=encounters,
        duration_s=dataset.frame_columns.duration_s,
        **{step.name: made[step.name] for step in TRUTH_STEPS},
        **{step.name: both[step.name] for step in BOTH_STEPS},
        made=made | both,
        stages=memo.used,
    )


def _same_numbers(a: Dataset, b: Dataset) -> bool:
    """Return whether two datasets give equal results. Names, tags and settings may differ."""
    if a is b:
        return True
    columns = ["width", "height", "fps", "horizon", "context", "speed_kmh"]
    is_same_table = a.frames is b.frames and a.boxes is b.boxes
    is_same_table &= a.objects == b.objects
    return is_same_table and a.recordings[columns].equals(b.recordings[columns])


def _pick(dataset: Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    x, y = dataset.compared(x, y)
    if x is None or y is None:
        raise InputError(
            f"a comparison needs two systems; there is {len(dataset.systems)} "
            f"({', '.join(dataset.systems) or 'none'}): give a second one"
        )
    for name in (x, y):
        dataset.system(name)
    return x, y
