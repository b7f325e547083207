"""Selection of features and settings of a regression by cross-validation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.common.extras import needs
from nvcore.subjects.driver.estimators.model import KERNELS, N_FEATURES, Regression, SvrSettings

COST: Final = (0.03, 3.0)
EPSILON: Final = (0.01, 0.2)
GAMMA: Final = (0.05, 2.0)
"""Ranges from which settings are drawn, uniformly on a logarithmic scale. (Our choice.) With
features of unit spread and targets of 0 to 1, a higher cost changes the fit little and takes much
longer.
"""
Columns = tuple[int, ...]
Check = Callable[[], None]


@dataclass(frozen=True, kw_only=True)
class Search:
    """Settings of the search for features and regression settings.

    Attributes
    ----------
    n_settings
        Number of random settings, each tried with each choice of features.
    n_folds
        Number of folds of the inner cross-validation, split by pedestrian.
    seed
        Random seed.

    Raises
    ------
    ParameterError
        If a value is outside its range.
    """

    n_settings: int = 30
    n_folds: int = 5
    seed: int = 0

    def __post_init__(self) -> None:
        for name, low, high in (
            ("n_settings", 1, 1000),
            ("n_folds", 2, 20),
            ("seed", 0, 2**32 - 1),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ParameterError(f"{name}: expected {low} to {high}, got {value}")

    @property
    def is_quick(self) -> bool:
        """Whether fewer settings are tried than by default."""
        return self.n_settings < Search.n_settings


QUICK: Final = Search(n_settings=4, n_folds=3)
"""Search for a first look and for tests. It takes a tenth of the time."""


def draw_settings(search: Search) -> tuple[SvrSettings, ...]:
    """Draw the settings to try, alternating between both kernels."""
    rng = np.random.default_rng(search.seed)
    low, high = np.log([COST, EPSILON, GAMMA]).T
    drawn = np.exp(rng.uniform(low, high, (search.n_settings, 3)))
    return tuple(
        SvrSettings(KERNELS[(i + 1) % 2], *values) for i, values in enumerate(drawn.tolist())
    )


def feature_sets(known: NDArray[Any]) -> tuple[Columns, ...]:
    """Return the choices of features to try: each alone, each pair, and all.

    Parameters
    ----------
    known
        Mask of the available features, shape (8,).
    """
    columns = np.flatnonzero(known).tolist()
    sets: list[Columns] = [(column,) for column in columns]
    sets += list(combinations(columns, 2))
    return tuple(sets + [tuple(columns)] * (len(columns) > 2))


PAIRS: Final = tuple(combinations(range(N_FEATURES), 2))
"""The 28 pairs of features, in the order of their keys."""


def fit(
    features: NDArray[np.float64],
    target: NDArray[np.float64],
    columns: Columns,
    settings: SvrSettings,
) -> Regression:
    """Fit a support vector regression.

    Parameters
    ----------
    features
        All eight features, float64, shape (n, 8). Those of `columns` must be finite.
    target
        Detectability, float64, shape (n,).

    Raises
    ------
    MissingExtraError
        If the extra ``driver`` is not installed.
    """
    with needs("driver", "training an estimator needs"):
        from sklearn import config_context
        from sklearn.svm import SVR

    chosen = features[:, columns]
    centre = chosen.mean(axis=0)
    scale = chosen.std(axis=0)
    # a constant feature has no information
    scale[scale <= 1e-12 * np.maximum(np.abs(centre), 1.0)] = 1.0
    machine = SVR(
        kernel=settings.kernel,
        C=settings.cost,
        epsilon=settings.epsilon,
        gamma=settings.gamma / len(columns),
    )
    with config_context(assume_finite=True, skip_parameter_validation=True):
        machine.fit((chosen - centre) / scale, target)
    return Regression(
        columns=np.array(columns, dtype=np.int64),
        centre=centre,
        scale=scale,
        low=chosen.min(axis=0),
        high=chosen.max(axis=0),
        vectors=np.ascontiguousarray(machine.support_vectors_, dtype=np.float64),
        weights=np.ascontiguousarray(machine.dual_coef_[0], dtype=np.float64),
        offset=float(machine.intercept_[0]),
        settings=settings,
    )


def folds_of(groups: NDArray[np.int64], n_folds: int, seed: int) -> NDArray[np.int64]:
    """Return the fold of each row, 0 to n_folds - 1, int64, shape (n,). Groups are never split.

    Parameters
    ----------
    groups
        Pedestrian number of each row, shape (n,).
    """
    numbers, rows = np.unique(groups, return_inverse=True)
    order = np.random.default_rng(seed).permutation(len(numbers))
    return (order % min(n_folds, len(numbers)))[rows]


class Choice(NamedTuple):
    """Choice of features with its best settings and their out-of-fold mean squared error."""

    columns: Columns
    settings: SvrSettings
    error: float


def choose(
    features: NDArray[np.float64],
    target: NDArray[np.float64],
    groups: NDArray[np.int64],
    search: Search,
    *,
    check: Check,
) -> list[Choice]:
    """Find the best settings for each choice of features by cross-validation.

    Parameters
    ----------
    features
        Float64, shape (n, 8). Each column is either all finite or all NaN.
    target, groups
        Detectability and pedestrian number of each row, shape (n,).
    check
        Called regularly. It may raise to cancel.
    """
    sets = feature_sets(np.isfinite(features.sum(axis=0)))
    drawn = draw_settings(search)
    fold = folds_of(groups, search.n_folds, search.seed)
    assert fold.max() > 0, "a single pedestrian leaves nothing to choose by"
    squares = np.zeros((len(sets), len(drawn)))
    for number in range(int(fold.max()) + 1):
        test = fold == number
        train = ~test
        for i, columns in enumerate(sets):
            check()
            for j, settings in enumerate(drawn):
                regression = fit(features[train], target[train], columns, settings)
                residual = regression.predict(features[test]) - target[test]
                squares[i, j] += residual @ residual
    best, errors = squares.argmin(axis=1).tolist(), squares.min(axis=1) / len(target)
    return [Choice(*of) for of in zip(sets, (drawn[j] for j in best), errors, strict=True)]
