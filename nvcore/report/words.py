"""Notes on misses, fusion and saliency, and cells for tables."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.wording import UNDEFINED, count_text, difference, interval_text, number
from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import MeasureTable
from nvcore.comparison.measures.table import evidence_form, has_several_recordings
from nvcore.comparison.measures.values import relevant_share
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.dataset.columns import FrameColumns
from nvcore.evidence.measures import ODDS_RATIO, Evidence
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.units import BLOCKS, MIN_RECORDINGS, count_whole
from nvcore.inputs.evaluated_frames import nth
from nvcore.notes import Note
from nvcore.settings.params import Params
from nvcore.tables.classes import names_classes, read_share
from nvcore.tables.scorecard import ScoreRow, score_rows

FEW_MISSES: Final = 5
"""Phi is explained only if both systems have at least this many misses."""

WITHIN: Final = "*"
WITHIN_NOTE: Final = "within these recordings alone"
"""Mark and footnote of an interval that says nothing about other recordings."""


def score_cells(rows: Iterable[ScoreRow], *, indent: str, mark: str = "") -> list[tuple[str, ...]]:
    """Return table rows of label, X, Y, X - Y, and which direction is better.

    `indent` precedes the labels of parts. Labels of measures that need encounters of several frames
    end with `mark`.
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
    """Return table rows of the scorecard, then of the outcomes of encounters."""
    return [
        *score_cells(score_rows(result), indent=indent, mark=mark),
        (f"how the {count_text(result.venn.n_near, 'encounter')} went:", "", "", "", ""),
        *score_cells(score_rows(result, MeasureTable.MISS_CLASSES), indent=indent, mark=mark),
    ]


def interval_cell(of: Evidence, notes: Footnotes) -> tuple[str, str]:
    """Return the interval of a difference, and a footnote's mark if there is no interval."""
    interval = interval_text(of.low, of.high, evidence_form(of.figure))
    if interval == UNDEFINED:
        reason = of.note.partition("; ")[0]
        return interval, notes.mark(reason) if reason else ""
    if of.unit == BLOCKS:
        notes.mark(WITHIN_NOTE, WITHIN)
        return f"{interval} {WITHIN}", ""
    return interval, ""


def difference_cell(of: Evidence) -> str:
    """Return the difference between X and Y with its sign."""
    return difference(of.x, of.y, evidence_form(of.figure))


def effect_text(row: Mapping[Hashable, Any]) -> str:
    """Return a row's effect size as text, with the kind of effect size.

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
    """Return which frames are evaluated ("every 10th frame"), or "" if all are."""
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
    """Return the number of evaluated frames, with "every 10th" or the like if not all are."""
    every = every_nth(result.dataset.frame_columns)
    return count_text(len(result.dataset.frames), noun) + (f" ({every})" if every else "")


def sampling_note(frames: FrameColumns) -> str:
    """Return a caution about rates per minute or hour if frames are sampled, else ""."""
    every = every_nth(frames)
    if not every:
        return ""
    return (
        f"Only {every} is evaluated: per minute and per hour count those frames alone, over all "
        "the time between them."
    )


def at_best(dataset: Dataset) -> tuple[Note, ...]:
    """Return what so few recordings could show at best. Empty if they are many."""
    n, noun = count_whole(dataset)
    if n > MIN_RECORDINGS:
        return ()
    n_needed = None if n == MIN_RECORDINGS else MIN_RECORDINGS
    return (Note("verdict.at_best", n=n, noun=noun, n_needed=n_needed),)


def missed(result: Result) -> Note:
    """Return how many encounters X misses, Y misses, and both miss."""
    e = result.exclusivity
    return Note(
        "encounters.missed",
        n=result.venn.n_near,
        by_x=e.missed_by_x,
        by_y=e.missed_by_y,
        by_both=e.missed_by_both,
        jaccard=e.jaccard,
        phi=e.phi,
    )


def parted(result: Result) -> Note:
    """Return how many encounters only one system detects, with the p-value of McNemar's test."""
    p = result.mcnemar_p
    return Note(
        "encounters.parted",
        x=result.venn.x_only,
        y=result.venn.y_only,
        is_short=result.is_short,
        p=None if np.isnan(p) else p,
        is_uneven=bool(p <= SIGNIFICANT),
    )


