"""Export page: the whole comparison as an HTML file, written in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from typing import Final, NamedTuple

import streamlit as st

from nvcore.common.arguments.report import MAX_CHARACTERS, Inscription
from nvcore.common.progress import Progress, with_time_left
from nvcore.comparison.compare import Result
from nvcore.report.html import write_html_report
from nvcore.report.sections.evidence import AT_ONCE
from nvcore.settings.params import Params
from nvcore.settings.protocols import Protocol
from ui.jobs.page_run import PageRun
from ui.jobs.progress import start_as_made
from ui.session import state, store
from ui.session.results import input_findings
from ui.shell.messages import path_remover
from ui.views.export.session import public_findings, with_public_names
from ui.widgets import drawing
from ui.widgets.text import plain

NAME: Final = "nvcore-report.html"
RUN: Final = PageRun[None]("html", "report", "Making the report", folder="html", has_time_left=True)
LABELS: Final = {
    "title": "Title",
    "author": "Author",
    "question": "Which question it answers",
    "date": "Date",
}


class ReportKey(NamedTuple):
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
    if (job := RUN.job) is not None:
        made = {f"html_{name}": text for name, text in vars(job.key.inscription).items()}
        start_as_made(job, RUN.name, html_stability=bool(job.key.with_map), **made)
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
    if RUN.start_button("Make the report", "description", "make_html"):
        _start(result, key)
        st.rerun()
    RUN.draw_file(key)


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
    pictures = replace(state.workspace().pictures, stretch=drawing.stretch())
    public, session = path_remover(), state.opened().session
    shown, findings = shown_result(result, public), public_findings(input_findings(), public)
    folder = RUN.new_folder()

    def write(progress: Progress) -> None:
        write_html_report(
            shown,
            session,
            findings,
            folder / NAME,
            pictures=pictures,
            stability=key.with_map,
            inscription=key.inscription,
            progress=with_time_left(progress),
        )

    RUN.start(write, key=key, title=NAME, folder=folder)


def shown_result(result: Result, public: Callable[[object], str]) -> Result:
    """Return the result with file names and notes made `public`, hiding folders of the machine."""
    named = with_public_names(result, public)
    notes = tuple(public(note) for note in result.dataset.notes)
    return replace(named, dataset=replace(named.dataset, notes=notes))
