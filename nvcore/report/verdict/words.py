"""Sentences of the verdict by topic."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import (
    CLAIMED,
    Claim,
    Support,
    count_tests,
    is_turned_strictly,
    values_of,
    winner_of,
)
from nvcore.evidence.companions import Companions
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.operating_points import are_unequal, describe_alarms, has_scores
from nvcore.evidence.units import RECORDINGS
from nvcore.measures.table import evidence_form, has_several_recordings, inference_of, measure_of
from nvcore.measures.values import relevant_share
from nvcore.report.words import every_nth
from nvcore.schema import Category
from nvcore.wording import (
    capitalised,
    count_text,
    duration_text,
    interval_text,
    listed,
    one_line,
    p_text,
    shortened,
)

ENCOUNTERS: Final = "encounters_detected_by_unit"
HALF: Final = 0.5
"""With less of the events' time of pedestrians that count, saliency is mostly of others."""
NAME_WIDTH: Final = 40
"""Longest name of a recording."""


class Quality(NamedTuple):
    """A measure that the verdict puts side by side.

    Attributes
    ----------
    key
        Of `nvcore.measures.table.MEASURES`.
    comparative
        What the better system has of it.
    noun
        What it is called there.
    form, unit
        Format specification of the values, and what follows them.
    """

    key: str
    comparative: str
    noun: str
    form: str
    unit: str = ""


QUALITIES: Final = (
    Quality("mean_similarity", "the higher", "mean similarity", ".3f"),
    Quality("severity_s_per_encounter", "the lower", "severity per encounter", ".2f", " s"),
    Quality("saliency", "the lower", "saliency", ".2f", " s"),
    Quality("false_alert_episodes", "fewer", "false-alert episodes", "d"),
    Quality(MISS_RATE, "the lower", "log-average miss rate", ".1%"),
)


def describe_operating_points(result: Result, companions: Companions | None) -> tuple[str, ...]:
    """How X and Y are set, where that is unequal, and what the verdict compares instead."""
    if not are_unequal(result):
        return ()
    as_set = f"As set, {describe_alarms(result)}."
    if companions is None or companions.equal is None:
        return as_set, "What follows is as set."
    return (
        as_set,
        f"What follows is at equal false alarms ({companions.equal.setting}): nothing is claimed "
        "from the comparison as set.",
    )


def describe_encounters(
    result: Result, evidence: pd.DataFrame | None, support: Support
) -> tuple[str, ...]:
    """Who detects more encounters, and p of that by recordings, unless it is withheld."""
    venn = result.venn
    n_split = venn.x_only + venn.y_only
    if not venn.n_near:
        return ("There is no encounter near enough to count.",)
    if not n_split:
        return (f"X and Y detect the same {venn.both} of {venn.n_near} encounters.",)
    if venn.dominant is not None:
        winner, loser = ("X", "Y") if venn.dominant == "x" else ("Y", "X")
        text = (
            f"{winner} detects every encounter that {loser} detects, and {n_split} more of "
            f"{venn.n_near}"
        )
    else:
        text = (
            f"Of the {n_split} encounters that only one system detects, X detects {venn.x_only} "
            f"and Y {venn.y_only}"
        )
    p = "" if ENCOUNTERS in support.withheld else _p_of_encounters(evidence)
    return (f"{text}{p}.",)


def _p_of_encounters(evidence: pd.DataFrame | None) -> str:
    if evidence is None:
        return ""
    row = evidence[evidence["figure"] == ENCOUNTERS].iloc[0]
    if row["unit"] != RECORDINGS:
        return ""
    if np.isfinite(row["p_holm"]):
        p = p_text(row["p"], row["p_holm"], count_tests(evidence))
        return f" (by {count_text(int(row['n']), 'recording')}, {p})"
    return " (too few recordings tell the two apart to test it)"


def describe_weights(result: Result) -> tuple[str, ...]:
    """What the encounters weigh that only one system detects, and the worst failure."""
    venn = result.venn
    of_x, of_y = (result.severity_of(system) for _, system in result.sides)
    sides = [
        (letter, n, weight_s)
        for letter, n, weight_s in (
            ("X", venn.x_only, of_y[Category.X_ONLY]),
            ("Y", venn.y_only, of_x[Category.Y_ONLY]),
        )
        if n
    ]
    parts: list[str] = []
    for letter, n, weight_s in sides:
        verb = "" if parts else " weighs" if n == 1 else " weigh"
        what = "" if parts else f" of missed {result.objects.singular}"
        parts.append(f"the {n} that only {letter} detects{verb} {weight_s:.1f} s{what}")
    sentences = [f"{capitalised(', '.join(parts))}."] if parts else []
    worst = _worst_failure(result)
    return (*sentences, worst) if worst else tuple(sentences)


def _worst_failure(result: Result) -> str:
    severity_s = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    if not len(severity_s[0]) or not max(values.max() for values in severity_s) > 0:
        return ""
    letter = int(severity_s[1].max() > severity_s[0].max())
    row = int(severity_s[letter].argmax())
    encounters = result.encounters
    name = str(result.dataset.recordings["name"].iloc[encounters.recording[row]])
    return (
        f"The worst single failure is {'XY'[letter]}'s: {result.objects.singular} "
        f"{encounters.track[row]} in {shortened(one_line(name), NAME_WIDTH)}, "
        f"{severity_s[letter][row]:.1f} s."
    )


