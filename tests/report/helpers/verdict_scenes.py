"""Results and tables of evidence that verdicts are about, and what a verdict says on a topic."""

from __future__ import annotations

from typing import Any

import pandas as pd
from builders import NAN, Box, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.measures import significance_table
from nvcore.report.verdict import Verdict, verdict

N_FRAMES = 3
"""Frames in which a pedestrian is seen."""


def detecting(
    n: int, by_x: range, by_y: range, alarms_y: int = 0, n_frames: int = N_FRAMES
) -> Result:
    """`n` pedestrians, each alone in `n_frames` frames; each system sees some of them."""

    truth = [at(n_frames * i + f, 50, track=i) for i in range(n) for f in range(n_frames)]

    def seen(whom: range) -> list[Box]:
        return [
            box._replace(track=-1, score=1.0 if box.frame else 0.9)
            for box in truth
            if box.track in whom
        ]

    y = seen(by_y) + [at(f, 5, score=1.0) for f in range(alarms_y)]
    dataset = make_dataset(truth, seen(by_x), y, n_frames=n_frames * n)
    return result_of(dataset)


def row_of(
    figure: str,
    p_corrected: float,
    low: float = NAN,
    high: float = NAN,
    *,
    difference: float = 1.0,
    better: str = "higher",
    unit: str = "recordings",
    n: int = 12,
    doubt: str = "",
) -> dict[str, object]:
    """A row of the table of evidence."""
    return {
        "figure": figure, "p": p_corrected / 2, "p_corrected": p_corrected,
        "low": low, "high": high, "x": 1.0, "y": 2.0,
        "difference": difference, "better": better, "unit": unit, "n": n, "doubt": doubt,
        "least_p": 2 / 2**n, "note": "",
    }  # fmt: skip


BY_UNIT = "encounters_detected_by_unit"


def verdict_by(result: Result, *rows: dict[str, object], companions: bool = True) -> Verdict:
    """The verdict by this evidence, which holds at equal false alarms as well."""
    table = pd.DataFrame([row_of(BY_UNIT, NAN), *rows])
    table = table.drop_duplicates("figure", keep="last").reset_index(drop=True)
    both = Companions(result, table, result) if companions else None
    return verdict(result, evidence=table, companions=both)


def said(text: Verdict, topic: str) -> tuple[Any, ...]:
    """The facts of a verdict on a topic; none: it says nothing on it."""
    return next((point.notes for point in text.points if point.topic == topic), ())


def whole_verdict(result: Result) -> Verdict:
    """The verdict with the evidence and the companions that belong to the result."""
    evidence = significance_table(result)
    return verdict(result, evidence=evidence, companions=find_companions(result, evidence))
