"""The settings that a stability map changes: their values, and which of them are plausible."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, Literal, get_args

import numpy as np

from nvcore.common.errors import InputError, ParameterError
from nvcore.comparison.compare import Result
from nvcore.metrics.detection.operating_point import false_alarm_curve
from nvcore.metrics.proximity import in_use
from nvcore.settings.params import MIDPOINT_SHARE, SETTINGS
from nvcore.settings.params.traffic import UNSTATED

Plane = Literal[
    "alpha-midpoint",
    "thresholds",
    "matching",
    "edge-weight",
    "edge-weight-alpha",
    "pairing-alpha",
    "saliency-rule",
]

AXES: Final[dict[Plane, tuple[str, ...]]] = {
    "alpha-midpoint": ("alpha", "midpoint"),
    "thresholds": ("threshold_x", "threshold_y"),
    "matching": ("iou", "match"),
    "edge-weight": ("edge_weight",),
    "edge-weight-alpha": ("edge_weight", "alpha"),
    "pairing-alpha": ("alpha", "pairing"),
    "saliency-rule": ("saliency_weight", "saliency_of"),
}
"""Settings of each plane."""

MIDPOINT_PLAUSIBLE: Final = (0.06, 0.15)
"""Shares of a picture's height: from the preset for rural roads to that for towns, with the default
between them. Taken of the lowest and the tallest picture, to include every recording's own."""
MIDPOINT_DRAWN: Final = (0.02, 0.25)
ALARMS_PLAUSIBLE: Final = (0.01, 1.0)
"""False alarms per frame at usable thresholds: the range over which pedestrian benchmarks average
the miss rate (Dollár et al. 2012)."""


@dataclass(frozen=True)
class Range:
    """Range of a numeric axis: plausible values, and drawn ones, to show a flip just outside.

    `parameter` is the setting's name where the title is another.
    """

    title: str
    plausible: tuple[float, float]
    drawn: tuple[float, float]
    reason: str
    parameter: str = ""


RANGES: Final = {
    # a warning system exists for the pedestrian who would be missed
    "alpha": Range(
        "alpha", (0.5, 1.0), (0.0, 1.0), "a miss counts at least as much as a false alarm"
    ),
    # from the preset for towns to that for rural roads: the whole range of the setting
    "edge_weight": Range(
        "traffic context", (0.0, 1.0), (0.0, 1.0), "from towns to rural roads", "edge weight"
    ),
    # pedestrian benchmarks use 0.5; at 0.3 a match is still the same person (the limit of linking)
    "iou": Range(
        "IoU",
        (0.3, 0.7),
        (0.1, 0.9),
        "below, a match may be someone else; above, annotators' own boxes disagree",
    ),
    # metres where a person of 1.75 m has the shares of `MIDPOINT_PLAUSIBLE` in a camera like the
    # default's (focal length 720 px, picture 375 px high)
    "midpoint_m": Range(
        "counts half at",
        (22.0, 56.0),
        (10.0, 90.0),
        "from the preset for rural roads to that for towns",
        "midpoint",
    ),
}
"""Of the settings whose range is the same for all data."""

CHOICES: Final = {
    "match": "matching by",
    "pairing": "distances to",
    "saliency_of": "events of",
    "saliency_weight": "an event weighing by",
}
"""Titles of the settings that are choices."""
REASON_OF_CHOICES: Final = "both are in use"

MIN_POINTS: Final = 3
DIGITS: Final = 10
"""Digits to which values are rounded, counted from the first digit of the axis' length."""
ON_GRID: Final = 1e-6
"""A value this close to a point, as a share of the distance between points, is that point."""


