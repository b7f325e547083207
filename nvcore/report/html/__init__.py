"""The comparison as one HTML file that needs neither program nor network.

    with_pictures = session_pictures(session, dataset)
    write_html_report(result, session, findings, Path("report.html"), pictures=with_pictures)

Its charts are drawn by Plotly, which is inside the file. The same inputs, parameters and version
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
from nvcore.errors import InputError
from nvcore.figures.style import CONFIG
from nvcore.findings import Finding
from nvcore.inputs.session import Session
from nvcore.progress import Progress, no_progress
from nvcore.report.html.blocks import Chart
from nvcore.report.html.charts import figure_json, packed_plotly
from nvcore.report.html.content import Content, report_content
from nvcore.report.html.frames import RecordingPictures, decisive_moments, session_pictures
from nvcore.settings import Settings
from nvcore.wording import shortened

__all__ = ["RecordingPictures", "css_text", "render", "session_pictures", "write_html_report"]

FOLDER: Final = Path(__file__).parent
LONG_WORD: Final = 24
CHART_CONFIG: Final = {**CONFIG, "responsive": True}


def write_html_report(
    result: Result,
    session: Settings,
    findings: Sequence[Finding],
    path: Path,
    *,
    pictures: RecordingPictures | None = None,
    stability: bool | None = None,
    progress: Progress = no_progress,
) -> None:
    """Write the report; with an existing file it is replaced.

    Parameters
    ----------
    session
        Names the protocol of the detection figures and, if it is a `Session`, the recordings'
        pictures.
    findings
        Of the audit of the same inputs.
    pictures
        Open already; None: those that the session names and that are shown are opened, and closed
        again.
    stability
        Whether to compute the stability maps; None: for up to 20,000 frames.
    progress
        Called before each part; if it raises, nothing is written.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    own = None
    if pictures is None and isinstance(session, Session):
        own = _needed_pictures(result, session)
    try:
        content = report_content(
            result,
            findings,
            pictures=own or pictures or RecordingPictures(),
            protocol=session.protocol,
            stability=stability,
            progress=progress,
        )
    finally:
        if own is not None:
            own.close()
    page = render(content).encode()
    progress(1.0, "done")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(page)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", file=path) from error


def _needed_pictures(result: Result, session: Session) -> RecordingPictures:
    """Those of the recordings that are shown: opening a video takes time."""
    recording = result.dataset.frame_columns.recording
    shown = {int(recording[one.row]) for one in decisive_moments(result)}
    return session_pictures(session, result.dataset, shown)


def render(content: Content) -> str:
    """The page as text."""
    environment = Environment(
        loader=FileSystemLoader(FOLDER), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    charts = {
        block.name: Markup(figure_json(block.figure))  # noqa: S704  # escaped there
        for section in content.sections
        for block in section.blocks
        if isinstance(block, Chart)
    }
    nonce = hashlib.sha256(f"{content.fingerprint} {content.version}".encode()).hexdigest()[:32]
    return environment.get_template("page.html").render(
        content=content, charts=charts, plotly=packed_plotly(), nonce=nonce, config=CHART_CONFIG,
        base64=lambda picture: base64.b64encode(picture).decode(), is_long=_is_long,
        css_text=css_text,
    )  # fmt: skip


def css_text(text: str, most: int) -> Markup:
    """A text as a string of CSS that can end neither it nor the style, cut to `most` signs."""
    signs = (
        sign if sign == " " or (sign.isascii() and sign.isalnum()) else f"\\{ord(sign):x} "
        for sign in shortened(text, most)
    )
    return Markup(f'"{"".join(signs)}"')  # noqa: S704  # nothing but letters, digits, escapes


def _is_long(cell: str) -> bool:
    """Whether a word of it may be broken anywhere: a hash, a path."""
    return max(map(len, cell.split()), default=0) > LONG_WORD
