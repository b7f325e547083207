"""A detector trained: the call of Python users, and what the command makes of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from nvcore.api.inputs import keywords_named, load_part
from nvcore.arguments import PathLike, called_with
from nvcore.detectors.arguments import TrainArguments
from nvcore.extras import needs
from nvcore.inputs.pipes import pipes_kept
from nvcore.output.files import check_file
from nvcore.progress import Progress, no_progress
from nvcore.report.protect_inputs import files_read, refuse_to_replace
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.detectors.icf import IcfSettings
    from nvcore.detectors.training.run import Training
    from nvcore.detectors.training.shots import TrainingData


@called_with(TrainArguments)
@pipes_kept()
def train(arguments: TrainArguments) -> Training:
    """Train a detector (Integral Channel Features). `detect` then takes its file.

    The same data, settings and seed give the same file.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`: its truth and pictures are learned.
        None: folders alone.
    settings
        Changes of the preset, by name; several values of one as a sequence.
    hold_out, split, share, gap
        What is not learned but calibrates the rejection: recordings by name; or this share of the
        physical objects (tracks), of the recordings, or of the end of each recording, after a gap
        of so many frames; ``auto``: the first that is possible.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`:
        nothing is then written.

    Returns
    -------
    Training
        ``.model``, and how many objects were learned, held out, kept and found. ``print`` shows
        what the command prints.

    Raises
    ------
    InputError
        If an input cannot be used, would be replaced, or there is nothing to learn.
    MissingFactError
        As `load`.
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
    """Training that is known to be possible, with its data gathered and its pictures open.

    Attributes
    ----------
    arguments
        Of the call.
    training_data
        Pictures and boxes.
    settings, label
        Of the model, and what it detects.
    """

    arguments: TrainArguments
    training_data: TrainingData
    settings: IcfSettings
    label: str

    def run(self, progress: Progress) -> Training:
        """Train the model and write it. Errors are those of `train`."""
        from nvcore.detectors.icf import write_model
        from nvcore.detectors.training.run import train_on

        out = Path(self.arguments.out)
        training = train_on(
            self.training_data,
            self.settings,
            name=self.arguments.name or one_line(out.stem),
            label=self.label,
            seed=self.arguments.seed,
            progress=progress,
        )
        write_model(training.model, out)
        return training


@contextmanager
def training_job(
    arguments: TrainArguments, *, inputs: Sequence[Path] = (), loading: Progress = no_progress
) -> Iterator[TrainingJob]:
    """Gather all that a training needs, and refuse what cannot be done before anything is trained.

    Parameters are as of `nvcore.detectors.face.detector_job`, errors as of `train`.
    """
    with needs("detectors", "training a detector needs"):
        from nvcore.detectors.training.presets import objects_of, preset_for, preset_settings
        from nvcore.detectors.training.run import gather
        from nvcore.pictures import session_pictures

    preset, settings = arguments.preset, arguments.settings or {}
    preset_settings(preset or preset_for(None), settings)  # what is wrong is said before loading
    dataset = session = pictures = None
    if arguments.source is not None:
        # of the frames that the session evaluates, those of the arguments are learned
        dataset, session = load_part(
            arguments.source, replace(arguments, frames=None), progress=loading
        )
    read = (arguments.source, arguments.crops, arguments.background)
    files = [*inputs, *(Path(path) for path in read if isinstance(path, PathLike))]
    check_file(Path(arguments.out), "model.npz")
    files += files_read(session) if session is not None else ()
    refuse_to_replace([Path(arguments.out)], files)
    preset = preset or preset_for(None if dataset is None else dataset.objects)
    resolved = preset_settings(preset, settings)
    objects = objects_of(preset) if dataset is None else dataset.objects
    try:
        if dataset is not None and session is not None:
            pictures = session_pictures(session, dataset)
        gathered = gather(dataset, pictures, resolved, arguments)
        yield TrainingJob(arguments, gathered, resolved, objects.singular)
    finally:
        if pictures is not None:
            pictures.close()
