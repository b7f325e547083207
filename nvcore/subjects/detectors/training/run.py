"""Train a detector: choose settings, gather pictures, train, and check the held-out objects."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np

from nvcore.common.errors import InputError, ParameterError
from nvcore.common.memory import free_bytes
from nvcore.common.output.model_files import LONGEST_NAME, check_name
from nvcore.common.progress import Progress, no_progress, part_of, with_time_left
from nvcore.common.wording import count_text, did_you_mean, duration_text, listed, one_line
from nvcore.dataset import Dataset
from nvcore.pictures import RecordingPictures
from nvcore.settings.objects import SPEED_SIGN, Objects
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.calls.arguments import Preset, TrainArguments
from nvcore.subjects.detectors.classifier import MAX_CLASSES
from nvcore.subjects.detectors.icf import (
    AS_IN_REPORT,
    PEDESTRIANS,
    SIGNS,
    IcfModel,
    IcfSettings,
    train,
)
from nvcore.subjects.detectors.icf.cascade import passes
from nvcore.subjects.detectors.icf.windows import object_values
from nvcore.subjects.detectors.settings import check_names, typed_like
from nvcore.subjects.detectors.training.folders import folder_shots
from nvcore.subjects.detectors.training.recordings import session_shots
from nvcore.subjects.detectors.training.shots import PictureStore, Shot, TrainingData

_READING: Final = 0.05
"""Approximate share of the time for reading pictures."""
_BYTES_OF_VALUE: Final = 13
"""Peak memory per feature value, bytes: joined from parts, binned, in the search of splits."""


PRESETS: Final[Mapping[str, IcfSettings]] = {
    "pedestrians": PEDESTRIANS,
    "signs": SIGNS,
    "as-in-report": AS_IN_REPORT,
}
"""Settings by preset name (`nvcore.subjects.detectors.calls.arguments.Preset`)."""


def preset_for(objects: Objects | None) -> Preset:
    """Return the default preset for a session's objects. None: no session."""
    return "signs" if objects == SPEED_SIGN else "pedestrians"


def preset_settings(preset: str, given: Mapping[str, Any]) -> IcfSettings:
    """Return the settings of a preset with some of them changed.

    Parameters
    ----------
    given
        Changed values by name; see `typed_like`.

    Raises
    ------
    DetectorError
        If there is no such preset or setting, or a text cannot be parsed as the setting's type.
    ParameterError
        If a value is not possible.
    """
    if preset not in PRESETS:
        known = f"they are {listed([*PRESETS])}"
        raise DetectorError(
            f"there is no preset {preset!r}; {did_you_mean(preset, PRESETS, known)}"
        )
    check_names(given, [spec.name for spec in fields(IcfSettings)])
    start = PRESETS[preset]
    patience = given.get("patience")
    if isinstance(patience, str):
        try:
            given = {**given, "patience": None if patience == "none" else int(patience)}
        except ValueError as error:
            raise DetectorError(
                f"patience: expected a whole number or none, found {patience!r}"
            ) from error
    return replace(start, **typed_like(start, given))


def gather(
    dataset: Dataset | None,
    pictures: RecordingPictures | None,
    settings: IcfSettings,
    arguments: TrainArguments,
) -> TrainingData:
    """Gather pictures and boxes of a training without reading pictures of recordings.

    Parameters
    ----------
    dataset, pictures
        Those of a session. None: use folders only.

    Raises
    ------
    InputError
        If there is nothing to learn from, or all objects would be on one side of the split.
    ParameterError
        If the split is not possible.
    """
    gathered = folder_shots(settings, arguments)
    if dataset is not None and pictures is not None:
        of_session = session_shots(dataset, pictures, settings, arguments)
        gathered = replace(
            of_session,
            shots=[*of_session.shots, *gathered.shots],
            trained_on=of_session.trained_on + gathered.trained_on,
            held_out="; ".join(filter(None, (of_session.held_out, gathered.held_out))),
        )
    elif not gathered.shots:
        raise InputError("there is nothing to learn from; name a session, or folders")
    n_learned = sum(len(shot.learned) for shot in gathered.shots)
    n_out = sum(len(shot.held_out) for shot in gathered.shots)
    if n_learned + n_out and not (n_learned and n_out):
        every = "all are" if n_out else "none is"
        raise InputError(
            f"of {count_text(n_learned + n_out, 'box', 'boxes')} {every} held out "
            f"({one_line(gathered.held_out)}); a training needs some to learn, and at least one, "
            "of another physical object, to calibrate the rejection on: choose more recordings or "
            "frames, or another split or share"
        )
    return gathered


