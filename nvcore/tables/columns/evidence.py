"""Columns of ``significance.csv``, ``subgroups.csv`` and ``matrix.csv``."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from nvcore.comparison.measures.table import MEASURES
from nvcore.tables.column import CellKind, Column

_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER

_TOO_FEW = "too few data for one (`note`)"
_NO_MCNEMAR, _NO_DETECTED, _NO_SIMILARITY = (
    f"too few data for one (`{name}_note`)"
    for name in ("mcnemar", "detected_by_unit", "similarity")
)

SIGNIFICANCE_COLUMNS: Final[tuple[Column, ...]] = (
    Column("figure", _TEXT, "", "Key of the measure."),
    Column("label", _TEXT, "", "What it is, with its unit."),
    Column("better", _TEXT, "", "`higher` or `lower`."),
    Column("x", _NUMBER, "measure's", "Of X.", empty="undefined"),
    Column("y", _NUMBER, "measure's", "Of Y.", empty="undefined"),
    Column("difference", _NUMBER, "measure's", "X minus Y.", empty="undefined"),
    Column("low", _NUMBER, "measure's", "Lower end of its 95 % interval.", empty=_TOO_FEW),
    Column("high", _NUMBER, "measure's", "Upper end.", empty=_TOO_FEW),
    Column(
        "p",
        _NUMBER,
        "0..1",
        "How often chance alone makes a difference as large, if X and Y could be exchanged.",
        empty=_TOO_FEW,
    ),
    Column(
        "p_corrected",
        _NUMBER,
        "0..1",
        "The same, corrected for what is tested together (docs/significance.md).",
        empty=f"{_TOO_FEW}, or another row has the same hypothesis",
    ),
    Column("least_p", _NUMBER, "0..1", "The least p that so many could give.", empty=_TOO_FEW),
    Column(
        "effect",
        _NUMBER,
        "",
        "Size of the difference.",
        empty="neither interval nor p, or an odds ratio that is infinite",
    ),
    Column("effect_name", _TEXT, "", "`Cohen's d_z` over the units, or `odds ratio`."),
    Column("n", _INTEGER, "units", "How many were compared."),
    Column("unit", _TEXT, "", "`encounters`, `recordings` or `blocks` of time."),
    Column(
        "scope",
        _TEXT,
        "",
        "What interval and p speak of: `other recordings` like these, or `these recordings` alone.",
    ),
    Column("method", _TEXT, "", "How interval and p were made.", empty="neither could be"),
    Column(
        "doubt",
        _TEXT,
        "",
        "Why no claim can rest on the difference, however small p is.",
        empty="no such reason",
    ),
    Column(
        "note",
        _TEXT,
        "",
        "Why something is missing, and what it does not say.",
        empty="nothing to say",
    ),
)

_EVIDENCE = {column.name: column for column in SIGNIFICANCE_COLUMNS}
_SPLIT = [
    (measure.key, measure.inference.split_in_group)
    for measure in MEASURES
    if measure.inference is not None and measure.inference.split_in_group
]
_NO_GROUP = "undefined for this group (`note`)"

SUBGROUP_COLUMNS: Final[tuple[Column, ...]] = (
    Column(
        "factor",
        _TEXT,
        "",
        "What encounters are divided by: `all`, `distance`, `place`, `occlusion`, `pose`, `class`, "
        "`tag`.",
    ),
    Column("group", _TEXT, "", "The part."),
    replace(_EVIDENCE["figure"], meaning="Key of the measure, as in `significance.csv`."),
    _EVIDENCE["label"],
    _EVIDENCE["better"],
    replace(_EVIDENCE["n"], meaning="How many were compared; 0: undefined for this group."),
    _EVIDENCE["unit"],
    Column(
        "both",
        _INTEGER,
        "encounters",
        "Of the group, detected by both systems"
        + "".join(f"; in `{key}`, here and in the next three, {what}" for key, what in _SPLIT)
        + ".",
        "high",
    ),
    Column("x_only", _INTEGER, "encounters", "Detected by X only."),
    Column("y_only", _INTEGER, "encounters", "Detected by Y only."),
    Column("neither", _INTEGER, "encounters", "Detected by neither.", "low"),
    *(replace(_EVIDENCE[name], empty=_NO_GROUP) for name in ("x", "y", "difference")),
    *(_EVIDENCE[name] for name in ("low", "high", "p")),
    replace(
        _EVIDENCE["p_corrected"],
        meaning="The same, corrected for all groups and measures (Holm).",
        empty=f"{_TOO_FEW}, `all`, or another row has the same hypothesis",
    ),
    _EVIDENCE["least_p"],
    _EVIDENCE["effect"],
    _EVIDENCE["effect_name"],
    Column(
        "odds_low",
        _NUMBER,
        "",
        "Lower end of the odds ratio's 95 % interval, which is exact for however few.",
        empty="{nobody} is detected by one system alone, or another effect",
    ),
    Column(
        "odds_high",
        _NUMBER,
        "",
        "Upper end.",
        empty="{nobody} is detected by one system alone, another effect, or it is infinite",
    ),
    _EVIDENCE["scope"],
    _EVIDENCE["method"],
    _EVIDENCE["doubt"],
    _EVIDENCE["note"],
)

_WITHIN = "within these recordings"


def _of_both(column: Column) -> tuple[Column, Column]:
    """Return the column of the first system, then that of the second."""
    return replace(column, name=f"{column.name}_x"), replace(column, name=f"{column.name}_y")


MATRIX_COLUMNS: Final[tuple[Column, ...]] = (
    Column("x", _TEXT, "", "The pair's first system."),
    Column("y", _TEXT, "", "Its second system."),
    *_of_both(Column("threshold", _NUMBER, "score", "Score threshold.", empty="all scores count")),
    *_of_both(
        Column(
            "false_alarms_per_frame",
            _NUMBER,
            "",
            "Detections that match {nobody}, per evaluated frame.",
            "low",
            empty="no evaluated frames",
        )
    ),
    Column(
        "is_unequal",
        CellKind.TRUTH_VALUE,
        "",
        "1: at unequal operating points, where p and claims are at equal false alarms, all else is "
        "as set.",
    ),
    Column("n_encounters", _INTEGER, "encounters", "Encounters that count."),
    Column("x_only", _INTEGER, "encounters", "Detected by the first alone."),
    Column("y_only", _INTEGER, "encounters", "Detected by the second alone."),
    *_of_both(
        Column("detected", _NUMBER, "0..1", "Share of encounters detected.", "high", "none counts")
    ),
    Column("difference", _NUMBER, "", "First minus second.", empty="none counts"),
    Column("low", _NUMBER, "", f"Lower end of its 95 % interval {_WITHIN}.", empty=_NO_MCNEMAR),
    Column("high", _NUMBER, "", "Upper end.", empty=_NO_MCNEMAR),
    Column("odds_ratio", _NUMBER, "", "`x_only` by `y_only`.", empty="undefined or infinite"),
    Column("mcnemar_p", _NUMBER, "0..1", f"McNemar's exact p {_WITHIN}.", empty=_NO_MCNEMAR),
    Column(
        "mcnemar_note",
        _TEXT,
        "",
        "Why there is none, and what it does not say.",
        empty="nothing to say",
    ),
    Column("n_units", _INTEGER, "units", "How many recordings or blocks were compared."),
    Column("unit", _TEXT, "", "`recordings`, or `blocks` of time within them."),
    Column(
        "detected_by_unit_low",
        _NUMBER,
        "",
        "Lower end of the 95 % interval of `difference` over these units.",
        empty=_NO_DETECTED,
    ),
    Column("detected_by_unit_high", _NUMBER, "", "Upper end.", empty=_NO_DETECTED),
    Column(
        "detected_by_unit_p",
        _NUMBER,
        "0..1",
        "How often chance alone makes a difference as large, if the two could be exchanged.",
        empty=_NO_DETECTED,
    ),
    Column(
        "detected_by_unit_p_holm",
        _NUMBER,
        "0..1",
        "The same, corrected for all pairs and both measures.",
        empty=_NO_DETECTED,
    ),
    Column(
        "detected_by_unit_note",
        _TEXT,
        "",
        "Why one is missing, and what they do not say.",
        empty="nothing to say",
    ),
    *_of_both(
        Column(
            "similarity", _NUMBER, "0..1", "Mean similarity.", "high", empty="no evaluated frames"
        )
    ),
    Column(
        "similarity_difference", _NUMBER, "", "First minus second.", empty="no evaluated frames"
    ),
    Column(
        "similarity_low",
        _NUMBER,
        "",
        "Lower end of its 95 % interval over the units.",
        empty=_NO_SIMILARITY,
    ),
    Column("similarity_high", _NUMBER, "", "Upper end.", empty=_NO_SIMILARITY),
    Column("similarity_p", _NUMBER, "0..1", "As `detected_by_unit_p`.", empty=_NO_SIMILARITY),
    Column(
        "similarity_p_holm", _NUMBER, "0..1", "As `detected_by_unit_p_holm`.", empty=_NO_SIMILARITY
    ),
    Column(
        "similarity_note",
        _TEXT,
        "",
        "Why one is missing, and what they do not say.",
        empty="nothing to say",
    ),
    Column(
        "detects_more",
        _TEXT,
        "",
        "The system of which it is claimed that it detects more encounters.",
        empty="nothing is claimed",
    ),
    Column(
        "higher_similarity",
        _TEXT,
        "",
        "The system of which it is claimed that it has the higher mean similarity.",
        empty="nothing is claimed",
    ),
    Column(
        "withheld",
        _TEXT,
        "",
        "Why a difference with a small p is no claim, such as that it does not hold at equal false "
        "alarms.",
        empty="no such difference",
    ),
)
