"""Graded statement: the probability that a system misses fewer encounters than the other.

In each unit, b encounters are missed by X alone and c by Y alone. Of the b + c, the share that X
alone misses has the logit d + tau z, with z ~ N(0, 1) for each unit. A priori d ~ N(0, 1.5) and
tau ~ half-normal(2). The likelihood is raised to the power 1 / 1.5, because people in groups are
missed together. The statement is P(d > 0): that Y misses fewer in a typical recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import scipy

from nvcore.comparison.compare import Result
from nvcore.dataset.schema import Category
from nvcore.evidence.units import MIN_RECORDINGS, Units

PRIOR_SD: Final = 1.5
"""Standard deviation of the difference d, in logits."""
SPREAD_SD: Final = 2.0
"""Scale of the half-normal spread tau between units, in logits."""
POWER: Final = 1 / 1.5
N_APART: Final = 81
"""Points of the grid over d."""
COARSE: Final = 7, 21
FINE: Final = 15, 81
"""Points of the grid over tau and z."""
MOST_COARSE: Final = 20
"""Most encounters of a unit missed by one system alone for the coarse grid. With 60, it gave 0.77
in place of 0.83."""
MIN_UNITS: Final = 2
MOST_OF_FEW: Final = 0.9
"""Highest probability with fewer than six units. In simulated studies with people in groups, 85 %
of the statements of at least 90 in 100 from four recordings were right (bench/graded.py)."""
ROUNDING: Final = 1e-9

_APART: Final = np.linspace(-4, 4, N_APART) * PRIOR_SD
_LOG_PRIOR: Final = -0.5 * (_APART / PRIOR_SD) ** 2


def _unit_logits(n_spread: int, n_unit: int) -> np.ndarray:
    """Return tau z on a grid of equal prior weights, shape (n_spread, n_unit)."""
    middle = [(np.arange(n) + 0.5) / n for n in (n_spread, n_unit)]
    spread = SPREAD_SD * scipy.special.ndtri(0.5 + 0.5 * middle[0])
    logits: np.ndarray = spread[:, None] * scipy.special.ndtri(middle[1])
    return logits


@dataclass(frozen=True)
class Graded:
    """Probability that Y misses fewer encounters than X in a typical recording.

    Attributes
    ----------
    y_better
        The probability, 0 to 1; NaN if undefined.
    n_units, noun
        Number of units, and the noun for one (`nvcore.evidence.units.Units.noun`).
    x_misses, y_misses
        Encounters that only X and only Y misses.
    reason
        Why it is undefined: fewer than two ``units``, no ``scores``, no ``points`` with equal false
        alarms, too few false ``alarms``, ``none`` missed by one system alone, or that leaving out
        ``one`` unit moves it across 50 %. Empty if defined.
    """

    y_better: float
    n_units: int
    noun: str
    x_misses: int = 0
    y_misses: int = 0
    reason: str = ""

    @classmethod
    def undefined(cls, reason: str, units: Units) -> Graded:
        """Return a statement without a probability."""
        return cls(np.nan, len(units), units.noun, reason=reason)


def probability(only_x: np.ndarray, only_y: np.ndarray) -> np.ndarray:
    """Return the probability that Y misses fewer encounters, for all units and without each one.

    Parameters
    ----------
    only_x, only_y
        Number of encounters that only X and only Y misses in each unit; shape (n_units,).

    Returns
    -------
    Float64, shape (1 + n_units,).
    """
    pairs, unit = np.unique(np.stack([only_x, only_y], axis=1), axis=0, return_inverse=True)
    grid = COARSE if pairs.sum(axis=1).max(initial=0) <= MOST_COARSE else FINE
    logit = _APART[:, None, None] + _unit_logits(*grid)  # (d, tau, z)
    log_x, log_y = -np.logaddexp(0, -logit), -np.logaddexp(0, logit)
    of_pair = np.array(
        [scipy.special.logsumexp(POWER * (n_x * log_x + n_y * log_y), axis=2) for n_x, n_y in pairs]
    )
    total = np.tensordot(np.bincount(unit.ravel(), minlength=len(pairs)), of_pair, axes=1)
    log = total - np.concatenate([np.zeros((1, *total.shape)), of_pair[unit.ravel()]])
    posterior = np.exp(log + _LOG_PRIOR[:, None] - log.max(axis=(1, 2), keepdims=True))
    of_apart = posterior.sum(axis=2)
    middle = N_APART // 2
    better = of_apart[:, middle + 1 :].sum(axis=1) + 0.5 * of_apart[:, middle]
    share: np.ndarray = better / of_apart.sum(axis=1)
    return share


def missed_alone(result: Result, units: Units) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of encounters that only X, and only Y, misses in each unit."""
    unit = units.of_recording[result.encounters.recording]
    x_misses, y_misses = (
        units.total(unit[result.category == category.value])
        for category in (Category.Y_ONLY, Category.X_ONLY)
    )
    return x_misses, y_misses


def grade(results: Sequence[Result], units: Units) -> Graded:
    """Return the statement, averaged over comparisons at several thresholds.

    Parameters
    ----------
    results
        Comparisons of the same systems. The first one's encounters are those that are returned.
    units
        `nvcore.evidence.units.find_whole` of these.
    """
    counts = [missed_alone(result, units) for result in results]
    n_x, n_y = (int(of.sum()) for of in counts[0])
    graded = Graded(np.nan, len(units), units.noun, n_x, n_y, "none")
    if not any(of.any() for pair in counts for of in pair):
        return graded
    shares = np.mean([probability(*pair) for pair in counts], axis=0)
    side = np.sign(np.where(np.abs(shares - 0.5) < ROUNDING, 0.0, shares - 0.5))
    if (side != side[0]).any():
        return replace(graded, reason="one")
    most = 1.0 if len(units) >= MIN_RECORDINGS else MOST_OF_FEW
    return replace(graded, y_better=float(np.clip(shares[0], 1 - most, most)), reason="")
