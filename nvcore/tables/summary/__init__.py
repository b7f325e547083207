"""Aggregates in ``summary.json``: key, unit, type, description and value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache, partial
from itertools import chain
from operator import attrgetter
from typing import Any, Final

import numpy as np

from nvcore import __version__
from nvcore.common.subject import subjects
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import is_met
from nvcore.comparison.measures.table import MEASURES, hides_rate
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import Category
from nvcore.tables.column import CellKind, Column, measure_column
from nvcore.tables.columns import VENN_COLUMNS
from nvcore.tables.summary.entry import SummaryEntry

_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER
_NO_LEAD: Final = "no such encounter"

_OF_SYSTEM: Final = {measure.key: measure for measure in MEASURES if measure.meaning and measure.of}
"""Measures of each system, by key."""

SYSTEM_KEYS: Final[tuple[Column, ...]] = (
    Column("name", _TEXT, "", "Name of the system."),
    Column(
        "threshold",
        _NUMBER,
        "",
        "Score below which detections are left out.",
        empty="none was given (every detection counts), or it is infinite",
    ),
    *(measure_column(measure) for measure in MEASURES if measure.key in _OF_SYSTEM),
)
"""Keys of each system: below `x` and `y`, and below `fusion` for their combinations."""


def _lead_s(result: Result) -> np.ndarray:
    """Return the lead of X over Y in each encounter that both match, seconds."""
    lead_s = result.lead_time_s
    finite: np.ndarray = lead_s[np.isfinite(lead_s)]
    return finite


def _severity_of(result: Result, *, kind: Category, letter: str) -> float:
    return result.severity_of(result.system(letter))[kind]


_NOT_BORROWED: Final = "`missing_distance` is not `borrow`, or `proximity` not `distance`"
_BORROWED: Final = (
    SummaryEntry(
        Column(
            "truth.boxes_reported_distance",
            _INTEGER,
            "boxes",
            "{Many} weighted by a distance that their matches report.",
            empty=_NOT_BORROWED,
        ),
        lambda result: result.borrowed and result.borrowed.n_reported,
    ),
    SummaryEntry(
        Column(
            "truth.boxes_between_distances",
            _INTEGER,
            "boxes",
            "{Many} weighted by a distance interpolated along the track.",
            empty=_NOT_BORROWED,
        ),
        lambda result: result.borrowed and result.borrowed.n_between,
    ),
    SummaryEntry(
        Column(
            "truth.distances_lent",
            CellKind.TABLE,
            "boxes",
            "How many of the reported distances are from each system, by its name; several may "
            "report one.",
            empty=_NOT_BORROWED,
        ),
        lambda result: result.borrowed and result.borrowed.lent,
    ),
    SummaryEntry(
        Column(
            "truth.distance_spread",
            _NUMBER,
            "share",
            "Median range of the distances that several systems report of one {one}, as a "
            "share of their mean.",
            empty="as above, or no two systems report one",
        ),
        lambda result: result.borrowed and result.borrowed.spread,
    ),
)


def _threshold_as_set(result: Result, letter: str) -> float | None:
    return (result.as_set or result).system(letter).threshold


_ENTRIES: Final[tuple[SummaryEntry, ...]] = (
    SummaryEntry(Column("version", _TEXT, "", "Version of nvcore."), lambda _: __version__),
    SummaryEntry(
        Column(
            "fingerprint",
            _TEXT,
            "",
            "SHA-256 of the input files' content, how they were read, sizes, frame rates, and "
            "evaluated frames. The parameters are not in it.",
        ),
        lambda result: result.dataset.fingerprint,
    ),
    SummaryEntry(
        Column(
            "parameters",
            CellKind.TABLE,
            "",
            "Every parameter by name, those that act on what not all data have only where it is "
            "there or they were changed; null where it has no value.",
        ),
        lambda result: result.params.stated(result.dataset),
    ),
    SummaryEntry(
        Column(
            "operating_point",
            _TEXT,
            "",
            "`as-set`; or `equal-alarms`: one threshold was moved, so that X and Y have equally "
            "many false alarms.",
        ),
        lambda result: "as-set" if result.as_set is None else "equal-alarms",
    ),
    *(
        SummaryEntry(
            Column(
                f"as_set.threshold_{letter}",
                _NUMBER,
                "score",
                f"Threshold of {letter.upper()} as set; `{letter}.threshold` is the one in use.",
                empty="without a threshold",
            ),
            partial(_threshold_as_set, letter=letter),
        )
        for letter in "xy"
    ),
    SummaryEntry(
        Column("recordings", _INTEGER, "recordings", "Recordings compared."),
        lambda result: len(result.dataset.recordings),
    ),
    SummaryEntry(
        Column("frames", _INTEGER, "frames", "Evaluated frames."),
        lambda result: len(result.dataset.frames),
    ),
    SummaryEntry(Column("duration_s", _NUMBER, "s", "Sum of their time steps.")),
    SummaryEntry(
        Column("truth.boxes", _INTEGER, "boxes", "Annotated {many}, ignore regions left out."),
        lambda result: int(result.n_truth.sum()),
    ),
    SummaryEntry(
        Column("truth.boxes_ignored", _INTEGER, "boxes", "Ignore regions."),
        lambda result: int(np.count_nonzero(result.dataset.truth.ignore)),
    ),
    SummaryEntry(
        Column(
            "truth.encounters",
            _INTEGER,
            "encounters",
            "Encounters, those too far to count as well.",
        ),
        lambda result: len(result.encounters),
    ),
    SummaryEntry(
        Column(
            "truth.recordings_with_linked_tracks",
            _INTEGER,
            "recordings",
            "Recordings whose truth has no track ids (or not everywhere), so that tracks were "
            "linked.",
        ),
        lambda result: len(result.tracks.linked_recordings),
    ),
    SummaryEntry(
        Column(
            "truth.boxes_without_distance",
            _INTEGER,
            "boxes",
            "{Many} weighted by height because `proximity` is `distance` and they have none.",
        ),
        lambda result: result.k_truth.n_without_distance,
    ),
    *_BORROWED,
    SummaryEntry(
        Column("x", CellKind.TABLE, "", "System X; the keys are those of each system, below."),
        lambda result: system_summary(result, result.x),
    ),
    SummaryEntry(
        Column("y", CellKind.TABLE, "", "System Y; the same keys."),
        lambda result: system_summary(result, result.y),
    ),
    *(SummaryEntry(replace(column, name=f"venn.{column.name}")) for column in VENN_COLUMNS),
    *(
        SummaryEntry(
            Column(
                f"venn_severity_s.{kind.value}_{letter}",
                _NUMBER,
                "s",
                f"What the failures of {letter.upper()} weigh in the encounters of `{kind.value}`.",
                "low",
            ),
            partial(_severity_of, kind=kind, letter=letter),
        )
        for kind in Category
        if kind is not Category.DISTANT
        for letter in "xy"
    ),
    SummaryEntry(
        Column(
            "dominant",
            _TEXT,
            "",
            "`x` or `y`: the system that detects every encounter that the other does, and more.",
            empty="neither does",
        ),
        lambda result: result.venn.dominant,
    ),
    SummaryEntry(
        Column(
            "exclusivity.missed_by_x", _INTEGER, "encounters", "Encounters that X missed.", "low"
        )
    ),
    SummaryEntry(
        Column(
            "exclusivity.missed_by_y", _INTEGER, "encounters", "Encounters that Y missed.", "low"
        )
    ),
    SummaryEntry(
        Column(
            "exclusivity.missed_by_both", _INTEGER, "encounters", "Those that both missed.", "low"
        )
    ),
    SummaryEntry(
        Column(
            "exclusivity.jaccard",
            _NUMBER,
            "0 to 1",
            "Shared misses over all misses: 0 no miss is shared, 1 all are.",
            empty="no misses",
        )
    ),
    SummaryEntry(
        Column(
            "exclusivity.phi",
            _NUMBER,
            "-1 to 1",
            "Correlation of the two systems' misses.",
            empty="a system misses none or all",
        )
    ),
    SummaryEntry(
        Column(
            "exclusivity.mcnemar_p",
            _NUMBER,
            "0 to 1",
            "Exact McNemar p, within these drives: how likely a split of `x_only` against `y_only` "
            "at least this uneven is if both are equally good and encounters independent.",
            empty="most encounters are one frame long, or fewer than 6 tell the systems apart",
        ),
        attrgetter("mcnemar_p"),
    ),
    SummaryEntry(Column("boxes.both", _INTEGER, "boxes", "{One} boxes that both systems matched.")),
    SummaryEntry(Column("boxes.x_only", _INTEGER, "boxes", "{One} boxes that only X matched.")),
    SummaryEntry(Column("boxes.y_only", _INTEGER, "boxes", "{One} boxes that only Y matched.")),
    SummaryEntry(
        Column("boxes.neither", _INTEGER, "boxes", "{One} boxes that neither system matched.")
    ),
    SummaryEntry(
        Column(
            "lead_time_s.encounters",
            _INTEGER,
            "encounters",
            "Encounters that both systems matched in a frame that counts.",
        ),
        lambda result: len(_lead_s(result)),
    ),
    SummaryEntry(
        Column(
            "lead_time_s.mean",
            _NUMBER,
            "s",
            "Mean lead of X over Y in these; negative: Y was first.",
            empty=_NO_LEAD,
        ),
        lambda result: float(lead_s.mean()) if len(lead_s := _lead_s(result)) else None,
    ),
    SummaryEntry(
        Column("lead_time_s.median", _NUMBER, "s", "Its median.", empty=_NO_LEAD),
        lambda result: float(np.median(lead_s)) if len(lead_s := _lead_s(result)) else None,
    ),
    SummaryEntry(
        Column("fusion.x_or_y", CellKind.TABLE, "", "What `X or Y` would do; the same keys."),
        lambda result: system_summary(result.fusion, result.fusion.x),
    ),
    SummaryEntry(
        Column("fusion.x_and_y", CellKind.TABLE, "", "What `X and Y` would do; the same keys."),
        lambda result: system_summary(result.fusion, result.fusion.y),
    ),
)


@cache
def entries() -> tuple[SummaryEntry, ...]:
    """Return all entries of ``summary.json``, each a key with its value. Subjects' come last.

    Nested keys have dots. Keys of a system are in `SYSTEM_KEYS`.
    """
    return (*_ENTRIES, *chain(*(subject.tables().entries for subject in subjects())))


def summary_keys() -> tuple[Column, ...]:
    """Return the descriptions of all keys in `entries`."""
    return tuple(entry.column for entry in entries())


def summary(result: Result) -> dict[str, Any]:
    """Return all aggregates for JSON, with None for undefined values.

    Keys whose `Column.only_if` is not met are omitted.
    """
    content = _nest(
        {
            entry.column.name: entry.value(result)
            for entry in entries()
            if is_met(entry.column.only_if, result)
        }
    )
    aggregates: dict[str, Any] = without_nan(content)
    return aggregates


def system_summary(result: Result, system: SystemResult) -> dict[str, Any]:
    """Return the aggregates of one system over all recordings.

    Measures whose `Measure.only_if` is not met are omitted.
    """
    measures = {
        key: np.nan if hides_rate(measure, result.duration_s) else measure.of(result, system)
        for key, measure in _OF_SYSTEM.items()
        if measure.of is not None and is_met(measure.only_if, result)
    }
    return _nest({"name": system.name, "threshold": system.threshold, **measures})


def _nest(content: Mapping[str, Any]) -> dict[str, Any]:
    """Move entries named ``outer.inner`` into nested dictionaries."""
    nested: dict[str, Any] = {}
    for name, value in content.items():
        outer, _, inner = name.partition(".")
        if inner:
            nested.setdefault(outer, {})[inner] = value
        else:
            nested[name] = value
    return nested


def without_nan(value: Any) -> Any:
    """Convert to plain Python values, replacing NaN and infinities by None for JSON."""
    if isinstance(value, dict):
        return {key: without_nan(item) for key, item in value.items()}
    if isinstance(value, list):
        return [without_nan(item) for item in value]
    value = value.item() if isinstance(value, np.generic) else value
    return None if isinstance(value, float) and not np.isfinite(value) else value
