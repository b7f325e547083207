"""Score thresholds of a rating session's clips, beside those of the open comparison."""

from __future__ import annotations

from collections.abc import Mapping

from nvcore.subjects.ratings.clip_task import RatingStudy
from ui.session import state


def shown_thresholds() -> dict[str, float | None]:
    """Return the score threshold of each compared system, by name."""
    settings = state.params()
    values = (settings.threshold_x, settings.threshold_y)
    return {
        name: value for name, value in zip(state.systems(), values, strict=True) if name is not None
    }


def thresholds_apart(study: RatingStudy) -> dict[str, tuple[float | None, float | None]]:
    """Return (threshold of the clips, current threshold) of each system where they differ."""
    live, apart = shown_thresholds(), {}
    for name, value in live.items():
        span = state.score_span(name)
        if span is None or name not in study.thresholds:
            continue
        threshold = study.thresholds[name]
        if threshold is not None:
            threshold = None if threshold <= span[0] else min(threshold, span[1])
        if value != threshold:
            apart[name] = threshold, value
    return apart


def set_thresholds(of: Mapping[str, float | None]) -> None:
    """Set the thresholds of these systems for the next run, if they are compared."""
    for letter, name in zip("xy", state.systems(), strict=True):
        if name is not None and name in of:
            state.set_threshold(letter, of[name])
