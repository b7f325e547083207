"""The settings that a stability map moves: their values, and which of them are plausible."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, get_args

import numpy as np

from nvcore.analysis import Result
from nvcore.errors import InputError, ParameterError
from nvcore.operating_point import false_alarm_curve
from nvcore.params import MIDPOINT_SHARE, Match

Plane = Literal["alpha-midpoint", "thresholds", "matching", "edge-weight", "edge-weight-alpha"]

ALPHA_PLAUSIBLE: Final = (0.5, 1.0)
"""A warning system exists for the pedestrian who is missed: a miss counts at least as much as a
false alarm."""
MIDPOINT_PLAUSIBLE: Final = (0.06, 0.15)
"""Shares of the tallest picture's height: from the preset for rural roads to that for towns."""
MIDPOINT_M_PLAUSIBLE: Final = (22.0, 56.0)
"""Metres: where a person of 1.75 m has these shares of the height, by a camera as that of the
default (focal length 720 px, picture 375 px high)."""
EDGE_WEIGHT_PLAUSIBLE: Final = (0.0, 1.0)
"""From the preset for towns to that for rural roads, which are the ends of the setting."""
IOU_PLAUSIBLE: Final = (0.3, 0.7)
"""0.5 is the pedestrian benchmarks' limit. At 0.3 a match still is the same person (the limit of
linking); above 0.7 the annotators' own boxes of small pedestrians disagree."""
ALARMS_PLAUSIBLE: Final = (0.01, 1.0)
"""False alarms per frame at thresholds that are used: the range over which pedestrian benchmarks
average the miss rate (Dollár et al. 2012)."""

ALPHA_DRAWN: Final = (0.0, 1.0)
MIDPOINT_DRAWN: Final = (0.02, 0.25)
MIDPOINT_M_DRAWN: Final = (10.0, 90.0)
IOU_DRAWN: Final = (0.1, 0.9)
"""Drawn beyond what is plausible, so that a turn just outside is seen."""

SIZE_PERCENTILES: Final = (1, 99)
"""A midpoint outside of these pedestrians' sizes weighs nearly all of them alike."""
MIN_POINTS: Final = 3
DIGITS: Final = 10
"""Digits of a value below the first of the axis' length."""
ON_GRID: Final = 1e-6
"""A value this near to a point, in shares of the distance between points, is that point."""


@dataclass(frozen=True, eq=False)
class Axis:
    """One setting of `nvcore.params.Params` and the values a map gives it.

    Attributes
    ----------
    name
        Field of `Params`.
    title, unit
        In words; the unit is empty for shares and scores.
    values
        Increasing, float64, shape (n,), read-only; positions 0, 1, ... of `labels` if there are.
    plausible
        Ends of the range that an analyst may reasonably choose from, within `values`.
    reason
        Why this range, in words.
    present
        Ends of where the analysed setting lies: equal, unless the recordings' own values differ.
    labels
        Of a choice: the values of the parameter.
    """

    name: str
    title: str
    unit: str
    values: np.ndarray
    plausible: tuple[float, float]
    reason: str
    present: tuple[float, float]
    labels: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.values)

    def setting(self, i: int) -> float | str:
        """Value of the parameter at point i."""
        return self.labels[i] if self.labels else float(self.values[i])

    def is_plausible(self, i: int) -> bool:
        """Whether point i lies in the plausible range."""
        return self.plausible[0] <= float(self.values[i]) <= self.plausible[1]

    @property
    def present_index(self) -> int | None:
        """Point at which the analysed setting lies; None if the recordings' own values differ."""
        low, high = self.present
        return int(np.argmin(np.abs(self.values - low))) if low == high else None

    @cached_property
    def weights(self) -> np.ndarray:
        """Share of the plausible range that each point stands for; float64, (n,), sums to 1.

        A point stands for what lies nearer to it than to any other.
        """
        if self.labels:
            return np.full(len(self), 1 / len(self))
        middle = (self.values[1:] + self.values[:-1]) / 2
        edges = np.concatenate([self.values[:1], middle, self.values[-1:]])
        width = np.diff(np.clip(edges, *self.plausible))
        share: np.ndarray = width / width.sum()
        return share

    @cached_property
    def distances(self) -> np.ndarray:
        """How far each point is from the analysed setting, in plausible ranges; float64, (n,).

        Another choice is a whole range away.
        """
        low, high = self.present
        if self.labels:
            return np.where(self.values == low, 0.0, 1.0)
        apart = np.maximum(np.maximum(low - self.values, self.values - high), 0)
        share: np.ndarray = apart / (self.plausible[1] - self.plausible[0])
        return share

    def text(self, i: int) -> str:
        """Point i in words, such as "alpha 0.3" or "midpoint 48 px"."""
        return f"{self.title} {self.value_text(i)}"

    def value_text(self, i: int) -> str:
        """Value of point i with its unit."""
        return self.labels[i] if self.labels else self.number_text(float(self.values[i]))

    def number_text(self, value: float) -> str:
        """A value on this axis with its unit."""
        return f"{value:.4g} {self.unit}".rstrip()


