"""Page What changed: two versions of a system, case by case."""

from __future__ import annotations

from typing import ClassVar

from nvcore.subjects.releases.versions import version_lines
from ui import subject
from ui.session import state


def _lacks() -> str:
    return "" if version_lines(state.opened().dataset) else "Needs two versions of a system."


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
