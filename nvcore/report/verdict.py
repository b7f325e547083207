"""What a comparison supports, in sentences that claim no more than its measures show."""

from __future__ import annotations

from collections.abc import Sequence, Set
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.paired_tests import MIN_DISCORDANT, MIN_SWAPPED, SIGNIFICANT
from nvcore.evidence.units import UNIT_WORDS
from nvcore.findings import Finding, Severity
from nvcore.measures import EVIDENCE_KEYS, has_several_recordings, inference_of
from nvcore.wording import capitalised, listed

SIDE_BY_SIDE: Final = tuple(key for key in EVIDENCE_KEYS if inference_of(key).noun)
"""Keys of the measures that the verdict puts side by side."""

BLOCKS: Final = "blocks"

CAVEATS: Final = {
    "track-reused": "track ids of the ground truth are used again after a gap, so that two persons "
    "may be taken for one encounter",
    "short-encounters": "most encounters are one frame long, so that counts of them are counts of "
    "frames rather than persons, and saliency and episodes mean little",
    "score-floors": "X and Y are compared at different operating points; with thresholds the "
    "other may come out better",
    "mixed-weighting": "X and Y are weighted by different rules",
    "same-boxes": "two of the inputs have the same boxes",
    "size-too-large": "the image size seems wrong",
    "implausible-fps": "the frame rate seems wrong",
    "time-offset": "a system seems to be off in time",
    "pixel-offset": "a system's boxes seem to be displaced",
    "scale-mismatch": "a system's boxes seem to be of another resolution",
    "frames-beyond-boxes": "frames without any box are evaluated",
    "no-detections": "a system has no detections",
    "threshold-keeps-nothing": "a threshold leaves no detection",
}
"""What a finding of the audit means for the verdict, by its code."""


def verdict(
    result: Result, findings: Sequence[Finding] = (), *, evidence: pd.DataFrame | None = None
) -> tuple[str, ...]:
    """Which system detects more pedestrians, and what the other measures say, in plain sentences.

    The first sentence is about encounters: one system dominates, is better beyond chance, or these
    data show no difference. The second puts measures side by side, and says which of their
    differences are more than chance. The last one lists the warnings and errors of the audit that
    all this depends on. X and Y are called ``X`` and ``Y``.

    Parameters
    ----------
    findings
        Of the audit of the same inputs.
    evidence
        `nvcore.evidence.measures.significance_table` of the result; None: the text says that the
        differences are not tested.

    Notes
    -----
    Without a near encounter the first sentence says that there is none; a measure that is
    undefined for a system is left out of the second.

    Examples
    --------
    >>> print(" ".join(verdict(result)))  # doctest: +SKIP
    X detects every encounter that Y detects, and 9 more of 40 (p = 0.0039).
    """
    codes = {finding.code for finding in findings}
    sentences = [_encounters(result, codes, evidence) + _by_units(result, codes, evidence)]
    side_by_side = _side_by_side(result)
    if side_by_side:
        sentences.append(f"{side_by_side}; {_chance(evidence, result.is_short)}.")
    unlimited = _without_threshold(result)
    if unlimited:
        sentences.append(unlimited)
    serious = [finding for finding in findings if finding.severity is not Severity.NOTE]
    if serious:
        sentences.append(_caveat(serious))
    return tuple(sentences)


def _caveat(serious: Sequence[Finding]) -> str:
    causes = list(
        dict.fromkeys(CAVEATS[finding.code] for finding in serious if finding.code in CAVEATS)
    )
    others = [finding.code for finding in serious if finding.code not in CAVEATS]
    if others:
        causes.append(
            f"{len(others)} {'other ' if causes else ''}finding{'s' if len(others) > 1 else ''} "
            "that it lists"
        )
    return f"This depends on what the audit found: {'; '.join(causes)}."


def _without_threshold(result: Result) -> str:
    """Which systems have scores but no threshold."""
    letters = [
        letter.upper()
        for letter, system in result.sides
        if system.threshold is None and np.isfinite(result.dataset.system(system.name).score).any()
    ]
    if not letters:
        return ""
    return f"Every detection of {' and '.join(letters)} counts, however low its score."


