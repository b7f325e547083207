"""Urgent encounters, one by one: the confirmation by each system, and the time left then."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.subjects.time_left.kinds import TimeLeft
from nvcore.subjects.time_left.steps import confirmed_by, time_left_in
from nvcore.tables.result import encounters_table

QUADRANTS: Final = ("both", "only_x", "only_y", "neither")
"""Systems that confirmed an urgent encounter in time."""


def urgent_encounters(result: Result) -> pd.DataFrame:
    """Return the urgent encounters, fastest impacts first.

    They are sorted by the larger impact speed of X and Y, then by the sum of both, then by the
    smaller margin.

    Returns
    -------
    Rows of `nvcore.tables.result.encounters_table`, indexed by the row in ``result.encounters``,
    with further columns. Rows of the frames table: first_row, urgent_row (the last chance),
    confirmed_row_x, confirmed_row_y (-1 never). Seconds before contact, whose time follows from the
    time to contact at the last chance: first_s and last_s (first and last annotated frame;
    negative: after contact), ttc_s (last chance), confirmed_s_x, confirmed_s_y (NaN never). Also
    speed_kmh and in_time (one of `QUADRANTS`).
    """
    rows = np.flatnonzero(time_left_in(result).is_urgent)
    encounters, time_s = result.encounters, result.dataset.frames["time_s"].to_numpy()
    urgent_row = time_left_in(result).urgency["urgent_row"].to_numpy()[rows]
    ttc_s = contact_at(result, rows, urgent_row)
    contact_s = time_s[urgent_row] + ttc_s
    first_row = encounters.first_row[rows]
    columns = {
        "first_row": first_row,
        "urgent_row": urgent_row,
        "ttc_s": ttc_s,
        "speed_kmh": time_left_in(result).urgency["speed_kmh"].to_numpy()[rows],
        "first_s": contact_s - time_s[first_row],
        "last_s": contact_s - time_s[encounters.last_row[rows]],
    }
    for letter, system in result.sides:
        row = confirmed_by(system)["confirmed_row"].to_numpy()[rows]
        columns[f"confirmed_row_{letter}"] = row
        columns[f"confirmed_s_{letter}"] = np.where(row < 0, np.nan, contact_s - time_s[row])
    table = encounters_table(result).iloc[rows].assign(**columns)
    x, y = (table[f"time_left_{letter}"] == TimeLeft.IN_TIME.value for letter in "xy")
    table["in_time"] = np.select([x & y, x, y], QUADRANTS[:3], QUADRANTS[3]).astype(object)
    impact_kmh = table[["impact_kmh_x", "impact_kmh_y"]].to_numpy(dtype=float).round(6)
    margin_s = table[["margin_s_x", "margin_s_y"]].min(axis=1).to_numpy(dtype=float)
    keys = margin_s, -impact_kmh.sum(axis=1), -impact_kmh.max(axis=1, initial=0)
    return table.iloc[np.lexsort(keys)]


def count_in_time(urgent: pd.DataFrame) -> dict[str, int]:
    """Count urgent encounters by the systems that confirmed them in time, for each of `QUADRANTS`.

    Parameters
    ----------
    urgent
        Result of `urgent_encounters`.
    """
    return {name: int((urgent["in_time"] == name).sum()) for name in QUADRANTS}


def nearest_contact(result: Result, recording: int) -> pd.DataFrame:
    """Find the pedestrian nearest to contact in each frame of a recording.

    Returns
    -------
    One row per frame: ttc_s (least time to contact, s; inf: no pedestrian is being approached, NaN:
    unknown, or no pedestrian), encounter (row of ``result.encounters``; -1 if unknown).
    """
    truth, rows = result.dataset.truth, result.dataset.frame_columns.rows_of(recording)
    boxes = truth.rows_of(rows.start, rows.stop)
    ttc_s, frame = time_left_in(result).contact.ttc_s[boxes], truth.frame_index[boxes] - rows.start
    order = np.lexsort((ttc_s, frame))  # NaN last
    frames, place = np.unique(frame[order], return_index=True)
    nearest = order[place]
    is_known = ~np.isnan(ttc_s[nearest])
    frames, nearest = frames[is_known], nearest[is_known]
    least, encounter = np.full(rows.stop - rows.start, np.nan), np.full(rows.stop - rows.start, -1)
    least[frames] = ttc_s[nearest]
    encounter[frames] = result.encounters.encounter_of[boxes][nearest]
    return pd.DataFrame({"ttc_s": least, "encounter": encounter})


def contact_at(result: Result, encounter: np.ndarray, frame_row: np.ndarray) -> np.ndarray:
    """Return the time to contact of encounters in one frame each, s, NaN if unknown.

    It is unknown, too, if the encounter is not annotated in that frame.

    Parameters
    ----------
    encounter, frame_row
        Rows of ``result.encounters`` and of the frames table; int64, shape (n,).
    """
    encounters, n_frames = result.encounters, len(result.dataset.frames)
    own = np.repeat(np.arange(len(encounters)), np.diff(encounters.offsets))
    key, wanted = own * n_frames + encounters.frame_index, encounter * n_frames + frame_row
    place = np.minimum(np.searchsorted(key, wanted), max(len(key) - 1, 0))
    ttc_s = np.full(len(wanted), np.nan)
    if len(key):
        is_there = key[place] == wanted
        ttc_s[is_there] = time_left_in(result).contact.ttc_s[encounters.order[place[is_there]]]
    return ttc_s
