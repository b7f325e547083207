"""Detectability of every pedestrian of recordings: the estimator at the end of the pass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.driver.features import FEATURE_KEYS
from nvcore.driver.run import BOX_COLUMNS, FeatureRun
from nvcore.wording import count_text

DETECTABILITY_COLUMNS: Final = (*BOX_COLUMNS, "detectability", "sd", "is_outside", "period_s")
"""Columns of a detectability file: one row for each truth box that is not ignored."""


class Estimated(Protocol):
    """What an estimator says of pedestrians; see `nvcore.driver.estimators`."""

    @property
    def detectability(self) -> NDArray[np.float64]:
        """0 to 1, shape (n,); NaN: a feature that it needs is undefined."""
        ...

    @property
    def sd(self) -> NDArray[np.float64]:
        """Uncertainty, shape (n,)."""
        ...

    @property
    def is_outside(self) -> NDArray[np.bool_]:
        """Whether a feature lies outside the range of the training, shape (n,)."""
        ...


class Estimating(Protocol):
    """An estimator of detectability."""

    def estimate(
        self,
        features: NDArray[np.float64],
        period_s: NDArray[np.float64],
        *,
        interpolate: bool = False,
    ) -> Estimated:
        """Detectability from features (n, 8) and adaptation periods (n,), NaN adapted."""
        ...


@dataclass(frozen=True, eq=False, repr=False)
class EstimateRun:
    """Detectability of the pedestrians of recordings; ``print`` says what came out.

    Attributes
    ----------
    features
        What it was estimated from.
    table
        `DETECTABILITY_COLUMNS`, rows as those of the features.
    about
        The estimator, in words and numbers, for a record.
    """

    features: FeatureRun
    table: pd.DataFrame
    about: dict[str, Any]

    @property
    def n_estimated(self) -> int:
        """Pedestrian boxes with an estimate."""
        return int(self.table["detectability"].notna().sum())

    def __repr__(self) -> str:
        return f"<EstimateRun of {count_text(len(self.table), 'box', 'boxes')}>"

    def __str__(self) -> str:
        table = self.table
        known = table[table["detectability"].notna()]
        lines = [
            str(self.features),
            f"detectability of {len(known):,} of {len(table):,} pedestrian boxes"
            + (f": {known['detectability'].mean():.2f} on average" if len(known) else ""),
        ]
        n_adapted = int(known["period_s"].isna().sum())
        if n_adapted:
            lines.append(
                f"{n_adapted:,} of these after no known change of light: by the estimator of the "
                "longest period, as for adapted eyes"
            )
        n_outside = int(known["is_outside"].sum())
        if n_outside:
            lines.append(
                f"{n_outside:,} of these have features outside the range of the training: take "
                "them with care"
            )
        return "\n".join(lines)


def run_estimate(
    features: FeatureRun,
    estimator: Estimating,
    *,
    about: dict[str, Any] | None = None,
    interpolate: bool = False,
) -> EstimateRun:
    """Detectability of every pedestrian of a run.

    Parameters
    ----------
    estimator
        That of `nvcore.driver.estimators`.
    about
        What a record is to say of it.
    interpolate
        Whether to interpolate between the estimators of the periods before and after; else that of
        the nearest period is taken.
    """
    table = features.table
    period_s = table["period_s"].to_numpy(np.float64)
    estimates = estimator.estimate(
        table[list(FEATURE_KEYS)].to_numpy(np.float64), period_s, interpolate=interpolate
    )
    is_known = ~np.isnan(estimates.detectability)
    own = table[list(BOX_COLUMNS)].assign(
        detectability=estimates.detectability,
        sd=estimates.sd,
        is_outside=estimates.is_outside & is_known,
        period_s=period_s,
    )
    return EstimateRun(features, own[list(DETECTABILITY_COLUMNS)], dict(about or {}))