def axes_of(result: Result, plane: Plane, *, n_points: int) -> tuple[Axis, ...]:
    """The axes of a map, one or two; what these data cannot show is left out.

    Without proximity there is no midpoint, and without scores no threshold.

    Raises
    ------
    ParameterError
        If there is no such plane, or fewer than `MIN_POINTS` points are asked for.
    InputError
        If no threshold changes anything: neither system has scores that differ.
    """
    if plane not in get_args(Plane):
        raise ParameterError(f"plane: expected one of {', '.join(get_args(Plane))}, got {plane!r}")
    if n_points < MIN_POINTS:
        raise ParameterError(f"n_points: expected at least {MIN_POINTS}, got {n_points}")
    found: tuple[Axis | None, ...]
    match plane:
        case "alpha-midpoint":
            found = (_alpha(result, n_points), _midpoint(result, n_points))
        case "thresholds":
            found = (_threshold(result, "x", n_points), _threshold(result, "y", n_points))
        case "matching":
            found = (_iou(result, n_points), _match_mode(result))
        case "edge-weight":
            found = (_edge_weight(result, n_points),)
        case "edge-weight-alpha":
            found = (_edge_weight(result, n_points), _alpha(result, n_points))
    axes = tuple(axis for axis in found if axis is not None)
    if not axes:
        raise InputError(
            "neither system has scores that differ: no threshold changes anything; read "
            "detections with scores, or look at another map"
        )
    return axes


def _alpha(result: Result, n_points: int) -> Axis:
    return _numeric(
        "alpha", "alpha", "", result.params.alpha, n_points, ALPHA_PLAUSIBLE, ALPHA_DRAWN,
        "a miss counts at least as much as a false alarm",
    )  # fmt: skip


def _edge_weight(result: Result, n_points: int) -> Axis:
    return _numeric(
        "edge_weight", "edge weight", "", result.params.edge_weight, n_points,
        EDGE_WEIGHT_PLAUSIBLE, EDGE_WEIGHT_PLAUSIBLE, "from towns to rural roads",
    )  # fmt: skip


def _iou(result: Result, n_points: int) -> Axis:
    return _numeric(
        "iou", "IoU", "", result.params.iou, n_points, IOU_PLAUSIBLE, IOU_DRAWN,
        "below, a match may be someone else; above, annotators' own boxes disagree",
    )  # fmt: skip


def _match_mode(result: Result) -> Axis:
    labels = get_args(Match)
    place = float(labels.index(result.params.match))
    values = np.arange(len(labels), dtype=float)
    values.flags.writeable = False
    return Axis(
        "match", "match by", "", values, (0.0, len(labels) - 1.0), "both are in use",
        (place, place), labels,
    )  # fmt: skip


def _midpoint(result: Result, n_points: int) -> Axis | None:
    """Midpoint of the proximity sigmoid in px, or in metres if proximity is by distance."""
    params, height = result.params, result.dataset.frame_columns.height
    if params.proximity == "none" or not len(height):
        return None
    reason = "from the preset for rural roads to that for towns"
    sizes = _sizes(result)
    if params.proximity == "distance":
        return _numeric(
            "midpoint_m", "midpoint", "m", params.midpoint_m, n_points,
            *_held(MIDPOINT_M_PLAUSIBLE, MIDPOINT_M_DRAWN, sizes), reason,
        )  # fmt: skip
    default = MIDPOINT_SHARE * height
    present = (float(default.min()), float(default.max()))
    plausible, drawn = (
        (low * height.max(), high * height.max()) for low, high in
        (MIDPOINT_PLAUSIBLE, MIDPOINT_DRAWN)
    )  # fmt: skip
    return _numeric(
        "midpoint", "midpoint", "px", present if params.midpoint is None else params.midpoint,
        n_points, *_held(plausible, drawn, sizes), reason,
    )  # fmt: skip


