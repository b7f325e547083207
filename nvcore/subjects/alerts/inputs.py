"""Alert logs and policies that a session names, assigned to the data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import FormatError, InputError
from nvcore.common.findings import Finding
from nvcore.common.wording import one_line
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.files.find import digest, find_files
from nvcore.inputs.readers.base import SourceFile, warning
from nvcore.inputs.readers.csv.columns import (
    ALERTED,
    NUMBERS,
    Header,
    csv_content,
    read_columns,
    read_header,
)
from nvcore.inputs.readers.parse.table import LONGEST_S, TextTable, parse_table
from nvcore.inputs.session import Session, SystemSource
from nvcore.inputs.session.added import Input, with_files
from nvcore.metrics.linking import track_truth
from nvcore.subjects.alerts.policy import Policy, read_policy

ROUNDING_S: Final = 5e-4
"""Tolerance for times beyond the end of a recording, because tables are rounded."""
_LINES: Final = 1 << 32
"""Bound on the number of lines of a file."""


AlertLog = np.ndarray | pd.DataFrame
"""A system's own log of its alerts, in one of two forms.

Either `places_of` the detections that were alerts, or a table with one row per alert: recording
(its name in the data), start_s, end_s (since the recording's first listed frame), track
(`NO_TRACK`: none), log_kind (the log's own word)."""


@dataclass(frozen=True)
class AlertInputs:
    """Logs and policies by the number of the system, without systems that have none."""

    logs: dict[int, AlertLog]
    policies: dict[int, Policy]


def places_of(boxes: pd.DataFrame) -> np.ndarray:
    """Combine file and line of boxes into one number, int64, shape (n,)."""
    file, line = (boxes[name].to_numpy(dtype=np.int64) for name in ("file", "line"))
    places: np.ndarray = file * _LINES + line
    return places


def with_alerts(dataset: Dataset, session: Session) -> Dataset:
    """Add the logs and policies that the session names, or the systems' files hold, to the dataset.

    Raises
    ------
    InputError
        If a file cannot be used, with file and line.
    """
    logs: dict[int, AlertLog] = {}
    policies: dict[int, Policy] = {}
    files: dict[str, SourceFile] = {}
    findings: list[Finding] = []
    for number, (name, source) in enumerate(zip(dataset.systems, session.systems, strict=True)):
        own = _own_files(dataset, session, source, name)
        if source.alerts is not None:
            file = SourceFile(session.folder / source.alerts, source.alerts)
            logs[number] = _read_log(file, dataset, session, own, name)
            files[f"log of {name}"] = file
        elif any(map(_has_flags, own.values())):
            try:
                logs[number] = _flagged(own)
            except FormatError as error:
                findings += [
                    warning(
                        "alerted-unused",
                        1,
                        f"The column {ALERTED} is no log, and is left unused: {error.message}.",
                        "Write 1 where a detection was an alert, else 0, in all of its files.",
                        role=name,
                        file=str(error.file),
                        example="" if error.line is None else f"line {error.line}",
                    )
                ]
        if source.alert_policy is not None:
            file = SourceFile(session.folder / source.alert_policy, source.alert_policy)
            policies[number] = read_policy(file)
            files[f"policy of {name}"] = file
    if not (logs or policies or findings):
        return dataset
    names, digests = [file.name for file in files.values()], digest([*files.values()])
    return with_files(
        dataset,
        session,
        "alerts",
        names,
        digests,
        says="\n".join([*files, *digests]).encode(),
        form=["toml" if what.startswith("policy") else "csv" for what in files],
        conversion=[*files],
        findings=findings,
        of_subjects={**dataset.of_subjects, "alerts": AlertInputs(logs, policies)},
    )


def _own_files(
    dataset: Dataset, session: Session, source: SystemSource, system: str
) -> dict[int, SourceFile]:
    """Return the plain CSV files of a system, by their rows in `Dataset.inputs`."""
    inputs = dataset.inputs
    rows = np.flatnonzero((inputs["subject"] == system) & (inputs["format"] == "csv"))
    files = find_files(source, session.folder, "detections")[0] if len(rows) else []
    return dict(zip(rows.tolist(), files, strict=True))


def _has_flags(file: SourceFile) -> bool:
    """Whether a plain CSV file has the column `ALERTED`."""
    with file.open() as stream:
        head = stream.read(1 << 14).lower()  # no header is longer
    return (
        ALERTED.encode() in head and _place_of_flags(csv_content(file, role="detections"))[1] >= 0
    )


def _place_of_flags(content: bytes) -> tuple[Header, int]:
    """Return the header of a plain CSV file and the index of the column `ALERTED`, or -1."""
    header = read_header(content.partition(b"\n")[0].decode())
    columns = [column.lower() for column in header.names]
    return header, columns.index(ALERTED) if ALERTED in columns else -1


def _flagged(files: Mapping[int, SourceFile]) -> np.ndarray:
    """Return `places_of` the boxes that a system's files flag as alerts.

    Raises FormatError if they have no flags.

    Parameters
    ----------
    files
        Files by their rows in `Dataset.inputs`.
    """
    places = []
    for row, file in files.items():
        content = csv_content(file, role="detections")
        header, place = _place_of_flags(content)
        if place >= 0:
            known = replace(header, place=header.place | {ALERTED: place})
            number = next(column for column in header.place if column in NUMBERS)
            values, line, _ = read_columns(file, known, content, [number, ALERTED])
            flags = values[ALERTED].to_numpy(dtype=bool)
            places.append(row * _LINES + line[flags].astype(np.int64))
        elif content.partition(b"\n")[2].strip():  # a file without boxes has no alerts
            raise file.fault(f"expected a column {ALERTED}", 1)
    return np.concatenate(places)


def _read_log(
    file: SourceFile, dataset: Dataset, session: Session, own: Mapping[int, SourceFile], system: str
) -> AlertLog:
    """Read the log that a session names: a table of alerts, or a file of the system with flags.

    Rows of a table with the same begin, end and track are one alert.
    """
    content = csv_content(file, role="detections")
    if _place_of_flags(content)[1] >= 0:
        path = file.path.resolve()
        same = {row: known for row, known in own.items() if known.path.resolve() == path}
        if not same:
            problem = f"has a column {ALERTED}, and is no file of the detections of"
            text = f"{problem} {one_line(system)}; name that file, or a table of alerts"
            raise InputError(text, file=file.name)
        return _flagged(same)
    required = ("start_s", "end_s", "kind")
    log = parse_table(content, name=file.name, what="alerts", required=required)
    title_of = {entry.name: entry.title for entry in session.recordings if entry.title}
    spans = read_spans(log, dataset, title_of=title_of)
    track = np.full(len(log), NO_TRACK)
    if "track" in log:
        track = log.whole_numbers("track", if_empty=NO_TRACK)
    # with sampled frames, a track may have boxes in the others
    is_sampled = dataset.frame_columns.sampling_step[spans["recording"]] > 1
    if (is_checked := (track >= 0) & ~is_sampled).any():
        boxes, frames = dataset.system(system), dataset.frame_columns
        tracks = track_truth(boxes, frames).track.tolist()  # linked where it has none
        known = {*zip(frames.recording[boxes.frame_index].tolist(), tracks, strict=True)}
    for row in np.flatnonzero(is_checked):
        number = int(spans["recording"].iloc[row])
        if (number, int(track[row])) not in known:
            where = one_line(dataset.recordings["name"].iloc[number])
            text = f"track: {one_line(system)} has no track {track[row]} in {where}"
            raise log.fault(int(row), text)
    name_of = {title: name for name, title in title_of.items()}
    names = [name_of.get(name, name) for name in dataset.recordings["name"]]
    table = spans.assign(
        recording=pd.Series(names, dtype=object).iloc[spans["recording"]].to_numpy(),
        track=track,
        log_kind=pd.Series(log.texts("kind", may_be_empty=True), dtype=object),
    )
    # one warning through several channels reaches the driver as one
    by_span = table.groupby(["recording", "start_s", "end_s", "track"], sort=False)
    kinds = by_span["log_kind"].agg(lambda kinds: ", ".join(dict.fromkeys(filter(None, kinds))))
    return kinds.reset_index()


def read_spans(
    table: TextTable,
    dataset: Dataset,
    *,
    title_of: Mapping[str, str] | None = None,
    end: str = "end_s",
) -> pd.DataFrame:
    """Read the begin and end of a table's rows, within the recordings of a dataset.

    Parameters
    ----------
    table
        Table with start_s and `end`, and with recording if the dataset has several.
    title_of
        Names of recordings in the dataset, by other names that the table may use.
    end
        Column of the end, or ``duration_s``.

    Returns
    -------
    One row per row of the table: recording (row of the recordings), start_s and end_s (seconds
    since its first listed frame).

    Raises
    ------
    FormatError
        If there is no such recording, or a time is outside it; with the line.
    """
    names = dataset.recordings["name"].tolist()
    if "recording" in table:
        called = [(title_of or {}).get(name, name) for name in table.texts("recording")]
    elif len(names) > 1 and len(table):
        raise table.fault(0, "expected a column recording, as there are several recordings")
    else:
        called = names[:1] * len(table)
    recording = pd.Index(names, dtype=object).get_indexer(pd.Index(called, dtype=object))
    if len(unknown := np.flatnonzero(recording < 0)):
        text = f"recording: there is no {one_line(called[unknown[0]])!r}"
        raise table.fault(int(unknown[0]), text)
    start_s, end_s = (table.numbers(name, low=0, high=LONGEST_S) for name in ("start_s", end))
    if end == "duration_s":
        end_s = (start_s + end_s).round(6)
    frames, time_s = dataset.frame_columns, dataset.frames["time_s"].to_numpy()
    first, stop = frames.first[recording], frames.first[recording + 1]
    last = np.where(stop > first, stop - 1, -1)
    last_s, stop_s = (np.append(of, -np.inf)[last] for of in (time_s, time_s + frames.step_s))
    for column, is_right, words in (
        ("start_s", start_s <= last_s + ROUNDING_S, "{start:g} s, but {name} ends at {last:g} s"),
        (end, end_s >= start_s, "expected start_s or more"),
        (end, end_s <= stop_s + ROUNDING_S, "{end:g} s, but {name} ends at {stop:g} s"),
    ):
        if not is_right.all():
            row = int(np.argmin(is_right))
            values = {"start": start_s[row], "end": end_s[row], "last": last_s[row]}
            text = words.format(**values, stop=stop_s[row], name=one_line(called[row]))
            raise table.fault(row, f"{column}: {text}")
    return pd.DataFrame({"recording": recording, "start_s": start_s, "end_s": end_s})


INPUT: Final = Input(
    name="alerts",
    is_named=lambda session: any(
        system.alerts is not None or system.alert_policy is not None for system in session.systems
    ),
    join=with_alerts,
    may_be_found=True,
)
