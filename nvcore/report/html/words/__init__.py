"""Introductions to the sections of the report, for a reader who does not have the program."""

from nvcore.report.html.words.evidence import (
    EVIDENCE,
    ONLY_ONE,
    PLAN,
    SIGNIFICANCE,
    STABILITY,
    SUBGROUPS,
)
from nvcore.report.html.words.inputs import (
    AUDIT,
    INPUTS,
    PARAMETERS,
)
from nvcore.report.html.words.results import (
    DETECTION,
    FALSE_ALERTS,
    NO_PICTURES,
    SHORT_ENCOUNTERS,
    SHORT_TESTS,
    VERDICT,
    classes,
    reading,
    saliency,
    scorecard,
    similarity,
    who,
)

__all__ = [
    "AUDIT",
    "DETECTION",
    "EVIDENCE",
    "FALSE_ALERTS",
    "INPUTS",
    "NO_PICTURES",
    "ONLY_ONE",
    "PARAMETERS",
    "PLAN",
    "SHORT_ENCOUNTERS",
    "SHORT_TESTS",
    "SIGNIFICANCE",
    "STABILITY",
    "SUBGROUPS",
    "VERDICT",
    "classes",
    "reading",
    "saliency",
    "scorecard",
    "similarity",
    "who",
]