def _sizes(result: Result) -> np.ndarray:
    """What the proximity sigmoid is over, of the pedestrians: px, or metres where known."""
    truth, frames, params = result.dataset.truth, result.dataset.frame_columns, result.params
    if params.proximity == "distance":
        size = truth.distance_m
    elif params.proximity == "horizon":
        horizon = (
            frames.horizon[frames.recording[truth.frame_index]]
            if params.horizon is None
            else params.horizon
        )
        size = truth.y + truth.h - horizon
    else:
        size = truth.h
    known: np.ndarray = size[~truth.ignore & np.isfinite(size)]
    return known


def _held(
    plausible: tuple[float, float], drawn: tuple[float, float], sizes: np.ndarray
) -> tuple[tuple[float, float], tuple[float, float]]:
    """The plausible range within the pedestrians' sizes, if that leaves any, and what is drawn."""
    if len(sizes):
        low, high = np.percentile(sizes, SIZE_PERCENTILES)
        within = (max(plausible[0], float(low)), min(plausible[1], float(high)))
        if within[0] < within[1]:
            plausible = within
    return plausible, drawn


def _threshold(result: Result, letter: Literal["x", "y"], n_points: int) -> Axis | None:
    """Score threshold of a system; None if all its scores are the same, or it has none."""
    system = getattr(result, letter)
    score = result.dataset.system(system.name).score
    score = score[np.isfinite(score)]
    low, high = (float(score.min()), float(score.max())) if len(score) else (0.0, 0.0)
    if low == high:
        return None
    # without a threshold every detection counts, as at the lowest score
    present = low if system.threshold is None else system.threshold
    if not np.isfinite(present):
        present = low if present < 0 else float(np.nextafter(high, np.inf))
    curve = false_alarm_curve(result.dataset, system.name, result.params)
    per_frame = curve["false_alarms_per_frame"].to_numpy()
    threshold = curve["threshold"].to_numpy()
    least, most = ALARMS_PLAUSIBLE
    usable = threshold[(per_frame >= least) & (per_frame <= most)]
    usable = usable[np.isfinite(usable)]
    plausible = (float(usable.min()), float(usable.max())) if len(usable) else (low, high)
    reason = f"{least:g} to {most:g} false alarms per frame, where the scores give that"
    if plausible[0] == plausible[1]:
        plausible = (low, high)
        reason = f"all scores: no range of them gives {least:g} to {most:g} false alarms per frame"
    title = f"threshold of {letter.upper()}"
    return _numeric(
        f"threshold_{letter}", title, "", present, n_points, plausible, plausible, reason
    )


def _numeric(
    name: str,
    title: str,
    unit: str,
    present: float | tuple[float, float],
    n_points: int,
    plausible: tuple[float, float],
    drawn: tuple[float, float],
    reason: str,
) -> Axis:
    """Evenly spaced values over what is drawn, plausible and present, the present one among them.

    So that the map shows the analysed setting itself, there is one point more where it lies
    between two of the even ones.
    """
    place = present if isinstance(present, tuple) else (float(present), float(present))
    low, high = min(drawn[0], plausible[0], place[0]), max(drawn[1], plausible[1], place[1])
    values = np.linspace(low, high, n_points)
    # 0.6, not 0.6000000000000001, which a score of 0.6 would not pass
    values[1:-1] = values[1:-1].round(DIGITS - int(np.floor(np.log10(high - low))))
    if place[0] == place[1]:
        nearest = int(np.argmin(np.abs(values - place[0])))
        if abs(values[nearest] - place[0]) <= ON_GRID * (high - low) / (n_points - 1):
            values[nearest] = place[0]
        else:
            values = np.sort(np.append(values, place[0]))
    values.flags.writeable = False
    return Axis(name, title, unit, values, plausible, reason, place)
