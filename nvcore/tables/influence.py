"""Influence of single recordings on which system is ahead."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.values import (
    detected_by_recording,
    duration_of_recordings,
    episodes_by_recording,
    per_recording,
    severity_by_recording,
)
from nvcore.notes import Note

FORM: Final = ".3f"


def similarity_without_each(result: Result) -> pd.DataFrame:
    """Compute the mean similarity of both systems with each recording left out in turn.

    Returns
    -------
    A row for each recording with frames: recording (name), x and y (0 to 1, 1 is best). Empty if
    fewer than two recordings have frames.
    """
    frames = result.dataset.frame_columns
    n_frames = np.diff(frames.first)
    with_frames = np.flatnonzero(n_frames)
    if len(with_frames) < 2:
        with_frames = with_frames[:0]
    names = result.dataset.recordings["name"].to_numpy(dtype=object)
    columns = {"recording": names[with_frames]}
    for letter, system in result.sides:
        total = per_recording(result, system.similarity, frames.recording)
        others = (total.sum() - total[with_frames]) / (n_frames.sum() - n_frames[with_frames])
        columns[letter] = others
    return pd.DataFrame(columns)


def leads(result: Result) -> tuple[Note, ...]:
    """Return which system is ahead, and whether leaving out one recording changes that.

    The first note is about mean similarity, the second about encounters detected, severity and
    false-alert episodes, each per encounter near enough to count or per second. There are no notes
    if fewer than two recordings have frames, or no system is ahead. They say nothing about chance.
    """
    return (*_similarity_lead(result), *_other_leads(result))


def _similarity_lead(result: Result) -> tuple[Note, ...]:
    others = similarity_without_each(result)
    lead = 0.0 if others.empty else _lead(result.x.summary.mean, result.y.summary.mean)
    if not lead:
        return ()
    left = np.array([_lead(x, y) for x, y in zip(others["x"], others["y"], strict=True)])
    left *= np.sign(lead)
    ahead, behind = "xy" if lead > 0 else "yx"
    note = Note(
        "moments.lead",
        ahead=ahead,
        behind=behind,
        by=abs(lead),
        n_decide=int(np.count_nonzero(left <= 0)),
        least=float(left.min()),
        recording=others["recording"].iloc[int(left.argmin())],
    )
    return (note,)


def _lead(x: float, y: float) -> float:
    """Return X minus Y, rounded as shown."""
    return float(format(x - y, f"z{FORM}"))


def _other_leads(result: Result) -> tuple[Note, ...]:
    n_frames = np.diff(result.dataset.frame_columns.first)
    if np.count_nonzero(n_frames) < 2:
        return ()
    is_near = result.is_near
    n_near = per_recording(result, is_near.astype(float), result.encounters.recording)
    leads: dict[str, list[str]] = {"x": [], "y": [], "rests": []}
    for name, sums, of, sign in (
        ("encounters detected", detected_by_recording, n_near, 1),
        ("severity", severity_by_recording, n_near, -1),
        ("false-alert episodes", episodes_by_recording, duration_of_recordings(result), -1),
    ):
        apart = sign * (sums(result, result.x) - sums(result, result.y)).astype(float)
        lead = apart.sum()
        if not lead or not of.sum():
            continue
        others = np.sign(lead) * (lead - apart)[(n_frames > 0) & (of < of.sum())]
        if others.min(initial=np.inf) > 0:
            leads["x" if lead > 0 else "y"].append(name)
        else:
            leads["rests"].append(name)
    return (Note("moments.other_leads", **leads),) if any(leads.values()) else ()
