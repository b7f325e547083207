"""The content of the report in order: sections of texts, tables, charts and frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

from nvcore import __version__
from nvcore.arguments.report import Inscription
from nvcore.comparison import Result
from nvcore.evidence.operating_points import alarms_as_set, are_unequal
from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.evidence.table import judge_both
from nvcore.findings import Finding
from nvcore.notes import Note, say
from nvcore.palette import Scheme, Theme, scheme_of
from nvcore.pictures.recordings import RecordingPictures
from nvcore.progress import Progress, part_of
from nvcore.protocols import Protocol
from nvcore.report.decisive_moments import decisive_moments
from nvcore.report.html import words
from nvcore.report.html.blocks import Section, Sentences
from nvcore.report.html.classes_section import classes_section
from nvcore.report.html.cover import Cover, cover_of
from nvcore.report.html.encounter_sections import encounters_section, only_one_section
from nvcore.report.html.evidence_sections import (
    frames_section,
    planned_verdict,
    significance_section,
    subgroups_section,
    verdict_section,
)
from nvcore.report.html.frames import photo
from nvcore.report.html.input_sections import audit_section, inputs_section, parameters_section
from nvcore.report.html.plan_section import plan_measures, plan_section
from nvcore.report.html.result_sections import (
    false_alerts_section,
    saliency_section,
    scorecard_section,
    similarity_section,
)
from nvcore.report.html.settings_sections import detection_section, stability_section
from nvcore.stability.map import MAPS
from nvcore.subjects import contributed
from nvcore.tables.classes import has_classes
from nvcore.tables.pictures import pictures_table
from nvcore.wording import UNDEFINED, one_line

CAUTION = {
    "encounters": words.SHORT_ENCOUNTERS,
    "saliency": words.SHORT_ENCOUNTERS,
    "significance": words.SHORT_TESTS,
    "subgroups": words.SHORT_TESTS,
}
"""First sentences of these sections, by their anchors."""

AS_SET_SECTIONS = (
    *("scorecard", "encounters", "similarity", "saliency", "false-alerts"),
    *("significance", "subgroups", "only-one"),
)
"""Sections with numbers of X and Y as set, by their anchors; those of subjects are, too."""


@dataclass(frozen=True)
class Content:
    """The content of the page.

    Attributes
    ----------
    title
        The author's, or which systems are compared.
    cover
        The first page.
    names
        Names of X and Y.
    facts
        Labels and texts: protocol, program and fingerprint.
    sections
        Sections, in order.
    theme
        In which the systems have their colours.
    version, fingerprint
        Of the program and of the inputs.
    """

    title: str
    cover: Cover
    names: tuple[str, str]
    facts: tuple[tuple[str, str], ...]
    sections: tuple[Section, ...]
    theme: Scheme
    version: str
    fingerprint: str


def report_content(
    result: Result,
    findings: Sequence[Finding],
    *,
    pictures: RecordingPictures,
    protocol: Protocol,
    stability: bool | None,
    inscription: Inscription,
    progress: Progress,
) -> Content:
    """Gather the report."""
    inscription = inscription.in_short()
    progress(0.0, "testing the differences")
    evidence, companions = judge_both(result, protocol)
    subgroups = subgroup_table(result, protocol=protocol)
    progress(0.15, "detection curves")
    detection = detection_section(result, protocol)
    plans = plan_measures(result, evidence, protocol, progress=part_of(progress, 0.2, 0.3))
    progress(0.3, "tables")
    theme = result.scheme("light")
    conclusion = planned_verdict(result, findings, evidence, companions, plans)
    sections = [
        verdict_section(conclusion),
        scorecard_section(result),
        encounters_section(result),
        *(of.make(result) for of in chain(*contributed("sections")) if of.applies(result)),
        similarity_section(result),
        saliency_section(result),
        false_alerts_section(result),
        significance_section(result, evidence, theme),
        plan_section(result, evidence, plans),
        subgroups_section(subgroups, theme),
        detection,
        *([classes_section(result)] if has_classes(result) else []),
    ]
    progress(0.4, MAPS)
    maps = part_of(progress, 0.4, 0.6)
    sections.append(stability_section(result, evidence, is_wanted=stability, progress=maps))
    moments = decisive_moments(result)
    photos = []
    for number, moment in enumerate(moments):
        progress(0.6 + 0.3 * number / len(moments), "evidence frames")
        photos.append(photo(result, moment, pictures))
    names = result.dataset.recordings["name"]
    troubles = [
        f"{one_line(str(names.iloc[number]))}: {one_line(why)}"
        for number, why in pictures.troubles.items()
    ]
    sections += [
        frames_section(photos, troubles, result.objects),
        only_one_section(result),
        audit_section(findings),
        inputs_section(result, pictures_table(result.dataset, pictures)),
        parameters_section(result),
        Section(
            "reading",
            "How to read this report",
            None,
            (Sentences(tuple(map(result.objects.say, words.reading(result.params, theme)))),),
        ),
    ]
    progress(0.9, "the page")
    compared = f"{one_line(result.x.name)} (X) and {one_line(result.y.name)} (Y) compared"
    cover = cover_of(result, conclusion, evidence, companions, photos, inscription, compared)
    sections = _as_set(_with_caution(sections, result) if result.is_short else sections, result)
    return Content(
        title=inscription.title or compared,
        cover=cover,
        names=(one_line(result.x.name), one_line(result.y.name)),
        facts=_facts(result, protocol),
        sections=tuple(_said(section, result, theme) for section in sections),
        theme=scheme_of(theme),
        version=__version__,
        fingerprint=result.dataset.fingerprint,
    )


def _said(section: Section, result: Result, theme: Theme) -> Section:
    """The section, its title and introduction in words for the objects, with X's and Y's look."""
    x, y = (scheme_of(theme).style(letter) for letter in "xy")
    intro = section.intro and section.intro.said(result.objects, x=x, y=y)
    return replace(section, title=result.objects.say(section.title), intro=intro)


def _with_caution(sections: Sequence[Section], result: Result) -> list[Section]:
    """The sections with a caution where measures mean little as most encounters are one frame."""
    say = result.objects.say
    return [
        replace(section, blocks=(Sentences((say(CAUTION[section.anchor]),)), *section.blocks))
        if section.anchor in CAUTION
        else section
        for section in sections
    ]


def _as_set(sections: Sequence[Section], result: Result) -> list[Section]:
    """The sections, those marked that compare X and Y as set, if nothing is claimed from that."""
    note = None
    if are_unequal(result):
        note = Note("verdict.unequal_above", alarms=alarms_as_set(result))
    as_set = {*AS_SET_SECTIONS, *(of.anchor for of in chain(*contributed("sections")))}
    return [
        replace(section, blocks=(Sentences((say(note, result.objects),)), *section.blocks))
        if note and section.anchor in as_set
        else section
        for section in sections
    ]


def _facts(result: Result, protocol: Protocol) -> tuple[tuple[str, str], ...]:
    return (
        ("Protocol of the detection measures", protocol.title),
        ("Program", f"nvcore {__version__}"),
        ("Fingerprint of the inputs", result.dataset.fingerprint or UNDEFINED),
    )
