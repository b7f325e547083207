"""Columns of ``encounters.csv``."""

from __future__ import annotations

from typing import Final

from nvcore.tables.column import RECORDING, CellKind, Column, of_both

_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER
_SHARE: Final = "0 to 1"

_DISTANT = "too far to count"
_UNMATCHED = "too far to count, or matched in no frame that counts"

ENCOUNTER_COLUMNS: Final[tuple[Column, ...]] = (
    RECORDING,
    Column(
        "track",
        _INTEGER,
        "",
        "Track of the {one}: the truth's id, or a number given by linking where it has none.",
    ),
    Column("first_frame", _INTEGER, "", "First evaluated frame in which it is annotated."),
    Column("last_frame", _INTEGER, "", "Last evaluated frame in which it is annotated."),
    Column("n_relevant", _INTEGER, "frames", "Frames that count: it is near enough, k >= 0.5."),
    Column(
        "category", _TEXT, "", "Who detected it: `both`, `x_only`, `y_only`, `neither`, `distant`."
    ),
    *of_both(
        Column("matched", _INTEGER, "frames", "Frames that count in which it was matched.", "high"),
        Column("coverage", _NUMBER, _SHARE, "`matched` / `n_relevant`.", "high", empty=_DISTANT),
        Column(
            "detected",
            CellKind.TRUTH_VALUE,
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
        ),
        Column(
            "peak_cost",
            _NUMBER,
            _SHARE,
            "Largest cost among them: 1 is {a_one} straight ahead and near.",
            "low",
        ),
    ),
    Column(
        "lead_time_s",
        _NUMBER,
        "s",
        "`lag_s_y` - `lag_s_x`: how much earlier X matched it; negative: Y was first.",
        empty="X or Y matched it in no frame that counts",
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
        "Its classes, `;` between them: those in `attributes`, the codes of the stretches that it "
        "overlaps (`no_code`: none), and of `crossing`, `in_road`, `group` and `child` those that "
        "its boxes show.",
        empty="none",
    ),
)
