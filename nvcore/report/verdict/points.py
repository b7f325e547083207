"""Notes of the verdict, by topic."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding
from nvcore.common.wording import duration_text, interval_text, number, one_line, shortened
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import (
    evidence_form,
    has_several_recordings,
    measure_of,
    shown_as,
)
from nvcore.comparison.measures.values import relevant_share
from nvcore.dataset.schema import Category
from nvcore.evidence.claims import (
    ALARM_MARGIN,
    CLAIMED,
    Claim,
    Support,
    alarm_ratio_limit,
    has_primary,
    is_turned_strictly,
    values_of,
    winner_of,
)
from nvcore.evidence.companions import Companions, is_unsure
from nvcore.evidence.graded import Graded
from nvcore.evidence.looks import ONLY_LOOK, Look
from nvcore.evidence.measures import primary_of
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.operating_points import (
    alarms_as_set,
    are_delivered,
    are_unequal,
    equal_setting,
    has_scores,
)
from nvcore.evidence.units import WHOLE, find_whole
from nvcore.notes import Note
from nvcore.report.words import every_nth
from nvcore.settings.primary import DEFAULT

ENCOUNTERS: Final = "encounters_detected_by_unit"
HALF: Final = 0.5
"""Saliency is mostly about others if pedestrians who count have less than this share of time."""
NAME_WIDTH: Final = 40
"""Longest name of a recording."""
EPISODES: Final = "false_alert_episodes"
UNLISTED: Final = "false-alarms-like-matches"
"""Code of the finding on false alarms that may be people missing from the truth."""


class QualityMeasure(NamedTuple):
    """A measure that the verdict compares, with the format of its values.

    Attributes
    ----------
    key
        Key in `nvcore.comparison.measures.table.MEASURES`.
    form, unit
        Format specification of the values, and what follows them.
    """

    key: str
    form: str
    unit: str = ""


QUALITIES: Final = (
    QualityMeasure("mean_similarity", ".3f"),
    QualityMeasure("severity_s_per_encounter", ".2f", " s"),
    QualityMeasure("saliency", ".2f", " s"),
    QualityMeasure(EPISODES, "d"),
    QualityMeasure(MISS_RATE, ".1%"),
)


def operating_points(result: Result, companions: Companions | None) -> tuple[Note, ...]:
    """Describe the operating points of X and Y, or return nothing if they were always equal."""
    if are_delivered(result):
        return (Note("verdict.delivered", margin=ALARM_MARGIN, alarms=alarms_as_set(result)),)
    if result.as_set is not None:
        return (Note("verdict.equal_numbers", setting=equal_setting(result)),)
    if not are_unequal(result):
        return ()
    alarms = alarms_as_set(result)
    if companions is None or companions.equal is None:
        return (Note("verdict.unequal_comparison", alarms=alarms),)
    of_claims = Note("verdict.equal_claims", setting=equal_setting(companions.equal))
    return Note("verdict.unequal_numbers", alarms=alarms), of_claims


def question(
    result: Result, evidence: pd.DataFrame | None, look: Look = ONLY_LOOK
) -> tuple[Note, ...]:
    """Return the primary measure and how it was tested, or nothing without any p-value."""
    if evidence is None or not np.isfinite(evidence["p_corrected"]).any():
        return ()
    primary = primary_of(result.dataset)
    named = Note("verdict.measure", key=primary.key)
    tried = (Note("verdict.look", **look._asdict()),) if look.factor > 1 else ()
    if primary.is_changed:
        return (Note("verdict.primary_changed", primary=named, when=primary.when), *tried)
    if not has_primary(evidence, primary.key):
        return (Note("verdict.primary_untested", primary=named), *tried)
    if primary.key == DEFAULT and not primary.fixed_at:
        return (Note("verdict.primary_default", primary=named), *tried)
    return (Note("verdict.primary_chosen", primary=named, when=primary.when), *tried)


def encounters(result: Result, evidence: pd.DataFrame | None, support: Support) -> tuple[Note, ...]:
    """Return how many encounters each system detects, with a test over recordings.

    The test is omitted if its claim is withheld.
    """
    venn, test = result.venn, None
    if evidence is not None and ENCOUNTERS not in support.withheld:
        row = evidence[evidence["figure"] == ENCOUNTERS].iloc[0]
        n, noun, p = int(row["n"]), str(row["unit"]).removesuffix("s"), row["p_corrected"]
        if row["unit"] not in WHOLE:
            test = None
        elif np.isfinite(p):
            test = Note("verdict.tested", n=n, noun=noun, p=row["p"], p_corrected=p)
        elif is_unsure(row):
            test = Note("verdict.test_unsure")
        else:
            test = Note("verdict.too_few_differ", noun=noun)
    counts = {"n": venn.n_near, "both": venn.both, "x_only": venn.x_only, "y_only": venn.y_only}
    return (Note("verdict.detected", **counts, test=test or ""),)


def unlisted(result: Result, findings: Sequence[Finding]) -> tuple[Note, ...]:
    """Return how many false alarms would have to be real to turn the lead in encounters.

    Each that is real is one encounter more that only the trailing system detects, at most: it may
    be distant, or detected by both. Only for false alarms of that system that the audit found to
    look like its matches.
    """
    lead = result.venn.x_only - result.venn.y_only
    leader, trailing = ("x", "y") if lead > 0 else ("y", "x")
    name = result.names["xy".index(trailing)]
    counts = [of.count for of in findings if (of.code, of.subject) == (UNLISTED, name)]
    if not lead or not counts:
        return ()
    needed = abs(lead) + 1
    sides = {"leader": leader, "trailing": trailing}
    return (Note("verdict.unlisted", n=counts[0], n_needed=needed, **sides),)


def weights(result: Result) -> tuple[Note, ...]:
    """Return the severity of encounters that only one system detects, and the severest failure."""
    venn = result.venn
    of_x, of_y = (result.severity_of(system) for _, system in result.sides)
    costs = [
        Note("verdict.cost", finder=finder, loser=loser, n=n, seconds=seconds)
        for finder, loser, n, seconds in (
            ("x", "y", venn.x_only, of_y[Category.X_ONLY]),
            ("y", "x", venn.y_only, of_x[Category.Y_ONLY]),
        )
        if n
    ]
    return (*([Note("verdict.costs", costs=costs)] if costs else []), *_worst_failure(result))


def _worst_failure(result: Result) -> tuple[Note, ...]:
    severity_s = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    if not len(severity_s[0]) or not max(values.max() for values in severity_s) > 0:
        return ()
    side = int(severity_s[1].max() > severity_s[0].max())
    row = int(severity_s[side].argmax())
    encounters = result.encounters
    name = str(result.dataset.recordings["name"].iloc[encounters.recording[row]])
    return (
        Note(
            "verdict.worst_failure",
            system="xy"[side],
            track=str(encounters.track[row]),
            recording=shortened(one_line(name), NAME_WIDTH),
            seconds=float(severity_s[side][row]),
        ),
    )


def measures(result: Result, evidence: pd.DataFrame | None) -> tuple[Note, ...]:
    """Return in which of the other measures X or Y is better, and in which they are equal."""
    qualities: dict[str, list[Note]] = {"x": [], "y": [], "both": []}
    for key, form, unit in QUALITIES:
        x, y = _values(key, result, evidence)
        if np.isnan(x) or np.isnan(y):
            continue
        is_x = (x > y) == (measure_of(key).better == "higher")
        is_mean = key == "saliency" and has_several_recordings(result)
        note = Note(
            "verdict.quality",
            key="mean saliency" if is_mean else key,
            better=x if is_x else y,
            other=y if is_x else x,
            form=form,
            unit=unit,
            extent=_extent(result) if key == EPISODES else None,
        )
        is_same = number(x, form) == number(y, form)
        qualities["both" if is_same else "x" if is_x else "y"].append(note)
    return (
        *(Note("verdict.has", system=who, qualities=of) for who, of in qualities.items() if of),
        *_far_away(result),
    )


def _extent(result: Result) -> str:
    """Return the recording time in which episodes are counted, and which frames are evaluated."""
    every = every_nth(result.dataset.frame_columns)
    return f" in {duration_text(result.duration_s)}{every and f', {every}'}"


def _far_away(result: Result) -> tuple[Note, ...]:
    """Return relevant pedestrians' share of saliency if it is below half for either system."""
    shares = {letter: relevant_share(system) for letter, system in result.sides}
    if not any(share < HALF for share in shares.values()):
        return ()
    known = [
        Note("verdict.share", system=letter, share=share)
        for letter, share in shares.items()
        if np.isfinite(share)
    ]
    return (Note("verdict.far_away", shares=known),)


