"""Fits that were applied, and whether they are in use with the ratings that they were made from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from nvcore.comparison import Result
from nvcore.params import Params
from nvcore.ratings.fit import Fit
from ui.ratings.source import RatingSource
from ui.session import state
from ui.shell import live_params

FITS: Final = "rating_fits_taken"
MOST: Final = 8


@dataclass(frozen=True)
class AppliedFit:
    """Fitted settings that were put into the sidebar, and those before, by name.

    Knows the dataset's fingerprint, and by `RatingSource.rows` the ratings that it was fitted to,
    not their values: who rates a clip otherwise the second time is no new evidence.
    """

    fitted: dict[str, Any]
    before: dict[str, Any]
    fingerprint: str
    rating_keys: np.ndarray
    is_simulated: bool

    def is_in_use(self, params: Params) -> bool:
        """Whether all that was fitted has the fitted values, whatever else has moved."""
        return all(
            math.isclose(live, value, rel_tol=1e-9)
            if isinstance(live := getattr(params, name), float) and isinstance(value, float)
            else live == value
            for name, value in self.fitted.items()
        )

    def share_seen(self, rating_source: RatingSource) -> float:
        """Return the share of these ratings that it was fitted to, 0..1, whatever their values."""
        return float(np.mean(np.isin(rating_source.rows(), self.rating_keys)))


def _fits_in_use(result: Result) -> list[AppliedFit]:
    """Fits in use now, the newest first."""
    return [
        fit
        for fit in _all()
        if fit.fingerprint == result.dataset.fingerprint and fit.is_in_use(result.params)
    ]


def in_use(result: Result, rating_source: RatingSource) -> AppliedFit | None:
    """Return the fit in use that was made from most of these ratings, or None if from none."""
    most = max(_fits_in_use(result), key=lambda fit: fit.share_seen(rating_source), default=None)
    return most if most is not None and most.share_seen(rating_source) > 0 else None


def of_simulated(result: Result, rating_source: RatingSource) -> bool:
    """Whether the settings in use were fitted to simulated ratings, and these are not."""
    return not rating_source.is_simulated and any(fit.is_simulated for fit in _fits_in_use(result))


def apply(
    fit: Fit,
    start: Params,
    rating_source: RatingSource,
    fingerprint: str,
    fit_in_use: AppliedFit | None,
) -> None:
    """Move the sidebar to a fit, compared with `start`. Settings without a fitted value go back."""
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
