"""Whether X and Y are compared at like operating points when no threshold is given."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.audit.cases import Audited, counted
from nvcore.findings import Finding, Severity
from nvcore.matching import Matches
from nvcore.operating_point import threshold_for
from nvcore.params import Params

MIN_DETECTIONS: Final = 50
"""The lowest of fewer scores says little."""
FLOOR_DIFFERENCE: Final = 0.05
"""Difference of the lowest scores, both on a scale from 0 to 1, that is worth telling."""
MAX_RATIO: Final = 3.0
"""Ratio of the detections per frame that is worth telling on any scale."""


def audit_operating_points(
    x: Audited, y: Audited, matches: tuple[Matches, Matches], params: Params
) -> list[Finding]:
    """Scores that reach down to different values, or far more detections of one system.

    Only where both systems have scores and neither has a threshold.

    Parameters
    ----------
    matches
        Of X and Y, without thresholds.
    """
    scores = x.boxes.score, y.boxes.score
    if params.threshold_x is not None or params.threshold_y is not None:
        return []
    if min(map(len, scores)) < MIN_DETECTIONS or any(np.isnan(one).any() for one in scores):
        return []
    floors = [float(one.min()) for one in scores]
    per_frame = [len(one) / len(x.dataset.frames) for one in scores]
    is_unit = all(one.min() >= 0 and one.max() <= 1 for one in scores)
    is_apart = is_unit and abs(floors[0] - floors[1]) >= FLOOR_DIFFERENCE
    if not is_apart and max(per_frame) <= MAX_RATIO * min(per_frame):
        return []
    alarms = [
        np.sort(one[match.is_false_alarm])[::-1] for one, match in zip(scores, matches, strict=True)
    ]
    more = 0 if len(alarms[0]) >= len(alarms[1]) else 1
    told = (x, y)
    what = ", ".join(
        f"{one.name} {'has scores ' if i == 0 else ''}down to {floors[i]:.3f} "
        f"({per_frame[i]:.1f} detections per frame)"
        for i, one in enumerate(told)
    )
    return [
        Finding(
            severity=Severity.WARNING,
            code="score-floors",
            subject=told[more].name,
            count=len(told[more].boxes),
            message=f"{what}: without thresholds the comparison is at two different operating "
            "points.",
            advice="Give --threshold-x and --threshold-y."
            + _proposal(alarms[more], len(alarms[1 - more]), more, x, y),
        )
    ]


def _proposal(alarms: np.ndarray, n_wanted: int, more: int, x: Audited, y: Audited) -> str:
    """The threshold that leaves one system as many false alarms as the other has; or nothing."""
    threshold = threshold_for(alarms, n_wanted)
    if threshold is None:
        return ""
    n_left = int(np.count_nonzero(alarms >= threshold))
    one, other = ((x, y), (y, x))[more]
    n_frames = len(x.dataset.frames)
    return (
        f" For example, --threshold-{'xy'[more]} {threshold:g} alone leaves {one.name} "
        f"{n_left / n_frames:.2g} false alarms per frame; {other.name} has "
        f"{n_wanted / n_frames:.2g} ({counted(n_wanted, 'false alarm')} in all)."
    )
