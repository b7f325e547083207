"""Definitions of all columns of a report's files: unit, type and a sentence.

`docs/report.md` shows these sentences, and tables on screen use them as help texts.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Final

from nvcore.comparison.measures.entry import NO_FRAMES, Measure
from nvcore.comparison.measures.table import MEASURES
from nvcore.tables.classes import CLASS_COLUMNS
from nvcore.tables.column import RECORDING, CellKind, Column, added_columns, measure_column, of_both
from nvcore.tables.columns.encounters import ENCOUNTER_COLUMNS
from nvcore.tables.columns.evidence import SIGNIFICANCE_COLUMNS, SUBGROUP_COLUMNS


def _measure_by_recording(measure: Measure) -> Column:
    column = measure_column(measure)
    return replace(
        column,
        meaning=measure.meaning_by_recording or column.meaning,
        empty=measure.empty_by_recording
        or ("recording without evaluated frames" if column.empty == NO_FRAMES else column.empty),
    )


def column_names(file: str) -> list[str]:
    """Return the columns of a CSV file of the report, in order."""
    return [column.name for column in report_columns()[file]]


_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER
_SHARE = "0 to 1"

_SYSTEM = Column("system", _TEXT, "", "Which system it is about: `x` or `y`.")
_FRAMES = (
    RECORDING,
    Column(
        "frame",
        _INTEGER,
        "",
        "Frame number, as in the truth's files (with a frame base of 1: one less).",
    ),
    Column("time_s", _NUMBER, "s", "Time since the recording's first evaluated frame."),
    Column("n_truth", _INTEGER, "boxes", "Annotated {many}, ignore regions left out."),
    *of_both(
        Column(
            "n_det",
            _INTEGER,
            "boxes",
            "Detections that count: those that pass the threshold, without those that an ignore "
            "region absorbs. `matched` + `false_alarms`.",
        ),
        Column("matched", _INTEGER, "boxes", "Annotated {many} that were matched.", "high"),
        Column("false_alarms", _INTEGER, "boxes", "Detections that match {nobody}.", "low"),
        Column(
            "d_miss",
            _NUMBER,
            "px",
            "Effect of misses, D(G, S): the largest weighted distance of {a_one} from its "
            "nearest detection, limited by the border; 0 without {many}.",
            "low",
        ),
        Column(
            "d_false",
            _NUMBER,
            "px",
            "Effect of false alarms, D(S, G): the same of a detection from its nearest {one}; "
            "0 without detections.",
            "low",
        ),
        Column(
            "loss_miss",
            _NUMBER,
            _SHARE,
            "What the frame loses to misses: `alpha` * `d_miss` over half the width.",
            "low",
        ),
        Column(
            "loss_false",
            _NUMBER,
            _SHARE,
            "What it loses to false alarms: (1 - `alpha`) * `d_false` over half the width. "
            "Similarity is 1 minus both.",
            "low",
        ),
        Column("similarity", _NUMBER, _SHARE, "Similarity M of this frame.", "high"),
        Column(
            "similarity_window",
            _NUMBER,
            _SHARE,
            "Mean similarity of the frames within half a `window` to either side.",
            "high",
        ),
        Column(
            "salient_track",
            _INTEGER,
            "",
            "Track of the {one} where `d_miss` stands, if it is large enough for saliency.",
            empty="`d_miss` is at most `tolerance` of half the width",
        ),
    ),
)

_SPAN = (
    Column("first_frame", _INTEGER, "", "Its first frame."),
    Column("last_frame", _INTEGER, "", "Its last frame."),
    Column("start_s", _NUMBER, "s", "Time of the first frame, as `time_s` in `frames.csv`."),
    Column("duration_s", _NUMBER, "s", "Sum of its frames' time steps.", "low"),
)

_EVENTS = (
    _SYSTEM,
    RECORDING,
    Column("track", _INTEGER, "", "Track of the missed {one}, as in `encounters.csv`."),
    *_SPAN,
    Column(
        "relevant_s", _NUMBER, "s", "Of these, time in which the {one} counts (k >= 0.5).", "low"
    ),
    Column(
        "weight_s",
        _NUMBER,
        "s",
        "What it weighs before recency: `duration_s`, or with `saliency_weight` `risk` the sum of "
        "weighted distance over half the width * time step.",
        "low",
    ),
    Column(
        "tau",
        _NUMBER,
        _SHARE,
        "Share of the recording (or encounter, by `saliency_scope`) that has passed at its end.",
    ),
    Column("rest_s", _NUMBER, "s", "Time from its end to the end of the same."),
    Column("recency", _NUMBER, _SHARE, "Weight of that moment: larger, the later it ends."),
    Column("saliency_s", _NUMBER, "s", "`weight_s` * `recency`.", "low"),
)

_INTERVALS = (
    _SYSTEM,
    RECORDING,
    *_SPAN,
    Column("depth_s", _NUMBER, "s", "Sum of (`low` - similarity) * time step.", "low"),
    Column("min_similarity", _NUMBER, _SHARE, "Its lowest similarity.", "high"),
    Column("worst_frame", _INTEGER, "", "The first frame that has it."),
)

VENN_COLUMNS: Final[tuple[Column, ...]] = (
    Column("both", _INTEGER, "encounters", "Encounters that both systems detected."),
    Column("x_only", _INTEGER, "encounters", "Encounters that only X detected."),
    Column("y_only", _INTEGER, "encounters", "Encounters that only Y detected."),
    Column("neither", _INTEGER, "encounters", "Encounters that neither system detected."),
    Column("distant", _INTEGER, "encounters", "Encounters that never came near enough to count."),
)
"""Counts of encounters by the systems that detected them, of one recording or of all."""

_RECORDINGS = (
    RECORDING,
    Column("width", _NUMBER, "px", "Width of the picture."),
    Column("height", _NUMBER, "px", "Height of the picture."),
    Column("fps", _NUMBER, "frames/s", "Frame rate."),
    Column(
        "context",
        _NUMBER,
        _SHARE,
        "Traffic context: 0 urban, 1 rural. Used unless `edge_weight` has a value.",
        empty="not stated: as 0",
    ),
    Column(
        "speed_kmh",
        _NUMBER,
        "km/h",
        "Speed of the car; where a series states it, the mean over its frames.",
        empty="not stated: the parameter `speed_kmh` is assumed",
    ),
    Column(
        "unit",
        _TEXT,
        "",
        "What it is one with in tests and intervals: what it is said to be part of, or the first "
        "of the recordings with the same truth.",
        empty="it stands by itself",
    ),
    Column("n_frames", _INTEGER, "frames", "Evaluated frames."),
    Column("duration_s", _NUMBER, "s", "Sum of their time steps."),
    Column("n_truth", _INTEGER, "boxes", "Annotated {many}, ignore regions left out."),
    *VENN_COLUMNS,
    *of_both(
        *(
            _measure_by_recording(measure)
            for measure in MEASURES
            if measure.by_recording is not None
        )
    ),
)

_FINDINGS = (
    Column(
        "severity",
        _TEXT,
        "",
        "`error`: the measures are wrong until it is mended; `warning`: they may be; `note`: good "
        "to know.",
    ),
    Column("code", _TEXT, "", "Short stable name of the kind of finding."),
    Column("subject", _TEXT, "", "Whom it is about: `truth`, or the name of a system."),
    Column("count", _INTEGER, "", "How many rows, frames or recordings it concerns."),
    Column("file", _TEXT, "", "File it was first seen in.", empty="no single file is to blame"),
    Column("example", _TEXT, "", "The first case: line, recording, frame.", empty="no single case"),
    Column("message", _TEXT, "", "What was found."),
    Column("advice", _TEXT, "", "What to do about it."),
)

_CODES = (
    RECORDING,
    Column("start_s", _NUMBER, "s", "Start of the stretch, as `time_s` in `frames.csv`."),
    Column("end_s", _NUMBER, "s", "Its end, which belongs to it."),
    Column("code", _TEXT, "", "The code: a class of the encounters that the stretch overlaps."),
)
_NO_BOX = "the case is a frame or a row without a box"
_NO_LINE = "it stands in no file"
_FINDING_ENTRIES = (
    Column("finding", _INTEGER, "", "Which row of `findings.csv` it belongs to, from 1."),
    Column("code", _TEXT, "", "That of the finding."),
    Column("subject", _TEXT, "", "That of the finding."),
    RECORDING,
    Column("frame", _INTEGER, "", "Frame number, as in `frames.csv`."),
    Column("x", _NUMBER, "px", "Left edge of the box.", empty=_NO_BOX),
    Column("y", _NUMBER, "px", "Upper edge of the box.", empty=_NO_BOX),
    Column("w", _NUMBER, "px", "Width of the box.", empty=_NO_BOX),
    Column("h", _NUMBER, "px", "Height of the box.", empty=_NO_BOX),
    Column("score", _NUMBER, "", "Score of the detection.", empty="it has none"),
    Column("track", _INTEGER, "", "Track id.", empty="it has none"),
    Column("file", _TEXT, "", "File that it stands in.", empty=_NO_LINE),
    Column("line", _INTEGER, "", "Line of that file; JSON counts records.", empty=_NO_LINE),
)

_TABLES: Final[dict[str, tuple[str, tuple[Column, ...]]]] = {
    "frames.csv": ("evaluated frames: counts, distances and similarity of each", _FRAMES),
    "encounters.csv": (
        "encounters: who detected the {one}, how each system failed, when",
        ENCOUNTER_COLUMNS,
    ),
    "events.csv": ("saliency events of X and Y", _EVENTS),
    "intervals.csv": ("low-similarity intervals of X and Y", _INTERVALS),
    "recordings.csv": ("recordings, with all aggregates", _RECORDINGS),
    "significance.csv": ("measures with interval and p of their difference", SIGNIFICANCE_COLUMNS),
    "subgroups.csv": ("groups of encounters, such as near and far", SUBGROUP_COLUMNS),
    "findings.csv": ("findings of the audit of the inputs", _FINDINGS),
    "finding_entries.csv": ("boxes, frames and rows that the findings concern", _FINDING_ENTRIES),
    "classes.csv": ("matches by the class of the truth and the one that was read", CLASS_COLUMNS),
    "codes.csv": ("stretches of recordings with a code", _CODES),
}
"""Rows and columns of the core's own tables."""


@cache
def report_columns() -> dict[str, tuple[Column, ...]]:
    """Return the columns of every CSV file of a report: the core's own, then those of subjects."""
    return {file: own + added_columns(file) for file, (_, own) in _TABLES.items()}


def table_contents() -> dict[str, str]:
    """Return templates that describe the contents of every CSV file of a report."""
    return {file: rows for file, (rows, _) in _TABLES.items()}
