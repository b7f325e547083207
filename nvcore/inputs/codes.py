"""Coded intervals from a CSV file that a session names.

    recording,start_s,end_s,code
    night_01,12.5,18,glare

Times are seconds since the recording's first evaluated frame, as `time_s` in all tables and on the
axis of the Timeline.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from nvcore.common.errors import InputError, ParameterError
from nvcore.common.findings import Finding
from nvcore.common.wording import MOST_NAMED, count_text, did_you_mean, listed
from nvcore.dataset import Dataset
from nvcore.dataset.schema import SAME_S
from nvcore.inputs.readers.base import rows_finding
from nvcore.inputs.readers.parse.table import read_table
from nvcore.inputs.session import Session
from nvcore.settings.codes import COLUMNS, CodedInterval

MOST_CODES: Final = 10_000


def with_codes(session: Session, names: Sequence[str]) -> Session:
    """Read a session's file of intervals into the session, matching recordings by their titles.

    Parameters
    ----------
    names
        Titles of all recordings. Intervals may also use their names in the data.

    Raises
    ------
    InputError
        If the file cannot be used, or an interval names another recording; with file and line.
    """
    if session.codes_file is None and not session.codes:
        return session
    title_of = {entry.name: entry.title or entry.name for entry in session.recordings}
    title_of |= {name: name for name in names}
    file = session.codes_file
    rows = [(interval, 0) for interval in session.codes]
    rows += [] if file is None else read_codes(session.folder / file)
    if len(rows) > MOST_CODES:
        raise InputError(f"expected {MOST_CODES:,} coded intervals at the most", file=file)
    for interval, line in rows:
        if title_of.get(interval.recording) not in names:
            known = f"the recordings are {listed(names, most=MOST_NAMED)}"
            hint = did_you_mean(interval.recording, names, known)
            text = f"there is no recording {interval.recording!r}; {hint}"
            if line:
                raise InputError(text, file=file, line=line)
            raise InputError(f"[[code]]: {text}")
    called = dict.fromkeys(replace(of, recording=title_of[of.recording]) for of, _ in rows)
    return replace(session, codes=tuple(called), codes_file=None)


def codes_beyond(dataset: Dataset, codes: Sequence[CodedInterval]) -> list[Finding]:
    """Warn about intervals that contain no evaluated frame of their recording."""
    frames = dataset.frames.groupby("recording")["time_s"].agg(["min", "max"])
    spans = frames.rename(index=dict(enumerate(dataset.recordings["name"]))).T.to_dict()
    beyond = [
        of
        for of in codes
        if (span := spans.get(of.recording)) is None
        or of.start_s > span["max"] + SAME_S
        or of.end_s < span["min"] - SAME_S
    ]
    shown = [f"{of.recording}, {of.start_s:g} to {of.end_s:g} s, {of.code}" for of in beyond]
    return rows_finding(
        np.ones(len(beyond), dtype=bool),
        "code-beyond-recording",
        f"{count_text(len(beyond), 'coded interval')} of {len(codes):,} "
        f"{'lies' if len(beyond) == 1 else 'lie'} outside of the evaluated frames.",
        "Give times in seconds since the recording's first evaluated frame.",
        role="codes",
        place=lambda row: ("", shown[row]),
    )


def read_codes(path: Path) -> list[tuple[CodedInterval, int]]:
    """Read the intervals and the line of each.

    Raises
    ------
    InputError
        If the file cannot be used; with the line.
    """
    table = read_table(path, what="coded intervals", required=COLUMNS)
    columns = (
        table.texts("recording"),
        table.numbers("start_s").tolist(),
        table.numbers("end_s").tolist(),
        table.texts("code"),
    )
    rows = []
    for row, values in enumerate(zip(*columns, strict=True)):
        try:
            rows.append((CodedInterval(*values), int(table.lines[row])))
        except ParameterError as error:
            raise table.fault(row, str(error)) from error
    return rows
