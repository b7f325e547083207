"""Estimators of detectability that are ready to use: support vectors, evaluated by numpy."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.driver.inputs.record import EstimateRecord
from nvcore.driver.shapes import rows_of
from nvcore.errors import ParameterError

Kernel = Literal["linear", "rbf"]
KERNELS: Final[tuple[Kernel, ...]] = ("linear", "rbf")
N_FEATURES: Final = len(FEATURE_KEYS)
_ROWS_AT_ONCE: Final = 1 << 14
_DIGITS: Final = 9
"""Of how far it is from one period to the next: times of frames are rounded."""


@dataclass(frozen=True)
class SvrSettings:
    """Settings of a support vector regression.

    Attributes
    ----------
    kernel
        ``"linear"`` or ``"rbf"``, exp(-gamma |a - b|^2), of standardised features.
    cost
        C: what a residual beyond `epsilon` costs.
    epsilon
        Residuals that cost nothing, in units of detectability.
    gamma
        Of the kernel ``rbf``, for one feature; of n features it is gamma / n.
    """

    kernel: Kernel
    cost: float
    epsilon: float
    gamma: float


@dataclass(frozen=True)
class Quality:
    """How well a regression does on pedestrians that it has not seen.

    Attributes
    ----------
    n_rows
        Rows that it was trained on.
    error
        Mean squared error out of fold, features and settings chosen within each fold; 0 is best.
    constant
        Mean of the targets that it was trained on.
    constant_error
        Mean squared error of that constant, out of fold: what a regression has to beat.
    """

    n_rows: int
    error: float
    constant: float
    constant_error: float

    @property
    def sd(self) -> float:
        """Root mean square of the residuals out of fold: the uncertainty of an estimate."""
        return float(np.sqrt(self.error))


@dataclass(frozen=True)
class Regression:
    """A support vector regression on standardised features.

    Attributes
    ----------
    columns
        Which of the eight features it takes, ascending, int64, shape (f,).
    centre, scale
        Mean and standard deviation of each in the training, float64, shape (f,).
    low, high
        Range of each in the training, float64, shape (f,).
    vectors
        Support vectors, standardised, float64, shape (m, f).
    weights
        Of the vectors, float64, shape (m,).
    offset
        The value without any vector.
    settings
        What it was trained with.
    """

    columns: NDArray[np.int64]
    centre: NDArray[np.float64]
    scale: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    vectors: NDArray[np.float64]
    weights: NDArray[np.float64]
    offset: float
    settings: SvrSettings

    @property
    def features(self) -> tuple[str, ...]:
        """Keys of the features that it takes."""
        return tuple(FEATURE_KEYS[column] for column in self.columns)

    def predict(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Detectability, 0..1, float64, shape (n,); NaN where a feature that it takes is.

        Parameters
        ----------
        features
            All eight, float64, shape (n, 8).
        """
        values = (features[:, self.columns] - self.centre) / self.scale
        estimate = np.empty(len(values))
        for start in range(0, len(values), _ROWS_AT_ONCE):  # all kernels at once would not fit
            rows = values[start : start + _ROWS_AT_ONCE]
            estimate[start : start + len(rows)] = self._kernel(rows) @ self.weights
        return np.clip(estimate + self.offset, 0.0, 1.0)

    def outside(self, features: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which features that it takes are outside the range of the training, shape (n, 8).

        None is where it lacks one that it takes.
        """
        values = features[:, self.columns]
        is_whole = ~np.isnan(values.sum(axis=1, keepdims=True))
        outside = np.zeros(features.shape, dtype=np.bool_)
        outside[:, self.columns] = ((values < self.low) | (values > self.high)) & is_whole
        return outside

    def _kernel(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        products: NDArray[np.float64] = values @ self.vectors.T
        if self.settings.kernel == "linear":
            return products
        squares = (values**2).sum(axis=1)[:, None] + (self.vectors**2).sum(axis=1)
        gamma = self.settings.gamma / len(self.columns)
        kernel: NDArray[np.float64] = np.exp(-gamma * np.maximum(squares - 2 * products, 0.0))
        return kernel


@dataclass(frozen=True)
class Estimates:
    """What an estimator says of pedestrians.

    Attributes
    ----------
    detectability
        Share of drivers who would see each, 0..1, float64, shape (n,); NaN where a feature that is
        needed is undefined.
    sd
        Its uncertainty: root mean square of the residuals on unseen pedestrians, float64; NaN
        likewise.
    outside
        Which features are outside the range of the training, bool, shape (n, 8).
    period_s
        The adaptation period whose estimator was taken, float64, shape (n,); NaN: between two.
    """

    detectability: NDArray[np.float64]
    sd: NDArray[np.float64]
    outside: NDArray[np.bool_]
    period_s: NDArray[np.float64]

    @property
    def is_outside(self) -> NDArray[np.bool_]:
        """Whether any feature is, bool, shape (n,)."""
        is_outside: NDArray[np.bool_] = np.asarray(self.outside.any(axis=1))
        return is_outside


@dataclass(frozen=True)
class Origin:
    """What an estimator was trained on.

    Attributes
    ----------
    n_pedestrians, n_subjects, n_trials
        How much.
    simulated
        ``"no"``, ``"all"`` or ``"some"``: of the trials no person took.
    square_px, centre_share, display_s
        How responses were judged (`nvcore.driver.trials.Judging`).
    seed
        Of all that was drawn at random.
    fingerprint
        sha256 of the training table.
    search
        ``"quick"``: fewer settings were tried than by default; empty: not fewer, or not known.
    picture_px
        Width and height of its pictures; None: they differ, or are not known.
    """

    n_pedestrians: int
    n_subjects: int
    n_trials: int
    simulated: str
    square_px: float
    centre_share: float
    display_s: float
    seed: int
    fingerprint: str
    search: str = ""
    picture_px: tuple[int, int] | None = None

    def as_json(self) -> dict[str, Any]:
        """For a file; without what earlier ones did not have where it is empty or not known."""
        later = ("search", "picture_px")
        return {name: value for name, value in asdict(self).items() if name not in later or value}


@dataclass(frozen=True)
class Estimator:
    """Regressions for each adaptation period, and one for all of them.

    Attributes
    ----------
    name
        Of the model.
    periods_s
        Adaptation periods, ascending, float64, shape (p,).
    regressions
        One for each period, then the single one for all; p + 1.
    qualities
        Of each, likewise.
    origin
        What they were trained on.
    feature_settings
        With which the features were computed; None: not known.
    """

    name: str
    periods_s: NDArray[np.float64]
    regressions: tuple[Regression, ...]
    qualities: tuple[Quality, ...]
    origin: Origin
    feature_settings: FeatureSettings | None = None

    @property
    def no_better_at_s(self) -> tuple[float, ...]:
        """Periods whose regression is no better than a constant on pedestrians left out."""
        of_periods = zip(self.periods_s.tolist(), self.qualities[:-1], strict=True)
        return tuple(s for s, quality in of_periods if quality.error >= quality.constant_error)

    @property
    def is_of_no_use(self) -> bool:
        """Whether the switched regressions are no better than a constant over all periods."""
        of_periods = self.qualities[:-1]
        return sum(q.error for q in of_periods) >= sum(q.constant_error for q in of_periods)

    def caution(self, *, simulated: str = "") -> str:
        """Return why estimates are doubtful whatever the pictures, or "" without a reason.

        Parameters
        ----------
        simulated
            As of its origin; empty: nothing is said of it.
        """
        return EstimateRecord(
            simulated=simulated,
            no_better_at_s=self.no_better_at_s,
            of_no_use=self.is_of_no_use,
            search=self.origin.search,
        ).caution

    @property
    def features(self) -> tuple[str, ...]:
        """Keys of the features that any of the switched regressions takes, in their order."""
        used = {key for regression in self.regressions[:-1] for key in regression.features}
        return tuple(key for key in FEATURE_KEYS if key in used)

    def estimate(
        self,
        features: NDArray[np.float64],
        period_s: NDArray[np.float64] | float,
        *,
        interpolate: bool = False,
    ) -> Estimates:
        """Detectability of pedestrians, by the estimator of the nearest adaptation period.

        Of two periods equally near the shorter is taken. Beyond the longest period that one is
        taken, as where the period is NaN: no change of light is known, the eye is adapted.

        Parameters
        ----------
        features
            The eight in their order, float64, shape (n, 8), or (8,) of one pedestrian; NaN:
            undefined.
        period_s
            Seconds since the last change from bright to dark, shape (n,), or one for all.
        interpolate
            Whether the estimates (and uncertainties) of the periods before and after are
            interpolated linearly.

        Raises
        ------
        ParameterError
            If features or periods are of another shape, or a feature is infinite.
        """
        features = rows_of(np.atleast_2d(features), N_FEATURES, "features")
        period = np.asarray(period_s, np.float64)
        if period.shape not in ((), (len(features),)):
            raise ParameterError(
                f"period_s: expected one number, or one for each of {len(features)} rows, found "
                f"the shape {period.shape}"
            )
        period = np.broadcast_to(period, len(features))
        below, above, share = self._regression_rows(period, interpolate=interpolate)
        first, sd, outside = self._of_periods(features, below)
        second, second_sd, second_outside = self._of_periods(features, above)
        is_between = below != above
        detectability = np.where(is_between, (1 - share) * first + share * second, first)
        return Estimates(
            detectability,
            np.where(is_between, (1 - share) * sd + share * second_sd, sd),
            outside | (is_between[:, None] & second_outside),
            np.where(is_between, np.nan, self.periods_s[below]),
        )

    def regression_rows(self, period_s: float, *, interpolate: bool) -> list[int]:
        """Rows of the regressions that `estimate` takes at a period, ascending: one, or two."""
        below, above, _ = self._regression_rows(
            np.array([period_s], np.float64), interpolate=interpolate
        )
        return sorted({int(below[0]), int(above[0])})

    def _regression_rows(
        self, period: NDArray[np.float64], *, interpolate: bool
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """Rows of the regressions before and after, and how far it is from the one to the other.

        Unless it is interpolated both are the nearest; at a period that has one, both are that.
        """
        period = np.where(np.isnan(period), np.inf, period)
        periods = self.periods_s
        after = np.searchsorted(periods, period)
        below, above = (np.clip(at, 0, len(periods) - 1) for at in (after - 1, after))
        step, share = periods[above] - periods[below], np.zeros(len(period))
        np.divide(period - periods[below], step, out=share, where=step > 0)
        share = share.round(_DIGITS)
        if interpolate:
            return np.where(share < 1, below, above), np.where(share > 0, above, below), share
        nearest = np.where(share <= 0.5, below, above)
        return nearest, nearest, np.zeros(len(share))

    def _of_periods(
        self, features: NDArray[np.float64], index: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
        """Detectability, uncertainty and what is outside, by the regression of each row."""
        detectability, sd = np.full((2, len(features)), np.nan)
        outside = np.zeros(features.shape, dtype=np.bool_)
        for number in np.unique(index).tolist():  # a handful
            rows = index == number
            detectability[rows] = self.regressions[number].predict(features[rows])
            outside[rows] = self.regressions[number].outside(features[rows])
            sd[rows] = self.qualities[number].sd
        return detectability, np.where(np.isnan(detectability), np.nan, sd), outside
