"""Tables on the driver's view of encounters: detectability, and who sees which encounter."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.notes import Note, say
from nvcore.subjects.driver.comparison.in_time import is_in_time_alone
from nvcore.subjects.driver.comparison.judging import DRIVER_REGION_TEXT, DriverRegion
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.tables.result import encounters_table

REGION_NAMES: Final[dict[DriverRegion, str]] = {
    DriverRegion.DRIVER_X_Y: "driver, X and Y",
    DriverRegion.DRIVER_X: "driver and X",
    DriverRegion.DRIVER_Y: "driver and Y",
    DriverRegion.DRIVER: "driver alone",
    DriverRegion.X_Y: "X and Y",
    DriverRegion.X: "X alone",
    DriverRegion.Y: "Y alone",
    DriverRegion.NOBODY: "none of them",
    DriverRegion.UNKNOWN: "unknown of the driver",
}
"""Short description of who sees the encounters of a region."""


DRIVER_THRESHOLDS: Final = np.arange(5, 100, 5) / 100
"""Thresholds tabulated by `over_driver_threshold`."""
Sight = Literal["sees", "unseen", "open", "unknown", "distant"]
SIGHT_WORDS: Final[dict[Sight, str]] = {
    "sees": "sees",
    "unseen": "does not see",
    "open": "open",
    "unknown": "not known",
}
"""Short description of whether the driver sees the pedestrian of a near encounter."""


def driver_sights(result: Result) -> np.ndarray:
    """Classify each encounter by whether the driver sees the pedestrian unaided.

    Returns
    -------
    Values of `Sight`, object, shape (n_encounters,). ``open`` means that the largest detectability
    up to the first relevant frame is within its standard deviation of `driver_threshold`.
    """
    driver = driver_in(result)
    claims = [~driver.is_near, ~driver.is_known, driver.is_within_sd, driver.is_seen]
    kinds: list[Sight] = ["distant", "unknown", "open", "sees"]
    return np.select(claims, kinds, default="unseen").astype(object)


def describe_sight(result: Result, encounter: int) -> str:
    """Describe whether the driver sees an encounter's pedestrian unaided.

    Empty if the encounter is distant or the dataset has no detectability.

    Examples
    --------
    >>> describe_sight(result, 0)  # doctest: +SKIP
    'Driver: open. Detectability reaches 0.52 ± 0.15 by the first frame that counts.'
    """
    sight: Sight = driver_sights(result)[encounter]
    if sight == "distant" or not result.dataset.has_detectability:
        return ""
    largest, sd = driver_in(result).table[["detectability", "sd"]].iloc[encounter]
    record = result.dataset.of("driver")
    name = result.dataset.recordings["name"].iloc[result.encounters.recording[encounter]]
    is_estimated = record is not None and name in record.estimated_in
    note = Note(
        "driver.sight",
        sight=SIGHT_WORDS[sight],
        largest=None if sight == "unknown" else largest,
        sd=sd if np.isfinite(sd) else None,
        caution=(record.caution or None) if is_estimated else None,
    )
    return say(note, result.objects)


def driver_venn_table(result: Result) -> pd.DataFrame:
    """Count the encounters in each region of the Venn diagram of driver, X and Y.

    The last row counts those for which it is unknown whether the driver sees them.

    Returns
    -------
    Columns region (`judging.DriverRegion`), who (in short), encounters, severity_x,
    severity_y (severity of the systems' failures there, s), meaning (a sentence).
    """
    severity_s = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    rows = []
    for region, who in REGION_NAMES.items():
        is_here = driver_in(result).region == region.value
        of_x, of_y = (float(values[is_here].sum()) for values in severity_s)
        n = driver_in(result).counts[region]
        meaning = result.objects.say(DRIVER_REGION_TEXT[region])
        rows.append((region.value, who, n, of_x, of_y, meaning))
    names = ["region", "who", "encounters", "severity_x", "severity_y", "meaning"]
    return pd.DataFrame(rows, columns=names)


def over_driver_threshold(result: Result) -> pd.DataFrame:
    """Count the encounters that driver, X and Y see, at each of `DRIVER_THRESHOLDS`.

    The counts use the largest detectability of each encounter and the existing matches. Nothing is
    recomputed.

    Returns
    -------
    One row for each of `DRIVER_THRESHOLDS`, over near encounters with known detectability:
    driver_threshold, known (number of these encounters, equal in all rows), seen (by the driver
    unaided), useful_x, useful_y (detected by the system, not seen by the driver, higher is better),
    nobody (neither the driver nor X nor Y, lower is better). Empty if detectability is never known.
    """
    driver = driver_in(result)
    is_known, n_known = driver.is_known, driver.n_known
    thresholds = DRIVER_THRESHOLDS if n_known else DRIVER_THRESHOLDS[:0]
    largest = driver.table["detectability"].to_numpy()[is_known]
    is_unseen = largest < thresholds[:, np.newaxis]
    by_x, by_y = driver.by_x[is_known], driver.by_y[is_known]
    return pd.DataFrame(
        {
            "driver_threshold": thresholds,
            "known": n_known,
            "seen": (~is_unseen).sum(axis=1),
            "useful_x": (is_unseen & by_x).sum(axis=1),
            "useful_y": (is_unseen & by_y).sum(axis=1),
            "nobody": (is_unseen & ~by_x & ~by_y).sum(axis=1),
        }
    )


def detectability_course(result: Result, encounter: int) -> pd.DataFrame:
    """Return a pedestrian's detectability in each annotated frame of an encounter.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.

    Returns
    -------
    One row per annotated frame: row (of the frames table), truth_row (of the truth boxes), time_s,
    detectability, sd (0..1, NaN unknown), is_outside (estimated outside the training range),
    is_up_to_relevant (up to the first relevant frame, by which the driver has to see the
    pedestrian, and False throughout for a distant one). If a frame has a track id twice, the box
    with the larger detectability counts.
    """
    encounters, known = result.encounters, result.dataset.detectability
    places = slice(int(encounters.offsets[encounter]), int(encounters.offsets[encounter + 1]))
    truth_row, row = encounters.order[places], encounters.frame_index[places]
    relevant = row[result.k_truth.k[truth_row] >= RELEVANT_K]
    order = np.lexsort((-np.nan_to_num(known.value[truth_row], nan=-1.0), row))
    row, first = np.unique(row[order], return_index=True)
    truth_row = truth_row[order][first]
    return pd.DataFrame(
        {
            "row": row,
            "truth_row": truth_row,
            "time_s": result.dataset.frames["time_s"].to_numpy()[row],
            "detectability": known.value[truth_row],
            "sd": known.sd[truth_row],
            "is_outside": known.is_outside[truth_row],
            "is_up_to_relevant": row <= (relevant[0] if len(relevant) else -1),
        }
    )


def features_of_course(
    result: Result, course: pd.DataFrame, features: pd.DataFrame
) -> pd.DataFrame | None:
    """Return a pedestrian's features in each frame of a course, or None if the boxes differ.

    Parameters
    ----------
    course
        Table from `detectability_course`.
    features
        Features of the recording (`nvcore.subjects.driver.running.run.FEATURE_COLUMNS`), with one
        row for each box that is not ignored.

    Returns
    -------
    One row per row of the course, with its index, NaN if the box is ignored. None if the features
    belong to other boxes.
    """
    truth, frames = result.dataset.truth, result.dataset.frame_columns
    recording = int(frames.recording[int(course["row"].iloc[0])])
    rows = frames.rows_of(recording)
    boxes = truth.rows_of(rows.start, rows.stop)
    rank = np.cumsum(~truth.ignore[boxes]) - 1
    if len(features) != rank[-1] + 1:
        return None
    truth_row = course["truth_row"].to_numpy()
    own: pd.DataFrame = features.iloc[rank[truth_row - boxes.start]].set_index(course.index)
    is_same = own["frame"].to_numpy() == frames.frame[course["row"].to_numpy()]
    for name, side in zip("xywh", truth.xywh, strict=True):
        is_same &= np.isclose(own[name], side[truth_row], atol=1e-3)
    is_ignored = truth.ignore[truth_row]
    if not (is_same | is_ignored).all():
        return None
    return own.mask(is_ignored) if is_ignored.any() else own


def saved_encounters(result: Result) -> pd.DataFrame:
    """Return urgent encounters that only one system confirms in time and the driver does not.

    Returns
    -------
    Rows of `nvcore.tables.result.encounters_table` with the column system, ``x`` or ``y``. The
    index is the row in ``result.encounters``. The fastest avoided impact comes first.
    """
    table = encounters_table(result)
    is_alone = {letter: is_in_time_alone(result, system) for letter, system in result.sides}
    saved = table[is_alone["x"] | is_alone["y"]].copy()
    is_x = is_alone["x"][saved.index.to_numpy()]
    saved["system"] = np.where(is_x, "x", "y").astype(object)
    impact_kmh = np.where(is_x, saved["impact_kmh_y"], saved["impact_kmh_x"])
    ranked: pd.DataFrame = saved.iloc[np.argsort(-impact_kmh, kind="stable")]
    return ranked
