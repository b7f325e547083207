"""Exclusivity, fusion and saliency of a comparison, in sentences that claim no more than numbers.

The systems are called X and Y; these sentences contain no names from files.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import Any, Final, Literal

import numpy as np
import pandas as pd

from nvcore.columns import FrameColumns
from nvcore.comparison import Result
from nvcore.evidence.measures import ODDS_RATIO
from nvcore.evidence.operating_points import are_unequal
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.inputs.evaluated_frames import nth
from nvcore.measures.entry import MeasureTable
from nvcore.measures.table import has_several_recordings
from nvcore.measures.values import relevant_share
from nvcore.objects import Objects
from nvcore.params import Params
from nvcore.scoring import SystemResult
from nvcore.sentences.encounters import Correlated, Lead, Missed, Parted
from nvcore.sentences.facts import Fact
from nvcore.tables.classes import names_classes, read_share
from nvcore.tables.scorecard import ScoreRow, score_rows
from nvcore.wording import UNDEFINED, count_text, difference, number

FEW_MISSES: Final = 5
"""Fewest misses of a system for an explanation of phi."""


FUSION_RULE: Final = (
    "A fusion is of boxes, frame by frame (a pair counts once, by X's box), and an encounter then "
    "needs its share of matched frames like any other: so \u201cX or Y\u201d can detect one that "
    "neither system does, or not detect one that Y does; \u201cX and Y\u201d can lose one that "
    "both detect, in different frames; and as runs of false alarms break up, \u201cX and Y\u201d "
    "can have more episodes than either system."
)
"""Why the counts of fused systems are not those of the Venn diagram."""


def score_cells(rows: Iterable[ScoreRow], *, indent: str, mark: str = "") -> list[tuple[str, ...]]:
    """Measures as text: label, X, Y, X - Y, and which is better; `indent` marks parts.

    Labels of measures that need encounters of several frames end with `mark`.
    """
    return [
        (
            indent * row.level + row.label + (mark if row.needs_tracks else ""),
            *(number(value, row.form) for value in (row.x, row.y)),
            difference(row.x, row.y, row.form),
            row.better,
        )
        for row in rows
    ]


def scorecard_cells(result: Result, *, indent: str, mark: str = "") -> list[tuple[str, ...]]:
    """The scorecard, then how the encounters went, as `score_cells`."""
    return [
        *score_cells(score_rows(result), indent=indent, mark=mark),
        (f"how the {result.venn.n_near} encounters went:", "", "", "", ""),
        *score_cells(score_rows(result, MeasureTable.MISS_CLASSES), indent=indent, mark=mark),
    ]


def effect_text(row: Mapping[Hashable, Any]) -> str:
    """The size of a difference in a row of the table of evidence, with what it is measured in.

    Examples
    --------
    >>> effect_text({"effect": np.inf, "effect_name": ODDS_RATIO})
    'odds ∞'
    """
    if np.isnan(row["effect"]):
        return UNDEFINED
    name = "odds" if row["effect_name"] == ODDS_RATIO else "d_z"
    return f"{name} {'∞' if np.isinf(row['effect']) else number(row['effect'], '.2f')}"


def every_nth(frames: FrameColumns) -> str:
    """Which frames are evaluated: "every 10th frame"; empty where all are."""
    steps = [round(float(step)) for step in frames.sampling_step]
    sampled = sorted({step for step in steps if step > 1})
    if not sampled:
        return ""
    which = nth(sampled[0])
    if len(sampled) > 1:
        which += f" to {nth(sampled[-1])}"
    n_sampled = sum(step > 1 for step in steps)
    where = "" if n_sampled == len(steps) else f" of {n_sampled:,} of {len(steps):,} recordings"
    return f"every {which} frame{where}"


def n_frames_text(result: Result, noun: str = "frame") -> str:
    """How many frames are evaluated, and of how many, where not all are."""
    every = every_nth(result.dataset.frame_columns)
    return count_text(len(result.dataset.frames), noun) + (f" ({every})" if every else "")


def sampling_note(frames: FrameColumns) -> str:
    """A sentence for beside a rate per minute or hour; empty where every frame is evaluated."""
    every = every_nth(frames)
    if not every:
        return ""
    return (
        f"Only {every} is evaluated: per minute and per hour count those frames alone, over all "
        "the time between them."
    )


def missed(result: Result) -> Missed:
    """How many encounters X, Y and both do not detect."""
    e = result.exclusivity
    counts = result.venn.n_near, e.missed_by_x, e.missed_by_y, e.missed_by_both
    return Missed(*counts, e.jaccard, e.phi)


def parted(result: Result) -> Parted:
    """Whether the split between encounters that only one detects may be chance: McNemar's test."""
    x, y, p = result.venn.x_only, result.venn.y_only, result.mcnemar_p
    kind: Literal["none", "even", "short", "untested", "uneven", "chance"]
    if not x + y:
        kind = "none"
    elif x == y:
        kind = "even"
    elif result.is_short:
        kind = "short"
    elif np.isnan(p):
        kind = "untested"
    else:
        kind = "uneven" if p <= SIGNIFICANT else "chance"
    return Parted(kind, x, y, p, is_as_set=are_unequal(result))


