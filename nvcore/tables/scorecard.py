"""The scorecard's rows as a table: what the terminal prints and the dashboard shows."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from nvcore.comparison import Result
from nvcore.schema import MissClass
from nvcore.tables.result import system_summary

HIGHER: Final = "higher"
LOWER: Final = "lower"


class ScoreRow(NamedTuple):
    """One figure of both systems.

    Attributes
    ----------
    label
        What it is, with unit and denominator.
    x, y
        Values; NaN undefined.
    form
        Python's format of the values.
    better
        ``higher`` or ``lower``; empty in a heading.
    level
        0, or 1 for a part of the row above.
    """

    label: str
    x: float
    y: float
    form: str
    better: str
    level: int = 0


def score_rows(result: Result) -> list[ScoreRow]:
    """The figures of the scorecard, without how the encounters went."""
    venn, low = result.venn, result.params.low
    largest = "largest event" if result.params.saliency_aggregate == "max" else "sum of events"
    x, y = (system_summary(result, system) for _, system in result.sides)
    figures: tuple[tuple[str, str, str, str, int], ...] = (
        ("mean similarity", "mean_similarity", ".4f", HIGHER, 0),
        ("minimum similarity", "min_similarity", ".4f", HIGHER, 0),
        ("5th percentile similarity", "percentile_5_similarity", ".4f", HIGHER, 0),
        (f"frames with similarity below {low:g}", "share_low", ".1%", LOWER, 0),
        (f"saliency, {largest} (s)", "saliency", ".3f", LOWER, 0),
        (f"encounters detected, of {venn.n_near}", "encounters_detected", "d", HIGHER, 0),
        (
            f"boxes matched, near or far, of {int(result.n_truth.sum())}",
            "boxes_matched", "d", HIGHER, 0,
        ),
        ("false alarms per frame", "false_alarms_per_frame", ".3f", LOWER, 0),
        ("false-alert episodes", "false_alert_episodes", "d", LOWER, 0),
        ("per hour", "false_alert_episodes_per_hour", ".1f", LOWER, 1),
        ("longest (s)", "longest_episode_s", ".2f", LOWER, 1),
    )  # fmt: skip
    rows = [
        ScoreRow(label, x[key], y[key], form, better, level)
        for label, key, form, better, level in figures
    ]
    n_of = np.diff(result.dataset.frame_columns.first)
    if np.count_nonzero(n_of) > 1:
        at = 1 + [row.label for row in rows].index(f"saliency, {largest} (s)")
        mean_x, mean_y = (
            float(result.saliency_of_recordings(system)[n_of > 0].mean())
            for _, system in result.sides
        )
        rows.insert(at, ScoreRow("mean over recordings (s)", mean_x, mean_y, ".3f", LOWER, 1))
    return rows


def class_rows(result: Result) -> list[ScoreRow]:
    """How the near encounters went: a row for each miss class."""
    x, y = (_classes(system_summary(result, system)) for _, system in result.sides)
    return [
        ScoreRow(
            "no failure" if kind is MissClass.NONE else kind.value.replace("_", " "),
            x[kind.value], y[kind.value], "d",
            HIGHER if kind is MissClass.NONE else LOWER, 1,
        )
        for kind in MissClass
    ]  # fmt: skip


def _classes(summary: dict[str, Any]) -> dict[str, int]:
    classes: dict[str, int] = summary["miss_classes"]
    return classes
