"""Export page: the whole comparison as one HTML file, made in the background."""

from __future__ import annotations

import secrets
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.analysis import Result
from nvcore.findings import Finding
from nvcore.html_report import RecordingPictures, write_html_report
from nvcore.html_report.evidence_sections import AT_ONCE
from nvcore.protocols import PROTOCOLS
from nvcore.session import Session
from ui import state
from ui.background_job import JobState, Progress, while_open
from ui.export_session import public_findings
from ui.export_video import FOLDER, POLL_S
from ui.public import public
from ui.text import plain
from ui.video_job import VideoJob
from ui.workspace import Workspace

NAME: Final = "nvcore-report.html"
JOB: Final = "html_job"


class HtmlJob(VideoJob):
    """One report; `key` says of what."""

    def __init__(self, key: Any, *arguments: Any):
        """Start to write; see `VideoJob`."""
        self.key = key
        super().__init__(*arguments)


def draw(result: Result) -> None:
    """What is in it, the button, and how far it is."""
    st.header("Report to hand on")
    st.markdown(
        "One HTML file with verdict, figures, evidence frames, tables, all parameters and hashes "
        "of the inputs. It opens in any browser without network, and prints to PDF."
    )
    protocol, with_map = _draw_form(result)
    job: HtmlJob | None = st.session_state.get(JOB)
    if job is not None and not job.is_wanted():  # something else was opened meanwhile
        _discard()
        job = None
    key = (state.workspace().version, result.params, state.systems(), protocol, with_map)
    is_busy = job is not None and job.is_busy
    if st.button("Make the report", icon=":material/description:", key="make_html",
                 disabled=is_busy):  # fmt: skip
        _start(result, key, protocol, with_map)
        st.rerun()
    if job is None:
        return
    if is_busy:
        _draw_progress(job)
    else:
        _draw_outcome(job, is_current=job.key == key)


def _draw_form(result: Result) -> tuple[str, bool | None]:
    left, right = st.columns([1, 2], vertical_alignment="bottom")
    protocol = left.selectbox(
        "Protocol of the detection figures", list(PROTOCOLS), key="html_protocol",
        help="As on the Detection page.",
    )  # fmt: skip
    if len(result.dataset.frames) <= AT_ONCE:
        return protocol, None
    return protocol, right.toggle(
        "With the stability map", key="html_stability",
        help="With so many frames it takes some seconds to a minute.",
    )  # fmt: skip


def _discard() -> None:
    job: HtmlJob | None = st.session_state.pop(JOB, None)
    if job is not None:
        job.discard()


def _start(result: Result, key: Any, protocol: str, with_map: bool | None) -> None:
    space = state.workspace()
    assert space.session is not None
    _discard()
    folder = space.folder / FOLDER
    folder.mkdir(mode=0o700, exist_ok=True)
    path = folder / f"{secrets.token_hex(8)}.html"
    pictures = RecordingPictures(dict(space.pictures), dict(space.picture_rows), state.stretch())
    st.session_state[JOB] = start_job(
        space, key, shown_result(result), space.session,
        public_findings(state.findings(), public), path, pictures, protocol=protocol,
        stability=with_map,
    )  # fmt: skip


def shown_result(result: Result) -> Result:
    """The result with files named without the folders of the machine."""
    inputs = result.dataset.inputs
    named = inputs.assign(file=[public(name) for name in inputs["file"]])
    notes = tuple(public(note) for note in result.dataset.notes)
    return replace(result, dataset=replace(result.dataset, inputs=named, notes=notes))


def start_job(
    space: Workspace, key: Any, result: Result, session: Session, findings: tuple[Finding, ...],
    path: Path, pictures: RecordingPictures, *, protocol: str, stability: bool | None,
) -> HtmlJob:  # fmt: skip
    """Start writing; it ends with the session, and when the session opens something else."""

    def write(progress: Progress) -> bool:
        return write_html_report(
            result, session, findings, path, pictures=pictures, protocol=PROTOCOLS[protocol],
            stability=stability, progress=lambda share, _what: progress(share),
        )  # fmt: skip

    return HtmlJob(key, path, NAME, write, while_open(space))


@st.fragment(run_every=POLL_S)
def _draw_progress(job: HtmlJob) -> None:
    if not job.is_busy:
        st.rerun()
    if job.state is JobState.WAITING:
        st.progress(0.0, "Waiting for other work on this server.")
    else:
        st.progress(job.share, f"Making the report: {job.share:.0%}")
    if st.button("Cancel", icon=":material/close:", key="cancel_html"):
        job.cancel()


def _draw_outcome(job: HtmlJob, *, is_current: bool) -> None:
    if job.state is JobState.CANCELLED:
        st.info("The report was cancelled; nothing is left of it.")
    elif job.state is JobState.FAILED:
        st.error(plain(job.error) or "The report could not be made.", icon=":material/error:")
    else:
        path = job.path  # the callable must not hold the job, which holds the pictures
        st.download_button(
            NAME, lambda: path.open("rb"), NAME, "text/html", on_click="ignore",
            icon=":material/download:", type="primary", key="download_html",
        )  # fmt: skip
        size = f"{path.stat().st_size / 1e6:.1f} MB."
        if is_current:
            st.caption(f"{size} It stays here until the next one.")
        else:
            st.warning(f"{size} It was made with other settings: make it again for those of now.")
