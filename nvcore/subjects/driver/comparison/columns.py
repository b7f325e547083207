"""Columns about the driver in the CSV files of a report and in ``summary.json``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.values import per_recording
from nvcore.dataset import Dataset
from nvcore.dataset.schema import integers_of
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.subjects.driver.comparison.in_time import (
    is_driver_in_time,
    is_judged_in_time,
    is_seen_too_late,
)
from nvcore.subjects.driver.comparison.judging import DRIVER_REGION_TEXT, DriverRegion, is_unknown
from nvcore.subjects.driver.comparison.measures import KNOWN
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.tables.column import CellKind, Column, Columns
from nvcore.tables.result import frame_numbers, truth_values
from nvcore.tables.summary.entry import SummaryEntry

_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER
_SHARE: Final = "0 to 1"
_NOT_URGENT: Final = "`urgency` is not `urgent`"
_UNKNOWN: Final = "too far to count, or known in no frame up to then"

_ENCOUNTERS: Final = (
    Column(
        "detectability",
        _NUMBER,
        _SHARE,
        "Largest detectability up to the first frame that counts: the share of drivers who would "
        "see the {one} by themselves.",
        empty=_UNKNOWN,
    ),
    Column(
        "detectability_sd",
        _NUMBER,
        _SHARE,
        "Standard deviation of that estimate.",
        empty=f"{_UNKNOWN}, or not given",
    ),
    Column(
        "detectability_frames",
        _INTEGER,
        "frames",
        "Frames up to the first that counts in which detectability is known.",
    ),
    Column(
        "outside_training",
        CellKind.TRUTH_VALUE,
        "",
        "Whether what decides was estimated outside the range of the training: `detectability`, "
        "which is of one frame, and where it is below `driver_threshold` that of any frame up to "
        "the first that counts. `outside_features` in the file of estimates says by which feature.",
        empty=_UNKNOWN,
    ),
    Column(
        "adapted_eyes",
        CellKind.TRUTH_VALUE,
        "",
        "Whether `detectability` was estimated for adapted eyes, since no change from bright to "
        "dark is known before: in bright light it says little.",
        empty=_UNKNOWN,
    ),
    Column(
        "within_sd",
        CellKind.TRUTH_VALUE,
        "",
        "Whether `detectability` is no further than `detectability_sd` from the parameter "
        "`driver_threshold`: whether the driver sees the {one} is open then.",
        empty=f"{_UNKNOWN}, or no standard deviation is given",
    ),
    Column(
        "driver_sees",
        CellKind.TRUTH_VALUE,
        "",
        "Whether the driver sees the {one} unaided: detectability reaches the parameter "
        "`driver_threshold` in a frame up to the first that counts.",
        empty=_UNKNOWN,
    ),
    Column(
        "driver_seen_frames",
        _INTEGER,
        "frames",
        "In how many frames up to the first that counts it does: one is enough.",
        empty=_UNKNOWN,
    ),
    Column(
        "driver_frame",
        _INTEGER,
        "",
        "The first such frame: when the driver confirms.",
        empty="the driver does not see the {one}, or it is unknown",
    ),
    Column(
        "driver_in_time",
        CellKind.TRUTH_VALUE,
        "",
        "Whether detectability reaches `driver_threshold` in a frame before `urgent_frame`, also "
        "where that is after the first that counts, so that `driver_frame` is empty.",
        empty=f"{_NOT_URGENT}, or it is unknown whether the driver sees the {{one}}",
    ),
    Column(
        "driver_region",
        _TEXT,
        "",
        "Who sees the {one}, of driver, X and Y: `driver_x_y`, `driver_x`, `driver_y`, "
        "`driver`, `x_y`, `x`, `y`, `nobody`, `unknown`, `distant`.",
    ),
)

_VIEWS: Final = (
    Column(
        "has_visible",
        CellKind.TRUTH_VALUE,
        "",
        "Whether the session names pictures of visible light, by `visible`.",
    ),
    Column(
        "light_by",
        _TEXT,
        "",
        "What tells the light: `meter`, a light meter's file, or `picture`, the mean luminance of "
        "those pictures.",
        empty="the session names neither",
    ),
    Column("has_gaze", CellKind.TRUTH_VALUE, "", "Whether a file says where the driver looked."),
)

_KNOWN: Final = (
    Column(
        "driver_known",
        _INTEGER,
        "encounters",
        "Encounters that count of which it is known whether the driver sees them.",
    ),
)


def _of_encounters(result: Result) -> dict[str, Any]:
    """Return the columns about the driver's view of each encounter."""
    driver = driver_in(result)
    table, is_known = driver.table, driver.is_known
    return {
        "detectability": table["detectability"],
        "detectability_sd": table["sd"],
        "detectability_frames": table["n_known"],
        "outside_training": truth_values(table["is_outside"].to_numpy(), is_known),
        "adapted_eyes": truth_values(driver.is_adapted, is_known),
        "within_sd": truth_values(driver.is_within_sd, driver.has_sd),
        "driver_sees": truth_values(driver.is_seen, is_known),
        "driver_seen_frames": integers_of(table["n_seen"].to_numpy(), is_known),
        "driver_frame": frame_numbers(result, table["seen_row"].to_numpy()),
        "driver_in_time": truth_values(is_driver_in_time(result), is_judged_in_time(result)),
        "driver_region": driver.region,
    }


