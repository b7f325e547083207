"""The comparison as one HTML file that needs neither program nor network.

    with_pictures = session_pictures(session, dataset)
    write_html_report(result, session, findings, Path("report.html"), pictures=with_pictures)

Plotly, which is inside the file, draws its charts. The same inputs, parameters and version
give the same bytes.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from nvcore.comparison import Result
from nvcore.figures.style import CONFIG
from nvcore.findings import Finding
from nvcore.inputs.session import Session
from nvcore.output.files import write_whole
from nvcore.pictures.recordings import RecordingPictures, session_pictures
from nvcore.progress import Progress, no_progress
from nvcore.report.html.blocks import Chart, Table
from nvcore.report.html.charts import figure_json, packed_plotly
from nvcore.report.html.content import Content, report_content
from nvcore.report.html.cover import Inscription
from nvcore.report.html.frames import decisive_moments
from nvcore.settings import Settings
from nvcore.wording import shortened

__all__ = ["Inscription", "css_text", "render", "write_html_report"]

NO_INSCRIPTION: Final = Inscription()
FOLDER: Final = Path(__file__).parent
LONG_WORD: Final = 24
SHORT_ROWS: Final = 12
SHORT_SIGNS: Final = 900
CHART_CONFIG: Final = {**CONFIG, "responsive": True}


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
        Pictures that are open already; None: the session's pictures that the report shows are
        opened, and closed again.
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
        opened = _needed_pictures(result, session)
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


def _needed_pictures(result: Result, session: Session) -> RecordingPictures:
    """Pictures of the recordings that the report shows: opening a video takes time."""
    recording = result.dataset.frame_columns.recording
    recordings = {int(recording[moment.row]) for moment in decisive_moments(result)}
    return session_pictures(session, result.dataset, recordings)


def render(content: Content) -> str:
    """The page as text."""
    environment = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    charts = {
        block.name: Markup(figure_json(block.figure))  # noqa: S704  # figure_json escapes it
        for section in content.sections
        for block in section.blocks
        if isinstance(block, Chart)
    }
    nonce = hashlib.sha256(f"{content.fingerprint} {content.version}".encode()).hexdigest()[:32]
    return environment.get_template("page.html").render(
        content=content,
        charts=charts,
        plotly=packed_plotly(),
        nonce=nonce,
        config=CHART_CONFIG,
        base64=lambda picture: base64.b64encode(picture).decode(),
        is_long=_is_long,
        is_short=_is_short,
        css_text=css_text,
    )


def css_text(text: str, most: int) -> Markup:
    """A CSS string of the text, cut to `most` characters; no text can end the string or style."""
    signs = (
        sign if sign == " " or (sign.isascii() and sign.isalnum()) else f"\\{ord(sign):x} "
        for sign in shortened(text, most)
    )
    return Markup(f'"{"".join(signs)}"')  # noqa: S704  # nothing but letters, digits, escapes


def _is_short(block: Table) -> bool:
    """Whether a printed table goes to the next page whole: longer ones would leave a page empty."""
    n_signs = sum(len(cell) for row in block.rows for cell in row)
    return len(block.rows) < SHORT_ROWS and n_signs < SHORT_SIGNS


def _is_long(cell: str) -> bool:
    """Whether it has a word that may be broken anywhere, such as a hash or a path."""
    return max(map(len, cell.split()), default=0) > LONG_WORD