def misses(result: Result) -> tuple[Fact, ...]:
    """Whether X and Y miss the same pedestrians.

    How many each system misses, how much the two sets of misses share (Jaccard index), how they
    correlate (phi), and how encounters part that only one system detects.
    """
    first = missed(result)
    if not first.n_missed:
        return (first,)
    few = min(first.by_x, first.by_y) < FEW_MISSES
    phi = [] if np.isnan(first.phi) else [Correlated("few" if few else "known", first.phi)]
    return (first, *phi, parted(result))


def lead(result: Result) -> Lead:
    """Which system matches a pedestrian first: mean and median lead time (positive: X first)."""
    lead_s = result.lead_time_s
    lead_s = lead_s[np.isfinite(lead_s)]
    if not len(lead_s):
        return Lead("none")
    mean_s, median_s = float(lead_s.mean()), float(np.median(lead_s))
    mean, median = round(mean_s, 2), round(median_s, 2)
    kind: Literal["neither", "usually", "apart", "clear"] = "clear"
    if not median:
        kind = "usually" if mean else "neither"
    elif mean * median < 0:
        kind = "apart"
    x, y = (int(np.count_nonzero(sign * lead_s > 0)) for sign in (1, -1))
    return Lead(kind, len(lead_s), x, y, mean_s, median_s)


def describe_fusion(fusion: pd.DataFrame, objects: Objects) -> tuple[str, ...]:
    """What each fused system gains and costs against the better single one, in sentences.

    Parameters
    ----------
    fusion
        `nvcore.tables.encounters.miss_classes.fusion_table`.
    """
    rows = {row["system"]: row for row in fusion.to_dict("records")}
    n = rows["x"]["encounters"]
    if not n:
        one = objects.singular
        return (f"No {one} came near enough to count, so a fusion can neither gain nor lose.",)
    # against the single system that detects more; X if they are equal
    best = max("xy", key=lambda letter: rows[letter]["encounters_detected"])
    return tuple(
        _fused_sentence(rows[kind], name, best, n)
        for kind, name in (("x_or_y", "X or Y"), ("x_and_y", "X and Y"))
    )


def _fused_sentence(row: dict[Hashable, Any], name: str, best: str, n: int) -> str:
    gain, more = row[f"gain_on_{best}"], row[f"more_episodes_than_{best}"]
    per_hour = row[f"more_episodes_per_hour_than_{best}"]
    encounters = (
        f"as many as {best.upper()} alone"
        if not gain
        else f"{abs(gain)} {'more' if gain > 0 else 'fewer'} than {best.upper()} alone"
    )
    rate = "" if np.isnan(per_hour) or not more else f" ({per_hour:+.0f} an hour)"
    alerts = (
        "and has as many false-alert episodes"
        if not more
        else f"{'and costs' if more > 0 else 'and saves'} "
        f"{count_text(abs(more), 'false-alert episode')}{rate}"
    )
    return (
        f"\u201c{name}\u201d detects {row['encounters_detected']} of {n} encounters, "
        f"{encounters}, {alerts}."
    )


