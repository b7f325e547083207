"""What the verdict says by topic, as facts."""

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
    has_primary,
    is_turned_strictly,
    values_of,
    winner_of,
)
from nvcore.evidence.companions import Companions, is_unsure
from nvcore.evidence.measures import primary_of
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.operating_points import (
    alarms_as_set,
    are_unequal,
    equal_setting,
    has_scores,
)
from nvcore.evidence.units import WHOLE
from nvcore.measures.table import evidence_form, has_several_recordings, measure_of, shown_as
from nvcore.measures.values import relevant_share
from nvcore.primary import DEFAULT
from nvcore.report.words import every_nth
from nvcore.schema import Category
from nvcore.sentences import facts
from nvcore.sentences.facts import Fact
from nvcore.wording import duration_text, interval_text, one_line, shortened

ENCOUNTERS: Final = "encounters_detected_by_unit"
HALF: Final = 0.5
"""With less of the events' time of pedestrians that count, saliency is mostly of others."""
NAME_WIDTH: Final = 40
"""Longest name of a recording."""
EPISODES: Final = "false_alert_episodes"


class QualityMeasure(NamedTuple):
    """A measure that the verdict puts side by side.

    Attributes
    ----------
    key
        Of `nvcore.measures.table.MEASURES`.
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


def operating_points(result: Result, companions: Companions | None) -> tuple[Fact, ...]:
    """How X and Y are set, where that is unequal, or was; none where they are set alike."""
    if result.as_set is not None:
        return (facts.AtEqualAlarms("numbers", equal_setting(result)),)
    if not are_unequal(result):
        return ()
    if companions is None or companions.equal is None:
        return (alarms_as_set(result, "comparison"),)
    as_set = alarms_as_set(result, "numbers")
    return as_set, facts.AtEqualAlarms("claims", equal_setting(companions.equal))


def question(result: Result, evidence: pd.DataFrame | None) -> tuple[Fact, ...]:
    """The primary measure and how it is tested; none where nothing has a p."""
    if evidence is None or not np.isfinite(evidence["p_corrected"]).any():
        return ()
    primary = primary_of(result.dataset)
    named = facts.Named(primary.key)
    if primary.is_changed:
        return (facts.Question("changed", named, primary.when),)
    if not has_primary(evidence, primary.key):
        return (facts.Question("untested", named),)
    if primary.key == DEFAULT and not primary.fixed_at:
        return (facts.Question("default", named),)
    return (facts.Question("chosen", named, primary.when),)


def encounters(result: Result, evidence: pd.DataFrame | None, support: Support) -> tuple[Fact, ...]:
    """Who detects more encounters, and p of that by recordings, unless it is withheld."""
    venn = result.venn
    test = None
    if evidence is not None and ENCOUNTERS not in support.withheld:
        row = evidence[evidence["figure"] == ENCOUNTERS].iloc[0]
        if row["unit"] in WHOLE:
            is_tested = np.isfinite(row["p_corrected"])
            p = facts.P(row["p"], row["p_corrected"]) if is_tested else None
            test = facts.Tested(
                int(row["n"]), p, str(row["unit"]).removesuffix("s"), is_unsure(row)
            )
    return (facts.Split(venn.n_near, venn.both, venn.x_only, venn.y_only, test),)


def weights(result: Result) -> tuple[Fact, ...]:
    """What the encounters cost that only one system detects, and the worst failure."""
    venn = result.venn
    of_x, of_y = (result.severity_of(system) for _, system in result.sides)
    costs = tuple(
        cost
        for cost in (
            facts.Cost("x", "y", venn.x_only, of_y[Category.X_ONLY]),
            facts.Cost("y", "x", venn.y_only, of_x[Category.Y_ONLY]),
        )
        if cost.n
    )
    return (*([facts.EncounterWeights(costs)] if costs else []), *_worst_failure(result))


def _worst_failure(result: Result) -> tuple[Fact, ...]:
    severity_s = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    if not len(severity_s[0]) or not max(values.max() for values in severity_s) > 0:
        return ()
    side = int(severity_s[1].max() > severity_s[0].max())
    row = int(severity_s[side].argmax())
    encounters = result.encounters
    name = str(result.dataset.recordings["name"].iloc[encounters.recording[row]])
    return (
        facts.WorstFailure(
            letter="xy"[side],
            track=str(encounters.track[row]),
            recording=shortened(one_line(name), NAME_WIDTH),
            seconds=float(severity_s[side][row]),
        ),
    )


def measures(result: Result, evidence: pd.DataFrame | None) -> tuple[Fact, ...]:
    """In which of the other measures X is better, in which Y, and which are the same."""
    measured: dict[str, list[facts.Measured]] = {"x": [], "y": [], "both": []}
    for key, form, unit in QUALITIES:
        x, y = (facts.Amount(value, form, unit) for value in _values(key, result, evidence))
        if np.isnan(x.value) or np.isnan(y.value):
            continue
        is_x = (x.value > y.value) == (measure_of(key).better == "higher")
        of_many = key == "saliency" and has_several_recordings(result)
        fact = facts.Measured(
            "mean saliency" if of_many else key,
            *((x, y) if is_x else (y, x)),
            extent=_extent(result) if key == EPISODES else "",
        )
        measured["both" if fact.are_equal else "x" if is_x else "y"].append(fact)
    return (
        *(facts.Has(who, tuple(of)) for who, of in measured.items() if of),
        *_far_away(result),
    )


def _extent(result: Result) -> str:
    """In which time there are episodes, and of which frames, where not of all."""
    every = every_nth(result.dataset.frame_columns)
    return f" in {duration_text(result.duration_s)}{every and f', {every}'}"


def _far_away(result: Result) -> tuple[Fact, ...]:
    """How little of the saliency is of pedestrians that count; none: half or more of both's."""
    shares = [facts.SystemShare(letter, relevant_share(system)) for letter, system in result.sides]
    if not any(of.share < HALF for of in shares):
        return ()
    return (facts.FarAway(tuple(of for of in shares if np.isfinite(of.share))),)


