"""Export page: the files of a report, separately and as a zip, and the session file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Final, NamedTuple

import streamlit as st

from nvcore.common.findings import Finding
from nvcore.common.wording import listed
from nvcore.comparison.compare import Result
from nvcore.inputs.session import Session
from nvcore.inputs.session.changes import live_session
from nvcore.report.files import REPORT_CONTENTS, export_files, report_zip
from nvcore.tables.boxes.matches import MATCH_COLUMNS, MATCHES
from nvcore.tables.columns import report_columns
from ui.jobs.page_run import is_uploaded
from ui.session import state
from ui.session.opening import names_in_files
from ui.session.results import input_findings
from ui.shell.messages import path_remover, shown_root
from ui.subject import MadeFile, subject_pages
from ui.views.export.session import (
    inputs_beside,
    portable_session,
    public_findings,
    with_public_names,
)
from ui.widgets.buttons import download
from ui.widgets.text import UNDEFINED, docs_link, plain

TERMS: Final = (
    "{similarity} (0 to 1, 1 is best) says how near what a system shows is to what is there. An "
    "{encounter} is one {one}, from the first to the last annotated frame. In a {event} one missed "
    "{one} stands out."
)
COLUMNS: Final = {**report_columns(), MATCHES: MATCH_COLUMNS}
MOST_BOXES: Final = 5_000_000
"""Maximum number of boxes in a download, which is made in memory."""
MOST_NAMED: Final = 12
"""Maximum number of inputs that are named individually."""


class _Report(NamedTuple):
    """Contents of the files. `made` holds those that only the app has, by name in the session."""

    session: Session
    findings: tuple[Finding, ...]
    made: Mapping[str, MadeFile]

    @property
    def inputs(self) -> dict[str, Callable[[], bytes]]:
        return {name: file.path.read_bytes for name, file in self.made.items()}


def draw(result: Result) -> None:
    """Draw downloads of everything and of single files, and the meaning of their columns."""
    remove_paths = path_remover()
    report = _report(result, remove_paths)

    @cache
    def public() -> Result:  # called when a file is made, not in each run
        return with_public_names(result, remove_paths)

    st.header("Report")
    st.markdown(
        "The files that `nvcore compare --out` writes, with the parameters in the sidebar. "
        "[What they hold](metrics?doc=report)."
    )
    download(
        "All files (ZIP)",
        lambda: report_zip(public(), report.session, report.findings, inputs=report.inputs),
        "nvcore-report.zip",
        key="export_zip",
        icon="folder_zip",
        type="primary",
    )
    with st.expander("Single files"):
        _draw_files(result, report, public)
    st.markdown(
        state.say(
            TERMS,
            similarity=docs_link("Similarity", "similarity"),
            encounter=docs_link("encounter", "encounters"),
            event=docs_link("saliency event", "saliency"),
        )
    )
    with st.expander("What the columns mean"):
        _draw_columns()
    _draw_session_note(report)


def _report(result: Result, remove_paths: Callable[[object], str]) -> _Report:
    x, y = state.systems()
    session = live_session(state.opened().session, result.dataset, result.params, x=x, y=y)
    portable = portable_session(
        session,
        is_upload=is_uploaded(state.workspace(), session),
        recordings=names_in_files(session, state.opened().whole).values(),
        root=shown_root(),
    )
    return _Report(
        portable,
        public_findings(input_findings(), remove_paths),
        {
            name: file
            for subject in subject_pages()
            for make in subject.made_files()
            for name, file in make(session, portable).items()
        },
    )


def _draw_files(result: Result, report: _Report, public: Callable[[], Result]) -> None:
    counts = {
        "frames.csv": len(result.dataset.frames),
        "encounters.csv": len(result.encounters),
        "events.csv": len(result.x.events) + len(result.y.events),
        "intervals.csv": len(result.x.intervals) + len(result.y.intervals),
        "recordings.csv": len(result.dataset.recordings),
        "findings.csv": len(report.findings),
        "codes.csv": len(report.session.codes),
        MATCHES: len(result.dataset.boxes),
    }

    @cache
    def files(of: Callable[[], Result]) -> dict[str, Callable[[], bytes]]:
        with_boxes = counts[MATCHES] <= MOST_BOXES
        made = export_files(of(), report.session, report.findings, matches=with_boxes)
        return made | report.inputs

    def content(name: str) -> bytes:
        return files(public)[name]()

    contents = REPORT_CONTENTS | {name: file.meaning for name, file in report.made.items()}
    for name in files(lambda: result):
        button, text = st.columns([1, 4], vertical_alignment="center")
        key = f"export_{name}"
        download(name, partial(content, name), name, key=key, at=button, width="stretch")
        what = state.say(contents[name])
        text.markdown(f"{counts[name]:,} {what}" if name in counts else what[:1].upper() + what[1:])


def _draw_columns() -> None:
    file = st.segmented_control(
        "File",
        list(COLUMNS),
        default="frames.csv",
        required=True,
        key="export_columns",
        label_visibility="collapsed",
    )
    columns = {column.name: column for column in COLUMNS[file]}
    rows = ["| Column | Unit | Meaning | Empty |", "|---|---|---|---|"]
    for name, column in columns.items():
        kind, letter = name[:-2], name[-2:]
        if letter == "_y" and f"{kind}_x" in columns:  # shown in the row of X
            continue
        has_pair = letter == "_x" and f"{kind}_y" in columns
        names = f"`{name}`, `{kind}_y`" if has_pair else f"`{name}`"
        meaning, empty = state.say(column.meaning), state.say(column.empty or "never")
        rows.append(f"| {names} | {column.unit or UNDEFINED} | {meaning} | {empty} |")
    st.markdown("\n".join(rows))


def _draw_session_note(report: _Report) -> None:
    input_files = inputs_beside(report.session, report.made)
    more = len(input_files) - MOST_NAMED
    first_files = ", ".join(plain(name) for name in input_files[:MOST_NAMED])
    own = listed(["`session.toml`", *map(plain, report.made)])
    rest = " (the ZIP has what was made here)" if report.made else ""
    st.caption(
        f"To get the same report again, put {own}{rest} beside its inputs: {first_files}"
        + (f" and {more} more" if more > 0 else "")
        + ". Then run `nvcore compare session.toml --out again`, or open it on the Data page "
        "together with these files. It names no folder of this computer."
    )
