"""Python API for running and training detectors, and the jobs behind the commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.api.inputs import keywords_named, load_part
from nvcore.common.arguments import PathLike, called_with
from nvcore.common.errors import InputError
from nvcore.common.extras import needs
from nvcore.common.output.files import check_file
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import one_line
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn
from nvcore.inputs.facts import frame_range, is_frame_range
from nvcore.inputs.files.pipes import pipes_kept
from nvcore.report.protect_inputs import files_read, refuse_outputs, refuse_to_replace
from nvcore.settings.defaults import as_names
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN
from nvcore.subjects.detectors.calls.arguments import DetectArguments, TrainArguments

if TYPE_CHECKING:
    from nvcore.subjects.detectors.running.run import Expectation
    from nvcore.subjects.detectors.running.writing import WrittenRun
    from nvcore.subjects.detectors.training.run import Training


@called_with(DetectArguments)
@pipes_kept()
def detect(arguments: DetectArguments) -> WrittenRun:
    """Run a detector over the pictures of recordings, as a system like any other.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`. It names the pictures of each
        recording and may have no system.
    settings
        Settings of the detector, by name. ``nvcore models`` describes them.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`; then
        nothing is written.

    Returns
    -------
    WrittenRun
        ``.session`` is the file for `compare`. ``.run`` holds the boxes and the frames without a
        picture. ``print`` shows what the command prints.

    Raises
    ------
    InputError
        If an input or the model cannot be used, an output would replace an input, or no evaluated
        frame has a picture.
    MissingFactError
        As for `load`.
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
    """A validated run of a detector with open pictures, ready to start.

    Attributes
    ----------
    expect
        Estimates the duration of the run.
    cautions
        Returns warnings about frames that the detector was trained on.
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
    """Validate a run and open its detector and pictures, so that errors occur before it starts.

    Parameters
    ----------
    inputs
        Additional input files that outputs must not replace.
    loading
        Progress callback for reading the inputs.

    Raises
    ------
    InputError, MissingFactError, MissingExtraError
        As for `detect`.
    """
    with needs("detectors", "detectors need"):
        from nvcore.pictures import session_pictures
        from nvcore.subjects.detectors.findings import trained_findings
        from nvcore.subjects.detectors.registry import open_detector
        from nvcore.subjects.detectors.running.run import check_pictures, expect, run_detector
        from nvcore.subjects.detectors.running.writing import (
            check_target,
            outputs,
            write_detections,
        )

    source, out = arguments.source, Path(arguments.out)
    detector = open_detector(arguments.detector, arguments.settings)
    dataset, session = load_part(source, arguments, progress=loading)
    parts = _parts(as_names(arguments.trained_on), dataset)
    about = replace(detector.about, trained_on=(*detector.about.trained_on, *parts))
    detector.about = about
    names = {"name": arguments.name, "against": arguments.against}
    check_target(dataset, out, **names)
    refuse_outputs(out, outputs(dataset), [*inputs, source, arguments.detector], session)
    n_threads = arguments.n_threads

    def cautions() -> list[str]:
        findings = trained_findings(dataset, about.name, about.trained_on)
        return [f"{finding.message} {finding.advice}" for finding in findings]

    def run(progress: Progress) -> WrittenRun:
        done = run_detector(detector, dataset, pictures, n_threads=n_threads, progress=progress)
        return write_detections(done, dataset, out, threshold=arguments.threshold, **names)

    with closing(session_pictures(session, dataset)) as pictures:
        check_pictures(pictures, dataset)
        duration = partial(expect, detector, pictures, n_threads=n_threads)
        yield DetectorJob(dataset, duration, cautions, run)


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


@called_with(TrainArguments)
@pipes_kept()
def train(arguments: TrainArguments) -> Training:
    """Train a detector (Integral Channel Features). `detect` then takes its file.

    The same data, settings and seed give the same file.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`, whose truth and pictures are
        learned. None: use folders only.
    settings
        Changes of the preset, by name. Settings with several values take a sequence.
    hold_out, split, share, gap
        Data that is not learned but calibrates the rejection: the named recordings, or this share
        of the physical objects (tracks), of the recordings, or of the end of each recording, after
        a gap of this many frames. ``auto`` takes the first of these that is possible.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`; then
        nothing is written.

    Returns
    -------
    Training
        ``.model``, and the numbers of objects that were learned, held out, kept and found.
        ``print`` shows what the command prints.

    Raises
    ------
    InputError
        If an input cannot be used or would be replaced, or there is nothing to learn.
    MissingFactError
        As for `load`.
    ParameterError
        If a setting cannot be used.
    MissingExtraError
        If the extra ``detectors`` is not installed.

    Examples
    --------
    >>> train("night.toml", "night.npz", only="urban_01")  # doctest: +SKIP
    >>> detect("night.toml", "night.npz", "icf", only="urban_02")  # doctest: +SKIP
    """
    with keywords_named(), training_job(arguments) as job:
        return job.run(arguments.progress)


@dataclass(frozen=True, eq=False)
class TrainingJob:
    """A validated training with its data gathered and its pictures open.

    Attributes
    ----------
    session
        Session as given, before recordings were selected. None if there is no session.
    run
        Trains the model and writes it.
    """

    session: object
    run: Callable[[Progress], Training]


@contextmanager
def training_job(
    arguments: TrainArguments, *, inputs: Sequence[Path] = (), loading: Progress = no_progress
) -> Iterator[TrainingJob]:
    """Validate a training and gather its data, so that errors occur before it starts.

    Parameters as for `detector_job`, errors as for `train`.
    """
    with needs("detectors", "training a detector needs"):
        from nvcore.pictures import session_pictures
        from nvcore.subjects.detectors.icf import write_model
        from nvcore.subjects.detectors.training.run import (
            gather,
            preset_for,
            preset_settings,
            train_on,
        )

    source, settings, out = arguments.source, arguments.settings or {}, Path(arguments.out)
    # wrong settings are refused before loading
    preset_settings(arguments.preset or preset_for(None), settings)
    dataset = session = pictures = None
    if source is not None:
        # the arguments select from the frames that the session evaluates
        dataset, session = load_part(source, replace(arguments, frames=None), progress=loading)
    read = (source, arguments.crops, arguments.background)
    files = [*inputs, *(Path(path) for path in read if isinstance(path, PathLike))]
    check_file(out, "model.npz")
    files += files_read(session) if session is not None else ()
    refuse_to_replace([out], files)
    preset = arguments.preset or preset_for(None if dataset is None else dataset.objects)
    objects = PEDESTRIAN if preset == "pedestrians" else SPEED_SIGN
    label = (objects if dataset is None else dataset.objects).singular

    def run(progress: Progress) -> Training:
        training = train_on(
            gathered,
            resolved,
            name=arguments.name or one_line(out.stem),
            label=label,
            seed=arguments.seed,
            progress=progress,
        )
        write_model(training.model, out)
        return training

    with ExitStack() as stack:
        if dataset is not None and session is not None:
            pictures = stack.enter_context(closing(session_pictures(session, dataset)))
        resolved = preset_settings(preset, settings)
        gathered = gather(dataset, pictures, resolved, arguments)
        yield TrainingJob(source, run)
