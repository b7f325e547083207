"""Export page: the whole comparison as an HTML file, written in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.arguments.report import MAX_CHARACTERS, Inscription
from nvcore.comparison import Result
from nvcore.findings import Finding
from nvcore.inputs.session import Session
from nvcore.params import Params
from nvcore.pictures import RecordingPictures
from nvcore.progress import Progress
from nvcore.protocols import Protocol
from nvcore.report.html import write_html_report
from nvcore.report.sections.evidence import AT_ONCE
from ui.export.session import public_findings, with_public_names
from ui.jobs.background import FileJob, JobState, new_path, while_open
from ui.jobs.progress import draw_file, draw_job, start_as_made
from ui.session import state, store
from ui.session.results import input_findings
from ui.session.workspace import Workspace
from ui.shell.messages import path_remover
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.text import plain

NAME: Final = "nvcore-report.html"
JOB: Final = "html"
LABELS: Final = {
    "title": "Title",
    "author": "Author",
    "question": "Which question it answers",
    "date": "Date",
}


@dataclass(frozen=True)
class ReportKey:
    """Inputs that determine a report. `with_map` None: stability maps only for few frames."""

    version: str
    params: Params
    systems: tuple[str, str | None]
    protocol: Protocol
    with_map: bool | None
    inscription: Inscription


def draw(result: Result) -> None:
    """Draw what the report contains, the button that writes it, and the progress."""
    st.header("Report to share")
    st.markdown(
        "One HTML file with verdict, charts, evidence frames, tables, all parameters and hashes of "
        "the inputs. It opens in any browser without network, and prints to PDF."
    )
    job: FileJob | None = state.workspace().job(JOB)
    if job is not None:
        made = {f"html_{name}": text for name, text in vars(job.key.inscription).items()}
        start_as_made(job, JOB, html_stability=bool(job.key.with_map), **made)
    protocol = state.protocol()
    st.caption(
        f"Protocol of the detection measures: {plain(protocol.title)}, as on the Detection page."
    )
    key = ReportKey(
        state.workspace().version,
        result.params,
        state.systems(),
        protocol,
        _ask_for_map(result),
        _ask_for_first_page(),
    )
    if button(
        "Make the report",
        icon=":material/description:",
        key="make_html",
        disabled=job is not None and job.is_busy,
    ):
        _start(result, key)
        st.rerun()
    if job is None:
        return
    if draw_job(job, JOB, thing="report", doing="Making the report") is not JobState.DONE:
        return
    size = draw_file(job, JOB)
    if job.key == key:
        st.caption(f"{size} It stays here until the next one.")
    else:
        st.warning(f"{size} It was made with other settings: make it again for those of now.")


def _ask_for_map(result: Result) -> bool | None:
    """Draw the switch for stability maps, and return its value. Few frames: no switch, None."""
    if len(result.dataset.frames) <= AT_ONCE:
        return None
    return st.toggle(
        "With the stability maps",
        key="html_stability",
        persist_state="session",
        help="With so many frames they take some seconds to some minutes.",
    )


def _ask_for_first_page() -> Inscription:
    """Draw fields for title, author and the like on the first page, and return their content."""
    store.HTML_DATE.setdefault(date.today().isoformat())
    with st.expander("Title, author, question and date on its first page"):
        texts = {
            name: st.text_input(
                label, key=f"html_{name}", max_chars=MAX_CHARACTERS, persist_state="session"
            )
            for name, label in LABELS.items()
        }
    return Inscription(**texts).in_short()


def _start(result: Result, key: ReportKey) -> None:
    space = state.workspace()
    space.drop_job(JOB)
    pictures = replace(space.pictures, stretch=drawing.stretch())
    public = path_remover()
    findings = public_findings(input_findings(), public)
    path = new_path(space, ".html")
    job = start_job(
        space, key, shown_result(result, public), state.opened().session, findings, path, pictures
    )
    space.put_job(JOB, job)


def shown_result(result: Result, public: Callable[[object], str]) -> Result:
    """Return the result with file names and notes made `public`, hiding folders of the machine."""
    named = with_public_names(result, public)
    notes = tuple(public(note) for note in result.dataset.notes)
    return replace(named, dataset=replace(named.dataset, notes=notes))


def start_job(
    space: Workspace,
    key: ReportKey,
    result: Result,
    session: Session,
    findings: tuple[Finding, ...],
    path: Path,
    pictures: RecordingPictures,
) -> FileJob:
    """Start writing the report. Closing the session or opening other data cancels the job."""

    def write(progress: Progress) -> None:
        write_html_report(
            result,
            session,
            findings,
            path,
            pictures=pictures,
            stability=key.with_map,
            inscription=key.inscription,
            progress=progress,
        )

    return FileJob(path, NAME, write, while_open(space), key=key)