def _encounters(result: Result, codes: Set[str], evidence: pd.DataFrame | None) -> str:
    venn, p = result.venn, _p_of_encounters(result, evidence)
    if "same-boxes" in codes:
        return "Two of the inputs have the same boxes: this is no comparison of two systems."
    is_testable = not result.is_short
    n_split = venn.x_only + venn.y_only
    test_text = f"p = {result.exclusivity.mcnemar_p:.2g}"
    if p != result.exclusivity.mcnemar_p:
        test_text += f"; corrected for all measures, p = {p:.2g}"
    if n_split < MIN_DISCORDANT:
        test_text = "too few to test"
    chance = f" ({test_text})" if is_testable else ""
    if not venn.n_near:
        return (
            "There is no encounter near enough to count: these data do not show which system "
            "detects more."
        )
    if not n_split:
        return (
            f"X and Y detect the same {venn.both} of {venn.n_near} encounters: these data do not "
            "tell them apart by whom they detect."
        )
    winner, loser = ("X", "Y") if venn.x_only > venn.y_only else ("Y", "X")
    more = max(venn.x_only, venn.y_only)
    if venn.dominant is not None:
        claim = (
            f"{winner} detects every encounter that {loser} detects, and {more} more of "
            f"{venn.n_near}"
        )
        if p <= SIGNIFICANT or not is_testable:
            return f"{claim}{chance}."
        if n_split < MIN_DISCORDANT:
            return f"{claim}; so few do not show a difference beyond chance."
        return f"{claim}; that is not shown to be more than chance{chance}."
    split = (
        f"of the {n_split} encounters that only one system detects, X detects {venn.x_only} and Y "
        f"{venn.y_only}{chance}"
    )
    if not is_testable:
        return f"{capitalised(split)}."
    if p <= SIGNIFICANT:
        return f"{winner} detects more encounters, but not all that {loser} detects: {split}."
    return f"These data do not show which system detects more encounters: {split}."


def _p_of_encounters(result: Result, evidence: pd.DataFrame | None) -> float:
    """McNemar's p, corrected for the other measures where there are any."""
    if evidence is not None:
        row = evidence[evidence["figure"] == "encounters_detected"]
        if len(row) and np.isfinite(row["p_holm"].iloc[0]):
            return float(row["p_holm"].iloc[0])
    return result.exclusivity.mcnemar_p


def _by_units(result: Result, codes: Set[str], evidence: pd.DataFrame | None) -> str:
    """What is left of the evidence once similar encounters of one recording are allowed for.

    Empty unless single encounters support a claim, or are frames rather than persons.
    """
    venn, short = result.venn, result.is_short
    has_claim = short or _p_of_encounters(result, evidence) <= SIGNIFICANT
    if evidence is None or "same-boxes" in codes or not has_claim or venn.x_only == venn.y_only:
        return ""
    row = evidence[evidence["figure"] == "encounters_detected_by_unit"]
    p = np.nan if row.empty else float(row["p_holm"].iloc[0])
    is_significant = p <= SIGNIFICANT
    if row.empty or (is_significant and not short):
        return ""
    n, kind = int(row["n"].iloc[0]), str(row["unit"].iloc[0])
    unit = f"{n:,} {kind.removesuffix('s') if n == 1 else kind}"
    unit += " of time" if kind == BLOCKS else ""
    if np.isnan(p) and n < MIN_SWAPPED:
        outcome = "cannot be tested: there are too few of them"
    elif np.isnan(p):
        outcome = "cannot be tested: too few of them tell X and Y apart"
    elif is_significant:
        outcome = f"is more than chance (p = {p:.2g})"
    else:
        outcome = "is not shown to be more than chance"
    return f" Judged by {unit} instead of single encounters, that {outcome}."


