"""Scores of a system: missing, all the same, on an unusual scale; and what its threshold does."""

from __future__ import annotations

import numpy as np

from nvcore.auditing.cases import Audited, counted
from nvcore.findings import Finding, Severity


def audit_scores(audited: Audited) -> list[Finding]:
    """Missing, constant and unusual scores of a system."""
    score = audited.boxes.score
    if not len(score):
        return []
    is_missing = np.isnan(score)
    if is_missing.all():
        return [
            audited.finding(
                Severity.NOTE,
                "no-scores",
                np.arange(len(score)),
                "No detection has a score.",
                "Nothing to do if the system decides by itself: every detection counts, and a "
                "threshold has no effect.",
            )
        ]
    findings = []
    rows = np.flatnonzero(is_missing)
    if len(rows):
        share = len(rows) / len(score)
        findings.append(
            audited.finding(
                Severity.WARNING,
                "missing-score",
                rows,
                f"{counted(len(rows), 'detection has', 'detections have')} no score ({share:.0%} "
                "of all), while others have one.",
                "Complete the scores: a detection without one passes every threshold.",
            )
        )
    low, high = float(np.nanmin(score)), float(np.nanmax(score))
    n_scores = len(score) - len(rows)
    if low == high and n_scores > 1:
        findings.append(
            audited.finding(
                Severity.NOTE,
                "constant-score",
                np.flatnonzero(~is_missing),
                f"Every score is {low:g}.",
                "Nothing to do if the system decides by itself; a threshold keeps all or nothing.",
            )
        )
    unusual = np.flatnonzero((score < 0) | (score > 1))
    if len(unusual):
        findings.append(
            audited.finding(
                Severity.NOTE,
                "unusual-scores",
                unusual,
                f"The scores go from {low:g} to {high:g}, not from 0 to 1.",
                "That is allowed; give a threshold on this scale, and check that the score was "
                "read from the right column.",
            )
        )
    return findings


def audit_threshold(audited: Audited, threshold: float | None, *, flag: str) -> list[Finding]:
    """A threshold that keeps nothing, keeps everything, or has no scores to work on.

    Parameters
    ----------
    flag
        The threshold's flag, for the advice.
    """
    score = audited.boxes.score
    if threshold is None or not len(score):
        return []
    rows = np.arange(len(score))
    low, high = _range(score)
    if np.isnan(score).all():
        return [
            audited.finding(
                Severity.WARNING,
                "threshold-without-scores",
                rows,
                f"The threshold {threshold:g} has no effect: no detection has a score.",
                f"Leave out {flag}, or give a file with scores.",
            )
        ]
    n_below = int(np.count_nonzero(score < threshold))
    if n_below == len(score):
        return [
            audited.finding(
                Severity.ERROR,
                "threshold-keeps-nothing",
                rows,
                f"The threshold {threshold:g} leaves no detection: the scores go from {low:g} to "
                f"{high:g}.",
                f"Give {flag} a value within that range.",
            )
        ]
    if n_below == 0:
        return [
            audited.finding(
                Severity.NOTE,
                "threshold-keeps-all",
                rows,
                f"The threshold {threshold:g} removes no detection: the scores go from {low:g} to "
                f"{high:g}.",
                "Nothing to do if the file was made at that threshold or a higher one; else check "
                "it against the range of the scores.",
            )
        ]
    return []


def _range(score: np.ndarray) -> tuple[float, float]:
    known = score[~np.isnan(score)]
    return (float(known.min()), float(known.max())) if len(known) else (np.nan, np.nan)
