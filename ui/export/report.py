"""Export page: the files of a report, one by one and as a zip, and the session file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain
from typing import Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.findings import Finding
from nvcore.inputs.session import Session
from nvcore.report.files import REPORT_CONTENTS, export_files, report_zip
from nvcore.tables.boxes.matches import MATCH_COLUMNS, MATCHES
from nvcore.tables.column import Column
from nvcore.tables.columns import report_columns
from nvcore.wording import listed
from ui.export.session import (
    inputs_beside,
    names_in_files,
    portable_session,
    public_findings,
    with_public_names,
)
from ui.session import state
from ui.session.opening import live_session
from ui.session.results import input_findings
from ui.shell.messages import path_remover, shown_root
from ui.subjects import MadeFile, contributed
from ui.widgets.text import UNDEFINED, docs_link, plain

TERMS: Final = (
    "{similarity} (0 to 1, 1 is best) says how near what a system shows is to what is there. An "
    "{encounter} is one {one}, from the first to the last annotated frame. In a {event} one missed "
    "{one} stands out."
)
MIME: Final = {
    "csv": "text/csv",
    "json": "application/json",
    "toml": "application/toml",
    "parquet": "application/vnd.apache.parquet",
}
COLUMNS: Final = {**report_columns(), MATCHES: MATCH_COLUMNS}
MOST_BOXES: Final = 5_000_000
"""Boxes that are written for a download, which is made in memory."""
MOST_NAMED: Final = 12
"""Inputs that are named one by one."""


@dataclass(frozen=True)
class _Report:
    """What goes into the files.

    Attributes
    ----------
    made
        Files that only the app has, by their names in the session.
    """

    session: Session
    findings: tuple[Finding, ...]
    made: Mapping[str, MadeFile]

    @property
    def inputs(self) -> dict[str, Callable[[], bytes]]:
        """Their contents."""
        return {name: file.path.read_bytes for name, file in self.made.items()}


def draw(result: Result) -> None:
    """Downloads of everything, of single files, and what their columns mean."""
    remove_paths = path_remover()
    report = _report(result, remove_paths)

    @cache
    def public() -> Result:  # when a file is made, not in each run
        return with_public_names(result, remove_paths)

    st.header("Report")
    st.markdown(
        "The files that `nvcore compare --out` writes, with the parameters in the sidebar. "
        "[What they hold](metrics?doc=report)."
    )
    st.download_button(
        "All files (ZIP)",
        lambda: report_zip(public(), report.session, report.findings, inputs=report.inputs),
        "nvcore-report.zip",
        "application/zip",
        on_click="ignore",
        type="primary",
        icon=":material/folder_zip:",
        key="export_zip",
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
    is_upload = session.folder.is_relative_to(state.workspace().folder)
    portable = portable_session(
        session,
        is_upload=is_upload,
        recordings=names_in_files(session, state.opened().whole),
        root=shown_root(),
    )
    return _Report(
        portable,
        public_findings(input_findings(), remove_paths),
        dict(chain(*(made(session, portable).items() for made in contributed("MADE_FILES")))),
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
        button.download_button(
            name,
            partial(content, name),
            name,
            MIME[name.rpartition(".")[2]],
            on_click="ignore",
            width="stretch",
            icon=":material/download:",
            key=f"export_{name}",
        )
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
    rows = ["| Column | Unit | Meaning | Empty |", "|---|---|---|---|"]
    for names, column in _joined(COLUMNS[file]):
        empty = column.empty or "never"
        texts = " | ".join(map(state.say, (column.meaning, empty)))
        rows.append(f"| {names} | {column.unit or UNDEFINED} | {texts} |")
    st.markdown("\n".join(rows))


def _joined(columns: tuple[Column, ...]) -> list[tuple[str, Column]]:
    """Columns with their names as Markdown; those of X and of Y in one row."""
    names = {column.name for column in columns}
    rows = []
    for column in columns:
        of_y = column.name[:-1] + "y"
        if column.name.endswith("_x") and of_y in names:
            rows.append((f"`{column.name}`, `{of_y}`", column))
        elif not (column.name.endswith("_y") and column.name[:-1] + "x" in names):
            rows.append((f"`{column.name}`", column))
    return rows


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
