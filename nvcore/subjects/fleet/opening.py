"""Export a recording of a store as a session for the dashboard and all commands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final
from urllib.parse import unquote

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Step
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import write_whole
from nvcore.common.wording import listed
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_LABEL, NO_TRACK, READING_DTYPES, conform
from nvcore.inputs.readers.base import Reading, Role, recordings_table
from nvcore.inputs.session import TABLES_OF_SUBJECTS, RecordingEntry, Session, Source, SystemSource
from nvcore.inputs.session.toml import write_session
from nvcore.inputs.writers import write, write_frame_lists
from nvcore.inputs.writers.coco import class_names
from nvcore.subjects.fleet.batch import dataset_of
from nvcore.subjects.fleet.folder import plan_shown
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.results import ScanParams
from nvcore.subjects.fleet.store import Snapshot, Store
from nvcore.subjects.fleet.tables import FACTS

SESSION: Final = "session.toml"
TRUTH: Final = "truth.parquet"
SYSTEMS: Final = ("x.parquet", "y.parquet")
FRAMES: Final = "frames.txt"
SPEED: Final = "speed.csv"
DETECTABILITY: Final = "detectability.csv"
IGNORED: Final = "ignore"
"""Class of boxes of a truth with classes that it ignores."""
FILES: Final = (SESSION, TRUTH, *SYSTEMS, FRAMES, SPEED, DETECTABILITY)
"""Files that `write_recording` may write."""


def recording_of(
    location: Location,
    recording: str,
    *,
    x: str | None = None,
    y: str | None = None,
    truth: str | None = None,
) -> tuple[Dataset, dict[str, Any]]:
    """Return a recording of a store or of a scan, and its `pictures` and `first_picture`.

    `location` is a store, or the results of a scan, whose settings and versions are then used.
    `x`, `y` and `truth` are sources as of `Snapshot.pick`. None: the scan's, or the only two
    systems there are.

    Raises
    ------
    InputError
        If there is no such recording or source, or the choice of systems is ambiguous.
    """
    plan = plan_shown(location)
    if plan is None:
        snapshot = Store(location).snapshot()
        rows = snapshot.sources[snapshot.sources["recording"] == recording]
        systems = rows.loc[rows["kind"] == "system", "source"].unique().tolist()
        left = [name for name in systems if name not in (x, y)]
        if len(left) == [x, y].count(None):
            x, y = (left.pop(0) if name is None else name for name in (x, y))
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
    tables = snapshot.read([recording], params.sources)
    [facts] = tables["recordings"].select(["pictures", "first_picture"]).to_pylist()
    scheme, separator, path = (facts["pictures"] or "").partition("://")
    if separator:
        facts["pictures"] = unquote(path) if scheme == "file" else None
    return dataset_of(tables, params), facts | {"pictures": facts["pictures"] or None}


def write_recording(
    dataset: Dataset,
    folder: Path,
    *,
    pictures: str | None = None,
    first_picture: int | None = None,
    force: bool = False,
) -> Path:
    """Write a dataset of one recording as a session with the same numbers, and return its file.

    Parameters
    ----------
    folder
        Folder for `FILES`.
    pictures
        Path of the recording's pictures, if there are any on this machine.
    first_picture
        Frame number of the first picture. None: by the names of pictures.
    force
        Whether existing files are replaced.

    Raises
    ------
    InputError
        If one of the files exists, the folder cannot be written to, or no frame is evaluated.
    """
    folder = folder.absolute()
    [recording] = dataset.recordings.to_dict("records")
    if not len(dataset.frames):
        raise InputError(f"recording {recording['name']!r} has no evaluated frame to open")
    there = [folder / name for name in FILES if (folder / name).exists()]
    if there and not force:
        step = Step(Remedy.OPTION, "", "force")
        raise InputError("exists; name another folder", file=there[0], steps=(step,))
    facts: dict[str, Any] = {"pictures": pictures, "first_picture": first_picture}
    facts |= {"frames": FRAMES, "tags": recording["tags"], "unit": recording["unit"] or None}
    facts |= {name: None if pd.isna(recording[name]) else recording[name] for name in FACTS}
    write_frame_lists({"": dataset.frames["frame"].to_numpy()}, folder / FRAMES, force=True)
    series = dataset.frames.loc[dataset.frames["speed_kmh"].notna(), ["time_s", "speed_kmh"]]
    if len(series):  # when it is read again, each frame has a reading
        write_whole(folder / SPEED, to_csv_bytes(series, digits=None))
        facts["speed"] = SPEED
    more: dict[str, Any] = {}
    truth, *detections = (_reading(dataset, number) for number in range(len(SYSTEMS) + 1))
    own = dataset.boxes[: len(truth.boxes)].assign(frame=truth.boxes["frame"].to_numpy())
    is_known = own["is_outside"] | own["is_adapted"] | own["detectability_sd"].notna()
    if is_known.any():  # the column of the truth has only the value
        table = own[own["detectability"].notna()].assign(
            recording=recording["name"],
            track=lambda of: of["track"].astype("Int64").mask(of["track"] == NO_TRACK),
            period_s=lambda of: np.where(of["is_adapted"], np.nan, 0.0),
        )
        table = table.rename(columns={"detectability_sd": "sd"})
        names = ("recording", "frame", "track", "x", "y", "w", "h", "detectability", "sd")
        content = to_csv_bytes(table[[*names, "is_outside", "period_s"]], digits=None)
        write_whole(folder / DETECTABILITY, content)
        truth = replace(truth, boxes=truth.boxes.assign(detectability=np.nan))
        more["driver"] = TABLES_OF_SUBJECTS["driver"](detectability=DETECTABILITY)
    sources = []
    for name, reading in zip((TRUTH, *SYSTEMS), (truth, *detections), strict=True):
        role: Role = "truth" if name == TRUTH else "detections"
        write(reading, "parquet", folder / name, role=role, objects=dataset.objects, force=True)
        # all boxes of a store count, whatever the names of their classes
        of_box = class_names(reading, dataset.objects)
        classes = None if of_box is None else tuple(sorted({*of_box} - {IGNORED}))
        sources.append(Source(name, "parquet", classes, frame_names="numbers"))
    systems = tuple(
        SystemSource(**vars(source), name=name)
        for source, name in zip(sources[1:], dataset.systems, strict=True)
    )
    session = Session(
        **vars(dataset.settings),
        folder=folder,
        truth=sources[0],
        systems=systems,
        recordings=(RecordingEntry(recording["name"], **facts),),
        **more,
    )
    text = write_session(session, version=__version__, fingerprint=dataset.fingerprint)
    write_whole(folder / SESSION, text.encode())
    return folder / SESSION


def _reading(dataset: Dataset, source: int) -> Reading:
    """Make the reading to write for the truth (`source` 0) or system number `source` - 1."""
    boxes = dataset.boxes[dataset.boxes["source"] == source]
    name = dataset.recordings["name"][0]
    columns: dict[str, object] = {of: boxes[of].to_numpy() for of in boxes if of in READING_DTYPES}
    frame = dataset.frames["frame"].to_numpy()[boxes["frame_index"]]
    columns |= {"recording": name, "frame": frame}
    labels: tuple[str, ...] = ()
    if (boxes["label"] != NO_LABEL).any():
        # ignored boxes without a class get the class `IGNORED`
        labels = (*dataset.labels, IGNORED)
        is_ignored = boxes["ignore"] & (boxes["label"] == NO_LABEL)
        if not dataset.objects.is_numbered:  # otherwise it is a class without a number
            columns["label"] = boxes["label"].mask(is_ignored, len(dataset.labels)).to_numpy()
    return Reading(
        conform(columns, READING_DTYPES, n_rows=len(boxes)),
        recordings_table([name]),
        "",
        labels=labels,
        attributes=dataset.attributes if source == 0 and len(dataset.attributes) else None,
    )
