"""Stability page: one map with its description, computed in the background."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.progress import Progress
from nvcore.comparison.compare import Result
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import StabilityMap, map_stability
from nvcore.evidence.stability.notes import (
    CRITERIA,
    PLANES,
    describe_chance,
    describe_in_short,
    describe_stability,
)
from nvcore.evidence.stability.scores import Criterion
from nvcore.evidence.stability.survey import SURVEY_PLANES
from nvcore.figures.maps import stability_map
from nvcore.settings.params import Params
from ui.jobs.computed import Computation
from ui.jobs.page_run import PageRun
from ui.jobs.progress import start_as_made
from ui.session import state, store
from ui.session.results import measure_evidence
from ui.widgets.charts import clicked_chart
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import plain

AT_ONCE: Final = 20_000
"""Number of frames up to which a map takes at most a second and is drawn without asking."""
RUN: Final = PageRun[StabilityMap]("stability", "map", "Computing the map")
THREADS: Final = 2


@dataclass(frozen=True)
class MapKey:
    """Inputs that determine a map."""

    version: str
    params: Params
    plane: Plane
    criterion: Criterion


def draw(result: Result) -> None:
    """Draw the choice of a map, the map, and sentences that describe it."""
    key = _choose(result)
    try:
        stability = _stability_map(result, key)
    except InputError as error:
        st.info(plain(str(error)))
        return
    if stability is not None:
        _draw_map(result, stability)


def _choose(result: Result) -> MapKey:
    first_plane, first_criterion = SURVEY_PLANES[0], next(iter(CRITERIA))
    store.STABILITY_PLANE.setdefault(first_plane)
    store.STABILITY_CRITERION.setdefault(first_criterion)
    if (job := RUN.job) is not None:
        plane, criterion = job.key.plane, job.key.criterion
        start_as_made(job, RUN.name, stability_plane=plane, stability_criterion=criterion)
    planes = {plane: PLANES[plane] for plane in SURVEY_PLANES}
    plane = choose_side_by_side("What is varied", planes, "stability_plane")
    criterion = choose_side_by_side("Who is better by", CRITERIA, "stability_criterion")
    version = state.workspace().version
    return MapKey(version, result.params, plane, criterion)


def _stability_map(result: Result, key: MapKey) -> StabilityMap | None:
    """Return the map if it is known or quick to compute. Else draw a button or the progress."""

    def compute(progress: Progress) -> StabilityMap:
        with ThreadPoolExecutor(THREADS) as pool:
            return map_stability(result, key.plane, key.criterion, executor=pool, progress=progress)

    return Computation(RUN, key, compute).draw_or_offer(
        "Compute the map",
        "grid_on",
        "With so many frames it takes some seconds to a minute; the page stays usable.",
        is_quick=len(result.dataset.frames) <= AT_ONCE,
        type="primary",
    )


def _draw_map(result: Result, stability: StabilityMap) -> None:
    short = describe_in_short(stability)
    st.markdown(f"**{plain(short)}**")
    chance = st.empty()  # filled last
    cell = clicked_chart(
        stability_map(stability, theme=state.theme()),
        f"stability_{stability.plane}_{stability.criterion}",
        help="Click a place to take its settings into the sidebar.",
    )
    more = [sentence for sentence in describe_stability(stability) if sentence not in short]
    if more:
        with st.expander("More in words: each setting by itself, equal false alarms"):
            for sentence in more:
                st.markdown(plain(sentence))
    if cell is not None:
        settings = stability.settings(int(cell))
        state.set_params(**settings)
        st.rerun()
    chance.markdown(plain(describe_chance(stability, measure_evidence(result))))
