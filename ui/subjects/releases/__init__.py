"""Page What changed: two versions of a system, case by case."""

from __future__ import annotations

from typing import ClassVar, Final

from nvcore.subjects.releases.versions import version_lines
from ui import subject
from ui.session import state

MOST_UNRELATED: Final = 2
"""Most systems that are compared as X and Y alone."""


def _lacks() -> str:
    dataset = state.opened().dataset
    has_versions = len(dataset.systems) > MOST_UNRELATED or version_lines(dataset)
    return "" if has_versions else "Needs two versions of a system."


class ReleasesPages(subject.SubjectPages):
    pages = (
        subject.Page(
            "releases",
            "What changed",
            "Compare",
            after="encounters",
            lacks=_lacks,
            asks="What did the new version change?",
        ),
    )
    documents = (subject.Document("releases", "Releases", after="detectors"),)
    column_looks: ClassVar = {
        "severity_s_old": subject.ColumnLook("severity, old (s)"),
        "severity_s_new": subject.ColumnLook("severity, new (s)"),
    }
