"""Miss rate against false positives per image, and its log-average."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.common.errors import ParameterError
from nvcore.common.wording import number
from nvcore.metrics.detection.curves import DetectionCurve
from nvcore.settings.objects import Objects

FPPI_REFERENCES: Final = np.logspace(-2.0, 0.0, 9)
"""Nine values of false positives per image, evenly spaced in logarithm: 10^-2, 10^-1.75, ..., 1."""
FPPI_REFERENCES.flags.writeable = False

FEW_PEDESTRIANS: Final = 100
"""With fewer, a single miss changes the miss rate by more than a percentage point."""

ROUNDED_REFERENCES: Final = np.array(
    [0.0100, 0.0178, 0.0316, 0.0562, 0.1000, 0.1778, 0.3162, 0.5623, 1.0000]
)
"""The same values, rounded as in KAIST's Python script. One false positive can make a difference.
"""
ROUNDED_REFERENCES.flags.writeable = False


def miss_rate_at(curve: DetectionCurve, fppi: np.ndarray | float) -> np.ndarray:
    """Return the miss rate at given false positives per image, 0 is best.

    This is the miss rate of the last point with at most `fppi`, or 1.0 if there is none, since
    nothing is detected at so few.

    Parameters
    ----------
    fppi
        False positives per image, any shape. Results are NaN if ``curve.why_undefined``.
    """
    references = np.asarray(fppi, dtype=float)
    if curve.why_undefined:
        return np.full(references.shape, np.nan)
    miss_rate = np.concatenate([[1.0], curve.miss_rate])
    rates: np.ndarray = miss_rate[np.searchsorted(curve.fppi, references, side="right")]
    return rates


def log_average_miss_rate(
    curve: DetectionCurve, *, references: np.ndarray = FPPI_REFERENCES
) -> float:
    """Compute the geometric mean of the miss rate at nine FPPI from 0.01 to 1 (LAMR), 0 is best.

    ``exp(mean(log(miss_rate_at(fppi))))``. A geometric mean with a zero is zero, so a system that
    misses nobody at some reference has 0. The result is 1 without detections and NaN if
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


def explain_zero(rates: np.ndarray) -> str:
    """Explain why the log-average of these miss rates is 0, or return "" if it is not."""
    is_zero = rates == 0
    if is_zero.all():
        return f"nothing is missed at any of the {len(rates)} references"
    if not is_zero.any():
        return ""
    return (
        f"0 at {np.count_nonzero(is_zero)} of {len(rates)} references: the geometric mean is 0 "
        f"though at the others up to {number(rates.max(), '.1%')} are missed"
    )


def explain_range(curve: DetectionCurve, rates: np.ndarray) -> tuple[str, ...]:
    """Explain the substitutes for the miss rate at references that the curve does not reach.

    Parameters
    ----------
    rates
        Miss rates of the curve at the references.
    """
    if curve.why_undefined or not len(curve) or not rates.any():
        return ()
    notes = []
    first, last = float(curve.fppi[0]), float(curve.fppi[-1])
    if first > FPPI_REFERENCES[0]:
        notes.append(
            f"the curve begins at {first:.3g} false positives per image: at fewer its miss rate "
            "counts as 100 %"
        )
    if not last:
        notes.append(
            "there is no false positive: at every reference the last miss rate counts, "
            f"{number(curve.miss_rate[-1], '.1%')}"
        )
    elif last < FPPI_REFERENCES[-1]:
        notes.append(
            f"the curve ends at {last:.3g} false positives per image: from there to 1 its last "
            f"miss rate counts, {number(curve.miss_rate[-1], '.1%')}"
        )
    return tuple(notes)


def explain_few(n_truth: int, objects: Objects) -> str:
    """Return a warning if few objects count, or "" if none or at least `FEW_PEDESTRIANS` count."""
    if not 0 < n_truth < FEW_PEDESTRIANS:
        return ""
    return (
        f"few {objects.plural}: {n_truth}, a single miss changes the miss rate by "
        f"{100 / n_truth:.1f} percentage points"
    )