def driver_views(dataset: Dataset) -> dict[str, np.ndarray]:
    """Return which data on the driver's view each recording has, according to the session.

    Returns
    -------
    By name, shape (n_recordings,): has_visible (bool, visible-light pictures), light_by ("meter",
    "picture" or empty: source of the brightness), has_gaze (bool, gaze file).
    """
    names = dataset.recordings["name"].tolist()
    session = dataset.settings
    entries = session.entries(names) if isinstance(session, Session) else {}
    own = [entries.get(name, RecordingEntry(name)) for name in names]
    return {
        "has_visible": np.array([entry.visible is not None for entry in own], bool),
        "light_by": np.array(
            ["meter" if entry.light else "picture" if entry.visible else "" for entry in own],
            object,
        ),
        "has_gaze": np.array([entry.gaze is not None for entry in own], bool),
    }


def _known_by_recording(result: Result) -> dict[str, Any]:
    is_known = per_recording(result, driver_in(result).is_known, result.encounters.recording)
    return {"driver_known": is_known.astype(np.int64)}


COLUMNS: Final = (
    Columns("encounters.csv", _ENCOUNTERS, _of_encounters, only_if=KNOWN),
    Columns("recordings.csv", _VIEWS, lambda result: driver_views(result.dataset)),
    Columns("recordings.csv", _KNOWN, _known_by_recording, only_if=KNOWN),
)
"""Columns of the CSV files."""

_NOBODY_URGENT: Final = "it is known of no urgent encounter whether the driver sees it"
Members = Callable[[Result], np.ndarray]
"""Mask of the encounters of a kind, bool, shape (n_encounters,)."""


def _entry(
    key: str,
    meaning: str,
    members: Members,
    *,
    of: Members | None = None,
    unit: str = "encounters",
    empty: str = "",
) -> SummaryEntry:
    """Return an entry that counts encounters. It is None without encounters of kind `of`."""

    def count(result: Result) -> int | None:
        is_defined = of is None or of(result).any()
        return int(np.count_nonzero(members(result))) if is_defined else None

    column = Column(key, CellKind.INTEGER, unit, meaning, empty=empty, only_if=KNOWN)
    return SummaryEntry(column, count)


def _region_entry(region: DriverRegion) -> SummaryEntry:
    meaning = DRIVER_REGION_TEXT[region]
    return _entry(
        f"driver_venn.{region.value}", meaning, lambda result: driver_in(result).region == region
    )


ENTRIES: Final = (
    _entry(
        "driver.seen",
        "Encounters that the driver sees unaided.",
        lambda result: driver_in(result).is_seen,
    ),
    _entry(
        "driver.unseen",
        "Encounters that the driver is known not to see.",
        lambda result: driver_in(result).is_unseen,
    ),
    _entry(
        "driver.outside_training",
        "Of both, those decided by an estimate outside the range of the training: by the largest "
        "up to the first frame that counts, and where that is below `driver_threshold` by any.",
        lambda result: driver_in(result).is_outside,
    ),
    _entry(
        "driver.adapted",
        "Of both, those decided by an estimate for adapted eyes, since no change from bright to "
        "dark is known before.",
        lambda result: driver_in(result).is_adapted,
    ),
    _entry(
        "driver.within_sd",
        "Of both, those whose largest one is no further than its standard deviation from "
        "`driver_threshold`: whether the driver sees them is open.",
        lambda result: driver_in(result).is_within_sd,
        of=lambda result: driver_in(result).has_sd,
        empty="no encounter has a standard deviation",
    ),
    _entry(
        "driver.seldom",
        "Of those seen, the ones that the driver sees in fewer than half of the frames up to the "
        "first that counts in which it is known.",
        lambda result: driver_in(result).is_seldom_seen,
    ),
    _entry(
        "driver.urgent",
        "Urgent encounters of which it is known whether the driver sees them.",
        is_judged_in_time,
    ),
    _entry(
        "driver.in_time",
        "Of these, the ones that the driver sees while the car can still stop.",
        is_driver_in_time,
        of=is_judged_in_time,  # so that the rule fails if no encounter is urgent
        empty=_NOBODY_URGENT,
    ),
    _entry(
        "driver.too_late",
        "Of these, the ones that the driver sees, but only when the car can no longer stop.",
        is_seen_too_late,
        of=is_judged_in_time,
        empty=_NOBODY_URGENT,
    ),
    _entry(
        "driver.boxes_without_detectability",
        "{One} boxes of unknown detectability; with `driver_weighting` they weigh in full.",
        lambda result: is_unknown(result.dataset),
        unit="boxes",
    ),
    *map(_region_entry, tuple(DriverRegion)[:-1]),
)
"""Keys of ``summary.json``."""
