"""The comparison as one HTML file that needs neither program nor network.

    with_pictures = session_pictures(session, dataset)
    write_html_report(result, session, findings, Path("report.html"), pictures=with_pictures)

Plotly, which is inside the file, draws its charts. The same inputs, parameters and version
give the same bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from nvcore.arguments.report import Inscription
from nvcore.comparison import Result
from nvcore.findings import Finding
from nvcore.inputs.session import Session
from nvcore.output.files import write_whole
from nvcore.pictures.recordings import RecordingPictures, session_pictures
from nvcore.progress import Progress, no_progress
from nvcore.report.html.content import Content, report_content
from nvcore.report.html.page import render_page
from nvcore.settings import Settings

__all__ = ["render", "write_html_report"]

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
    progress: Progress = no_progress,
) -> None:
    """Write the report; an existing file is replaced.

    Parameters
    ----------
    session
        Names the protocol of the detection measures and, if it is a `Session`, the recordings'
        pictures.
    findings
        Of the audit of the same inputs.
    pictures
        Pictures that are open already; None: those of the session are opened, and closed again.
    stability
        Whether to compute the stability maps; None: for up to 20,000 frames.
    inscription
        Title, author, question and date on the first page.
    progress
        Called before each part; if it raises, nothing is written.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    opened = None
    if pictures is None and isinstance(session, Session):
        opened = session_pictures(session, result.dataset)
    try:
        content = report_content(
            result,
            findings,
            pictures=opened or pictures or RecordingPictures(),
            protocol=session.protocol,
            stability=stability,
            inscription=inscription,
            progress=progress,
        )
    finally:
        if opened is not None:
            opened.close()
    page = render(content).encode()
    progress(1.0, "done")
    write_whole(path, page)


def render(content: Content) -> str:
    """The page as text."""
    return render_page(
        "comparison.html",
        sections=content.sections,
        title=content.title,
        version=content.version,
        fingerprint=content.fingerprint,
        content=content,
    )
