"""Stability page: the map, what it says in words, and its computation in the background."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.errors import InputError
from nvcore.figures.stability import stability_map
from nvcore.figures.style import CONFIG
from nvcore.params import Params
from nvcore.stability.axes import Plane
from nvcore.stability.map import StabilityMap, map_stability
from nvcore.stability.scores import Criterion
from nvcore.stability.survey import SURVEYED
from nvcore.stability.words import CRITERIA, PLANES, describe_chance, describe_stability
from ui.jobs.background import Computation, JobState, while_open
from ui.jobs.progress import draw_job, start_as_made
from ui.session import state
from ui.session.evidence import measure_evidence
from ui.widgets.clicks import is_new_click
from ui.widgets.text import plain

AT_ONCE: Final = 20_000
"""Frames up to which a map is there within a second: it is drawn without asking."""
JOB: Final = "stability"
THREADS: Final = 2
MOST_MAPS: Final = 8


@dataclass(frozen=True)
class MapKey:
    """What a map is made from."""

    version: str
    params: Params
    plane: Plane
    criterion: Criterion


def draw(result: Result) -> None:
    """Choice of the map, the map, and its sentences."""
    key = _choose(result)
    try:
        found = _found(result, key)
    except InputError as error:
        st.info(plain(str(error)))
        return
    if found is not None:
        _draw_map(found)


def _choose(result: Result) -> MapKey:
    st.session_state.setdefault("stability_plane", "alpha-midpoint")
    st.session_state.setdefault("stability_criterion", "similarity")
    if (job := _job()) is not None:
        start_as_made(
            job, JOB, stability_plane=job.key.plane, stability_criterion=job.key.criterion
        )
    plane: Plane = st.segmented_control(
        "What is varied",
        list(SURVEYED),
        required=True,
        format_func=PLANES.__getitem__,
        key="stability_plane",
        persist_state="session",
    )
    criterion: Criterion = st.segmented_control(
        "Who is better by",
        list(CRITERIA),
        required=True,
        format_func=CRITERIA.__getitem__,
        key="stability_criterion",
        persist_state="session",
    )
    return MapKey(state.workspace().version, result.params, plane, criterion)


def _job() -> Computation[StabilityMap] | None:
    job: Computation[StabilityMap] | None = state.workspace().job(JOB)
    return job


def _found(result: Result, key: MapKey) -> StabilityMap | None:
    """The map if it is known or quickly made; else its button or its progress."""
    space, job = state.workspace(), _job()
    if job is not None and job.key == key:
        at = draw_job(job, JOB, thing="map", doing="Computing the map")
        if at.is_busy:
            return None
        if at is JobState.DONE:
            return space.keep("stability", key, lambda: job.found, most=MOST_MAPS)
    is_small = len(result.dataset.frames) <= AT_ONCE
    if is_small or space.known("stability", key) is not None:
        return space.keep(
            "stability",
            key,
            lambda: map_stability(result, key.plane, key.criterion),
            most=MOST_MAPS,
        )
    st.button(
        "Compute the map",
        key="stability_start",
        type="primary",
        icon=":material/grid_on:",
        on_click=_start,
        args=(result, key),
    )
    st.caption("With so many frames it takes some seconds to a minute; the page stays usable.")
    return None


def _start(result: Result, key: MapKey) -> None:
    def compute(job: Computation[StabilityMap]) -> StabilityMap:
        with ThreadPoolExecutor(THREADS) as pool:
            return map_stability(
                result,
                key.plane,
                key.criterion,
                executor=pool,
                progress=job.tell,
                is_cancelled=job.has_to_stop,
            )

    space = state.workspace()
    space.put_job(JOB, Computation(compute, while_open(space), key=key))


def _draw_map(found: StabilityMap) -> None:
    first, *others = describe_stability(found)
    with st.container(border=True):
        st.markdown(f"**{plain(first)}**")
        chance = st.empty()  # filled last: the map is there sooner
        for sentence in others:
            st.markdown(plain(sentence))
    chosen = st.plotly_chart(
        stability_map(found, theme=state.theme()),
        theme=None,
        config=CONFIG,
        key=f"stability_{found.plane}_{found.criterion}",
        on_select="rerun",
        selection_mode="points",
    )
    st.caption("Click a place to take its settings into the sidebar.")
    points = chosen["selection"]["points"]
    if points and is_new_click("stability", points):
        cell = points[0]["customdata"]
        settings = found.settings(int(cell[0] if isinstance(cell, list) else cell))
        state.set_params(**settings)
        st.rerun()
    tested = measure_evidence()
    if tested is not None:
        chance.markdown(plain(describe_chance(found, tested)))
