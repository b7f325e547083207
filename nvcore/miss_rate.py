"""Miss rate against false positives per image, and its log-average."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.curves import DetectionCurve
from nvcore.errors import ParameterError

FPPI_REFERENCES: Final = np.logspace(-2.0, 0.0, 9)
"""Nine false positives per image, evenly spaced in logarithm: 10^-2, 10^-1.75, ..., 1."""
FPPI_REFERENCES.flags.writeable = False

ROUNDED_REFERENCES: Final = np.array(
    [0.0100, 0.0178, 0.0316, 0.0562, 0.1000, 0.1778, 0.3162, 0.5623, 1.0000]
)
"""The same as KAIST's Python script has them; one false positive can lie between."""
ROUNDED_REFERENCES.flags.writeable = False


def miss_rate_at(curve: DetectionCurve, fppi: np.ndarray | float) -> np.ndarray:
    """Miss rate at given false positives per image, 0 is best.

    That of the last point with at most so many; 1.0 where there is none, as nothing is detected
    at so few.

    Parameters
    ----------
    fppi
        False positives per image, any shape; NaN results where ``curve.why_undefined``.
    """
    wanted = np.asarray(fppi, dtype=float)
    if curve.why_undefined:
        return np.full(wanted.shape, np.nan)
    miss_rate = np.concatenate([[1.0], curve.miss_rate])
    rates: np.ndarray = miss_rate[np.searchsorted(curve.fppi, wanted, side="right")]
    return rates


def log_average_miss_rate(
    curve: DetectionCurve, *, references: np.ndarray = FPPI_REFERENCES
) -> float:
    """Geometric mean of the miss rate at nine FPPI from 0.01 to 1 (LAMR), 0 is best.

    ``exp(mean(log(miss_rate_at(fppi))))``. A geometric mean with a zero is zero: a system that
    misses nobody at some reference has 0. Without detections 1; NaN where
    ``curve.why_undefined``.

    Parameters
    ----------
    references
        False positives per image, positive.

    Raises
    ------
    ParameterError
        If a reference is not positive, or there is none.

    References
    ----------
    P. Dollár, C. Wojek, B. Schiele, P. Perona: Pedestrian detection: an evaluation of the state
    of the art, PAMI 2012, section 3.1.
    """
    if not len(references) or not np.all(np.asarray(references) > 0):
        raise ParameterError(f"references: expected positive numbers, got {references!r}")
    rates = miss_rate_at(curve, references)
    if np.any(rates == 0):
        return 0.0
    return float(np.exp(np.log(rates).mean()))
