"""Where to look at an encounter: the first frame in which a system misses it, and its box."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.analysis import Result
from nvcore.box_states import RELEVANT_K
from nvcore.tables import sides

ENCOUNTER_MOMENT_COLUMNS: Final = ("first_row", "missed_row_x", "missed_row_y", "shown_row")
NEVER: Final = -1
"""Frame row of what does not happen."""


def encounter_moments(result: Result) -> pd.DataFrame:
    """The frames of every encounter that are worth opening, as rows of the frames table.

    Returns
    -------
    One row per encounter, columns `ENCOUNTER_MOMENT_COLUMNS`, int64: first_row, the first relevant frame (of
    a distant encounter the first annotated one); missed_row_x and missed_row_y, the first relevant
    frame in which that system misses the pedestrian, -1 if it never does; shown_row, the earlier
    of these two, else first_row.
    """
    encounters = result.encounters
    n, rows = len(encounters), encounters.order
    of = np.repeat(np.arange(n), np.diff(encounters.offsets))
    at = encounters.frame_index
    is_relevant = result.k_truth.k[rows] >= RELEVANT_K
    first = _earliest(n, of[is_relevant], at[is_relevant])
    first = np.where(first == NEVER, encounters.first_row, first)
    moments = {"first_row": first}
    # a track that stands twice in a frame is one pedestrian there, found if one box is
    key = of * (len(result.dataset.frames) + 1) + at
    for letter, system in sides(result):
        is_matched = system.matches.is_matched[rows]
        is_missed = is_relevant & ~is_matched
        found_twin = np.isin(key[is_missed], _twice(key[is_relevant & is_matched], key))
        moments[f"missed_row_{letter}"] = _earliest(
            n, of[is_missed][~found_twin], at[is_missed][~found_twin]
        )
    both = np.stack([moments["missed_row_x"], moments["missed_row_y"]])
    earlier = np.where(both == NEVER, len(result.dataset.frames), both).min(axis=0)
    is_missed_at_all = (both != NEVER).any(axis=0)
    moments["shown_row"] = np.where(is_missed_at_all, earlier, first)
    return pd.DataFrame(moments, columns=list(ENCOUNTER_MOMENT_COLUMNS)).astype("int64")


def encounter_box(result: Result, encounter: int, row: int) -> np.ndarray:
    """x, y, w, h (px) of the pedestrian of an encounter in a frame.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    row
        Row of the frames table, one in which the pedestrian is annotated. Where the track stands
        there twice: its first box.

    Raises
    ------
    ValueError
        If the pedestrian is not annotated in this frame.
    """
    of, truth = result.encounters, result.dataset.truth
    start, stop = of.offsets[encounter : encounter + 2]
    at = start + np.searchsorted(of.frame_index[start:stop], row)
    if at == stop or of.frame_index[at] != row:
        raise ValueError(f"encounter {encounter} has no box in row {row} of the frames table")
    box = of.order[at]
    return np.array([truth.x[box], truth.y[box], truth.w[box], truth.h[box]])


def _twice(found: np.ndarray, keys: np.ndarray) -> np.ndarray:
    """Those of `found` that stand more than once in the sorted `keys`."""
    several = keys[1:][keys[1:] == keys[:-1]]
    return found[np.isin(found, several)] if len(several) else several


def _earliest(n: int, of: np.ndarray, at: np.ndarray) -> np.ndarray:
    """First value of each group, `NEVER` for a group without; sorted by group and value."""
    earliest = np.full(n, NEVER, dtype=np.int64)
    is_first = np.ones(len(of), dtype=bool)
    is_first[1:] = of[1:] != of[:-1]
    earliest[of[is_first]] = at[is_first]
    return earliest
