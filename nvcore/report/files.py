"""Files of a `Result`: tables, a summary, and a session that reproduces them."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import Final, Literal, get_args

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.common.errors import InputError
from nvcore.common.findings import Finding
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import MANIFEST, manifest, refuse_other_run, write_run
from nvcore.common.output.parquet import to_parquet_bytes
from nvcore.common.progress import Progress, no_progress
from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.evidence.looks import ONLY_LOOK, Look, multiplied
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.evidence.table import evidence_table
from nvcore.inputs.files.hashes import source_hashes
from nvcore.inputs.readers.table import FORMAT as TABLE
from nvcore.inputs.session import Session
from nvcore.inputs.session.changes import stated
from nvcore.inputs.session.toml import write_session
from nvcore.settings.defaults import Settings
from nvcore.tables.boxes.matches import MATCHES, matches_parquet
from nvcore.tables.classes import classes_table, has_classes
from nvcore.tables.columns import table_contents
from nvcore.tables.inputs import finding_entries, horizons_table
from nvcore.tables.result import (
    codes_table,
    encounters_table,
    events_table,
    findings_table,
    frames_table,
    intervals_table,
    recordings_table,
)
from nvcore.tables.summary import summary

ZIP_TIME: Final = (1980, 1, 1, 0, 0, 0)
"""Time of every file in a zip, the earliest possible, so that the same report gives the same bytes.
"""

TableFormat = Literal["csv", "parquet"]
TABLE_FORMATS: Final = get_args(TableFormat)
SESSION_FILE: Final = "session.toml"
REPORT_CONTENTS: Final = {
    **table_contents(),
    MATCHES: "boxes of truth, X and Y: {what} each matches, whether it counts, what it weighs",
    "summary.json": "all aggregates over all recordings, parameters and version",
    SESSION_FILE: "the session: what to run to get the same report again",
}
"""Templates that describe each file that a report may have, with its tables as CSV."""
REPORT_FILES: Final = (
    *REPORT_CONTENTS,
    *(str(PurePath(name).with_suffix(".parquet")) for name in table_contents()),
)
"""Files that a report may have, in addition to `nvcore.common.output.files.MANIFEST`."""


AUDIT_FILES: Final = ("findings.csv", "finding_entries.csv", "horizons.csv")
"""Files that the audit by itself writes."""


def export_files(
    result: Result,
    session: Settings,
    findings: tuple[Finding, ...] = (),
    *,
    tables: TableFormat = "csv",
    matches: bool = False,
    look: Look = ONLY_LOOK,
) -> dict[str, Callable[[], bytes]]:
    """Return functions that write the files of a report, by file name.

    The same input gives the same bytes. There is a ``session.toml`` only if the session names
    files, which tables in memory lack. There is a ``classes.csv`` only if truth and systems name
    classes, and a ``codes.csv`` only with coded intervals.

    Parameters
    ----------
    tables
        ``"csv"``, or ``"parquet"`` for all digits.
    matches
        True to include ``matches.parquet``, with a row for each box.
    look
        Look for which p are corrected in ``significance.csv``.
    """
    made: dict[str, Callable[[], pd.DataFrame]] = {
        "frames": lambda: frames_table(result),
        "encounters": lambda: encounters_table(result),
        "events": lambda: events_table(result),
        "intervals": lambda: intervals_table(result),
        "recordings": lambda: recordings_table(result),
        "significance": lambda: multiplied(evidence_table(result, session.protocol), look),
        "subgroups": lambda: subgroup_table(result, protocol=session.protocol),
        "findings": lambda: findings_table(findings),
        "finding_entries": lambda: finding_entries(result.dataset, findings),
    }
    if has_classes(result):
        made["classes"] = lambda: classes_table(result)
    if session.codes:
        made["codes"] = lambda: codes_table(session.codes)
    files: dict[str, Callable[[], bytes]] = {
        f"{name}.{tables}": partial(_bytes_of, make, tables) for name, make in made.items()
    }
    if matches:
        files[MATCHES] = partial(matches_parquet, result)
    files["summary.json"] = lambda: summary_json(result).encode()
    if isinstance(session, Session) and TABLE.name not in set(result.dataset.inputs["format"]):
        files[SESSION_FILE] = partial(_session_toml, result, session)
    return files


def _session_toml(result: Result, session: Session) -> bytes:
    fingerprint = result.dataset.fingerprint
    complete = replace(
        stated(session, result.dataset),
        hashes=source_hashes(result.dataset),
        primary=replace(result.dataset.primary, fingerprint=fingerprint),
        operating_point=session.operating_point if result.as_set is None else "equal-alarms",
    )
    text = write_session(complete, version=__version__, fingerprint=fingerprint)
    return text.encode()


def _bytes_of(make: Callable[[], pd.DataFrame], tables: TableFormat) -> bytes:
    table = make()
    if tables == "parquet":
        return to_parquet_bytes(table)
    if "effect" in table:  # which may be infinite, and CSV has no infinity
        table = table.replace([np.inf, -np.inf], np.nan)
    return to_csv_bytes(table)


def summary_json(result: Result) -> str:
    """Return the summary as JSON text."""
    return json.dumps(summary(result), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _file_contents(
    files: Mapping[str, Callable[[], bytes]], progress: Progress
) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of the files of a report, one after another."""
    for n_done, (name, make) in enumerate(files.items()):
        progress(n_done / len(files), f"writing {name}")
        yield name, make()


