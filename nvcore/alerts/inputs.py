"""Logs of alerts and policies that a session names, read and put to the data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.alerts.policy import Policy, read_policy
from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.inputs.added import Input, with_files
from nvcore.inputs.files import digest, find_files
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.csv_columns import (
    NUMBERS,
    Header,
    csv_content,
    read_columns,
    read_header,
)
from nvcore.inputs.readers.parse.table import TextTable, parse_table
from nvcore.inputs.session import Session, SystemSource
from nvcore.metrics.linking import track_truth
from nvcore.schema import NO_TRACK
from nvcore.wording import one_line

ALERTS_INPUT: Final = "alerts"
"""Subject of these files among truth and systems."""
ALERTED: Final = "alerted"
LOG_COLUMNS: Final = ("start_s", "end_s", "kind")
"""Of a log; track and recording may follow, and recording must where there are several."""
_LINES: Final = 1 << 32
"""More than the lines of any file."""


@dataclass(frozen=True, eq=False)
class AlertLog:
    """A system's own log of its alerts, of one of two forms.

    Attributes
    ----------
    places
        File and line of each detection that was an alert, as one number (`places_of`); None: the
        log is a table.
    table
        One row per alert: recording (its name in the data), start_s, end_s (since the
        recording's first listed frame), track (`NO_TRACK`: none), log_kind (the log's own word).
    """

    places: np.ndarray | None = None
    table: pd.DataFrame | None = None


@dataclass(frozen=True)
class AlertInputs:
    """Logs and policies by the number of the system; those without are absent."""

    logs: dict[int, AlertLog]
    policies: dict[int, Policy]


def places_of(boxes: pd.DataFrame) -> np.ndarray:
    """File and line of boxes as one number; int64, shape (n,)."""
    file, line = (boxes[name].to_numpy(dtype=np.int64) for name in ("file", "line"))
    places: np.ndarray = file * _LINES + line
    return places


def with_alerts(dataset: Dataset, session: Session) -> Dataset:
    """The dataset with the logs and policies that its session names.

    Raises
    ------
    InputError
        If a file cannot be used; with file and line.
    """
    logs: dict[int, AlertLog] = {}
    policies: dict[int, Policy] = {}
    files: dict[str, SourceFile] = {}
    for number, (name, source) in enumerate(zip(dataset.systems, session.systems, strict=True)):
        if source.alerts is not None:
            file = SourceFile(session.folder / source.alerts, source.alerts)
            logs[number] = _read_log(file, dataset, session, source, name)
            files[f"log of {name}"] = file
        if source.alert_policy is not None:
            file = SourceFile(session.folder / source.alert_policy, source.alert_policy)
            policies[number] = read_policy(file)
            files[f"policy of {name}"] = file
    names, digests = [file.name for file in files.values()], digest([*files.values()])
    return with_files(
        dataset,
        session,
        ALERTS_INPUT,
        names,
        digests,
        says="\n".join([*files, *digests]).encode(),
        form=["toml" if what.startswith("policy") else "csv" for what in files],
        conversion=[*files],
        of_subjects={**dataset.of_subjects, "alerts": AlertInputs(logs, policies)},
    )


def _read_log(
    file: SourceFile, dataset: Dataset, session: Session, source: SystemSource, name: str
) -> AlertLog:
    content = csv_content(file, role="detections")
    header = read_header(content.partition(b"\n")[0].decode())
    columns = [column.lower() for column in header.names]
    if ALERTED not in columns:
        log = parse_table(content, name=file.name, what="alerts", required=LOG_COLUMNS)
        title_of = {entry.name: entry.title for entry in session.recordings if entry.title}
        return AlertLog(table=_log_table(log, dataset, title_of, name))
    of_system = find_files(source, session.folder, "detections")[0]
    same = [known.name for known in of_system if known.path.resolve() == file.path.resolve()]
    inputs = dataset.inputs
    rows = np.flatnonzero((inputs["subject"] == name) & inputs["file"].isin(same))
    if not len(rows):
        problem = f"has a column {ALERTED}, and is no file of the detections of {one_line(name)}"
        raise InputError(f"{problem}; name that file, or a table of alerts", file=file.name)
    place = header.place | {ALERTED: columns.index(ALERTED)}
    number = next(column for column in header.place if column in NUMBERS)
    known = Header(header.names, header.delimiter, place)
    values, line, _ = read_columns(file, known, content, [number, ALERTED])
    alerted = line[values[ALERTED].to_numpy(dtype=bool)].astype(np.int64)
    return AlertLog(places=int(rows[0]) * _LINES + alerted)


def _log_table(
    log: TextTable, dataset: Dataset, title_of: dict[str, str], system: str
) -> pd.DataFrame:
    start_s, end_s = (log.numbers(name, low=0.0) for name in ("start_s", "end_s"))
    if (is_before := end_s < start_s).any():
        raise log.fault(int(np.argmax(is_before)), "end_s: expected start_s or more")
    track = np.full(len(log), NO_TRACK)
    if "track" in log:
        track = log.whole_numbers("track", if_empty=NO_TRACK)
    names = dataset.recordings["name"].tolist()
    if "recording" in log:
        recording = [title_of.get(name, name) for name in log.texts("recording")]
    elif len(names) == 1:
        recording = names * len(log)
    else:
        raise log.fault(0, "expected a column recording, as there are several recordings")
    row_of = {name: row for row, name in enumerate(names)}
    frames, time_s = dataset.frame_columns, dataset.frames["time_s"].to_numpy()
    known = _tracks_of(dataset, system) if (track >= 0).any() else set()
    for row, name in enumerate(recording):  # small tables: every row may be wrong by itself
        if name not in row_of:
            raise log.fault(row, f"recording: there is no {one_line(name)!r}")
        number = row_of[name]
        own_s = time_s[frames.rows_of(number)]
        if not len(own_s) or start_s[row] > own_s[-1]:
            ends = f"ends at {own_s[-1]:g} s" if len(own_s) else "has no frames"
            raise log.fault(row, f"start_s: {start_s[row]:g} s, but {one_line(name)} {ends}")
        # of sampled frames, a track may have boxes in the others
        is_checked = track[row] != NO_TRACK and frames.sampling_step[number] == 1
        if is_checked and (number, int(track[row])) not in known:
            text = f"track: {one_line(system)} has no track {track[row]} in {one_line(name)}"
            raise log.fault(row, text)
    name_of = {title: name for name, title in title_of.items()}
    return pd.DataFrame(
        {
            "recording": pd.Series([name_of.get(name, name) for name in recording], dtype=object),
            "start_s": start_s,
            "end_s": end_s,
            "track": track,
            "log_kind": pd.Series(log.texts("kind", may_be_empty=True), dtype=object),
        }
    )


def _tracks_of(dataset: Dataset, system: str) -> set[tuple[int, int]]:
    """Number of the recording and track of all boxes of a system, linked where it has none."""
    boxes, frames = dataset.system(system), dataset.frame_columns
    track = track_truth(boxes, frames).track
    return {*zip(frames.recording[boxes.frame_index].tolist(), track.tolist(), strict=True)}


INPUT: Final = Input(
    name=ALERTS_INPUT,
    is_named=lambda session: any(
        system.alerts is not None or system.alert_policy is not None for system in session.systems
    ),
    join=with_alerts,
)
