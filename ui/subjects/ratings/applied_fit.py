"""Applied fits, and whether they are in use with the ratings that they were fitted to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.settings.params import Params
from nvcore.subjects.ratings.fit import Fit
from ui.session import state
from ui.shell import live_params
from ui.subjects.ratings.source import RatingSource

FITS: Final = "rating_fits_taken"
MOST: Final = 8


@dataclass(frozen=True)
class AppliedFit:
    """Fitted settings that were applied to the sidebar, and previous ones, by name.

    It records the dataset's fingerprint and, as `RatingSource.rows`, the ratings that it was fitted
    to, but not their values: a participant who changes a rating adds no new evidence.
    """

    fitted: dict[str, Any]
    before: dict[str, Any]
    fingerprint: str
    rating_keys: np.ndarray
    is_simulated: bool

    def is_in_use(self, params: Params) -> bool:
        """Whether all fitted settings have their fitted values, regardless of other settings."""
        return all(
            math.isclose(live, value, rel_tol=1e-9)
            if isinstance(live := getattr(params, name), float) and isinstance(value, float)
            else live == value
            for name, value in self.fitted.items()
        )

    def share_seen(self, rating_source: RatingSource) -> float:
        """Return the share of these ratings that it was fitted to, 0..1, regardless of values."""
        return float(np.mean(np.isin(rating_source.rows(), self.rating_keys)))


def _fits_in_use(result: Result) -> list[AppliedFit]:
    """Return the fits in use, newest first."""
    return [
        fit
        for fit in _all()
        if fit.fingerprint == result.dataset.fingerprint and fit.is_in_use(result.params)
    ]


def in_use(result: Result, rating_source: RatingSource) -> AppliedFit | None:
    """Return the fit in use that used most of these ratings, or None if no fit used any."""
    most = max(_fits_in_use(result), key=lambda fit: fit.share_seen(rating_source), default=None)
    return most if most is not None and most.share_seen(rating_source) > 0 else None


def of_simulated(result: Result, rating_source: RatingSource) -> bool:
    """Whether the settings in use were fitted to simulated ratings, while these are real."""
    return not rating_source.is_simulated and any(fit.is_simulated for fit in _fits_in_use(result))


def apply(
    fit: Fit,
    start: Params,
    rating_source: RatingSource,
    fingerprint: str,
    fit_in_use: AppliedFit | None,
) -> None:
    """Move the sidebar to a fit that was compared with `start`. Other settings are reset."""
    before = {name: getattr(start, name) for name in fit.changed}
    newest = AppliedFit(
        fit.changed, before, fingerprint, rating_source.rows(), rating_source.is_simulated
    )
    state.workspace().notes[FITS] = [newest, *_others(fit_in_use)][:MOST]
    _set({**(fit_in_use.before if fit_in_use else {}), **fit.changed})


def undo(fit_in_use: AppliedFit) -> None:
    """Move the sidebar to the settings before the fit."""
    state.workspace().notes[FITS] = _others(fit_in_use)
    _set(fit_in_use.before)


def _all() -> list[AppliedFit]:
    fits: list[AppliedFit] = state.workspace().notes.get(FITS, [])
    return fits


def _others(fit_in_use: AppliedFit | None) -> list[AppliedFit]:
    return [fit for fit in _all() if fit is not fit_in_use]


def _set(values: dict[str, Any]) -> None:
    changes = {
        name: live_params.slider_start(name) if value is None else value
        for name, value in values.items()
    }
    state.set_params(**changes)
