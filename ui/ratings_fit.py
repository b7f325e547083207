"""Ratings page: saliency's parameters fitted to the ratings, and what that is worth."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import replace
from typing import Any, Final

import pandas as pd
import streamlit as st

from nvcore.analysis import Result
from nvcore.errors import InputError
from nvcore.figures.style import count_text
from nvcore.ratings.fit import Fit, fit_saliency
from ui import live_params, state
from ui.background_job import BackgroundJob, JobState, Progress, while_open
from ui.sidebar import CHOICES, LABELS
from ui.text import docs_link, plain

AT_ONCE: Final = 20_000
"""Frames up to which a fit takes seconds: it is made while the page waits."""
JOB: Final = "rating_fit_job"
TAKEN: Final = "rating_fit_taken"
POLL_S: Final = 0.3
MOST_FITS: Final = 4


class FitJob(BackgroundJob):
    """One fit, computed in the background; `found` once it is done."""

    def __init__(self, key: Any, result: Result, clips: pd.DataFrame, is_wanted: Any):
        """Start to compute."""
        self.key = key
        self.found: Fit | None = None

        def work(progress: Progress) -> bool:
            def tell(done: int, of: int) -> None:
                if not progress(done / of):
                    raise CancelledError

            try:
                self.found = fit_saliency(result, clips, progress=tell)
            except CancelledError:
                return False
            return True

        super().__init__(work, is_wanted)


def draw(result: Result, clips: pd.DataFrame, ratings_key: object) -> None:
    """The button that fits, and what the fit found."""
    st.header("Fit saliency to these ratings")
    st.caption(
        "Tries tolerance, recency, height sigmoid and aggregate in many combinations, and takes "
        "those settings that put most pairs of clips in the order in which people put them "
        f"({docs_link('how it is judged', 'the-fit', doc='ratings')})."
    )
    key = (ratings_key, state.workspace().version, result.params)
    if st.session_state.get(TAKEN) == result.params:
        st.warning(
            "The fitted settings are in use. They were chosen by ratings: if by these, the plot, "
            "the correlations and another fit on this page are too good, and no evidence. Reset in "
            "the sidebar takes them back.",
            icon=":material/warning:",
        )
    found: Any = state.workspace().known("rating_fit", key) or _from_job(key)
    if found is None:
        found = _ask(result, clips, key)
    if found is not None:
        _draw_fit(result, found)


def _from_job(key: Any) -> Fit | None:
    job: FitJob | None = st.session_state.get(JOB)
    if job is None or job.key != key or job.found is None:
        return None
    return _keep(key, job.found)


def _keep(key: Any, found: Fit) -> Fit:
    return state.workspace().keep("rating_fit", key, lambda: found, most=MOST_FITS)


def _ask(result: Result, clips: pd.DataFrame, key: Any) -> Fit | None:
    """The button, or the progress of the fit; the fit where it was made at once."""
    job: FitJob | None = st.session_state.get(JOB)
    if job is not None and job.key == key:
        if job.is_busy:
            _draw_progress(job)
            return None
        if job.state is JobState.FAILED:
            st.error(plain(job.error) or "The fit could not be made.", icon=":material/error:")
    if not st.button("Fit saliency to these ratings", key="rating_fit", icon=":material/tune:"):
        return None
    if len(result.dataset.frames) > AT_ONCE:
        _start(result, clips, key)
        st.rerun()
    bar = st.progress(0.0, "Fitting")
    try:
        found = fit_saliency(
            result, clips, progress=lambda done, of: bar.progress(done / of, "Fitting")
        )
    except InputError as error:
        st.info(plain(str(error)))
        return None
    finally:
        bar.empty()
    return _keep(key, found)


def _start(result: Result, clips: pd.DataFrame, key: Any) -> None:
    _cancel()
    st.session_state[JOB] = FitJob(key, result, clips, while_open(state.workspace()))


def _cancel() -> None:
    job: FitJob | None = st.session_state.get(JOB)
    if job is not None:
        job.cancel()


@st.fragment(run_every=POLL_S)
def _draw_progress(job: FitJob) -> None:
    if not job.is_busy:
        st.rerun()
    st.progress(job.share, f"Fitting: {job.share:.0%}")
    st.button("Cancel", icon=":material/close:", key="rating_fit_cancel", on_click=_cancel)


def _draw_fit(result: Result, found: Fit) -> None:
    with st.container(border=True, key="rating_fit_found"):
        st.markdown("**Share of the pairs of clips in the order in which people put them**")
        columns = st.columns(3)
        columns[0].metric("settings in use", f"{found.share_default:.0%}")
        columns[1].metric("fit, on recordings left out", f"{found.share_fitted:.0%}")
        columns[2].metric("fit, on what it has seen", f"{found.share_training:.0%}")
        st.caption(
            f"{count_text(found.n_pairs, 'pair')} of {count_text(found.n_clips, 'clip')}, "
            f"{found.n_settings:,} combinations tried; 50% is chance. **The second figure is the "
            "result**: each pair is judged by a fit that has seen neither of its recordings. The "
            "third is too good by construction."
        )
        if not found.changed:
            st.markdown("The settings in use are the best of those tried.")
            return
        if found.share_fitted <= found.share_default:
            st.markdown(
                "On recordings that it has not seen, the fit is **no better than the settings in "
                "use**: these ratings give no reason to change them."
            )
        st.markdown("\n".join(f"- {line}" for line in _changes(result, found)))
        st.button(
            "Take these settings", key="rating_fit_take", type="primary", on_click=_take,
            args=(result, found),
        )  # fmt: skip


def _changes(result: Result, found: Fit) -> list[str]:
    """The parameters that the fit changes, as the sidebar calls them."""
    return [
        f"{plain(LABELS[name])}: {_shown(_in_use(result, name))} → **{_shown(value)}**"
        for name, value in found.changed.items()
    ]


def _in_use(result: Result, name: str) -> Any:
    value = getattr(result.params, name)
    return live_params.default_of_height(name) if value is None else value


def _shown(value: Any) -> str:
    return plain(CHOICES.get(value, value) if isinstance(value, str) else f"{value:g}")


def _take(result: Result, found: Fit) -> None:
    state.set_params(**found.changed)
    st.session_state[TAKEN] = replace(result.params, **found.changed)