def _values(key: str, result: Result, evidence: pd.DataFrame | None) -> tuple[float, float]:
    """Return the values of a measure for X and Y, NaN where undefined."""
    if key != MISS_RATE:
        is_defined = key != EPISODES or bool(result.duration_s)
        return values_of(key, result) if is_defined else (np.nan, np.nan)
    rows = [] if evidence is None else evidence[evidence["figure"] == key].to_dict("records")
    return (float(rows[0]["x"]), float(rows[0]["y"])) if rows else (np.nan, np.nan)


def chance(result: Result, evidence: pd.DataFrame | None, support: Support) -> tuple[Note, ...]:
    """Return significant differences, and why other apparent ones are not claimed."""
    if evidence is None:
        return ()
    of_key = {row["figure"]: row for row in evidence.to_dict("records")}
    notes = []
    if support.claims:
        shown = [_shown(result, claim, of_key[claim.key]) for claim in support.claims]
        notes.append(Note("verdict.more_than_chance", shown=shown))
    for reason in dict.fromkeys(support.withheld.values()):
        withheld = [key for key in CLAIMED if support.withheld.get(key) == reason]
        measures = [Note("verdict.measure", key=key) for key in withheld]
        notes.append(Note("verdict.unclaimed", measures=measures, reason=reason))
    settled = {*support.withheld, *(claim.key for claim in support.claims)}
    others = [row for key, row in of_key.items() if key in CLAIMED and key not in settled]
    if settled and any(np.isfinite(row["p_corrected"]) for row in others):
        notes.append(Note("verdict.others_not_shown"))
    if result.is_short:
        notes.append(Note("verdict.short_encounters"))
    return tuple(notes)