@dataclass(frozen=True, eq=False)
class Axis:
    """One setting of `nvcore.settings.params.Params` and the values a map gives it.

    Attributes
    ----------
    name
        Field of `Params`.
    title, unit
        Words for use within a sentence; the unit is empty for shares and scores.
    label
        The setting's label, with the parameter's name in brackets if it differs.
    values
        Increasing, float64, shape (n,), read-only; for a choice the indices of `labels`.
    plausible
        Ends of the range that an analyst may reasonably choose from, within `values`.
    reason
        Why this range, in words.
    present
        Lowest and highest analysed value: equal unless the recordings' own values differ.
    labels, words
        For a choice, the values of the parameter and their names.
    """

    name: str
    title: str
    unit: str
    values: np.ndarray
    plausible: tuple[float, float]
    reason: str
    present: tuple[float, float]
    label: str
    labels: tuple[str, ...] = ()
    words: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.values)

    def setting_at(self, value: float) -> float | str:
        """Value of the parameter at a value of the axis."""
        return self.labels[round(value)] if self.labels else float(value)

    def is_plausible(self, values: np.ndarray | float) -> np.ndarray:
        """Check which values lie in the plausible range, bool, the same shape."""
        low, high = self.plausible
        room = ON_GRID * (high - low)  # 22.2 px is not below 0.06 * 370
        return (np.asarray(values) >= low - room) & (np.asarray(values) <= high + room)

    @property
    def present_index(self) -> int | None:
        """Index of the analysed setting, or None if the recordings' own values differ."""
        low, high = self.present
        return int(np.argmin(np.abs(self.values - low))) if low == high else None

    @cached_property
    def weights(self) -> np.ndarray:
        """Share of the plausible range that each point represents, float64, shape (n,), sum 1.

        A point represents the values nearer to it than to any other.
        """
        if self.labels:
            return np.full(len(self), 1 / len(self))
        middle = (self.values[1:] + self.values[:-1]) / 2
        edges = np.concatenate([self.values[:1], middle, self.values[-1:]])
        width = np.diff(np.clip(edges, *self.plausible))
        share: np.ndarray = width / width.sum()
        return share

    def distance(self, values: np.ndarray) -> np.ndarray:
        """Return distances from the analysed setting, in plausible ranges, float64, shape (n,).

        Another choice is a whole range away.
        """
        low, high = self.present
        if self.labels:
            return np.where(values == low, 0.0, 1.0)
        apart = np.maximum(np.maximum(low - values, values - high), 0)
        share: np.ndarray = apart / (self.plausible[1] - self.plausible[0])
        return share

    def range_text(self, low: float, high: float) -> str:
        """Format a range on this axis, such as "28.8 to 72 px", or all the values of a choice."""
        if self.labels:
            return " or ".join(self.words)
        return self.number_text(high) if low == high else f"{low:.4g} to {self.number_text(high)}"

    def text(self, value: float) -> str:
        """A value in words, such as "alpha 0.3" or "counts half at 48 px"."""
        value_text = self.words[round(value)] if self.labels else self.number_text(value)
        return f"{self.title} {value_text}"

    def number_text(self, value: float) -> str:
        """A value on this axis with its unit."""
        return f"{value:.4g} {self.unit}".rstrip()


def axes_of(result: Result, plane: Plane, *, n_points: int) -> tuple[Axis, ...]:
    """Return the one or two axes of a map. Axes that these data do not have are left out.

    Without proximity there is no midpoint, and without scores no threshold.

    Raises
    ------
    ParameterError
        If there is no such plane, or `n_points` is less than `MIN_POINTS`.
    InputError
        If no threshold changes anything: neither system has scores that differ.
    """
    if plane not in get_args(Plane):
        raise ParameterError(f"plane: expected one of {', '.join(get_args(Plane))}, got {plane!r}")
    if n_points < MIN_POINTS:
        raise ParameterError(f"n_points: expected at least {MIN_POINTS}, got {n_points}")
    candidates = (_axis(result, name, n_points) for name in AXES[plane])
    axes = tuple(axis for axis in candidates if axis is not None)
    if not axes:
        raise InputError(
            "neither system has scores that differ: no threshold changes anything; read "
            "detections with scores, or look at another map"
        )
    return axes


def _axis(result: Result, name: str, n_points: int) -> Axis | None:
    """Return the axis of a setting, or None if these data do not have it."""
    if name in CHOICES:
        return _choice(result, name)
    if name == "midpoint":
        return _midpoint(result, n_points)
    if name.startswith("threshold_"):
        return _threshold(result, name[-1], n_points)
    present = getattr(result.params, name)
    if name == "edge_weight":  # the recordings' own where none is given
        own = in_use(result.params, name, result.dataset.frame_columns)
        present = (float(own.min()), float(own.max())) if len(own) else UNSTATED
    return _numeric(name, RANGES[name], present=present, n_points=n_points)


