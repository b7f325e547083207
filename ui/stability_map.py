"""Stability page: the map, what it says in words, and its computation in the background."""

from __future__ import annotations

from concurrent.futures import CancelledError, ThreadPoolExecutor
from typing import Any, Final

import streamlit as st

from nvcore.analysis import Result
from nvcore.errors import InputError
from nvcore.figures.stability import stability_map
from nvcore.figures.style import CONFIG
from nvcore.stability import StabilityMap, map_stability
from nvcore.stability_axes import Plane
from nvcore.stability_scores import Criterion
from nvcore.stability_words import describe_stability
from ui import state
from ui.background_job import BackgroundJob, JobState, Progress, while_open
from ui.clicks import is_new_click
from ui.text import plain

PLANE_WORDS: Final[dict[Plane, str]] = {
    "alpha-midpoint": "Alpha and what counts as near",
    "thresholds": "Both thresholds",
    "matching": "Matching rule",
    "edge-weight-alpha": "Traffic context and alpha",
}
CRITERION_WORDS: Final[dict[Criterion, str]] = {
    "similarity": "mean similarity",
    "encounters": "encounters detected",
    "saliency": "saliency",
}
AT_ONCE: Final = 20_000
"""Frames up to which a map is there within a second: it is drawn without asking."""
JOB: Final = "stability_job"
THREADS: Final = 2
POLL_S: Final = 0.3
MOST_MAPS: Final = 8


class MapJob(BackgroundJob):
    """One map, computed in the background; `found` once it is done."""

    def __init__(self, key: Any, result: Result, plane: Plane, criterion: Criterion,
                 is_wanted: Any):  # fmt: skip
        """Start to compute."""
        self.key = key
        self.found: StabilityMap | None = None

        def work(progress: Progress) -> bool:
            return self._compute(result, plane, criterion, progress)

        super().__init__(work, is_wanted)

    def _compute(
        self, result: Result, plane: Plane, criterion: Criterion, progress: Progress
    ) -> bool:
        def tell(done: int, of: int) -> None:
            progress(done / of)

        try:
            with ThreadPoolExecutor(THREADS) as pool:
                self.found = map_stability(
                    result, plane, criterion, executor=pool, progress=tell,
                    is_cancelled=lambda: not progress(self.share),
                )  # fmt: skip
        except CancelledError:
            return False
        return True


def draw(result: Result) -> None:
    """Choice of the map, the map, and its sentences."""
    plane: Plane = st.segmented_control(
        "What is varied", list(PLANE_WORDS), default="alpha-midpoint", required=True,
        format_func=PLANE_WORDS.__getitem__, key="stability_plane", persist_state="session",
    )  # fmt: skip
    criterion: Criterion = st.segmented_control(
        "Who is better by", list(CRITERION_WORDS), default="similarity", required=True,
        format_func=CRITERION_WORDS.__getitem__, key="stability_criterion",
        persist_state="session",
    )  # fmt: skip
    key = (state.workspace().version, result.params, plane, criterion)
    try:
        found = _found(result, plane, criterion, key)
    except InputError as error:
        st.info(plain(str(error)))
        return
    if found is not None:
        _draw_map(found)


def _found(result: Result, plane: Plane, criterion: Criterion, key: Any) -> StabilityMap | None:
    """The map if it is known or quickly made; else its button or its progress."""
    space = state.workspace()
    job: MapJob | None = st.session_state.get(JOB)
    if job is not None and job.key == key and job.found is not None:
        made = job.found
        return space.keep("stability", key, lambda: made, most=MOST_MAPS)
    is_small = len(result.dataset.frames) <= AT_ONCE
    if is_small or space.known("stability", key) is not None:
        return space.keep(
            "stability", key, lambda: map_stability(result, plane, criterion), most=MOST_MAPS
        )
    if job is not None and job.key == key and job.is_busy:
        _draw_progress(job)
        return None
    if job is not None and job.key == key:
        _draw_outcome(job)
    st.button(
        "Compute the map", key="stability_start", type="primary", icon=":material/grid_on:",
        on_click=_start, args=(result, plane, criterion, key),
    )  # fmt: skip
    st.caption("With so many frames it takes some seconds to a minute; the page stays usable.")
    return None


def _start(result: Result, plane: Plane, criterion: Criterion, key: Any) -> None:
    _cancel()
    st.session_state[JOB] = MapJob(key, result, plane, criterion, while_open(state.workspace()))


def _cancel() -> None:
    job: MapJob | None = st.session_state.get(JOB)
    if job is not None:
        job.cancel()


@st.fragment(run_every=POLL_S)
def _draw_progress(job: MapJob) -> None:
    if not job.is_busy:
        st.rerun()
    words = (
        "Waiting for other work on this server" if job.state is JobState.WAITING else "Computing"
    )
    st.progress(job.share, f"{words}: {job.share:.0%}")
    st.button("Cancel", icon=":material/close:", key="stability_cancel", on_click=_cancel)


def _draw_outcome(job: MapJob) -> None:
    if job.state is JobState.CANCELLED:
        st.info("The map was cancelled.")
    elif job.state is JobState.FAILED:
        st.error(plain(job.error) or "The map could not be computed.", icon=":material/error:")


def _draw_map(found: StabilityMap) -> None:
    first, *others = describe_stability(found)
    with st.container(border=True):
        st.markdown(f"**{plain(first)}**")
        for sentence in others:
            st.markdown(plain(sentence))
    chosen = st.plotly_chart(
        stability_map(found, theme=state.theme()), theme=None, config=CONFIG,
        key=f"stability_{found.plane}_{found.criterion}", on_select="rerun",
        selection_mode="points",
    )  # fmt: skip
    st.caption("Click a place to take its settings into the sidebar.")
    points = chosen["selection"]["points"]
    if points and is_new_click("stability", points):
        cell = points[0]["customdata"]
        settings = found.settings(int(cell[0] if isinstance(cell, list) else cell))
        state.set_params(**settings)
        st.rerun()
