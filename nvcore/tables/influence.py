"""Whether who is ahead rests on a single recording."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.measures.values import (
    detected_by_recording,
    duration_of_recordings,
    episodes_by_recording,
    per_recording,
    severity_by_recording,
)
from nvcore.wording import listed

FORM: Final = ".3f"


def similarity_without_each(result: Result) -> pd.DataFrame:
    """Mean similarity of both systems over all frames but those of one recording.

    Returns
    -------
    A row for each recording with frames: recording (name), x and y (0 to 1, 1 is best). Empty where
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


def lead_text(result: Result) -> str:
    """Who is ahead in mean similarity, and whether leaving out one recording changes that.

    A sentence with a recording's name as it is; empty where nobody is ahead, or only one recording
    has frames. It says nothing of chance.
    """
    others = similarity_without_each(result)
    if others.empty:
        return ""
    lead = _lead(result.x.summary.mean, result.y.summary.mean)
    if not lead:
        return ""
    ahead, behind = ("X", "Y") if lead > 0 else ("Y", "X")
    leads = np.array([_lead(x, y) for x, y in zip(others["x"], others["y"], strict=True)])
    leads *= np.sign(lead)
    least, name = leads.min(), others["recording"].iloc[int(leads.argmin())]
    first = f"{ahead} is ahead by {abs(lead):{FORM}} in mean similarity"
    n_decide = int(np.count_nonzero(leads <= 0))
    if not n_decide:
        return (
            f"{first}, whichever recording is left out: by {least:{FORM}} or more (least without "
            f"{name})."
        )
    who = f"{behind} would be, by {-least:{FORM}}" if least < 0 else "neither would be"
    rests = (
        "that rests on one recording" if n_decide == 1 else f"any of {n_decide} recordings decides"
    )
    return f"{first}, but {rests}: without {name} {who}."


def _lead(x: float, y: float) -> float:
    """X minus Y, as shown."""
    return float(format(x - y, f"z{FORM}"))


def other_leads_text(result: Result) -> str:
    """The same of encounters detected, severity and false-alert episodes, in short.

    Each per encounter near enough to count, or per second. Empty where fewer than two recordings
    have frames, or nobody is ahead in any of them.
    """
    n_frames = np.diff(result.dataset.frame_columns.first)
    if np.count_nonzero(n_frames) < 2:
        return ""
    is_near = result.is_near
    n_near = per_recording(result, is_near.astype(float), result.encounters.recording)
    stays: dict[str, list[str]] = {"X": [], "Y": []}
    rests = []
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
            stays["X" if lead > 0 else "Y"].append(name)
        else:
            rests.append(name)
    leads = [f"{letter} stays ahead in {listed(names)}" for letter, names in stays.items() if names]
    sentences = [f"With any one left out, {', and '.join(leads)}."] if leads else []
    if rests:
        sentences.append(f"Who is ahead in {listed(rests)} rests on one recording.")
    return " ".join(sentences)