def _choice(result: Result, name: str) -> Axis:
    """An axis of all choices of a setting (`CHOICES`)."""
    setting = SETTINGS[name]
    assert setting.words is not None
    labels = tuple(setting.words)
    place = float(labels.index(getattr(result.params, name)))
    values = np.arange(len(labels), dtype=float)
    values.flags.writeable = False
    return Axis(
        name=name,
        title=CHOICES[name],
        unit=setting.unit,
        values=values,
        plausible=(0.0, len(labels) - 1.0),
        reason=REASON_OF_CHOICES,
        present=(place, place),
        label=result.objects.say(setting.label),
        labels=labels,
        words=tuple(map(result.objects.say, setting.words.values())),
    )


def _midpoint(result: Result, n_points: int) -> Axis | None:
    """Midpoint of the proximity sigmoid in px, or in metres if proximity is by distance."""
    params, height = result.params, result.dataset.frame_columns.height
    if params.proximity == "none" or not len(height):
        return None
    if params.proximity == "distance":
        return _axis(result, "midpoint_m", n_points)
    least, most = float(height.min()), float(height.max())
    present = (MIDPOINT_SHARE * least, MIDPOINT_SHARE * most)
    plausible, drawn = (
        (low * least, high * most) for low, high in (MIDPOINT_PLAUSIBLE, MIDPOINT_DRAWN)
    )
    low, high = (f"{100 * share:g}" for share in MIDPOINT_PLAUSIBLE)
    share = f"{low} to {high} % of the picture's height"
    if least < most:
        share = f"{low} % of the lowest picture's height to {high} % of the tallest's"
    in_metres = RANGES["midpoint_m"]
    reason = f"{share}, {in_metres.reason}"
    own = replace(in_metres, plausible=plausible, drawn=drawn, reason=reason)
    midpoint = present if params.midpoint is None else params.midpoint
    return _numeric("midpoint", own, present=midpoint, n_points=n_points)


def _threshold(result: Result, letter: str, n_points: int) -> Axis | None:
    """Return the axis of a score threshold, or None if the system has no scores that differ."""
    system = result.system(letter)
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
    usual = Range(f"threshold of {letter.upper()}", plausible, plausible, reason)
    return _numeric(f"threshold_{letter}", usual, present=present, n_points=n_points)


def _numeric(
    name: str, usual: Range, *, present: float | tuple[float, float], n_points: int
) -> Axis:
    """Values over the drawn, plausible and present range, evenly spaced with two exceptions.

    The ends of the plausible range replace the nearest even points, so that no point represents
    settings on both sides. The present setting is an extra point if it lies between two, so that
    the map shows it.
    """
    place = present if isinstance(present, tuple) else (float(present), float(present))
    plausible, drawn = usual.plausible, usual.drawn
    low, high = min(drawn[0], plausible[0], place[0]), max(drawn[1], plausible[1], place[1])
    values = np.linspace(low, high, n_points)
    # 0.6, not 0.6000000000000001, which a score of 0.6 would not pass
    values[1:-1] = values[1:-1].round(DIGITS - int(np.floor(np.log10(high - low))))
    near = ON_GRID * (high - low) / (n_points - 1)
    shown = plausible if place[0] < place[1] else (*plausible, place[0])
    for number, value in enumerate(shown):
        nearest = int(np.argmin(np.abs(values - value)))
        is_free = number < len(plausible) and 0 < nearest < len(values) - 1
        is_free &= values[nearest] != plausible[0]
        if is_free or abs(values[nearest] - value) <= near:
            values[nearest] = value
        else:
            values = np.sort(np.append(values, value))
    values.flags.writeable = False
    setting = SETTINGS[name]
    label = f"{setting.label} ({usual.parameter})" if usual.parameter else setting.label
    unit, reason = setting.unit, usual.reason
    return Axis(name, usual.title, unit, values, plausible, reason, place, label)
