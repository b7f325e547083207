"""Findings on a system's scores (missing, constant, on an unusual scale) and threshold."""

from __future__ import annotations

import numpy as np

from nvcore.auditing.cases import BoxSource
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text, percent


def audit_scores(source: BoxSource) -> list[Finding]:
    """Report missing, constant and unusual scores of a system."""
    score = source.boxes.score
    if not len(score):
        return []
    is_missing = np.isnan(score)
    if is_missing.all():
        return source.findings(
            Severity.NOTE,
            "no-scores",
            np.arange(len(score)),
            "No detection has a score.",
            "Nothing to do if the system decides by itself: every detection counts, and a "
            "threshold has no effect.",
            is_of_all=True,
        )
    low, high = float(np.nanmin(score)), float(np.nanmax(score))
    without = np.flatnonzero(is_missing)
    is_constant = low == high and len(score) - len(without) > 1
    record = source.dataset.provenance.get(source.name)
    has_own_scale = record is not None and bool(record.about.kind)  # detector that ran here
    is_unusual = (low < 0 or high > 1) and not has_own_scale
    return [
        *source.findings(
            Severity.WARNING,
            "missing-score",
            without,
            f"{count_text(len(without), 'detection has', 'detections have')} no score "
            f"({percent(len(without) / len(score))} of all), while others have one.",
            "Complete the scores: a detection without one passes every threshold.",
        ),
        *source.findings(
            Severity.NOTE,
            "constant-score",
            np.flatnonzero(~is_missing) if is_constant else without[:0],
            f"Every score is {low:g}: there are no curves, and no threshold to move.",
            "Nothing to do if the system decides by itself.",
            is_of_all=True,
        ),
        *source.findings(
            Severity.NOTE,
            "unusual-scores",
            np.flatnonzero((score < 0) | (score > 1)) if is_unusual else without[:0],
            f"The scores go from {low:g} to {high:g}, not from 0 to 1.",
            "That is allowed; give a threshold on this scale, and check that the score was read "
            "from the right column.",
            is_of_all=True,
        ),
    ]


def audit_threshold(source: BoxSource, threshold: float | None) -> list[Finding]:
    """Report a threshold that keeps nothing, keeps everything, or has no scores to work on."""
    score = source.boxes.score
    if threshold is None or not len(score):
        return []
    rows = np.arange(len(score))
    subject = f"The threshold {threshold:g}"
    if np.isnan(score).all():
        return source.findings(
            Severity.WARNING,
            "threshold-without-scores",
            rows,
            f"{subject} has no effect: no detection has a score.",
            "Leave out the threshold, or give a file with scores.",
            is_of_all=True,
        )
    span = f"the scores go from {np.nanmin(score):g} to {np.nanmax(score):g}"
    n_below = int(np.count_nonzero(score < threshold))
    if n_below == len(score):
        return source.findings(
            Severity.ERROR,
            "threshold-keeps-nothing",
            rows,
            f"{subject} leaves no detection: {span}.",
            "Set a threshold within that range.",
            is_of_all=True,
            steps=(Step(Remedy.THRESHOLD, "", source.name),),
        )
    if n_below == 0:
        return source.findings(
            Severity.NOTE,
            "threshold-keeps-all",
            rows,
            f"{subject} removes no detection: {span}.",
            "Nothing to do if the file was made at that threshold or a higher one; else check it "
            "against the range of the scores.",
            is_of_all=True,
        )
    return []