def _side_by_side(result: Result) -> str:
    x, y = result.x, result.y
    parts = [
        _better(
            "the higher mean similarity",
            x.summary.mean,
            y.summary.mean,
            ".3f",
            is_high_better=True,
        ),
        _better(
            "the lower saliency in the mean over recordings"
            if has_several_recordings(result)
            else "the lower saliency",
            x.saliency_s,
            y.saliency_s,
            ".2f",
            unit=" s",
        ),
        _better(
            "fewer false-alert episodes",
            x.false_alarm_summary.episodes if result.duration_s else np.nan,
            y.false_alarm_summary.episodes if result.duration_s else np.nan,
            "d",
            unit=f" in {_duration(result.duration_s)}",
        ),
    ]
    defined = [part for part in parts if part]
    if not defined:
        return ""
    text = defined[0] if len(defined) == 1 else ", ".join(defined[:-1]) + ", and " + defined[-1]
    return capitalised(text)


def _chance(evidence: pd.DataFrame | None, short: bool) -> str:
    """Which of these differences are more than chance, by their corrected p-values."""
    if evidence is None:
        return "whether these differences are more than chance is not tested"
    keys = [key for key in SIDE_BY_SIDE if not (short and inference_of(key).needs_tracks)]
    text = _beyond_chance(evidence[evidence["figure"].isin(keys)])
    return f"{text}; saliency and episodes mean little here and are not judged" if short else text


def _beyond_chance(rows: pd.DataFrame) -> str:
    tested = rows[np.isfinite(rows["p_holm"])]
    if tested.empty:
        return "there are too few data to test these differences for chance"
    beyond = tested[tested["p_holm"] <= SIGNIFICANT]
    by = f"by these {int(tested['n'].iloc[0]):,} {UNIT_WORDS[tested['unit'].iloc[0]]}"
    if beyond.empty and len(rows) == 1:
        noun = inference_of(rows["figure"].iloc[0]).noun
        return f"{by}, the difference in {noun} is not shown to be more than chance"
    if beyond.empty:
        return f"{by}, none of these differences is shown to be more than chance"
    parts = [
        f"{inference_of(key).noun} (for {_winner(difference, better)}, "
        f"{_interval(key, low, high)}p = {p:.2g})"
        for key, difference, better, low, high, p in zip(
            *(beyond[name] for name in ("figure", "difference", "better", "low", "high", "p_holm")),
            strict=True,
        )
    ]
    is_one = len(parts) == 1
    others = "" if len(beyond) == len(rows) else "; the others are not shown to be"
    noun, verb = ("difference", "is") if is_one else ("differences", "are")
    return f"{by}, the {noun} in {listed(parts)} {verb} more than chance{others}"


def _winner(difference: float, better: str) -> str:
    """The system that a difference X - Y favours."""
    return "X" if (difference > 0) == (better == "higher") else "Y"


def _interval(key: str, low: float, high: float) -> str:
    if not np.isfinite(low):
        return ""
    ends = f"{_with_sign(low)} to {_with_sign(high)}"
    return f"X - Y 95 % interval {ends}{inference_of(key).noun_unit}, "


def _with_sign(value: float) -> str:
    """With sign and at least three digits, without exponent."""
    return f"{value:+,.0f}" if abs(value) >= 100 else f"{value:+.3g}"


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 600 else f"{seconds / 3600:.1f} h"


def _better(
    quality: str, x: float, y: float, form: str, *, unit: str = "", is_high_better: bool = False
) -> str:
    """Who has the quality, with both values, the better one first; empty where undefined."""
    if np.isnan(x) or np.isnan(y):
        return ""
    shown_x, shown_y = format(x, form), format(y, form)
    if shown_x == shown_y:
        noun = (
            quality.split(" ", 2)[-1] if quality.startswith("the ") else quality.split(" ", 1)[-1]
        )
        return f"both have the same {noun} ({shown_x}{unit})"
    is_x = (x > y) == is_high_better
    winner, first, second = ("X", shown_x, shown_y) if is_x else ("Y", shown_y, shown_x)
    return f"{winner} has {quality} ({first} to {second}{unit})"