def _values(key: str, result: Result, evidence: pd.DataFrame | None) -> tuple[float, float]:
    """A measure of X and Y; NaN where undefined."""
    if key != MISS_RATE:
        is_defined = key != EPISODES or bool(result.duration_s)
        return values_of(key, result) if is_defined else (np.nan, np.nan)
    rows = [] if evidence is None else evidence[evidence["figure"] == key].to_dict("records")
    return (float(rows[0]["x"]), float(rows[0]["y"])) if rows else (np.nan, np.nan)


def chance(result: Result, evidence: pd.DataFrame | None, support: Support) -> tuple[Fact, ...]:
    """Which differences are more than chance, and why others that seem so are not claimed."""
    if evidence is None:
        return ()
    of_key = {row["figure"]: row for row in evidence.to_dict("records")}
    remarks: list[Fact] = []
    if support.claims:
        shown = (_shown(result, claim, of_key[claim.key]) for claim in support.claims)
        remarks.append(facts.MoreThanChance(tuple(shown)))
    for reason in dict.fromkeys(support.withheld.values()):
        withheld = (key for key in CLAIMED if support.withheld.get(key) == reason)
        remarks.append(facts.Unclaimed(tuple(map(facts.Named, withheld)), reason))
    settled = {*support.withheld, *(claim.key for claim in support.claims)}
    others = [row for key, row in of_key.items() if key in CLAIMED and key not in settled]
    if settled and any(np.isfinite(row["p_corrected"]) for row in others):
        remarks.append(facts.OthersNotShown())
    if result.is_short:
        remarks.append(facts.ShortEncounters())
    return tuple(remarks)


def _shown(result: Result, claim: Claim, row: Mapping[Hashable, Any]) -> facts.Shown:
    key, low, high = claim.key, row["low"], row["high"]
    interval = ""
    if np.isfinite(low):
        interval = interval_text(low, high, evidence_form(key)) + shown_as(key, result)[1]
    return facts.Shown(key, claim.winner, facts.P(row["p"], claim.p), interval)


def strict_pairing(result: Result, strict: Result) -> tuple[Fact, ...]:
    """Where strict pairing puts the other system first; none where it agrees."""
    better: dict[str, list[facts.OfBoth]] = {"x": [], "y": []}
    for key, form, unit in QUALITIES:
        if is_turned_strictly(key, result, strict):
            x, y = values_of(key, strict)
            of_both = facts.OfBoth(key, facts.Amount(x, form, unit), facts.Amount(y, form, unit))
            better[winner_of(x - y, measure_of(key).better)].append(of_both)
    turned = tuple(facts.Better(winner, tuple(of)) for winner, of in better.items() if of)
    return (facts.Strict(turned),) if turned else ()


def thresholds(result: Result) -> tuple[Fact, ...]:
    """Which systems have scores but no threshold."""
    letters = tuple(
        letter
        for letter, system in result.sides
        if system.threshold is None and has_scores(result, letter)
    )
    return (facts.Unfiltered(letters),) if letters else ()