def write_report(
    result: Result,
    session: Settings,
    folder: Path,
    findings: tuple[Finding, ...] = (),
    *,
    tables: TableFormat = "csv",
    matches: bool = False,
    look: Look = ONLY_LOOK,
    progress: Progress = no_progress,
) -> None:
    """Write all files of a report into a folder, which is created if missing.

    They replace an older report at once; see `nvcore.common.output.files.write_run`.

    Parameters
    ----------
    tables, matches, look
        See `export_files`.

    Raises
    ------
    InputError
        If the folder cannot be written to, or holds the run of another command.
    """
    refuse_other_run(folder, REPORT_FILES)
    files = export_files(result, session, findings, tables=tables, matches=matches, look=look)
    write_run(folder, _file_contents(files, progress), known=REPORT_FILES)


def write_audit(folder: Path, dataset: Dataset, findings: tuple[Finding, ...]) -> None:
    """Write the audit's findings and estimated horizons into a folder, as `write_report` does.

    Raises
    ------
    InputError
        If the folder cannot be written to, or holds the run of another command.
    """
    if (folder / "summary.json").exists():  # only a part of it would be replaced
        raise InputError("holds the report of a comparison; give another folder", file=folder)
    refuse_other_run(folder, AUDIT_FILES)
    contents = [
        ("findings.csv", to_csv_bytes(findings_table(findings))),
        ("finding_entries.csv", to_csv_bytes(finding_entries(dataset, findings))),
        ("horizons.csv", to_csv_bytes(horizons_table(dataset))),
    ]
    write_run(folder, contents, known=AUDIT_FILES)


def report_zip(
    result: Result,
    session: Session,
    findings: tuple[Finding, ...] = (),
    *,
    inputs: Mapping[str, Callable[[], bytes]] = MappingProxyType({}),
    progress: Progress = no_progress,
) -> bytes:
    """Return a zip of the files of a report, byte for byte those of `write_report`.

    Parameters
    ----------
    inputs
        Contents of files that the session names and only the caller has, by name.
    """
    content = io.BytesIO()
    made = {**export_files(result, session, findings), **inputs}
    files = list(_file_contents(made, progress))
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, text in (*files, (MANIFEST, manifest(files))):
            entry = zipfile.ZipInfo(name, ZIP_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # the same bytes on every system
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, text)
    return content.getvalue()
