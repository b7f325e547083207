"""The call of Python users that runs a detector over recordings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import Setting
from nvcore.errors import InputError
from nvcore.extras import needs
from nvcore.inputs.load import load
from nvcore.inputs.recordings_file import with_recordings_file
from nvcore.inputs.session import Session
from nvcore.inputs.session_toml import read_session
from nvcore.progress import Progress, no_progress
from nvcore.report.protect_inputs import files_read, input_folder_around, replaced_input

if TYPE_CHECKING:
    from nvcore.detectors.writing import WrittenRun


def detect(
    source: str | Path | Session | Dataset,
    detector: str | Path,
    out: str | Path,
    *,
    settings: Mapping[str, Setting] | None = None,
    name: str | None = None,
    threshold: float | None = None,
    against: str | None = None,
    only: Sequence[str] = (),
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> WrittenRun:
    """Run a detector over the pictures of recordings, as a system like any other.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`: it names the pictures of each
        recording, and need not name a system.
    detector
        ``"hog"``, ``"hog:daimler"``, or a model: one that was trained here, or an ONNX file.
    out
        Folder for the boxes (CSV), the record of how they were made, and ``session.toml``.
    settings
        Of the detector, by name; ``nvcore models`` describes them.
    name, threshold
        Of the new system; None: the detector's.
    against
        The system that it is compared with, as X; None: the session's X.
    only
        Names of recordings; empty: all.
    n_threads
        Pictures at a time, each in one thread; None: as many as there are cores. 1: a picture may
        take all cores.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`:
        nothing is then written.

    Returns
    -------
    WrittenRun
        ``.session`` is the file that `compare` takes; ``.run`` says what came out, and which frames
        have no picture.

    Raises
    ------
    InputError
        If an input or the model cannot be used, an input would be replaced, or no evaluated frame
        has a picture.
    MissingExtraError
        If the extra ``detectors``, or for ONNX files ``onnx``, is not installed.

    Examples
    --------
    >>> hog = detect("night.toml", "hog", "hog", settings={"upscale": 2})  # doctest: +SKIP
    >>> compare(hog.session)  # doctest: +SKIP
    """
    with needs("detectors", "detectors need"):
        from nvcore.detectors.registry import open_detector
        from nvcore.detectors.run import run_detector
        from nvcore.detectors.writing import check_target, outputs, write_detections
        from nvcore.pictures import session_pictures

    opened = open_detector(detector, settings)
    dataset = dataset_of(source).only(names=only)
    session = dataset.settings
    if not isinstance(session, Session):
        raise InputError("expected a session, or a dataset that was loaded: it names the pictures")
    check_target(dataset, Path(out), name=name, against=against)
    files = [Path(path) for path in (source, detector) if isinstance(path, str | Path)]
    check_not_inputs(outputs(Path(out), dataset), Path(out), session, files)
    pictures = session_pictures(session, dataset)
    try:
        run = run_detector(opened, dataset, pictures, n_threads=n_threads, progress=progress)
    finally:
        pictures.close()
    return write_detections(
        run, dataset, Path(out), name=name, threshold=threshold, against=against
    )


def check_not_inputs(
    files: Iterable[Path], out: Path, session: Session, inputs: Sequence[Path]
) -> None:
    """Refuse to write over what is read.

    Parameters
    ----------
    files, out
        What is written, and the folder for it.
    inputs
        Further files that are read, beside those of the session.

    Raises
    ------
    InputError
        If one of the files is an input, or the folder lies in one of inputs.
    """
    clash = replaced_input(files, [*inputs, *files_read(session)])
    if clash is not None:
        raise InputError("is an input, and would be replaced; give another folder", file=clash)
    around = input_folder_around(out, session)
    if around is not None:
        raise InputError(f"lies in the folder of inputs {around}; give another", file=out)


def dataset_of(source: str | Path | Session | Dataset) -> Dataset:
    """The data of a session; a session file need not name a system."""
    if isinstance(source, Dataset):
        return source
    if not isinstance(source, Session):
        source = read_session(source, needs_system=False)
    return load(with_recordings_file(source))
