"""All that one training learns from: a session, folders, or both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn
from nvcore.detectors.arguments import TrainArguments
from nvcore.detectors.icf import IcfSettings
from nvcore.detectors.training.folders import folder_shots
from nvcore.detectors.training.recordings import session_shots
from nvcore.detectors.training.shots import Shot
from nvcore.errors import InputError
from nvcore.pictures import RecordingPictures
from nvcore.wording import count_text, one_line


@dataclass(frozen=True, eq=False)
class TrainingData:
    """What a training learns from.

    Attributes
    ----------
    shots
        Pictures of recordings, crops, background.
    trained_on
        What to note of them.
    every
        Of so many evaluated frames of the recordings one is taken.
    held_out
        What is held out, in words.
    notes
        Recordings and frames that have no picture, and how many boxes are left out.
    """

    shots: Sequence[Shot]
    trained_on: tuple[TrainedOn, ...]
    every: int
    held_out: str
    notes: tuple[str, ...] = ()


def gather(
    dataset: Dataset | None,
    pictures: RecordingPictures | None,
    settings: IcfSettings,
    arguments: TrainArguments,
) -> TrainingData:
    """Everything that a training learns from; no picture of a recording is read.

    Parameters
    ----------
    dataset, pictures
        Of a session; None: there are folders alone.

    Raises
    ------
    InputError
        If there is nothing to learn from.
    ParameterError
        If the split is not possible.
    """
    crops, background = (
        None if folder is None else Path(folder)
        for folder in (arguments.crops, arguments.background)
    )
    from_folders = folder_shots(
        crops,
        background,
        settings,
        crop_share=arguments.crop_share,
        share=arguments.share,
        seed=arguments.seed,
    )
    if dataset is None or pictures is None:
        if not from_folders.shots:
            raise InputError("there is nothing to learn from; name a session, or folders")
        _check_held_out(from_folders.shots, from_folders.split)
        return TrainingData(from_folders.shots, from_folders.trained_on, 1, from_folders.split)
    of_session = session_shots(dataset, pictures, settings, arguments)
    shots = [*of_session.shots, *from_folders.shots]
    held_out = "; ".join(text for text in (of_session.split, from_folders.split) if text)
    _check_held_out(shots, held_out)
    return TrainingData(
        shots=shots,
        trained_on=of_session.trained_on + from_folders.trained_on,
        every=of_session.every,
        held_out=held_out,
        notes=of_session.notes,
    )


def _check_held_out(shots: Sequence[Shot], held_out: str) -> None:
    """Refuse a training of which all objects would be on one side."""
    n_learned, n_out = (
        sum(len(boxes) for boxes in side)
        for side in zip(*((shot.learned, shot.held_out) for shot in shots), strict=True)
    )
    if n_learned + n_out and not (n_learned and n_out):
        every = "all are" if n_out else "none is"
        raise InputError(
            f"of {count_text(n_learned + n_out, 'box', 'boxes')} {every} held out "
            f"({one_line(held_out)}); a training needs some to learn, and at least one, of another "
            "physical object, to calibrate the rejection on: choose more recordings or frames, or "
            "another split or share"
        )
