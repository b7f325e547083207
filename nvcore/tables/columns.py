"""What every column of a report's files holds: unit, type and a sentence.

`docs/report.md` shows these sentences; tables on screen take their help texts from here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from nvcore.measures import MEASURES, NO_FRAMES, Measure
from nvcore.tables.column import Column, Kind, measure_column
from nvcore.tables.evidence_columns import SIGNIFICANCE_COLUMNS, SUBGROUP_COLUMNS


def _of_both(*columns: Column) -> tuple[Column, ...]:
    """The columns of X, then the same of Y."""
    return tuple(
        replace(column, name=f"{column.name}_{letter}") for letter in "xy" for column in columns
    )


def _measure_by_recording(measure: Measure) -> Column:
    column = measure_column(measure)
    return replace(
        column,
        meaning=measure.meaning_by_recording or column.meaning,
        empty="recording without evaluated frames" if column.empty == NO_FRAMES else column.empty,
    )


def column_names(file: str) -> list[str]:
    """Columns of a CSV file of the report, in order."""
    return [column.name for column in REPORT_COLUMNS[file]]


_TEXT, _INTEGER, _NUMBER = Kind.TEXT, Kind.INTEGER, Kind.NUMBER
_SHARE = "0 to 1"

_RECORDING = Column("recording", _TEXT, "", "Name of the recording.")
_SYSTEM = Column("system", _TEXT, "", "Which system it is about: `x` or `y`.")
_DISTANT = "too far to count"
_NOT_URGENT = "`urgency` is not `urgent`"
_UNMATCHED = "too far to count, or matched in no frame that counts"

_FRAMES = (
    _RECORDING,
    Column(
        "frame",
        _INTEGER,
        "",
        "Frame number, as in the truth's files (with a frame base of 1: one less).",
    ),
    Column("time_s", _NUMBER, "s", "Time since the recording's first evaluated frame."),
    Column("n_truth", _INTEGER, "boxes", "Annotated pedestrians, ignore regions left out."),
    Column(
        "min_ttc_s",
        _NUMBER,
        "s",
        "Least time to contact of its pedestrians; `inf`: none is being approached.",
        empty="known of no pedestrian",
    ),
    *_of_both(
        Column(
            "n_det",
            _INTEGER,
            "boxes",
            "Detections that count: those that pass the threshold, without those that an ignore "
            "region absorbs. `matched` + `false_alarms`.",
        ),
        Column("matched", _INTEGER, "boxes", "Annotated pedestrians that were matched.", "high"),
        Column("false_alarms", _INTEGER, "boxes", "Detections that match nobody.", "low"),
        Column(
            "d_miss",
            _NUMBER,
            "px",
            "Effect of misses, D(G, S): the largest weighted distance of a pedestrian from its "
            "nearest detection, limited by the border; 0 without pedestrians.",
            "low",
        ),
        Column(
            "d_false",
            _NUMBER,
            "px",
            "Effect of false alarms, D(S, G): the same of a detection from its nearest pedestrian; "
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
            "Similarity is 1 less both.",
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
            "Track of the pedestrian at whom `d_miss` stands, if it is large enough for saliency.",
            empty="`d_miss` is at most `tolerance` of half the width",
        ),
    ),
)

_ENCOUNTERS = (
    _RECORDING,
    Column(
        "track",
        _INTEGER,
        "",
        "Track of the pedestrian: the truth's id, or a number given by linking where it has none.",
    ),
    Column("first_frame", _INTEGER, "", "First evaluated frame in which it is annotated."),
    Column("last_frame", _INTEGER, "", "Last evaluated frame in which it is annotated."),
    Column("n_relevant", _INTEGER, "frames", "Frames that count: it is near enough, k >= 0.5."),
    Column(
        "category",
        _TEXT,
        "",
        "Who detected it: `both`, `x_only`, `y_only`, `neither`, `distant`.",
    ),
    *_of_both(
        Column("matched", _INTEGER, "frames", "Frames that count in which it was matched.", "high"),
        Column("coverage", _NUMBER, _SHARE, "`matched` / `n_relevant`.", "high", empty=_DISTANT),
        Column(
            "detected",
            Kind.TRUTH_VALUE,
            "",
            "Whether the system detected it: coverage is at least the parameter `coverage`, and "
            "a frame that counts is matched.",
            "high",
            _DISTANT,
        ),
        Column(
            "miss_class",
            _TEXT,
            "",
            "How the system failed: `never`, `late`, `dropout`, `lost_early`, `brief`; `none` is a "
            "value, too: no failure.",
            empty=_DISTANT,
        ),
        Column(
            "lag_s",
            _NUMBER,
            "s",
            "Time from the first frame that counts to the first of them that is matched.",
            "low",
            _UNMATCHED,
        ),
        Column(
            "gap_s",
            _NUMBER,
            "s",
            "Longest time of unmatched frames that count between two matched ones.",
            "low",
            _UNMATCHED,
        ),
        Column(
            "tail_s",
            _NUMBER,
            "s",
            "Time of the unmatched frames that count after the last matched one.",
            "low",
            _UNMATCHED,
        ),
        Column(
            "severity_s",
            _NUMBER,
            "s",
            "What its failures weigh: sum of cost * time step over the frames that count in which "
            "it was not matched; 1 s is one second of a full-weight miss.",
            "low",
            _DISTANT,
        ),
        Column(
            "peak_cost",
            _NUMBER,
            _SHARE,
            "Largest cost among them: 1 is a pedestrian straight ahead and near.",
            "low",
            _DISTANT,
        ),
        Column(
            "time_left",
            _TEXT,
            "",
            "Whether the system confirmed the pedestrian before `urgent_frame`: `in_time`, `late`, "
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
            "Speed with which the car reaches him, if it brakes after `confirmed_frame`.",
            "low",
            _NOT_URGENT,
        ),
    ),
    Column(
        "lead_time_s",
        _NUMBER,
        "s",
        "`lag_s_y` - `lag_s_x`: how much earlier X matched it; negative: Y was first.",
        empty="X or Y matched it in no frame that counts",
    ),
    Column(
        "min_ttc_s",
        _NUMBER,
        "s",
        "Least time to contact; `inf`: the pedestrian is never being approached.",
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
    Column("n_frames", _INTEGER, "frames", "Evaluated frames in which it is annotated."),
    Column(
        "lateral_offset",
        _NUMBER,
        _SHARE,
        "Mean distance from the picture's middle over half the width: 0 middle, 1 edge.",
    ),
    Column(
        "lateral_position",
        _NUMBER,
        "-1 to 1",
        "Mean position: -1 left edge, 0 middle, 1 right edge.",
    ),
    Column("peak_height", _NUMBER, "px", "Largest height of its boxes."),
    Column("peak_k", _NUMBER, _SHARE, "Largest proximity weight k; below 0.5: too far to count."),
    Column("aspect_ratio", _NUMBER, "", "Mean height over width of its boxes."),
    Column(
        "aspect_z",
        _NUMBER,
        "",
        "How far that is from the mean of all encounters, in standard deviations.",
        empty="fewer than two encounters, or all of one ratio",
    ),
    Column(
        "occluded_share",
        _NUMBER,
        _SHARE,
        "Share of its boxes that are at least partly occluded, of those where it is known.",
        empty="occlusion unknown throughout",
    ),
    Column(
        "attributes",
        _TEXT,
        "",
        "What the truth's column `attributes` says of it in most frames.",
        empty="nothing",
    ),
    Column(
        "classes",
        _TEXT,
        "",
        "Its classes, `;` between them: those in `attributes`, and of `crossing`, `in_road`, "
        "`group` and `child` those that its boxes show.",
        empty="none",
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
    _RECORDING,
    Column("track", _INTEGER, "", "Track of the missed pedestrian, as in `encounters.csv`."),
    *_SPAN,
    Column(
        "relevant_s",
        _NUMBER,
        "s",
        "Of these, time in which the pedestrian counts (k >= 0.5).",
        "low",
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
    _RECORDING,
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
"""Counts of encounters by who detected them, of one recording or of all."""

_RECORDINGS = (
    _RECORDING,
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
        "Speed of the car.",
        empty="not stated: the parameter `speed_kmh` is assumed",
    ),
    Column("n_frames", _INTEGER, "frames", "Evaluated frames."),
    Column("duration_s", _NUMBER, "s", "Sum of their time steps."),
    Column("n_truth", _INTEGER, "boxes", "Annotated pedestrians, ignore regions left out."),
    *VENN_COLUMNS,
    Column("urgent", _INTEGER, "encounters", "Encounters that are urgent, as in `encounters.csv`."),
    *_of_both(
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

_NO_BOX = "the case is a frame or a row without a box"
_NO_LINE = "it stands in no file"
_FINDING_ENTRIES = (
    Column("finding", _INTEGER, "", "Which row of `findings.csv` it belongs to, from 1."),
    Column("code", _TEXT, "", "That of the finding."),
    Column("subject", _TEXT, "", "That of the finding."),
    _RECORDING,
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

REPORT_COLUMNS: Final[dict[str, tuple[Column, ...]]] = {
    "frames.csv": _FRAMES,
    "encounters.csv": _ENCOUNTERS,
    "events.csv": _EVENTS,
    "intervals.csv": _INTERVALS,
    "recordings.csv": _RECORDINGS,
    "significance.csv": SIGNIFICANCE_COLUMNS,
    "subgroups.csv": SUBGROUP_COLUMNS,
    "findings.csv": _FINDINGS,
    "finding_entries.csv": _FINDING_ENTRIES,
}
"""Columns of every CSV file of a report, in order."""
