"""Write the boxes of a detector run, their provenance, and a session with the new system."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Final

from nvcore import __version__
from nvcore.common.errors import InputError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import check_folder, write_run
from nvcore.common.wording import one_line
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import Provenance, provenance_json, ranges_of, read_provenance
from nvcore.inputs.files.hashes import source_hash, source_hashes
from nvcore.inputs.session import Session, SystemSource
from nvcore.inputs.session.changes import live_session, stated
from nvcore.inputs.session.toml import write_session
from nvcore.inputs.writers import safe_names
from nvcore.settings.objects import labels_in_order
from nvcore.subjects.detectors.running.run import DetectorRun

SESSION_FILE: Final = "session.toml"
PROVENANCE_FILE: Final = "provenance.json"


@dataclass(frozen=True, eq=False, repr=False)
class WrittenRun:
    """Files written by `write_detections`. ``print`` shows a summary of the run and their folder.

    Attributes
    ----------
    session
        The session of the dataset with the new system.
    provenance
        Provenance record of the boxes.
    files
        Files with the boxes, one per recording.
    system
        The new system as the session names it, with absolute paths.
    """

    session: Path
    provenance: Path
    files: tuple[Path, ...]
    system: SystemSource
    run: DetectorRun

    @property
    def name(self) -> str:
        """Name of the new system."""
        assert self.system.name is not None
        return self.system.name

    def __repr__(self) -> str:
        return f"<WrittenRun of {one_line(self.name)}: {one_line(str(self.session))}>"

    def __str__(self) -> str:
        where = one_line(f"{self.session.parent} as {self.name}")
        parts = [*map(str, self.run.about.trained_on)] or ["not known"]
        return f"{self.run}\ntrained on: {'; '.join(parts)}\nwritten to {where}"


def outputs(dataset: Dataset) -> list[str]:
    """Return the names of the files that `write_detections` may write."""
    return [*_files_of(dataset).values(), PROVENANCE_FILE, SESSION_FILE]


def _files_of(dataset: Dataset) -> dict[str, str]:
    """Return the file name of the boxes of each recording."""
    names = [*dataset.recordings["name"]]
    return dict(zip(names, [f"{name}.csv" for name in safe_names(names)], strict=True))


def check_target(
    dataset: Dataset, folder: Path, *, name: str | None = None, against: str | None = None
) -> None:
    """Check the arguments of `write_detections` before a long run.

    Raises
    ------
    InputError
        If there is no system `against`, a system `name` exists already, or the folder is not
        writable.
    """
    if against is not None:
        dataset.system(against)
    if name is not None and name in dataset.systems:
        raise InputError(f"there is a system {name!r} already; give the new one another name")
    check_folder(folder, [*outputs(dataset), *_recorded_before(folder)])


def write_detections(
    run: DetectorRun,
    dataset: Dataset,
    folder: Path,
    *,
    name: str | None = None,
    threshold: float | None = None,
    against: str | None = None,
) -> WrittenRun:
    """Write the boxes, their provenance, and a session with the new system.

    Files of an earlier run are removed from the folder.

    Parameters
    ----------
    dataset
        Dataset of the run, with a `Session` as its settings.
    name
        Name of the new system. None: the detector's name, with a number if it is taken.
    threshold
        Score threshold of the new system. None: that of the detector.
    against
        System to compare with, as X. None: the previous X.

    Raises
    ------
    InputError
        If the detector has processed no picture, or as for `check_target`.
    """
    session = dataset.settings
    assert isinstance(session, Session)
    check_target(dataset, folder, name=name, against=against)
    own = run.about.name
    free = chain([own or "detector"], (f"{own} ({number})" for number in count(2)))
    name = name or next(text for text in free if text not in dataset.systems)
    entries = session.entries([part.name for part in run.recordings])
    files_of, contents, frames = _files_of(dataset), dict[str, bytes](), {}
    for part in run.recordings:
        if not len(part.frames):  # without pictures nothing is known about its frames
            continue
        in_data = entries[part.name].name if part.name in entries else part.name
        table = part.boxes.copy()
        table.insert(0, "recording", in_data)
        contents[files_of[part.name]] = to_csv_bytes(table)
        frames[in_data] = ranges_of(part.frames)
    if not contents:
        notes = " ".join(part.note for part in run.recordings if part.note)
        raise InputError(f"the detector has seen no picture. {notes}".strip())
    digests = {key: hashlib.sha256(content).hexdigest() for key, content in contents.items()}
    record = Provenance(run.about, digests, frames, f"nvcore {__version__}")
    paths = {key: folder / key for key in (*contents, PROVENANCE_FILE, SESSION_FILE)}
    system = SystemSource(
        path=tuple(str(paths[key].absolute()) for key in contents),
        format="csv",
        name=name,
        classes=_classes(run, dataset),
        threshold=run.about.threshold if threshold is None else threshold,
        provenance=str(paths[PROVENANCE_FILE].absolute()),
    )
    x, y = dataset.compared()
    old_x = x if against is None else against
    before = live_session(stated(session, dataset), dataset, dataset.params_of(), x=x, y=y)
    written = replace(
        before,
        systems=(*before.systems, system),
        hashes={**source_hashes(dataset), name: source_hash(digests.values())},
        x=old_x or name,
        y=None if old_x is None else name,
    )
    text = write_session(written, version=__version__, fingerprint=dataset.fingerprint)
    files = [
        *contents.items(),
        (PROVENANCE_FILE, provenance_json(record)),
        (SESSION_FILE, text.encode()),
    ]
    outdated = [
        key
        for key, digest in _recorded_before(folder).items()
        if (path := folder / key).suffix == ".csv" and path.is_file()
        if hashlib.sha256(path.read_bytes()).hexdigest() == digest  # not edited since the run
    ]
    write_run(folder, files, outdated)
    *of_boxes, provenance, session_file = paths.values()
    return WrittenRun(session_file, provenance, tuple(of_boxes), system, run)


def _classes(run: DetectorRun, dataset: Dataset) -> tuple[str, ...] | None:
    """Return the labels that occur if none is a name of the session's objects, else None.

    For example, labels 30 and 100 of a limit detector would not be read as speed signs.
    """
    used = {
        str(label)
        for part in run.recordings
        if "class" in part.boxes
        for label in part.boxes["class"].unique()
    }
    if not used or any(map(dataset.objects.counts, used)):
        return None
    return labels_in_order(used)


def _recorded_before(folder: Path) -> dict[str, str]:
    """Return names and hashes of an earlier run's files from its provenance record."""
    path = folder / PROVENANCE_FILE
    try:
        files = read_provenance(path, PROVENANCE_FILE).files if path.is_file() else {}
    except InputError:  # not our record, so none of its files is removed
        return {}
    return {name: digest for name, digest in files.items() if Path(name).name == name}