@dataclass(frozen=True, eq=False, repr=False)
class Training:
    """Trained model with statistics of its training. ``print`` shows them.

    Attributes
    ----------
    model
        Ready to be written.
    training_data
        Data of the training.
    n_pictures
        Number of pictures trained on.
    n_objects, n_held_out
        Numbers of boxes that were learned and held out.
    n_kept, n_found
        Numbers of held-out boxes whose own window passes the cascade, and of those that also reach
        the threshold. The share that passes a calibrated cascade is `kept_share` by construction.
        Reasons why pictures could not be read.
    seconds
        Duration of the training.
    """

    model: IcfModel
    training_data: TrainingData
    n_pictures: int
    n_objects: int
    n_held_out: int
    n_kept: int
    n_found: int
    faults: tuple[str, ...]
    seconds: float

    def __repr__(self) -> str:
        return f"<Training of {self.model!r}: {self._objects}>"

    def __str__(self) -> str:
        held_out, settings = one_line(self.training_data.held_out), self.model.settings
        cascade = f"lets {self.n_kept:,} through"
        # these cascades keep their share by construction
        if settings.cascade in ("calibrated", "hard"):
            share = f"{100 * settings.kept_share:g} %"
            cascade = f"was calibrated to let {share} of the held-out ones through"
        lines = [
            f"{one_line(self.model.name)}: {self._objects}",
            f"held out: {held_out} ({count_text(self.n_held_out, 'box', 'boxes')})",
            *self.model.windows_in_words(),
            f"{self.n_found:,} of {count_text(self.n_held_out, 'held-out box', 'held-out boxes')} "
            f"reach the threshold ({settings.threshold:g}) in a window of their own; the cascade "
            f"{cascade}",
            f"trained in {duration_text(self.seconds)}",
        ]
        if self.faults:
            n_faults = count_text(len(self.faults), "picture")
            lines.append(f"{n_faults} could not be read: {self.faults[0]}")
        lines += [f"not trained on {note}" for note in self.training_data.notes]
        return "\n".join(lines)

    @property
    def _objects(self) -> str:
        """Describe the numbers of learned boxes and of their pictures."""
        pictures = count_text(self.n_pictures, "picture")
        if self.training_data.every > 1:
            pictures += f", one in {self.training_data.every} of the evaluated frames"
        return f"{count_text(self.n_objects, 'box', 'boxes')} learned in {pictures}"


def train_on(
    training_data: TrainingData,
    settings: IcfSettings,
    *,
    name: str,
    label: str,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Training:
    """Train a model. The same pictures, boxes, settings and seed give the same model.

    Parameters
    ----------
    training_data
        Pictures and boxes.
    name, label
        Name of the model, and kind of object that it detects.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`.

    Raises
    ------
    InputError
        If no picture can be read, or there is no object or no background to learn from.
    ParameterError
        If the name is not valid for a model, or the classes of the boxes are not valid.
    """
    began = time.perf_counter()
    check_name("name", name)
    shots = training_data.shots
    _check_possible(shots, settings)
    progress = with_time_left(progress)
    store = PictureStore(shots, progress=part_of(progress, 0.0, _READING))
    faults = tuple(store.faults.values())
    if len(faults) == len(shots):
        raise InputError(f"no picture can be read: {faults[0]}")
    scenes, held_out = store.scenes()
    model = train(
        scenes,
        settings,
        name=name,
        label=label,
        seed=seed,
        held_out=held_out,
        trained_on=training_data.trained_on,
        progress=part_of(progress, _READING, 1.0),
    )
    plain = replace(model.settings, copies=0)  # no random copies
    values = object_values(iter(held_out), plain, model.features, model.is_colour, seed)
    sums = model.trees.running_sums(values)
    is_kept = passes(model.settings, model.calibration, sums).all(axis=1)
    progress(1.0, "done")
    read = [shot for i, shot in enumerate(shots) if i not in store.faults]
    return Training(
        model=model,
        training_data=training_data,
        n_pictures=len(scenes),
        n_objects=sum(len(shot.learned) for shot in read),
        n_held_out=len(sums),
        n_kept=int(np.count_nonzero(is_kept)),
        n_found=int(np.count_nonzero(is_kept & (sums[:, -1] >= model.settings.threshold))),
        faults=faults,
        seconds=time.perf_counter() - began,
    )


def _check_possible(shots: Sequence[Shot], settings: IcfSettings) -> None:
    """Reject impossible classes or too little memory before hours of training."""
    classes = {label for shot in shots for label in shot.labels if label}
    odd = [name for name in classes if len(name) > LONGEST_NAME or not name.isprintable()]
    if odd:
        raise ParameterError(
            f"class: expected at most {LONGEST_NAME} printable characters, got {min(odd)[:40]!r}"
        )
    if len(classes) > MAX_CLASSES:
        raise ParameterError(
            f"boxes are of {len(classes)} classes; a model tells {MAX_CLASSES} apart at most"
        )
    n_objects = sum(len(shot.learned) + len(shot.held_out) for shot in shots)
    n_rounds = len(settings.trees_per_round)
    n_windows = n_objects * (1 + settings.copies) + settings.negatives
    n_windows += (n_rounds - 1) * settings.negatives_per_round
    needed, free = n_windows * settings.features * _BYTES_OF_VALUE, free_bytes()
    if free is not None and needed > free:
        raise DetectorError(
            f"{n_windows:,} windows of {settings.features:,} features take about "
            f"{needed / 1e9:.1f} GB of memory; {max(free, 0) / 1e9:.1f} GB are free. Take fewer "
            "frames, fewer copies of objects, less background or fewer features"
        )
