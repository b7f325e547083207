"""The frame viewer with X and Y of a comparison, for use on several pages."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.tables.boxes.states import gather_boxes
from nvcore.tables.moments import next_misses
from ui.session import state, store
from ui.session.chosen import choose_encounter, chosen_encounter
from ui.subject import all_sights
from ui.widgets import drawing
from ui.widgets.drawing import Look, VisiblePictures, cost_map_of, keep_look, look, viewer_arguments
from ui.widgets.text import plain
from ui.widgets.viewer import ListedBox, settled_in, viewer


def settled(key: str) -> int:
    """Return the row within the recording that the viewer shows, even before it is drawn."""
    recording = state.recording()
    n_rows = len(state.frame_numbers(recording))
    if not n_rows:
        return 0
    return settled_in(key, recording=recording, n_rows=n_rows, seek=(state.row(), store.SEEK.get()))


def draw(
    result: Result,
    key: str,
    *,
    height_px: int,
    fits_window: bool = False,
    listed: ListedBox | None = None,
    seen: Look | None = None,
    visible: VisiblePictures | None = None,
    encounter: int | None = None,
) -> None:
    """Draw the viewer at the current recording and frame.

    Parameters
    ----------
    fits_window, listed
        See `viewer`.
    seen
        Initial look of the pictures. None: as chosen in this browser session.
    visible
        Visible-light pictures instead of the recording's own.
    encounter
        Encounter whose pedestrian is marked. None: the selected one.
    """
    recording = state.recording()
    rows = result.dataset.frame_columns.rows_of(recording)
    lo, hi = drawing.stretch()
    arguments = viewer_arguments(result, recording, with_visible=visible is None)
    if visible is not None:
        arguments["visible"] = visible
    viewer(
        **arguments,
        traces={letter: system.similarity[rows] for letter, system in result.sides},
        low=result.params.low,
        intervals=[_spans(system.intervals, recording, rows.start) for _, system in result.sides],
        misses=next_misses(result, recording),
        names=[system.name for _, system in result.sides],
        seek=(state.row(), store.SEEK.get()),
        lo=lo,
        hi=hi,
        cost=cost_map_of(recording),
        chosen=_track_of(result, recording, encounter),
        on_choose=partial(choose_encounter, result),
        listed=listed,
        look=look() if seen is None else seen,
        on_look=keep_look,
        height_px=height_px,
        fits_window=fits_window,
        key=key,
    )
    for sight in all_sights():
        if arguments["visible"] is not None and (trouble := sight.trouble(recording)):
            st.caption(plain(trouble))


def _track_of(result: Result, recording: int, encounter: int | None) -> int | None:
    """Return the pedestrian's track number in the boxes of this recording, or None elsewhere."""
    encounter = chosen_encounter(result) if encounter is None else encounter
    if encounter is None or result.encounters.recording[encounter] != recording:
        return None
    row = int(result.encounters.first_row[encounter])
    rows = result.dataset.truth.rows_of(row, row + 1)
    is_chosen = result.encounters.encounter_of[rows] == encounter
    return int(gather_boxes(result, row, row + 1).truth.track[is_chosen][0])


def _spans(intervals: pd.DataFrame, recording: int, first: int) -> np.ndarray:
    mine = intervals[intervals["recording"].to_numpy() == recording]
    return np.column_stack([mine["first_row"] - first, mine["last_row"] - first + 1])
