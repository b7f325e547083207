"""Which fitted settings were taken, and whether they are in use with the ratings they are from."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import streamlit as st

from nvcore.analysis import Result
from nvcore.params import Params
from nvcore.ratings.fit import Fit
from ui import live_params, state
from ui.ratings_source import Given

KEPT: Final = "rating_fits_taken"
MOST: Final = 8
LEAST_SEEN: Final = 0.5
"""Ratings are those that a fit has seen if it has seen so large a share of them: one more
participant, or one left out, makes no new evidence."""


@dataclass(frozen=True)
class Taken:
    """Fitted settings that somebody has taken.

    Attributes
    ----------
    fitted, before
        The parameters that the fit changed, and their values before, by name.
    fingerprint
        Of the dataset.
    seen
        `Given.rows` that it was fitted to.
    is_simulated
        Whether nobody was asked for those.
    """

    fitted: dict[str, Any]
    before: dict[str, Any]
    fingerprint: str
    seen: np.ndarray
    is_simulated: bool

    def is_in_use(self, params: Params) -> bool:
        """Whether all that was fitted has the fitted values, whatever else has moved."""
        return all(_is_same(getattr(params, name), one) for name, one in self.fitted.items())

    def has_seen(self, given: Given) -> bool:
        """Whether it was fitted to these ratings, or to most of them."""
        return bool(np.mean(np.isin(given.rows(), self.seen)) >= LEAST_SEEN)

    def is_of(self, fit: Fit) -> bool:
        """Whether these are the settings of that fit."""
        return self.fitted == fit.changed

    def settings_before(self, params: Params) -> Params:
        """The live parameters with the values before the fit."""
        return replace(params, **self.before)


def _is_same(live: Any, fitted: Any) -> bool:
    if isinstance(live, float) and isinstance(fitted, float):
        return math.isclose(live, fitted, rel_tol=1e-9)
    return bool(live == fitted)


def _kept(result: Result) -> list[Taken]:
    """What was taken and is in use now, the newest first."""
    return [
        one
        for one in st.session_state.get(KEPT, ())
        if one.fingerprint == result.dataset.fingerprint and one.is_in_use(result.params)
    ]


def in_use(result: Result, given: Given) -> Taken | None:
    """The fit to these ratings that is in use; None where the settings are not from them."""
    return next((one for one in _kept(result) if one.has_seen(given)), None)


def of_simulated(result: Result, given: Given) -> bool:
    """Whether the settings in use were fitted to other ratings, which were simulated."""
    return any(one.is_simulated and not one.has_seen(given) for one in _kept(result))


def take(fit: Fit, start: Params, given: Given, fingerprint: str, taken: Taken | None) -> None:
    """Move the sidebar to the settings of the fit.

    Parameters
    ----------
    fit, start
        The fit, and the settings that it was compared with.
    taken
        The fit that is in use now, whose values go where `fit` has none.
    """
    before = {name: getattr(start, name) for name in fit.changed}
    one = Taken(fit.changed, before, fingerprint, given.rows(), given.is_simulated)
    st.session_state[KEPT] = [one, *_others(taken)][:MOST]
    _set({**(taken.before if taken else {}), **fit.changed})


def give_back(taken: Taken) -> None:
    """Move the sidebar to the settings before the fit."""
    st.session_state[KEPT] = _others(taken)
    _set(taken.before)


def _others(taken: Taken | None) -> list[Taken]:
    return [one for one in st.session_state.get(KEPT, ()) if one is not taken]


def _set(values: dict[str, Any]) -> None:
    shown = {
        name: live_params.default_of_height(name) if one is None else one
        for name, one in values.items()
    }
    state.set_params(**shown)