def describe_saliency(result: Result) -> tuple[str, ...]:
    """How each system's saliency over all recordings comes about, a few sentences each."""
    return tuple(_saliency(result, letter.upper(), system) for letter, system in result.sides)


def saliency_caveat(params: Params) -> str:
    """What to know of a saliency that follows the paper's rule, a template; empty: of another."""
    if params.saliency_of != "most_salient":
        return ""
    return (
        "Only the most salient miss of a frame makes an event: two {people} missed side by side "
        "cut each other's events short, so that missing both can come out below missing one."
    )


def _saliency(result: Result, letter: str, system: SystemResult) -> str:
    events = system.events
    if events.empty:
        nobody = result.objects.say("{nobody}")
        return f"{letter} misses {nobody} by more than the tolerance: its saliency is 0."
    is_mean = has_several_recordings(result)
    n_events = count_text(len(events), "event")
    if result.params.saliency_aggregate == "sum":
        total_s, saliency_s = (float(events[name].sum()) for name in ("duration_s", "saliency_s"))
        weight = ""
        if result.params.saliency_weight == "risk":
            weight = f", which weigh {float(events['weight_s'].sum()):.2f} s"
        mean = f", {system.saliency_s:.2f} s a recording" if is_mean else ""
        text = (
            f"{letter}: {n_events}, {total_s:.1f} s in all{weight}; weighted by recency and added "
            f"they make {saliency_s:.2f} s{mean}."
        )
    elif is_mean:
        text = (
            f"{letter}: {n_events}. The largest of each recording makes {system.saliency_s:.2f} s "
            f"on average; the largest of all {_largest(result, events)}"
        )
    else:
        text = f"{letter}: the most salient of {n_events} {_largest(result, events)}"
    share = relevant_share(system)
    if share == 1:
        return f"{text} The missed {result.objects.plural} count (k >= 0.5) throughout."
    return result.objects.say(
        "{text} In {share:.0%} of the events' time the missed {one} counts (k >= 0.5); in the rest "
        "{he} is too far to count.",
        text=text,
        share=share,
    )


def _largest(result: Result, events: pd.DataFrame) -> str:
    """How the largest event comes about: "lasts ... s."."""
    worst = events.iloc[events["saliency_s"].argmax()]
    scope = "encounter" if result.params.saliency_scope == "encounter" else "recording"
    if result.params.recency_unit == "seconds":
        end = f"ends {worst['rest_s']:.1f} s before the end of the {scope}"
    else:
        end = f"ends when {worst['tau']:.0%} of the {scope} has passed"
    weight = ""
    if result.params.saliency_weight == "risk":
        weight = f", weighs {worst['weight_s']:.2f} s (weighted distance summed over time)"
    return (
        f"lasts {worst['duration_s']:.2f} s{weight} and {end}, which gives it the recency "
        f"{worst['recency']:.2f}: {worst['weight_s']:.2f} s × {worst['recency']:.2f} = "
        f"{worst['saliency_s']:.2f} s."
    )


def describe_read(result: Result, table: pd.DataFrame, letter: str) -> str:
    """How many of the matches of a system have the truth's class, with the interval.

    Parameters
    ----------
    table
        `nvcore.tables.classes.classes_table`.
    letter
        "x" or "y".
    """
    who = letter.upper()
    if not names_classes(result, dict(result.sides)[letter]):
        return f"{who} names no classes."
    right = read_share(table, letter)
    if not right.n:
        return f"{who}: – (no match has a class)."
    matches = count_text(right.n, "match", "matches")
    return (
        f"{who}: {right.share:.1%} of {matches} right, 95 % interval {right.low:.1%} to "
        f"{right.high:.1%} (Wilson; as if boxes were independent)."
    )
