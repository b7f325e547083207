"""Sections of a comparison. Each function returns a `nvcore.report.section.Section`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from nvcore.common.subject import subjects
from nvcore.comparison.compare import Result
from nvcore.evidence.operating_points import alarms_as_set, are_unequal
from nvcore.notes import Note
from nvcore.report.section import Paragraphs, Section, SectionOf
from nvcore.report.sections.encounters import encounters_section
from nvcore.report.sections.results import (
    false_alerts_section,
    saliency_section,
    similarity_section,
)

__all__ = ["result_sections", "with_cautions"]

CAUTIONS: Final = {
    "encounters": Note("sections.short_encounters"),
    "saliency": Note("sections.short_encounters"),
    "significance": Note("sections.short_tests"),
    "subgroups": Note("sections.short_tests"),
}
"""First paragraphs of sections, by anchor, where most encounters are one frame long."""
AS_SET_SECTIONS: Final = (
    *("scorecard", "encounters", "similarity", "saliency", "false-alerts"),
    *("significance", "subgroups", "only-one"),
)
"""Anchors of the sections with numbers of X and Y as set; those of subjects are added."""


def result_sections(result: Result) -> list[Section]:
    """Return the sections on the measures of X and Y, including those of subjects.

    The scorecard is not among them, as the terminal has its own table of all measures.
    """
    return [
        encounters_section(result),
        *(of.make(result) for of in _of_subjects() if of.applies(result)),
        similarity_section(result),
        saliency_section(result),
        false_alerts_section(result),
    ]


def _of_subjects() -> list[SectionOf]:
    return [section for subject in subjects() for section in subject.report().sections]


def with_cautions(sections: Iterable[Section], result: Result) -> list[Section]:
    """Prepend cautions to sections whose numbers mean little in this comparison."""
    cautions: dict[str, list[Note]] = {}
    if are_unequal(result):
        as_set = Note("verdict.unequal_above", alarms=alarms_as_set(result))
        of_subjects = (of.anchor for of in _of_subjects())
        cautions |= {anchor: [as_set] for anchor in (*AS_SET_SECTIONS, *of_subjects)}
    if result.is_short:
        for anchor, note in CAUTIONS.items():
            cautions[anchor] = [*cautions.get(anchor, []), note]
    return [
        replace(
            section,
            blocks=(
                *(Paragraphs((note,)) for note in cautions.get(section.anchor, [])),
                *section.blocks,
            ),
        )
        for section in sections
    ]
