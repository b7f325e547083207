"""Systems page: the table of all pairs, computed in the background if that takes long."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import comb
from typing import Final

import pandas as pd

from nvcore.common.progress import Progress
from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.evidence.pairwise import pairwise_table, thresholds_in_use
from nvcore.settings.params import Params
from ui.jobs.computed import Computation
from ui.jobs.page_run import PageRun
from ui.session import state

RUN: Final = PageRun[pd.DataFrame]("matrix", "table", "Comparing every pair of systems")
AT_ONCE: Final = 20_000
"""Frames times pairs up to which the table takes less than a second and is drawn without asking."""
COLUMNS: Final = ["name", "horizon", "context"]
"""Columns of the recordings that visitors may change on the Data page without another reading."""


def draw(result: Result) -> pd.DataFrame | None:
    """Return the rows of `pairwise_table`, or draw the button or the progress of computing them."""
    dataset = result.dataset
    params = replace(result.params, threshold_x=None, threshold_y=None)
    thresholds = thresholds_in_use(dataset, result.params)
    recordings = dataset.recordings[COLUMNS].to_csv()
    key = (dataset.fingerprint, recordings, dataset.systems, params, tuple(thresholds.items()))
    # survives a new choice of X and Y, which clears results of these
    notes = state.workspace().notes
    known_key, known = notes.get(RUN.name, (None, None))
    if known_key == key:
        table: pd.DataFrame = known
        return table
    n_pairs = comb(len(dataset.systems), 2)
    work = Computation(RUN, key, partial(_compute, dataset, params, thresholds))
    computed = work.draw_or_offer(
        f"Compare all {n_pairs:,} pairs",
        "table_chart",
        "With so many frames it takes a while; the other pages work meanwhile.",
        is_quick=n_pairs * len(dataset.frames) <= AT_ONCE,
        type="primary",
    )
    if computed is not None:
        notes[RUN.name] = key, computed
    return computed


def _compute(
    dataset: Dataset, params: Params, thresholds: Mapping[str, float | None], progress: Progress
) -> pd.DataFrame:
    return pairwise_table(dataset, params, thresholds=thresholds, progress=progress)
