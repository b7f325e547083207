"""The comparison as one HTML file that works without this program and offline.

    with_pictures = session_pictures(session, dataset)
    write_html_report(result, session, findings, Path("report.html"), pictures=with_pictures)

Plotly, which is inside the file, draws its charts. The same inputs, parameters and version
give the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from nvcore import __version__
from nvcore.common.arguments.report import Inscription
from nvcore.common.findings import Finding
from nvcore.common.output.files import write_whole
from nvcore.common.progress import Progress, no_progress, part_of
from nvcore.common.wording import UNDEFINED, one_line
from nvcore.comparison.compare import Result
from nvcore.evidence.looks import ONLY_LOOK, Look, correct_for_looks
from nvcore.evidence.stability.map import MAPS
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.evidence.table import judge_both
from nvcore.inputs.session import Session
from nvcore.pictures.recordings import RecordingPictures, session_pictures
from nvcore.report.decisive_moments import decisive_moments
from nvcore.report.html.cover import cover_of
from nvcore.report.html.frames import photo
from nvcore.report.html.page import render_page
from nvcore.report.plan import verdict_plan
from nvcore.report.section import Photo
from nvcore.report.sections import evidence as on_evidence
from nvcore.report.sections import inputs as on_inputs
from nvcore.report.sections import result_sections, with_cautions
from nvcore.report.sections import results as on_results
from nvcore.report.sections.encounters import only_one_section
from nvcore.report.verdict import verdict
from nvcore.settings.defaults import Settings
from nvcore.settings.protocols import Protocol
from nvcore.tables.classes import has_classes
from nvcore.tables.pictures import pictures_table

__all__ = ["write_html_report"]

NO_INSCRIPTION: Final = Inscription()


def write_html_report(
    result: Result,
    session: Settings,
    findings: Sequence[Finding],
    path: Path,
    *,
    pictures: RecordingPictures | None = None,
    stability: bool | None = None,
    inscription: Inscription = NO_INSCRIPTION,
    look: Look = ONLY_LOOK,
    progress: Progress = no_progress,
) -> None:
    """Write the HTML report, replacing an existing file.

    Parameters
    ----------
    session
        Settings with the protocol of the detection measures. A `Session` also has the pictures.
    findings
        Findings of the audit of the same inputs.
    pictures
        Open pictures. None: those of the session are opened, and closed again.
    stability
        Whether to compute the stability maps. None: for up to 20,000 frames.
    inscription
        Title, author, question and date on the first page.
    look
        Number and factor of this look at the data (`nvcore.evidence.looks`).
    progress
        Called before each part. If it raises, nothing is written.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    opened = None
    if pictures is None and isinstance(session, Session):
        opened = session_pictures(session, result.dataset)
    try:
        page = _render(
            result,
            findings,
            pictures=opened or pictures or RecordingPictures(),
            protocol=session.protocol,
            stability=stability,
            inscription=inscription.in_short(),
            look=look,
            progress=progress,
        ).encode()
    finally:
        if opened is not None:
            opened.close()
    progress(1.0, "done")
    write_whole(path, page)


def _render(
    result: Result,
    findings: Sequence[Finding],
    *,
    pictures: RecordingPictures,
    protocol: Protocol,
    stability: bool | None,
    inscription: Inscription,
    look: Look,
    progress: Progress,
) -> str:
    """Compute the report's contents and return its HTML."""
    progress(0.0, "testing the differences")
    evidence, companions = correct_for_looks(*judge_both(result, protocol), look)
    subgroups = subgroup_table(result, protocol=protocol)
    progress(0.15, "detection curves")
    detection = on_evidence.detection_section(result, protocol)
    of_plans = part_of(progress, 0.2, 0.3)
    plans = on_evidence.plan_measures(result, evidence, protocol, progress=of_plans)
    progress(0.3, "tables")
    plan = verdict_plan(result, evidence, companions, plans=plans)
    conclusion = verdict(
        result, findings, evidence=evidence, companions=companions, plan=plan, look=look
    )
    sections = [
        on_evidence.verdict_section(result, conclusion),
        on_results.scorecard_section(result),
        *result_sections(result),
        on_results.significance_section(result, evidence),
        on_evidence.plan_section(result, evidence, plans),
        on_evidence.subgroups_section(result, subgroups),
        detection,
        *([on_results.classes_section(result)] if has_classes(result) else []),
    ]
    progress(0.4, MAPS)
    maps = part_of(progress, 0.4, 0.6)
    sections.append(
        on_evidence.stability_section(result, evidence, is_wanted=stability, progress=maps)
    )
    photos = [*_photos(result, pictures, part_of(progress, 0.6, 0.9))]
    recordings = result.dataset.recordings["name"]
    troubles = [
        f"{one_line(str(recordings.iloc[number]))}: {one_line(why)}"
        for number, why in pictures.troubles.items()
    ]
    sections += [
        on_evidence.frames_section(result, photos, troubles),
        only_one_section(result),
        on_inputs.audit_section(result, findings),
        on_inputs.inputs_section(result, pictures_table(result.dataset, pictures)),
        on_inputs.parameters_section(result),
        on_inputs.reading_section(result),
    ]
    progress(0.9, "the page")
    names = one_line(result.x.name), one_line(result.y.name)
    compared = f"{names[0]} (X) and {names[1]} (Y) compared"
    facts = (
        ("Protocol of the detection measures", protocol.title),
        ("Program", f"nvcore {__version__}"),
        ("Fingerprint of the inputs", result.dataset.fingerprint or UNDEFINED),
    )
    return render_page(
        "comparison.html",
        result.objects,
        sections=with_cautions(sections, result),
        title=inscription.title or compared,
        version=__version__,
        fingerprint=result.dataset.fingerprint,
        cover=cover_of(result, conclusion, evidence, companions, photos, inscription, compared),
        names=names,
        facts=facts,
        theme=result.scheme("light"),
    )


def _photos(result: Result, pictures: RecordingPictures, progress: Progress) -> Iterator[Photo]:
    moments = decisive_moments(result)
    for number, moment in enumerate(moments):
        progress(number / len(moments), "evidence frames")
        yield photo(result, moment, pictures)
