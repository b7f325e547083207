"""Points of a detection curve that can be drawn: where they are, and what they say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from nvcore.detection.curves import DetectionCurve
from nvcore.figures.detection.kinds import CurveChart
from nvcore.figures.rate_axis import LogScale
from nvcore.published import PublishedPoint

MAX_POINTS: Final = 600
"""Points of a curve that are drawn and can be clicked, evenly over the axis."""
POINT: Final = ("threshold", "recall", "miss_rate", "precision", "f1", "fppi")
"""What is known of every point of a curve."""


@dataclass(frozen=True, eq=False)
class CurvePoints:
    """Points of one system that can be drawn: where they are, and their values."""

    x: np.ndarray
    y: np.ndarray
    values: Mapping[str, np.ndarray]

    @classmethod
    def along(cls, curve: DetectionCurve, of: CurveChart, windows: float | None) -> CurvePoints:
        """All points of a curve."""
        values = {name: getattr(curve, name) for name in POINT}
        return cls._drawable(values, of, windows)

    @classmethod
    def at(
        cls, curve: DetectionCurve, threshold: float | None, of: CurveChart, windows: float | None
    ) -> CurvePoints:
        """The point of a curve at a threshold."""
        point = curve.at(threshold)
        values = {name: np.array([getattr(point, name)]) for name in POINT}
        return cls._drawable(values, of, windows)

    @classmethod
    def published(cls, point: PublishedPoint, of: CurveChart) -> CurvePoints:
        """A point of others; none where the kind of curve needs more than is known."""
        values = {name: np.array([value]) for name, value in point.values().items()}
        nothing = np.array([np.nan])
        points = cls(values.get(of.x, nothing), values.get(of.y, nothing), values)
        return points.rows(np.flatnonzero(np.isfinite(points.x) & np.isfinite(points.y)))

    @classmethod
    def _drawable(
        cls, values: dict[str, np.ndarray], of: CurveChart, windows: float | None
    ) -> CurvePoints:
        values["fppw"] = values["fppi"] / (np.nan if windows is None else windows)
        points = cls(values[of.x], values[of.y], values)
        return points.rows(np.flatnonzero(np.isfinite(points.x) & np.isfinite(points.y)))

    def rows(self, rows: np.ndarray) -> CurvePoints:
        """Some of the points."""
        values = {name: column[rows] for name, column in self.values.items()}
        return CurvePoints(self.x[rows], self.y[rows], values)

    def placed(self, x_scale: LogScale | None, y_scale: LogScale | None) -> CurvePoints:
        """The points where they stand on the axes; None: linear."""
        return replace(
            self,
            x=self.x if x_scale is None else x_scale.place(self.x),
            y=self.y if y_scale is None else y_scale.place(self.y),
        )

    def thinned(self, *, is_log: bool) -> CurvePoints:
        """At most `MAX_POINTS` and the first."""
        if len(self.x) <= MAX_POINTS:
            return self
        along = np.log(self.x) if is_log else self.x
        span = np.ptp(along) or 1.0
        column = np.floor((along - along.min()) / span * (MAX_POINTS - 2)).astype(np.int64)
        is_last = np.concatenate([column[1:] != column[:-1], [True]])
        is_last[0] = True
        return self.rows(np.flatnonzero(is_last))

    def texts(self, letter: str, of: CurveChart) -> list[str]:
        """What each point says when it is pointed at."""
        texts = []
        for i, threshold in enumerate(self.values["threshold"]):
            score = f"score ≥ {threshold:.4g}" if np.isfinite(threshold) else "without scores"
            values = {name: float(column[i]) for name, column in self.values.items()}
            texts.append(f"{letter.upper()}, {score}<br>{of.hover.format(**values)}")
        return texts

    def clicked(self, letter: str) -> list[list[str | float | None]]:
        """The system and its score, None where there is none to set."""
        scores = self.values["threshold"]
        return [[letter, float(score) if np.isfinite(score) else None] for score in scores]