def describe_measures(result: Result, evidence: pd.DataFrame | None) -> tuple[str, ...]:
    """In which of the other measures X is better, in which Y, and which are the same."""
    better: dict[str, list[str]] = {"X": [], "Y": [], "": []}
    for quality in QUALITIES:
        x, y = _values(quality.key, result, evidence)
        if np.isnan(x) or np.isnan(y):
            continue
        shown_x, shown_y = (shown_value(value, quality.form) for value in (x, y))
        unit = quality.unit
        if quality.key == "false_alert_episodes":
            every = every_nth(result.dataset.frame_columns)
            of = f", {every}" if every else ""
            unit = f" in {duration_text(result.duration_s)}{of}"
        if shown_x == shown_y:
            better[""].append(f"the same {quality.noun} ({shown_x}{unit})")
            continue
        noun = quality.noun
        if quality.key == "saliency" and has_several_recordings(result):
            noun += " in the mean over recordings"
        is_x = (x > y) == (measure_of(quality.key).better == "higher")
        values = f"{shown_x} to {shown_y}" if is_x else f"{shown_y} to {shown_x}"
        better["X" if is_x else "Y"].append(f"{quality.comparative} {noun} ({values}{unit})")
    sentences = [
        f"{f'{who} has' if who else 'Both have'} {listed(texts)}."
        for who, texts in better.items()
        if texts
    ]
    return tuple(filter(None, (*sentences, _far_away(result))))


def _far_away(result: Result) -> str:
    """How little of the saliency is of pedestrians that count; empty: half or more of both's."""
    shares = [relevant_share(system) for _, system in result.sides]
    if not any(share < HALF for share in shares):
        return ""
    known = [
        f"{share:.0%} of {letter.upper()}'s"
        for (letter, _), share in zip(result.sides, shares, strict=True)
        if np.isfinite(share)
    ]
    return result.objects.say(
        "Of the time of the saliency events, {shares} is of {many} that count; the rest is of "
        "{people} too far away.",
        shares=listed(known),
    )


def shown_value(value: float, form: str) -> str:
    """The value in this format; whole numbers without decimals."""
    return format(int(value) if form == "d" else value, form)


def _values(key: str, result: Result, evidence: pd.DataFrame | None) -> tuple[float, float]:
    """A measure of X and Y; NaN where undefined."""
    if key != MISS_RATE:
        is_defined = key != "false_alert_episodes" or bool(result.duration_s)
        return values_of(key, result) if is_defined else (np.nan, np.nan)
    rows = [] if evidence is None else evidence[evidence["figure"] == key].to_dict("records")
    return (float(rows[0]["x"]), float(rows[0]["y"])) if rows else (np.nan, np.nan)


def describe_chance(
    result: Result, evidence: pd.DataFrame | None, support: Support
) -> tuple[str, ...]:
    """Which differences are more than chance, and why others that seem so are not claimed."""
    if evidence is None:
        return ()
    say = result.objects.say
    of_key = {row["figure"]: row for row in evidence.to_dict("records")}
    sentences = []
    if support.claims:
        n_tests = count_tests(evidence)
        parts = [
            f"{say(inference_of(claim.key).noun)} {_claim_text(claim, of_key[claim.key], n_tests)}"
            for claim in support.claims
        ]
        sentences.append(f"More than chance: {listed(parts)}.")
    for reason in dict.fromkeys(support.withheld.values()):
        withheld = [key for key in CLAIMED if support.withheld.get(key) == reason]
        nouns = [say(inference_of(key).noun) for key in withheld]
        sentences.append(f"Not claimed: {listed(nouns)} ({reason}).")
    settled = {*support.withheld, *(claim.key for claim in support.claims)}
    others = [row for key, row in of_key.items() if key in CLAIMED and key not in settled]
    if settled and any(np.isfinite(row["p_holm"]) for row in others):
        sentences.append("The other differences are not shown to be more than chance.")
    if result.is_short:
        sentences.append(
            "Most encounters are one frame long: saliency, severity and episodes mean little here "
            "and are not judged."
        )
    return tuple(sentences)


def _claim_text(claim: Claim, row: Mapping[Hashable, Any], n_tests: int) -> str:
    """For whom a difference speaks, with interval and p."""
    key, low, high = claim.key, row["low"], row["high"]
    interval = ""
    if np.isfinite(low):
        ends = interval_text(low, high, evidence_form(key))
        interval = f"X - Y 95 % interval {ends}{inference_of(key).noun_unit}, "
    return f"(for {claim.winner.upper()}, {interval}{p_text(row['p'], claim.p, n_tests)})"


def describe_strict(result: Result, strict: Result) -> tuple[str, ...]:
    """Where strict pairing puts the other system first, and which; empty where it agrees."""
    parts: dict[str, list[str]] = {"x": [], "y": []}
    for quality in QUALITIES:
        if is_turned_strictly(quality.key, result, strict):
            values = values_of(quality.key, strict)
            x, y = (format(value, quality.form) for value in values)
            winner = winner_of(values[0] - values[1], measure_of(quality.key).better)
            noun = result.objects.say(inference_of(quality.key).noun)
            parts[winner].append(f"{noun} (X {x}, Y {y}{quality.unit})")
    who = [f"{winner.upper()} is better in {listed(of)}" for winner, of in parts.items() if of]
    if not who:
        return ()
    return (
        "Paired strictly, so that false alarms cannot stand in for matches, it is the other way "
        f"round: {listed(who)}.",
    )


def describe_thresholds(result: Result) -> tuple[str, ...]:
    """Which systems have scores but no threshold."""
    letters = [
        letter.upper()
        for letter, system in result.sides
        if system.threshold is None and has_scores(result, letter)
    ]
    if not letters:
        return ()
    return (f"Every detection of {listed(letters)} counts, however low its score.",)
