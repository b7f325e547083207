"""A change of light that never was: estimates as if it had become dark at some time."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.driver.estimators import Estimator
from nvcore.driver.features import FEATURE_KEYS
from nvcore.driver.illumination.clock import period_after
from nvcore.errors import ParameterError


def simulate_change(
    features: pd.DataFrame,
    end_s: NDArray[np.float64],
    change_s: float,
    estimator: Estimator,
    *,
    interpolate: bool = False,
    real_s: NDArray[np.float64] | None = None,
) -> pd.DataFrame:
    """Estimates as they would be, had it become dark at `change_s` of a recording.

    The pictures, and with them the features, stay what they are: only the time that the eyes have
    had to adapt is another. Frames that end before the change keep their period; of the later ones
    it runs from the change, until a real change comes after it.

    Parameters
    ----------
    features
        Rows of one recording of a features file (`nvcore.driver.run.FEATURE_COLUMNS`), of pictures
        of visible light: unlike `nvcore.driver.estimate`, it is not asked here what they are of.
    end_s
        When the frame of each row ends, seconds from the recording's first frame, as the dataset
        counts them, shape (n,).
    change_s
        On the same axis.
    interpolate
        As in `Estimator.estimate`.
    real_s
        When it really became dark, on the same axis, float64 (`AdaptationClock.change_s`); None:
        only what the periods of the rows say of it. A change that began and ended between two rows
        is then not known.

    Returns
    -------
    One row per row, with its index: period_s (NaN: adapted), detectability, sd (0..1, NaN
    unknown), is_outside, is_simulated (whether the period is that of the simulated change).

    Raises
    ------
    ParameterError
        Unless the time is finite.
    """
    if not np.isfinite(change_s):
        raise ParameterError(f"change: expected seconds from the first frame, found {change_s:g}")
    known_s = features["period_s"].to_numpy(np.float64)
    period_s, is_simulated = period_after(known_s, end_s, change_s, real_s=real_s)
    estimates = estimator.estimate(
        features[list(FEATURE_KEYS)].to_numpy(np.float64), period_s, interpolate=interpolate
    )
    columns = {
        "period_s": period_s,
        "detectability": estimates.detectability,
        "sd": estimates.sd,
        "is_outside": estimates.is_outside & ~np.isnan(estimates.detectability),
        "is_simulated": is_simulated,
    }
    return pd.DataFrame(columns, index=features.index)
