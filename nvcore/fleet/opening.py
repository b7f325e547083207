"""A recording of a store as a session by itself, which the dashboard and all commands open."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.findings import Remedy, Step
from nvcore.fleet.batch import dataset_of
from nvcore.fleet.folder import plan_shown
from nvcore.fleet.location import Location
from nvcore.fleet.results import ScanParams
from nvcore.fleet.store import Snapshot, Store
from nvcore.fleet.tables import FACTS
from nvcore.inputs.readers.base import Reading, Role, recordings_table
from nvcore.inputs.session import (
    TABLES_OF_SUBJECTS,
    RecordingEntry,
    Session,
    Source,
    SystemSource,
)
from nvcore.inputs.session_toml.writing import write_session
from nvcore.inputs.writers import write
from nvcore.inputs.writers.classes import class_names
from nvcore.output.csv_text import to_csv_bytes
from nvcore.output.files import write_whole
from nvcore.schema import DETECTABILITY_COLUMNS, NO_LABEL, NO_TRACK, READING_DTYPES, conform
from nvcore.wording import count_text, did_you_mean, listed

SESSION: Final = "session.toml"
TRUTH: Final = "truth.parquet"
SYSTEMS: Final = ("x.parquet", "y.parquet")
FRAMES: Final = "frames.txt"
SPEED: Final = "speed.csv"
DETECTABILITY: Final = "detectability.csv"
IGNORED: Final = "ignore"
"""Class of boxes of a truth with classes that it ignores."""
ESTIMATES: Final = (
    *("recording", "frame", "track", "x", "y", "w", "h"),
    *("detectability", "sd", "is_outside", "period_s"),
)
"""Columns of the file of detectability: period_s is empty where eyes are adapted."""
FILES: Final = (SESSION, TRUTH, *SYSTEMS, FRAMES, SPEED, DETECTABILITY)
"""What `write_recording` may write."""


def recording_of(
    location: Location,
    recording: str,
    *,
    x: str | None = None,
    y: str | None = None,
    truth: str | None = None,
) -> tuple[Dataset, dict[str, Any]]:
    """A recording of a store, or as a scan has compared it, and where its pictures are.

    Parameters
    ----------
    location
        Of a store, or of the results of a scan, whose settings and versions are taken then.
    x, y, truth
        Sources, as of `Snapshot.pick`. None: the scan's, or the only two systems there are.

    Raises
    ------
    InputError
        If there is no such recording or source, or it is not clear which systems are meant.
    """
    plan = plan_shown(location)
    if plan is None:
        snapshot = Store(location).snapshot()
        rows = snapshot.sources[snapshot.sources["recording"] == recording]
        systems = rows.loc[rows["kind"] == "system", "source"].unique().tolist()
        left = [name for name in systems if name not in (x, y)]
        if len(left) == (x is None) + (y is None):
            x = left.pop(0) if x is None else x
            y = left.pop(0) if y is None else y
        if len(rows) and (x is None or y is None):
            raise InputError(
                f"expected two systems to compare, found {listed(systems) or 'none'}; name X and Y",
                file=location.uri,
            )
        params = ScanParams(x or "x", y or "y", truth or "truth")
    else:
        snapshot = Snapshot(Location(plan.store, location.options), plan.versions)
        own = plan.params
        params = replace(own, x=x or own.x, y=y or own.y, truth=truth or own.truth)
    if recording not in set(snapshot.recordings["recording"]):
        names = snapshot.recordings["recording"].tolist()
        known = f"there are {count_text(len(names), 'recording')}"
        raise InputError(
            f"there is no recording {recording!r}; {did_you_mean(recording, names, known)}",
            file=snapshot.location.uri,
        )
    tables = snapshot.read([recording], params.sources)
    [facts] = tables["recordings"].select(["pictures", "first_picture"]).to_pylist()
    pictures = facts["pictures"]
    scheme, separator, rest = (pictures or "").partition("://")
    if separator:
        pictures = unquote(rest) if scheme == "file" else None
    return dataset_of(tables, params), facts | {"pictures": pictures or None}


def write_recording(
    dataset: Dataset,
    folder: Path,
    *,
    pictures: str | None = None,
    first_picture: int | None = None,
    force: bool = False,
) -> Path:
    """Write a session that gives the same numbers as the dataset: boxes, frames, facts, settings.

    Parameters
    ----------
    dataset
        One recording with X and Y, and the settings of its comparison.
    folder
        Where to write `FILES`.
    pictures
        Path of the recording's pictures, if there are any on this machine.
    first_picture
        Number of the frame that the first one shows; None: by their names.
    force
        Whether files that are there are replaced.

    Returns
    -------
    Path
        The session file.

    Raises
    ------
    InputError
        If one of the files is there, the folder cannot be written to, or no frame of the recording
        is evaluated.
    """
    folder = folder.absolute()
    [recording] = dataset.recordings.to_dict("records")
    if not len(dataset.frames):
        raise InputError(f"recording {recording['name']!r} has no evaluated frame to open")
    there = [folder / name for name in FILES if (folder / name).exists()]
    if there and not force:
        step = Step(Remedy.OPTION, "", "force")
        raise InputError("exists; name another folder", file=there[0], steps=(step,))
    facts: dict[str, Any] = {
        name: None if pd.isna(recording[name]) else recording[name] for name in FACTS
    }
    frames = dataset.frames
    lines = "".join(f"{number}\n" for number in frames["frame"])
    write_whole(folder / FRAMES, lines.encode())
    has_speed = frames["speed_kmh"].notna()
    if has_speed.any():
        # read again, each frame is at a reading
        series = frames.loc[has_speed, ["time_s", "speed_kmh"]]
        write_whole(folder / SPEED, to_csv_bytes(series, digits=None))
        facts["speed"] = SPEED
    more: dict[str, Any] = {}
    truth = _reading(dataset, 0)
    estimates = truth.boxes.assign(
        **{
            name: dataset.boxes[name].to_numpy()[: len(truth.boxes)]
            for name in DETECTABILITY_COLUMNS
        }
    )
    is_estimated = estimates["is_outside"] | estimates["is_adapted"]
    if (is_estimated | estimates["detectability_sd"].notna()).any():
        # a column of the truth has the value alone
        table = estimates[estimates["detectability"].notna()].assign(
            track=lambda of: of["track"].astype("Int64").mask(of["track"] == NO_TRACK),
            period_s=lambda of: np.where(of["is_adapted"], np.nan, 0.0),
        )
        table = table.rename(columns={"detectability_sd": "sd"})[list(ESTIMATES)]
        write_whole(folder / DETECTABILITY, to_csv_bytes(table, digits=None))
        truth = replace(truth, boxes=truth.boxes.assign(detectability=np.nan))
        more["driver"] = TABLES_OF_SUBJECTS["driver"](detectability=DETECTABILITY)
    readings = [truth, *(_reading(dataset, number) for number in range(1, len(SYSTEMS) + 1))]
    sources = []
    for name, reading in zip((TRUTH, *SYSTEMS), readings, strict=True):
        role: Role = "truth" if name == TRUTH else "detections"
        write(reading, "parquet", folder / name, role=role, objects=dataset.objects, force=True)
        # all that a store holds counts, whatever its class is called
        of_box = class_names(reading, dataset.objects)
        classes = None if of_box is None else tuple(sorted({*of_box} - {IGNORED}))
        sources.append(Source(name, "parquet", classes, frame_names="numbers"))
    settings = dataset.settings
    session = Session(
        **{name: getattr(settings, name) for name in settings.__dataclass_fields__},
        folder=folder,
        truth=sources[0],
        systems=tuple(
            SystemSource(**vars(source), name=name)
            for source, name in zip(sources[1:], dataset.systems, strict=True)
        ),
        recordings=(
            RecordingEntry(
                recording["name"],
                frames=FRAMES,
                tags=recording["tags"],
                unit=recording["unit"] or None,
                pictures=pictures,
                first_picture=first_picture,
                **facts,
            ),
        ),
        **more,
    )
    text = write_session(session, version=__version__, fingerprint=dataset.fingerprint)
    write_whole(folder / SESSION, text.encode())
    return folder / SESSION


def _reading(dataset: Dataset, source: int) -> Reading:
    """Boxes of the truth (0) or of system number `source` - 1, as their file is to hold them."""
    boxes = dataset.boxes[dataset.boxes["source"] == source]
    name = dataset.recordings["name"][0]
    columns: dict[str, object] = {
        column: boxes[column].to_numpy() for column in boxes if column in READING_DTYPES
    }
    columns["recording"] = name
    columns["frame"] = dataset.frames["frame"].to_numpy()[boxes["frame_index"]]
    labels: tuple[str, ...] = ()
    if (boxes["label"] != NO_LABEL).any():
        # who ignores a box need not say of what class it is: another class than none
        labels = (*dataset.labels, IGNORED)
        is_ignored = boxes["ignore"] & (boxes["label"] == NO_LABEL)
        if not dataset.objects.is_numbered:  # else it is a class without a number
            columns["label"] = boxes["label"].mask(is_ignored, len(dataset.labels)).to_numpy()
    has_texts = source == 0 and len(dataset.attributes) > 0
    return Reading(
        conform(columns, READING_DTYPES, n_rows=len(boxes)),
        recordings_table([name]),
        "",
        labels=labels,
        attributes=dataset.attributes if has_texts else None,
    )
