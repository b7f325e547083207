"""The file of all rating sessions; whether clips show what is compared."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nvcore.ratings.store import RatingStore, Study
from ui.people.studies import Studies
from ui.session import state

SESSIONS: Final = Studies[Study, RatingStore](
    page="ratings",
    what="rating session",
    prefix="rating",
    variable="NVCORE_RATINGS",
    file_name="ratings.sqlite",
    open=RatingStore,
)


def shown_thresholds() -> dict[str, float | None]:
    """Score threshold of each compared system, by name."""
    settings = state.params()
    values = (settings.threshold_x, settings.threshold_y)
    return {
        name: value for name, value in zip(state.systems(), values, strict=True) if name is not None
    }


def thresholds_apart(study: Study) -> dict[str, tuple[float | None, float | None]]:
    """Compared systems whose threshold is not that of the clips, by name: of the clips, and now."""
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
    """Give the compared systems of these names these thresholds in the next run."""
    for letter, name in zip("xy", state.systems(), strict=True):
        if name is not None and name in of:
            state.set_threshold(letter, of[name])