def misses(result: Result) -> tuple[Note, ...]:
    """Return notes on whether X and Y miss the same pedestrians.

    The notes give the misses of each system, the overlap of the two sets (Jaccard index), their
    correlation (phi), and how many encounters only X or only Y detects.
    """
    first, e = missed(result), result.exclusivity
    if not e.missed_by_x + e.missed_by_y:
        return (first,)
    if np.isnan(e.phi):
        return (first, parted(result))
    are_few = min(e.missed_by_x, e.missed_by_y) < FEW_MISSES
    correlated = Note("encounters.few_misses" if are_few else "encounters.correlated", phi=e.phi)
    return (first, correlated, parted(result))


def lead(result: Result) -> Note:
    """Return which system matches a pedestrian first: mean and median lead (positive: X first)."""
    lead_s = result.lead_time_s
    lead_s = lead_s[np.isfinite(lead_s)]
    if not len(lead_s):
        return Note("encounters.lead", n=0)
    x, y = (int(np.count_nonzero(sign * lead_s > 0)) for sign in (1, -1))
    mean_s, median_s = float(lead_s.mean()), float(np.median(lead_s))
    return Note("encounters.lead", n=len(lead_s), x=x, y=y, mean_s=mean_s, median_s=median_s)


def fusion_gains(fusion: pd.DataFrame) -> tuple[Note, ...]:
    """Return what fusing both systems gains and costs compared to the better single system.

    Parameters
    ----------
    fusion
        Table of `nvcore.tables.encounters.miss_classes.fusion_table`.
    """
    rows = {row["system"]: row for row in fusion.to_dict("records")}
    n = rows["x"]["encounters"]
    if not n:
        return (Note("encounters.no_fusion"),)
    # compare with the single system that detects more, or with X if they are equal
    best = max("xy", key=lambda letter: rows[letter]["encounters_detected"])
    return tuple(
        Note(
            "encounters.fused",
            system=system,
            detected=rows[system]["encounters_detected"],
            n=n,
            gain=rows[system][f"gain_on_{best}"],
            best=best,
            more_episodes=rows[system][f"more_episodes_than_{best}"],
        )
        for system in ("x_or_y", "x_and_y")
    )


def saliencies(result: Result) -> tuple[Note, ...]:
    """Explain how each system's saliency over all recordings comes about."""
    return tuple(_saliency_of(result, letter, system) for letter, system in result.sides)


def saliency_caveat(params: Params) -> tuple[Note, ...]:
    """Return a caution about saliency if it follows the paper's rule, else nothing."""
    return (Note("saliency.side_by_side"),) * (params.saliency_of == "most_salient")


def _saliency_of(result: Result, letter: str, system: SystemResult) -> Note:
    events, params = system.events, result.params
    if events.empty:
        return Note("saliency.none", system=letter)
    shared = {
        "system": letter,
        "n": len(events),
        "mean_s": system.saliency_s if has_several_recordings(result) else None,
        "relevance": Note("saliency.relevance", share=relevant_share(system)),
    }
    is_by_risk = params.saliency_weight == "risk"
    if params.saliency_aggregate == "sum":
        total = events[["duration_s", "weight_s", "saliency_s"]].sum()
        return Note(
            "saliency.sum",
            **shared,
            duration_s=total["duration_s"],
            weight_s=total["weight_s"] if is_by_risk else None,
            saliency_s=total["saliency_s"],
        )
    worst = events.iloc[events["saliency_s"].argmax()]
    in_seconds = params.recency_unit == "seconds"
    return Note(
        "saliency.largest",
        **shared,
        **worst[["duration_s", "weight_s", "recency", "saliency_s"]],
        is_by_risk=is_by_risk,
        rest_s=worst["rest_s"] if in_seconds else None,
        passed=None if in_seconds else worst["tau"],
        scope=params.saliency_scope,
    )


def classes_read(result: Result, table: pd.DataFrame, letter: str) -> Note:
    """Return the share of a system's matches that have the true class, with a Wilson 95 % interval.

    Parameters
    ----------
    table
        Table of `nvcore.tables.classes.classes_table`.
    letter
        "x" or "y".
    """
    if not names_classes(result, dict(result.sides)[letter]):
        return Note("encounters.no_classes", system=letter)
    right = read_share(table, letter)
    if not right.n:
        return Note("encounters.classes_read", system=letter, n=0)
    interval = {"low": right.low, "high": right.high}
    return Note("encounters.classes_read", system=letter, n=right.n, share=right.share, **interval)
