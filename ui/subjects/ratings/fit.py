"""Ratings page: saliency parameters fitted to the ratings, and the gain of the fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.progress import Progress
from nvcore.common.wording import count_text, minus, percent
from nvcore.comparison.compare import Result, compare
from nvcore.settings.params import SETTINGS, Params
from nvcore.subjects.ratings.fit import Fit, fit_saliency
from ui.jobs.background import JobState
from ui.jobs.page_run import PageRun
from ui.session import state
from ui.shell import live_params
from ui.subjects.ratings import applied_fit
from ui.subjects.ratings.applied_fit import AppliedFit
from ui.subjects.ratings.source import RatingSource
from ui.widgets.buttons import button
from ui.widgets.text import docs_link, plain

AT_ONCE: Final = 20_000
"""Number of frames up to which a fit takes seconds and runs while the page waits."""
RUN: Final = PageRun[Fit]("rating_fit", "fit", "Fitting")
MOST_FITS: Final = 4
SIMULATED: Final = "Fitted to **simulated ratings**: nobody was asked."


def draw(
    result: Result,
    of_clips: Result,
    clips: pd.DataFrame,
    ratings_key: object,
    rating_source: RatingSource,
    fit_in_use: AppliedFit | None,
) -> None:
    """Draw the button that fits, and the results.

    If a fit that used some of these ratings is in use, the gain is relative to the settings before
    it. The recordings of `of_clips` are the clips. `ratings_key` identifies the ratings.
    """
    st.header("Fit saliency to these ratings")
    st.caption(
        "Tries tolerance, whose misses make events, what an event weighs, recency, aggregate and "
        "height sigmoid in many combinations, and takes those settings that put most pairs of "
        "clips in the order in which people put them "
        f"({docs_link('how it is judged', 'the-fit', doc='ratings')})."
    )
    start = replace(result.params, **(fit_in_use.before if fit_in_use else {}))
    key = ratings_key, result.x.name, result.y.name, start
    fit: Any = state.workspace().peek("rating_fit", key)
    if fit is None:
        fit = _ask(of_clips, start, clips, key)
    if fit is not None:
        with st.container(border=True, key="rating_fit_found"):
            _draw_worth(fit, "settings in use" if fit_in_use is None else "settings before")
            _draw_settings(result, fit, start, rating_source, fit_in_use)
    elif fit_in_use is not None:
        _draw_in_use(fit_in_use)


def _keep(key: Any, fit: Fit) -> Fit:
    return state.workspace().cached("rating_fit", key, lambda: fit, most=MOST_FITS)


def _ask(result: Result, start: Params, clips: pd.DataFrame, key: Any) -> Fit | None:
    """Draw the button or the progress of the fit. Return the fit if it is computed at once."""
    job = RUN.job
    if job is not None and job.key == key:
        job_state = RUN.draw(job)
        if job_state.is_busy:
            return None
        if job_state is JobState.DONE and job.output is not None:
            return _keep(key, job.output)
    if not button("Fit saliency to these ratings", key="rating_fit", icon=":material/tune:"):
        return None

    def compute(progress: Progress) -> Fit:
        x, y = result.names
        started = compare(result.dataset, start, x=x, y=y, previous=result)
        return fit_saliency(started, clips, progress=progress)

    if len(result.dataset.frames) > AT_ONCE:
        RUN.start(compute, key=key)
        st.rerun()
    bar = st.progress(0.0, "Fitting")

    def show(share: float, _what: str) -> None:
        bar.progress(share, "Fitting")

    try:
        return _keep(key, compute(show))
    except InputError as error:
        st.info(plain(str(error)))
        return None
    finally:
        bar.empty()


def _draw_worth(fit: Fit, start: str) -> None:
    """Draw the shares of pairs for the settings called `start` and for the fit."""
    st.markdown("**Share of the pairs of clips in the order in which people put them**")
    columns = st.columns(3)
    columns[0].metric(start, percent(fit.share_default))
    columns[1].metric("fit, on recordings left out", percent(fit.share_fitted))
    columns[2].metric("fit, on what it has seen", percent(fit.share_training))
    if fit.reason:
        columns[1].caption(f"No interval: {plain(fit.reason)}.")
    else:
        columns[1].caption(f"95 %: {percent(fit.low)} to {percent(fit.high)}")
    st.caption(
        f"{count_text(fit.n_pairs, 'pair')} of {count_text(fit.n_clips, 'clip')}, "
        f"{fit.n_settings:,} combinations tried; 50% is chance. **The second number is the "
        "result**: each pair is judged by a fit that has seen neither of its recordings. The "
        "third is too good by construction."
    )
    if fit.changed:
        st.markdown(_gain(fit, start))


def _gain(fit: Fit, start: str) -> str:
    """Describe the gain of the fit on unseen recordings, and whether it may be due to chance."""
    gain = fit.share_fitted - fit.share_default
    if gain <= 0:
        return (
            f"On recordings that it has not seen, the fit is **no better than the {start}**: these "
            "ratings give no reason to change them."
        )
    gain_text = f"Against the {start}, the fit gains {100 * gain:.0f} points"
    if not np.isfinite(fit.gain_low):
        return f"{gain_text}. Whether that is more than chance cannot be told."
    low, high = (
        minus(f"{100 * share:+z.0f}").replace("+0", "0") for share in (fit.gain_low, fit.gain_high)
    )
    return (
        f"{gain_text} (95 %: {low} to {high}, from resampling the {fit.n_recordings} recordings)"
        f"{'.' if fit.gain_low > 0 else ': **not shown to be more than chance**.'}"
    )


def _draw_settings(
    result: Result,
    fit: Fit,
    start: Params,
    rating_source: RatingSource,
    fit_in_use: AppliedFit | None,
) -> None:
    """Draw the changes of the fit, and the button that applies or undoes it."""
    if fit.changed:
        lines = [
            f"- {plain(state.say(SETTINGS[name].label_with_unit))}: "
            f"{_shown(name, getattr(start, name))} → **{_shown(name, value)}**"
            for name, value in fit.changed.items()
        ]
        st.markdown("\n".join(lines))
    else:
        st.markdown("The settings in use are the best of those tried.")
    if fit_in_use is not None:
        _draw_in_use(fit_in_use)
    if not fit.changed or (fit_in_use is not None and fit_in_use.fitted == fit.changed):
        return
    st.button(
        "Take these settings",
        key="rating_fit_take",
        type="primary",
        on_click=applied_fit.apply,
        args=(fit, start, rating_source, result.dataset.fingerprint, fit_in_use),
    )
    if rating_source.is_simulated:
        st.caption(SIMULATED)


def _draw_in_use(fit_in_use: AppliedFit) -> None:
    """Draw a note that fitted settings are in use, and the button that restores the others."""
    with st.container(horizontal=True, vertical_alignment="center"):
        of_whom = f" {SIMULATED}" if fit_in_use.is_simulated else ""
        st.markdown(f":material/check: **In use**.{of_whom}")
        st.button(
            "Go back to the settings before",
            key="rating_fit_back",
            icon=":material/undo:",
            on_click=applied_fit.undo,
            args=(fit_in_use,),
        )


def _shown(name: str, value: Any) -> str:
    """Format the value of a parameter as in the sidebar."""
    words = SETTINGS[name].words
    if value is None:
        value = live_params.slider_start(name)
    return plain(f"{value:g}" if words is None else state.say(words[value]))
