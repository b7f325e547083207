"""Python API for running a detector, and the job behind the command."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.api.inputs import keywords_named, load_part
from nvcore.arguments import called_with
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn
from nvcore.detectors.arguments import DetectArguments
from nvcore.errors import InputError
from nvcore.extras import needs
from nvcore.inputs.facts import frame_range, is_frame_range
from nvcore.inputs.pipes import pipes_kept
from nvcore.progress import Progress, no_progress
from nvcore.report.protect_inputs import refuse_outputs
from nvcore.settings import as_names

if TYPE_CHECKING:
    from nvcore.detectors.timing import Expectation
    from nvcore.detectors.writing import WrittenRun


@called_with(DetectArguments)
@pipes_kept()
def detect(arguments: DetectArguments) -> WrittenRun:
    """Run a detector over the pictures of recordings, as a system like any other.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`: it names the pictures of each
        recording, and need not name a system.
    settings
        Of the detector, by name; ``nvcore models`` describes them.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`:
        nothing is then written.

    Returns
    -------
    WrittenRun
        ``.session`` is the file that `compare` takes; ``.run`` says what came out, and which frames
        have no picture. ``print`` shows what the command prints.

    Raises
    ------
    InputError
        If an input or the model cannot be used, an input would be replaced, or no evaluated frame
        has a picture.
    MissingFactError
        As `load`.
    MissingExtraError
        If the extra ``detectors``, or for ONNX files ``onnx``, is not installed.

    Examples
    --------
    >>> hog = detect("night.toml", "hog", "hog", settings={"upscale": 2})  # doctest: +SKIP
    >>> compare(hog.session)  # doctest: +SKIP
    """
    with keywords_named(), detector_job(arguments) as job:
        return job.run(arguments.progress)


@dataclass(frozen=True, eq=False)
class DetectorJob:
    """A run that is known to be possible, with open pictures.

    Attributes
    ----------
    expect
        Estimates its duration.
    cautions
        Returns warnings that the detector was trained on some of the frames.
    run
        Runs the detector and writes the results.
    """

    dataset: Dataset
    expect: Callable[[], Expectation]
    cautions: Callable[[], list[str]]
    run: Callable[[Progress], WrittenRun]


@contextmanager
def detector_job(
    arguments: DetectArguments, *, inputs: Sequence[Path] = (), loading: Progress = no_progress
) -> Iterator[DetectorJob]:
    """Open all that a run needs, and refuse what cannot be done before anything runs.

    Parameters
    ----------
    inputs
        Further input files, which must not be replaced.
    loading
        Progress of the reading.

    Raises
    ------
    InputError, MissingFactError, MissingExtraError
        As `detect`.
    """
    with needs("detectors", "detectors need"):
        from nvcore.detectors.findings import trained_findings
        from nvcore.detectors.registry import open_detector
        from nvcore.detectors.run import check_pictures, run_detector
        from nvcore.detectors.timing import expect
        from nvcore.detectors.writing import check_target, outputs, write_detections
        from nvcore.pictures import session_pictures

    source, out = arguments.source, Path(arguments.out)
    detector = open_detector(arguments.detector, arguments.settings)
    dataset, session = load_part(source, arguments, progress=loading)
    parts = _parts(as_names(arguments.trained_on), dataset)
    about = replace(detector.about, trained_on=(*detector.about.trained_on, *parts))
    detector.about = about
    names = {"name": arguments.name, "against": arguments.against}
    check_target(dataset, out, **names)
    refuse_outputs(out, outputs(dataset), [*inputs, source, arguments.detector], session)
    pictures, n_threads = session_pictures(session, dataset), arguments.n_threads

    def cautions() -> list[str]:
        findings = trained_findings(dataset, about.name, about.trained_on)
        return [f"{finding.message} {finding.advice}" for finding in findings]

    def run(progress: Progress) -> WrittenRun:
        done = run_detector(detector, dataset, pictures, n_threads=n_threads, progress=progress)
        return write_detections(done, dataset, out, threshold=arguments.threshold, **names)

    try:
        check_pictures(pictures, dataset)
        duration = partial(expect, detector, pictures, n_threads=n_threads)
        yield DetectorJob(dataset, duration, cautions, run)
    finally:
        pictures.close()


def _parts(texts: Sequence[str], dataset: Dataset) -> list[TrainedOn]:
    """Parse texts such as ``RECORDING`` or ``RECORDING=first:last``."""
    names = {*dataset.recordings["name"]}
    parts = []
    for text in texts:
        name, sign, frames = text.rpartition("=")
        is_part = sign and text not in names
        if is_part and is_frame_range(frames):
            ends = frame_range(frames)
            parts.append(TrainedOn("", name, ends.first, ends.last))
        elif is_part and name in names:
            raise InputError(
                f"trained on {text!r}: expected a recording, or frames of it as {name}=first:last, "
                "such as 0:399, :399 or 400:"
            )
        else:
            parts.append(TrainedOn(recording=text))
    return parts
