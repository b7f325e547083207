"""Venn categories of encounters, dominance, and exclusivity of two systems' misses."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np
import scipy

from nvcore.dataset.schema import Category


@dataclass(frozen=True)
class Venn:
    """Number of encounters of each category (paper, figures 1 and 2: ``+ x y -``)."""

    both: int
    x_only: int
    y_only: int
    neither: int
    distant: int

    @property
    def dominant(self) -> str | None:
        """System that detects all that the other does and more (``"x"`` or ``"y"``), or None."""
        if self.y_only == 0 and self.x_only > 0:
            return "x"
        if self.x_only == 0 and self.y_only > 0:
            return "y"
        return None

    @property
    def n_near(self) -> int:
        """Number of encounters that count, which excludes distant ones."""
        return self.both + self.x_only + self.y_only + self.neither

    def counts(self) -> dict[str, int]:
        """Return the five counts by category."""
        return asdict(self)


MIN_DISCORDANT: Final = 6
"""Fewest encounters detected by only one system for a p-value. With 5, the most uneven split has p
= 2 / 2^5 = 0.0625, which can never be significant."""


@dataclass(frozen=True)
class Exclusivity:
    """Exclusivity of two systems' misses, over all encounters except distant ones.

    Attributes
    ----------
    missed_by_x, missed_by_y, missed_by_both
        Counts.
    jaccard
        Shared misses over all misses, 0 (exclusive) .. 1 (the same); NaN without any miss.
    phi
        Correlation of the two misses, -1..1; NaN if a system misses none or all.
    mcnemar_p
        Exact two-sided McNemar p-value of the encounters that only one system detects: the
        probability of so uneven a split if both are equally good. 1 without such encounters.
    """

    missed_by_x: int
    missed_by_y: int
    missed_by_both: int
    jaccard: float
    phi: float
    mcnemar_p: float


def categorise(
    is_distant: np.ndarray, detected_x: np.ndarray, detected_y: np.ndarray
) -> np.ndarray:
    """Return the category of every encounter, object array of `Category` values, shape (n,)."""
    names = (Category.DISTANT, Category.BOTH, Category.X_ONLY, Category.Y_ONLY, Category.NEITHER)
    code = np.select(
        [is_distant, detected_x & detected_y, detected_x, detected_y],
        range(len(names) - 1),
        default=len(names) - 1,
    )
    category: np.ndarray = np.array([name.value for name in names], dtype=object)[code]
    return category


def count_categories(category: np.ndarray) -> Venn:
    """Count the encounters of each category."""
    counts = Counter(category.tolist())
    return Venn(**{name.value: counts[name.value] for name in Category})


def measure_exclusivity(venn: Venn) -> Exclusivity:
    """Measure how exclusive the misses of X and Y are.

    ``jaccard = neither / (x_only + y_only + neither)``; phi of the 2 x 2 table of misses;
    ``p = min(1, 2 * P(Binomial(x_only + y_only, 1/2) <= min(x_only, y_only)))``.

    References
    ----------
    McNemar (1947); the exact form is the sign test on discordant pairs.
    """
    either = venn.x_only + venn.y_only + venn.neither
    n = venn.n_near
    missed_x, missed_y = venn.y_only + venn.neither, venn.x_only + venn.neither
    margins = missed_x * (n - missed_x) * missed_y * (n - missed_y)
    cross = venn.both * venn.neither - venn.x_only * venn.y_only
    discordant = venn.x_only + venn.y_only
    tail = (
        float(scipy.special.bdtr(min(venn.x_only, venn.y_only), discordant, 0.5))
        if discordant
        else 1.0
    )
    return Exclusivity(
        missed_by_x=missed_x,
        missed_by_y=missed_y,
        missed_by_both=venn.neither,
        jaccard=venn.neither / either if either else float("nan"),
        phi=cross / margins**0.5 if margins else float("nan"),
        mcnemar_p=min(1.0, 2 * tail),
    )


@dataclass(frozen=True)
class BoxVenn:
    """Number of annotated pedestrian boxes matched by both, only X, only Y, neither."""

    both: int
    x_only: int
    y_only: int
    neither: int


def count_boxes(is_pedestrian: np.ndarray, by_x: np.ndarray, by_y: np.ndarray) -> BoxVenn:
    """Count the boxes of each kind. All arguments are bool, shape (n_truth,)."""
    hit_x, hit_y = by_x & is_pedestrian, by_y & is_pedestrian
    both = int(np.count_nonzero(hit_x & hit_y))
    x_only, y_only = int(np.count_nonzero(hit_x)) - both, int(np.count_nonzero(hit_y)) - both
    neither = int(np.count_nonzero(is_pedestrian)) - both - x_only - y_only
    return BoxVenn(both, x_only, y_only, neither)
