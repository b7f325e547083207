"""Sentences of the verdict: encounters, what failures weigh, the other measures, strict pairing."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import CLAIMED, Support, values_of, values_turn
from nvcore.evidence.companions import MISS_RATE, STRICT_KEYS
from nvcore.evidence.units import MIN_RECORDINGS, RECORDINGS
from nvcore.measures import has_several_recordings, inference_of, ratio_of
from nvcore.schema import Category
from nvcore.wording import capitalised, count_text, listed, one_line, shortened

ENCOUNTERS: Final = "encounters_detected_by_unit"
SIDE_BY_SIDE: Final = tuple(key for key in CLAIMED if key != ENCOUNTERS)
"""Keys of the measures that the verdict puts side by side."""
NAME_WIDTH: Final = 40
"""Longest name of a recording."""
NOT_TESTED: Final = "whether that is more than chance is not tested"


def describe_encounters(result: Result, evidence: pd.DataFrame | None, support: Support) -> str:
    """Who detects more encounters, and whether other recordings would show it too."""
    venn = result.venn
    if not venn.n_near:
        return (
            "There is no encounter near enough to count: these data do not show which system "
            "detects more."
        )
    n_split = venn.x_only + venn.y_only
    if not n_split:
        return (
            f"X and Y detect the same {venn.both} of {venn.n_near} encounters: these data do not "
            "tell them apart by whom they detect."
        )
    winner, loser = ("X", "Y") if venn.x_only > venn.y_only else ("Y", "X")
    if n_split == 1:
        split = f"only one encounter is detected by a single system, by {winner}"
    else:
        split = (
            f"of the {n_split} encounters that only one system detects, X detects {venn.x_only} "
            f"and Y {venn.y_only}"
        )
    dominance = (
        f"{winner} detects every encounter that {loser} detects, and "
        f"{max(venn.x_only, venn.y_only)} more of {venn.n_near}"
    )
    fact = split if venn.dominant is None else dominance
    claim = next((claim for claim in support.claims if claim.key == ENCOUNTERS), None)
    if claim is not None:
        test = f"(by {claim.n:,} recordings, p = {claim.p:.2g})"
        if venn.dominant is not None:
            return f"{dominance} {test}."
        first, second = ("X", "Y") if claim.winner == "x" else ("Y", "X")
        return (
            f"{first} detects more encounters, but not all that {second} detects: {split} {test}."
        )
    if evidence is None:
        return f"{capitalised(fact)}; {NOT_TESTED}."
    row = evidence[evidence["figure"] == ENCOUNTERS].iloc[0]
    if row["unit"] != RECORDINGS:
        n = int(np.count_nonzero(np.diff(result.dataset.frame_columns.first)))
        few = "one recording does" if n == 1 else f"{n} recordings do"
        return (
            f"{capitalised(fact)}; {few} not show whether others would agree ({MIN_RECORDINGS} are "
            "needed)."
        )
    reason = support.withheld.get(ENCOUNTERS)
    if reason is None and np.isfinite(row["p_holm"]):
        reason = f"by {int(row['n']):,} recordings, p = {row['p_holm']:.2g}"
    reason = reason or "too few recordings tell the two apart to test it"
    if venn.dominant is not None:
        return f"{dominance}; that is not shown to be more than chance ({reason})."
    return f"These data do not show which system detects more encounters: {split} ({reason})."


def describe_weights(result: Result) -> str:
    """What the encounters weigh that only one system detects, and the worst failure."""
    venn = result.venn
    of_x, of_y = (result.severity_of(system) for _, system in result.sides)
    weights = [
        (f"the {n} that only {letter} detects", f"{weight:.1f} s")
        for letter, n, weight in (
            ("X", venn.x_only, of_y[Category.X_ONLY]),
            ("Y", venn.y_only, of_x[Category.Y_ONLY]),
        )
        if n
    ]
    parts = [f"{who} {weight}" for who, weight in weights]
    if weights:
        verb = "weighs" if weights[0][0].startswith("the 1 ") else "weigh"
        parts[0] = f"{weights[0][0]} {verb} {weights[0][1]} of missed pedestrian"
    text = ", ".join(parts)
    worst = _worst_failure(result)
    if worst:
        text = f"{text}; {worst}" if text else worst
    return f"{capitalised(text)}." if text else ""


def _worst_failure(result: Result) -> str:
    severity_s = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    if not len(severity_s[0]) or not max(values.max() for values in severity_s) > 0:
        return ""
    letter = int(severity_s[1].max() > severity_s[0].max())
    row = int(severity_s[letter].argmax())
    encounters = result.encounters
    name = str(result.dataset.recordings["name"].iloc[encounters.recording[row]])
    return (
        f"the worst single failure is {'XY'[letter]}'s: pedestrian {encounters.track[row]} in "
        f"{shortened(one_line(name), NAME_WIDTH)}, {severity_s[letter][row]:.1f} s"
    )


def describe_side_by_side(result: Result, evidence: pd.DataFrame | None) -> str:
    """Who is better in each of the other measures, without the full stop; empty without any."""
    x, y = result.x, result.y
    n_near = result.venn.n_near
    severity = [ratio_of(system.failures["severity_s"].sum(), n_near) for system in (x, y)]
    is_timed = bool(result.duration_s)
    episodes = [system.false_alarm_summary.episodes if is_timed else np.nan for system in (x, y)]
    saliency = "the lower saliency"
    if has_several_recordings(result):
        saliency += " in the mean over recordings"
    parts = [
        _better(
            "the higher mean similarity",
            x.summary.mean,
            y.summary.mean,
            ".3f",
            is_high_better=True,
        ),
        _better("the lower severity per encounter", severity[0], severity[1], ".2f", unit=" s"),
        _better(saliency, x.saliency_s, y.saliency_s, ".2f", unit=" s"),
        _better(
            "fewer false-alert episodes",
            episodes[0],
            episodes[1],
            "d",
            unit=f" in {_duration(result.duration_s)}",
        ),
        _better("the lower log-average miss rate", *_miss_rates(evidence), ".1%"),
    ]
    defined = [part for part in parts if part]
    if not defined:
        return ""
    text = defined[0] if len(defined) == 1 else ", ".join(defined[:-1]) + ", and " + defined[-1]
    return capitalised(text)


def _miss_rates(evidence: pd.DataFrame | None) -> tuple[float, float]:
    """Of X and Y; NaN where undefined."""
    if evidence is None:
        return np.nan, np.nan
    rows = evidence[evidence["figure"] == MISS_RATE].to_dict("records")
    return (float(rows[0]["x"]), float(rows[0]["y"])) if rows else (np.nan, np.nan)


def describe_chance(evidence: pd.DataFrame | None, support: Support, *, short: bool) -> str:
    """Which of these differences are more than chance, without the full stop."""
    if evidence is None:
        return "whether these differences are more than chance is not tested"
    keys = [key for key in SIDE_BY_SIDE if not (short and inference_of(key).needs_tracks)]
    text = _beyond_chance(evidence[evidence["figure"].isin(keys)], support)
    if short:
        text += "; saliency, severity and episodes mean little here and are not judged"
    return text


def _beyond_chance(rows: pd.DataFrame, support: Support) -> str:
    if not rows.empty and (rows["unit"] != RECORDINGS).all():
        return (
            "so few recordings do not show whether these differences are more than chance "
            f"({MIN_RECORDINGS} are needed)"
        )
    tested = rows[np.isfinite(rows["p_holm"])]
    if tested.empty:
        return "there are too few data to test these differences for chance"
    by = f"by these {count_text(int(tested['n'].iloc[0]), 'recording')}"
    of_key = {row["figure"]: row for row in rows.to_dict("records")}
    claims = [claim for claim in support.claims if claim.key in of_key]
    withheld = {key: reason for key, reason in support.withheld.items() if key in of_key}
    doubts = [
        f"that in {inference_of(key).noun} is none: {reason}" for key, reason in withheld.items()
    ]
    if not claims:
        text = f"{by}, none of these differences is shown to be more than chance"
        if len(rows) == 1:
            noun = inference_of(rows["figure"].iloc[0]).noun
            text = f"{by}, the difference in {noun} is not shown to be more than chance"
        if withheld:
            nouns = listed([inference_of(key).noun for key in withheld])
            reasons = "; ".join(dict.fromkeys(withheld.values()))
            text = f"{by}, none of these differences is claimed; as for {nouns}, {reasons}"
        return text
    parts = [
        f"{inference_of(claim.key).noun} (for {claim.winner.upper()}, "
        f"{_interval(claim.key, of_key[claim.key]['low'], of_key[claim.key]['high'])}"
        f"p = {claim.p:.2g})"
        for claim in claims
    ]
    is_one = len(parts) == 1
    noun, verb = ("difference", "is") if is_one else ("differences", "are")
    text = f"{by}, the {noun} in {listed(parts)} {verb} more than chance"
    if doubts:
        return f"{text}; {'; '.join(doubts)}"
    return text + ("" if len(parts) == len(rows) else "; the others are not shown to be")


def describe_strict(result: Result, strict: Result) -> str:
    """Where strict pairing puts the other system first; empty where it agrees."""
    turned = []
    for key, form, unit in zip(STRICT_KEYS, (".3f", ".2f"), ("", " s"), strict=True):
        as_set, strictly = values_of(key, result), values_of(key, strict)
        if values_turn(*as_set, *strictly):
            x, y = (format(value, form) for value in strictly)
            turned.append(f"{inference_of(key).noun} (X {x}, Y {y}{unit})")
    if not turned:
        return ""
    return (
        f"Paired strictly, so that false alarms cannot stand in for matches, the other system is "
        f"better in {listed(turned)}."
    )


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
