"""Estimators of detectability that are ready to use: support vectors, evaluated with numpy."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.subjects.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.subjects.driver.illumination.shapes import rows_of
from nvcore.subjects.driver.inputs.record import EstimateRecord

Kernel = Literal["linear", "rbf"]
KERNELS: Final[tuple[Kernel, ...]] = ("linear", "rbf")
N_FEATURES: Final = len(FEATURE_KEYS)
_ROWS_AT_ONCE: Final = 1 << 14
_DIGITS: Final = 9
"""Decimal places of interpolation weights, because times of frames are rounded."""


@dataclass(frozen=True)
class SvrSettings:
    """Settings of a support vector regression.

    Attributes
    ----------
    kernel
        ``"linear"`` or ``"rbf"``, exp(-gamma |a - b|^2), over standardised features.
    cost
        C: cost per residual beyond `epsilon`.
    epsilon
        Tolerated residual, in units of detectability.
    gamma
        Parameter of the kernel ``rbf`` for one feature. With n features, gamma / n is used.
    """

    kernel: Kernel
    cost: float
    epsilon: float
    gamma: float


@dataclass(frozen=True)
class Quality:
    """Error of a regression on pedestrians that it was not trained on.

    Attributes
    ----------
    n_rows
        Number of training rows.
    error
        Mean squared error out of fold, with features and settings chosen within each fold. 0 is
        best.
    constant
        Mean of the training targets.
    constant_error
        Out-of-fold mean squared error of that constant, which a regression has to beat.
    """

    n_rows: int
    error: float
    constant: float
    constant_error: float

    @property
    def sd(self) -> float:
        """Root mean square of the out-of-fold residuals: the uncertainty of an estimate."""
        return float(np.sqrt(self.error))


@dataclass(frozen=True)
class Regression:
    """Support vector regression over standardised features.

    Attributes
    ----------
    columns
        Indices of the features that it uses, ascending, int64, shape (f,).
    centre, scale
        Mean and standard deviation of each feature in the training, float64, shape (f,).
    low, high
        Range of each feature in the training, float64, shape (f,).
    vectors
        Support vectors, standardised, float64, shape (m, f).
    weights
        Weights of the vectors, float64, shape (m,).
    offset
        Constant term.
    settings
        Settings of the training.
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
        """Keys of the features that it uses."""
        return tuple(FEATURE_KEYS[column] for column in self.columns)

    def predict(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return detectability, 0..1, float64, shape (n,). It is NaN if a required feature is.

        Parameters
        ----------
        features
            All eight features, float64, shape (n, 8).
        """
        values = (features[:, self.columns] - self.centre) / self.scale
        estimate = np.empty(len(values))
        # in blocks, as all kernel values at once would not fit into memory
        for start in range(0, len(values), _ROWS_AT_ONCE):
            rows = values[start : start + _ROWS_AT_ONCE]
            estimate[start : start + len(rows)] = self._kernel(rows) @ self.weights
        return np.clip(estimate + self.offset, 0.0, 1.0)

    def outside(self, features: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which required features are outside the training range, shape (n, 8).

        All are False for a pedestrian that lacks a required feature.
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
    """Estimates of an estimator for pedestrians.

    Attributes
    ----------
    detectability
        Share of drivers who would see each pedestrian, 0..1, float64, shape (n,). NaN if a required
        feature is undefined.
    sd
        Uncertainty of each estimate: root mean square of the residuals on unseen pedestrians,
        float64. NaN like `detectability`.
    outside
        Features that are outside the training range, bool, shape (n, 8).
    period_s
        Adaptation period of the estimator used, float64, shape (n,). NaN: interpolated between two.
    """

    detectability: NDArray[np.float64]
    sd: NDArray[np.float64]
    outside: NDArray[np.bool_]
    period_s: NDArray[np.float64]

    @property
    def is_outside(self) -> NDArray[np.bool_]:
        """Mask of estimates with any feature outside the training range, bool, shape (n,)."""
        is_outside: NDArray[np.bool_] = np.asarray(self.outside.any(axis=1))
        return is_outside


@dataclass(frozen=True)
class Origin:
    """Training data of an estimator.

    Attributes
    ----------
    n_pedestrians, n_subjects, n_trials
        Size of the training data.
    simulated
        ``"no"``, ``"all"`` or ``"some"``: share of trials with simulated subjects.
    square_px, centre_share, display_s
        Judging of responses (`nvcore.subjects.driver.trials.Judging`).
    seed
        Random seed.
    fingerprint
        sha256 of the training table.
    search
        ``"quick"``: fewer settings than by default were tried. Empty: default search, or unknown.
    picture_px
        Width and height of the pictures. None: they differ, or are unknown.
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
        """Return JSON values, without empty fields that earlier versions did not have."""
        later = ("search", "picture_px")
        return {name: value for name, value in asdict(self).items() if name not in later or value}


@dataclass(frozen=True)
class Estimator:
    """Regressions for each adaptation period, and one for all of them.

    Attributes
    ----------
    name
        Name of the model.
    periods_s
        Adaptation periods, ascending, float64, shape (p,).
    regressions
        One for each period, then the one for all periods: p + 1.
    qualities
        Quality of each regression, in the same order.
    origin
        Training data.
    feature_settings
        Settings of the feature computation. None: unknown.
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
            Text on simulated subjects in the origin. Empty: leave it out.
        """
        return EstimateRecord(
            simulated=simulated,
            no_better_at_s=self.no_better_at_s,
            of_no_use=self.is_of_no_use,
            search=self.origin.search,
        ).caution

    @property
    def features(self) -> tuple[str, ...]:
        """Keys of the features that any of the periods' regressions uses, in their usual order."""
        used = {key for regression in self.regressions[:-1] for key in regression.features}
        return tuple(key for key in FEATURE_KEYS if key in used)

    def estimate(
        self,
        features: NDArray[np.float64],
        period_s: NDArray[np.float64] | float,
        *,
        interpolate: bool = False,
    ) -> Estimates:
        """Estimate detectability with the estimator of the nearest adaptation period.

        The shorter period wins ties. The longest period also serves longer times and NaN, which
        means that no change of light is known and the eyes are adapted.

        Parameters
        ----------
        features
            The eight features in order, float64, shape (n, 8), or (8,) for one pedestrian. NaN is
            undefined.
        period_s
            Seconds since the last change from bright to dark, shape (n,), or one value for all.
        interpolate
            Interpolate the estimates and uncertainties of the periods before and after linearly.

        Raises
        ------
        ParameterError
            If features or periods have another shape, or a feature is infinite.
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
        """Return the one or two rows of the regressions for a period, ascending."""
        below, above, _ = self._regression_rows(
            np.array([period_s], np.float64), interpolate=interpolate
        )
        return sorted({int(below[0]), int(above[0])})

    def _regression_rows(
        self, period: NDArray[np.float64], *, interpolate: bool
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """Return the regressions before and after each period, and the interpolation weight.

        Without interpolation, and at a period that has its own regression, both are the same.
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
        """Return detectability, uncertainty and `outside` mask from the regression of each row."""
        detectability, sd = np.full((2, len(features)), np.nan)
        outside = np.zeros(features.shape, dtype=np.bool_)
        for number in np.unique(index).tolist():  # a handful
            rows = index == number
            detectability[rows] = self.regressions[number].predict(features[rows])
            outside[rows] = self.regressions[number].outside(features[rows])
            sd[rows] = self.qualities[number].sd
        return detectability, np.where(np.isnan(detectability), np.nan, sd), outside