def probability(result: Result, companions: Companions | None) -> tuple[Note, ...]:
    """Return how likely one system misses fewer encounters than the other, or why this is open."""
    if companions is None or companions.graded is None:
        return ()
    graded = companions.graded
    is_delivered, counts = are_delivered(result), counts_of(graded)
    if graded.reason:
        reason = {"reason": graded.reason, "is_delivered": is_delivered}
        return (Note("verdict.ungraded", **reason, **counts),)
    of_y = graded.y_better
    winner, share = ("y", of_y) if of_y >= HALF else ("x", 1 - of_y)
    more, fewer = graded.x_misses, graded.y_misses
    if winner == "y":
        more, fewer = fewer, more
    said = {"winner": winner, "share": round(100 * share), "more": more, "fewer": fewer}
    if not is_delivered:
        return (Note("verdict.graded", **said),)
    is_worse = alarm_ratio_limit(result, find_whole(result.dataset), winner) > ALARM_MARGIN
    return (Note("verdict.graded_delivered", margin=ALARM_MARGIN if is_worse else 0, **said),)


def counts_of(graded: Graded) -> dict[str, Any]:
    """Return the numbers behind the probability, as values of notes."""
    counts = {"x_misses": graded.x_misses, "y_misses": graded.y_misses}
    return counts | {"n": graded.n_units, "noun": graded.noun}


def _shown(result: Result, claim: Claim, row: Mapping[Hashable, Any]) -> Note:
    key, low, high = claim.key, row["low"], row["high"]
    interval = None
    if np.isfinite(low):
        interval = interval_text(low, high, evidence_form(key)) + shown_as(key, result)[1]
    of_p = {"p": row["p"], "p_corrected": claim.p}
    return Note("verdict.shown", key=key, winner=claim.winner, interval=interval, **of_p)


def strict_pairing(result: Result, strict: Result) -> tuple[Note, ...]:
    """Return the measures in which strict pairing reverses who is better."""
    better: dict[str, list[Note]] = {"x": [], "y": []}
    for key, form, unit in QUALITIES:
        if is_turned_strictly(key, result, strict):
            x, y = values_of(key, strict)
            note = Note("verdict.measure", key=key, x=x, y=y, form=form, unit=unit)
            better[winner_of(x - y, measure_of(key).better)].append(note)
    turned = [
        Note("verdict.better", winner=winner, measures=of) for winner, of in better.items() if of
    ]
    return (Note("verdict.strict", better=turned),) if turned else ()


def thresholds(result: Result) -> tuple[Note, ...]:
    """Name the systems that have scores but no confidence threshold."""
    systems = [
        letter
        for letter, system in result.sides
        if system.threshold is None and has_scores(result, letter)
    ]
    return (Note("verdict.unfiltered", systems=systems),) if systems else ()
