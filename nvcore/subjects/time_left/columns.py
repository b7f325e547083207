"""Columns for CSV files and keys for ``summary.json`` that time left adds to a report."""

from __future__ import annotations

from functools import partial
from typing import Any, Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.values import per_recording
from nvcore.subjects.time_left.kinds import Urgency
from nvcore.subjects.time_left.steps import confirmed_by, time_left_in, time_left_of
from nvcore.tables.column import CellKind, Column, Columns, of_both
from nvcore.tables.result import frame_numbers
from nvcore.tables.summary.entry import SummaryEntry

_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER
_NOT_URGENT: Final = "`urgency` is not `urgent`"

_ENCOUNTERS: Final = (
    *of_both(
        Column(
            "time_left",
            _TEXT,
            "",
            "Whether the system confirmed the {one} before `urgent_frame`: `in_time`, `late`, "
            "`never`.",
            empty=_NOT_URGENT,
        ),
        Column(
            "confirmed_frame",
            _INTEGER,
            "",
            "First frame in which `confirm_n` of the last `confirm_m` are matched.",
            empty="never, or not every frame is evaluated, or the track was linked",
        ),
        Column(
            "margin_s",
            _NUMBER,
            "s",
            "Time from `confirmed_frame` to `urgent_frame`; negative: too late.",
            "high",
            f"{_NOT_URGENT}, or never confirmed",
        ),
        Column(
            "impact_kmh",
            _NUMBER,
            "km/h",
            "Speed with which the car reaches the {one}, if it brakes after `confirmed_frame`.",
            "low",
            empty=_NOT_URGENT,
        ),
    ),
    Column(
        "min_ttc_s",
        _NUMBER,
        "s",
        "Least time to contact; `inf`: the {one} is never being approached.",
        empty="known in no frame",
    ),
    Column(
        "urgency",
        _TEXT,
        "",
        "Whether there is a last chance to stop, the first that holds: `unknown`, `not_urgent`, "
        "`outside` (of the `corridor`), `no_chance` (too near from the first known time to contact "
        "on), `urgent`.",
    ),
    Column(
        "urgent_frame",
        _INTEGER,
        "",
        "First frame from which on the car could no longer stop: the last chance.",
        empty="`unknown` or `not_urgent`",
    ),
)


def _of_encounters(result: Result) -> dict[str, Any]:
    view = time_left_in(result)
    columns: dict[str, Any] = {}
    for letter, system in result.sides:
        judged = time_left_of(system)
        confirmed_row = np.where(view.contact.is_judged, confirmed_by(system)["confirmed_row"], -1)
        columns |= {
            f"time_left_{letter}": judged["time_left"],
            f"confirmed_frame_{letter}": frame_numbers(result, confirmed_row),
            f"margin_s_{letter}": judged["margin_s"],
            f"impact_kmh_{letter}": judged["impact_kmh"],
        }
    urgency = view.urgency
    return columns | {
        "min_ttc_s": urgency["min_ttc_s"],
        "urgency": urgency["urgency"],
        "urgent_frame": frame_numbers(result, urgency["urgent_row"].to_numpy()),
    }


def _of_frames(result: Result) -> dict[str, Any]:
    least = np.full(len(result.dataset.frames), np.nan)
    np.fmin.at(least, result.dataset.truth.frame_index, time_left_in(result).contact.ttc_s)
    return {"min_ttc_s": least}


def _of_recordings(result: Result) -> dict[str, Any]:
    is_urgent = time_left_in(result).is_urgent
    urgent = per_recording(result, is_urgent, result.encounters.recording)
    return {"urgent": urgent.astype(np.int64)}


COLUMNS: Final = (
    Columns("encounters.csv", _ENCOUNTERS, _of_encounters),
    Columns(
        "frames.csv",
        (
            Column(
                "min_ttc_s",
                _NUMBER,
                "s",
                "Least time to contact of its {many}; `inf`: none is being approached.",
                empty="known of no {one}",
            ),
        ),
        _of_frames,
    ),
    Columns(
        "recordings.csv",
        (
            Column(
                "urgent",
                _INTEGER,
                "encounters",
                "Encounters that are urgent, as in `encounters.csv`.",
            ),
        ),
        _of_recordings,
    ),
)
"""Columns of the CSV files."""


def _count(result: Result, *, kind: Urgency) -> int:
    return time_left_in(result).count_urgency()[kind]


ENTRIES: Final = (
    *(
        SummaryEntry(Column(key, _INTEGER, "encounters", meaning), partial(_count, kind=kind))
        for key, kind, meaning in (
            (
                "urgent",
                Urgency.URGENT,
                "Encounters with a last chance to stop before the {one}: of these are "
                "`in_time`, `late` and `never` of each system.",
            ),
            (
                "no_chance",
                Urgency.NO_CHANCE,
                "Encounters too near to stop from the first known time to contact on.",
            ),
            ("not_urgent", Urgency.NOT_URGENT, "Encounters in which it could stop throughout."),
            (
                "outside_corridor",
                Urgency.OUTSIDE,
                "Encounters outside the `corridor` when it could no longer stop.",
            ),
            (
                "urgency_unknown",
                Urgency.UNKNOWN,
                "Encounters without any known time to contact: too short, or cut by the picture's "
                "edge, or not every frame is evaluated, or the tracks were linked.",
            ),
        )
    ),
    SummaryEntry(
        Column(
            "recordings_with_assumed_speed",
            _INTEGER,
            "recordings",
            "Recordings that do not state the car's speed: the parameter `speed_kmh` is assumed.",
        ),
        lambda result: int(np.count_nonzero(time_left_in(result).has_assumed_speed)),
    ),
)
"""Keys of ``summary.json``."""
