"""Recordings of a new version's detections, found among those of an open dataset."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal, NamedTuple

from nvcore.dataset import Dataset
from nvcore.inputs.load import read_source
from nvcore.inputs.session import Session, Source


class FoundRecording(NamedTuple):
    """Recording of some detections, the dataset's one that it is, and by what it was found."""

    name: str
    recording: str | None
    by: Literal["name", "pictures", "only one"] | None


def find_recordings(path: Path, dataset: Dataset) -> tuple[FoundRecording, ...]:
    """Find the recordings of one file or folder of detections in a dataset, in their order.

    A recording is found by its name; else by pictures of that name in the folder (a video, an
    archive or a folder) that are those of the session byte by byte; else as the only one of both.

    Raises
    ------
    InputError
        If the detections cannot be read.
    """
    session, ours = dataset.settings, [*dataset.recordings["name"]]
    entries = session.recordings if isinstance(session, Session) else ()
    known = dict(zip(ours, ours, strict=True))
    known |= {of.name: of.title for of in entries if of.title in ours}
    reading = read_source(Source((str(path.absolute()),)), role="detections")
    names = list(dict.fromkeys([*reading.recordings["name"], *reading.boxes["recording"]]))
    shown: dict[str | None, str] = {}
    if isinstance(session, Session) and path.is_dir() and not set(names) <= known.keys():
        pictured = [of for of in entries if of.pictures and (of.title or of.name) in ours]
        shown = {_digest(session.folder / str(of.pictures)): of.title or of.name for of in pictured}
        shown.pop(None, None)

    def find(name: str) -> FoundRecording:
        if name in known:
            return FoundRecording(name, known[name], "name")
        for beside in sorted(path.iterdir()) if shown else ():
            if name in (beside.name, beside.stem) and (digest := _digest(beside)) in shown:
                return FoundRecording(name, shown[digest], "pictures")
        is_only = len(names) == len(ours) == 1
        return (
            FoundRecording(name, ours[0], "only one")
            if is_only
            else FoundRecording(name, None, None)
        )

    return tuple(map(find, names))


def _digest(pictures: Path) -> str | None:
    """Return the sha256 of a file, or of the files of a folder by name. None: there are none."""
    files = sorted(pictures.iterdir()) if pictures.is_dir() else [pictures]
    digests = []
    for file in filter(Path.is_file, files):
        with file.open("rb") as stream:
            digests.append(hashlib.file_digest(stream, "sha256").digest())
    return hashlib.sha256(b"".join(digests)).hexdigest() if digests else None
