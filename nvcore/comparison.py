"""The call that everything else is built on: ``compare(dataset, params) -> Result``."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.metrics.driver import DriverView, judge_driver, weigh_unseen
from nvcore.metrics.encounters import Encounters, encounters_of, mostly_one_frame
from nvcore.metrics.fusion import fuse
from nvcore.metrics.linking import TruthTracks
from nvcore.metrics.matching import count_per_frame
from nvcore.metrics.proximity import Weights, in_use, weigh_proximity
from nvcore.metrics.proximity.borrowing import (
    Borrowed,
    borrowed_distances,
    borrows,
    weighing_truth,
)
from nvcore.metrics.saliency import saliency_by_recording
from nvcore.metrics.severity import cost_of_miss
from nvcore.metrics.time_left import Contact, curve_over_speed, find_urgent, measure_contact
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
from nvcore.objects import Objects
from nvcore.palette import Scheme, Shade, scheme_for
from nvcore.params import Params
from nvcore.params.metadata import (
    CONTACT,
    COST,
    DRIVER,
    ENCOUNTERS,
    MATCH,
    PROXIMITY,
    UNSEEN,
    URGENCY,
)
from nvcore.schema import Category, DetectionState, Urgency
from nvcore.scoring import Memo, SystemResult, score_system

LEAST_FOR_THREADS: Final = 5_000
"""With fewer boxes, starting threads takes longer than scoring the systems one after the other."""


@dataclass(frozen=True, eq=False)
class Result:
    """Comparison of two systems. `nvcore.tables.result` makes tables of it.

    Attributes
    ----------
    dataset, params
        What was compared, and how.
    x, y
        The two systems.
    tracks
        Tracks of the truth, and where linking made them.
    encounters
        The encounters of the ground truth.
    k_truth
        Proximity weight of every truth box.
    k_miss
        What missing each truth box weighs: its proximity weight, less where the driver sees it by
        himself if `driver_weighting` says so (`nvcore.metrics.driver.weigh_unseen`).
    cost
        What missing each truth box would cost (`nvcore.metrics.severity.cost_of_miss`).
    contact
        Time to contact of every truth box (`nvcore.metrics.time_left.measure_contact`).
    urgency
        Whether and when each encounter becomes urgent (`nvcore.metrics.time_left.find_urgent`).
    detectable
        How detectable each encounter is to the driver (`nvcore.metrics.driver.judge_driver`).
    category
        Venn category of every encounter; object, shape (n_encounters,).
    venn, exclusivity, boxes
        Counts of encounters, how exclusive the misses are, counts of boxes.
    duration_s
        Recording time of all recordings.
    stages
        What `compare` can reuse when only some settings change.
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
    contact: Contact
    urgency: pd.DataFrame
    detectable: pd.DataFrame
    n_truth: np.ndarray
    category: np.ndarray
    venn: Venn
    exclusivity: Exclusivity
    boxes: BoxVenn
    duration_s: float
    stages: Mapping[tuple[Any, ...], Any] = field(repr=False)

    @property
    def sides(self) -> tuple[tuple[str, SystemResult], tuple[str, SystemResult]]:
        """The two systems, each with the letter that ends its columns' names."""
        return ("x", self.x), ("y", self.y)

    def system(self, letter: str) -> SystemResult:
        """System ``x`` or ``y``."""
        return dict(self.sides)[letter]

    @property
    def objects(self) -> Objects:
        """What the boxes are of."""
        return self.dataset.objects

    def scheme(self, shade: Shade) -> Scheme:
        """Colours and lines for a light or dark page: each system of the session has its own."""
        return scheme_for(shade, self.dataset.systems, self.x.name, self.y.name)

    @property
    def is_short(self) -> bool:
        """Whether most encounters that count are a single frame long."""
        is_near = self.category != Category.DISTANT.value
        return mostly_one_frame(self.encounters.n_frames[is_near])

    @property
    def mcnemar_p(self) -> float:
        """Exact McNemar p of the encounters that one system detects, within these drives.

        NaN where it is withheld: most encounters are one frame long, or fewer than
        `nvcore.metrics.venn.MIN_DISCORDANT` tell the systems apart.
        """
        n_split = self.venn.x_only + self.venn.y_only
        is_withheld = self.is_short or n_split < MIN_DISCORDANT
        return np.nan if is_withheld else self.exclusivity.mcnemar_p

    @property
    def borrowed(self) -> Borrowed | None:
        """Distances that pedestrians borrowed from their matches; None: not set so."""
        return borrowed_distances(self.dataset) if borrows(self.params) else None

    @property
    def weighed_truth(self) -> BoxColumns:
        """The truth, with the distances that its weights are of (borrowed ones, if set so)."""
        return weighing_truth(self.dataset, self.params)

    def saliency_of_recordings(self, system: SystemResult) -> np.ndarray:
        """Saliency of every recording by itself, s, 0 is best; float64, shape (n_recordings,)."""
        return saliency_by_recording(
            system.events,
            len(self.dataset.recordings),
            aggregate=self.params.saliency_aggregate,
        )

    @property
    def lead_time_s(self) -> np.ndarray:
        """Lead of X over Y per encounter, lag(Y) - lag(X), seconds; NaN unless both match."""
        lead: np.ndarray = (self.y.encounters["lag_s"] - self.x.encounters["lag_s"]).to_numpy()
        return lead

    def severity_of(self, system: SystemResult) -> dict[Category, float]:
        """What a system's failures weigh in the encounters of each category, seconds, 0 is best."""
        severity_s = system.failures["severity_s"].to_numpy()
        return {kind: float(severity_s[self.category == kind.value].sum()) for kind in Category}

    @cached_property
    def is_urgent(self) -> np.ndarray:
        """Encounters in which the driver had to be told in time; bool, shape (n_encounters,)."""
        urgent: np.ndarray = self.urgency["urgency"].to_numpy() == Urgency.URGENT.value
        return urgent

    def count_urgency(self) -> dict[Urgency, int]:
        """Encounters of each urgency."""
        return {kind: int((self.urgency["urgency"] == kind.value).sum()) for kind in Urgency}

    @cached_property
    def driver(self) -> DriverView:
        """Whom the driver sees by himself, beside X and Y."""
        is_near = self.category != Category.DISTANT.value
        detected = (system.encounters["is_detected"].to_numpy() for _, system in self.sides)
        return DriverView(self.detectable, is_near, *detected)

    @property
    def has_assumed_speed(self) -> np.ndarray:
        """Recordings that do not state the car's speed; bool, shape (n_recordings,)."""
        is_assumed: np.ndarray = np.isnan(self.dataset.frame_columns.speed_kmh)
        return is_assumed

    @property
    def assumed_speed_kmh(self) -> float | None:
        """The speed that all recordings are assumed to have; None: some state their own."""
        return float(self.params.speed_kmh) if self.has_assumed_speed.all() else None

    @cached_property
    def over_speed(self) -> pd.DataFrame:
        """Time left of both over the car's speed (`nvcore.metrics.time_left.curve_over_speed`)."""
        return curve_over_speed(
            *(self.contact, self.dataset.truth, self.encounters),
            [system.confirmed for _, system in self.sides],
            *(self.dataset.frame_columns, self.params),
        )

    @cached_property
    def fusion(self) -> Result:
        """The fused systems: ``X or Y`` as `x`, ``X and Y`` as `y`."""
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
) -> Result:
    """Compare two systems of a dataset.

    Parameters
    ----------
    dataset
        Recordings, ground truth, systems.
    params
        Settings; None: those that the dataset carries, with the thresholds of its systems.
    x, y
        Names of the systems; None: those that the dataset carries, else its first that is not the
        other one.
    previous
        A result of the same dataset, or of it with other names: stages whose settings are the same
        are taken from it, so that changing alpha or the sigmoid costs little. No number depends on
        it.

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
    previous_stages = previous.stages if previous is not None and is_same else {}
    memo = Memo(params, previous_stages)
    truth, frames = dataset.truth, dataset.frame_columns
    tracks, encounters = encounters_of(dataset)
    n_truth = memo.get("n_truth", lambda: count_per_frame(truth, ~truth.ignore))
    k_truth = memo.get(
        "k_truth",
        lambda: weigh_proximity(weighing_truth(dataset, params), ~truth.ignore, frames, params),
        PROXIMITY,
    )
    k_miss = memo.get(
        "k_miss", lambda: weigh_unseen(k_truth.k, dataset.detectability, params), UNSEEN
    )
    cost = memo.get(
        "cost",
        lambda: cost_of_miss(truth, k_miss, frames, in_use(params, "edge_weight", frames)),
        COST,
    )
    detectable = memo.get(
        "detectable",
        lambda: judge_driver(dataset.detectability, encounters, k_truth.k, params),
        DRIVER,
    )
    contact = memo.get(
        "contact",
        lambda: measure_contact(
            *(truth, encounters, frames),
            ttc_window=params.ttc_window,
            is_on_road=dataset.objects.is_on_road,
        ),
        CONTACT,
    )
    urgency = memo.get(
        "urgency", lambda: find_urgent(contact, truth, encounters, frames, params), URGENCY
    )
    shared = (dataset, params, tracks, encounters, k_truth, k_miss, cost, contact, urgency)
    pairs = list(zip(names, (params.threshold_x, params.threshold_y), strict=True))

    def score(pair: tuple[str, float | None]) -> SystemResult:
        name, threshold = pair
        return score_system(name, threshold, *shared, memo)

    if len(dataset.boxes) < LEAST_FOR_THREADS:
        result_x, result_y = map(score, pairs)
    else:  # numpy and the kernels release the lock: the two systems run side by side
        with ThreadPoolExecutor(2) as pool:
            result_x, result_y = pool.map(score, pairs)
    # by number: a system that is called otherwise is still the same
    numbered = [(dataset.systems.index(name), threshold) for name, threshold in pairs]
    category = memo.get(
        ("category", *numbered),
        lambda: categorise(
            result_x.encounters["n_relevant"].to_numpy() == 0,
            result_x.encounters["is_detected"].to_numpy(),
            result_y.encounters["is_detected"].to_numpy(),
        ),
        ENCOUNTERS,
    )
    venn = memo.get(("venn", *numbered), lambda: count_categories(category), ENCOUNTERS)
    boxes = memo.get(
        ("boxes", *numbered),
        lambda: count_boxes(
            ~truth.ignore, result_x.matches.is_matched, result_y.matches.is_matched
        ),
        MATCH,
    )
    return Result(
        dataset=dataset,
        params=params,
        x=result_x,
        y=result_y,
        tracks=tracks,
        encounters=encounters,
        k_truth=k_truth,
        k_miss=k_miss,
        cost=cost,
        contact=contact,
        urgency=urgency,
        detectable=detectable,
        n_truth=n_truth,
        category=category,
        venn=venn,
        exclusivity=measure_exclusivity(venn),
        boxes=boxes,
        duration_s=frames.duration_s,
        stages=memo.used,
    )


def _same_numbers(a: Dataset, b: Dataset) -> bool:
    """Whether two datasets differ in names, tags or settings at most."""
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
