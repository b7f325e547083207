"""Training: windows of objects and background, rounds of boosting, hard background between them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import TrainedOn
from nvcore.detectors.base import DetectorError
from nvcore.detectors.classifier import Classifier, train_classifier
from nvcore.detectors.icf.boosting import BoostingRound, boost
from nvcore.detectors.icf.cascade import Calibration, calibrate, lower
from nvcore.detectors.icf.channels import check_picture, has_colour, plane_names
from nvcore.detectors.icf.features import draw_features
from nvcore.detectors.icf.mining import MiningTask, mine
from nvcore.detectors.icf.model import IcfModel
from nvcore.detectors.icf.pyramid import scaling_powers
from nvcore.detectors.icf.regions import Band, learn_band
from nvcore.detectors.icf.settings import IcfSettings
from nvcore.detectors.icf.windows import (
    LazyScenes,
    Scene,
    object_values,
    random_background,
)
from nvcore.progress import Progress, no_progress, part_of

HELD_OUT_SHARE: Final = 0.1
"""Share of the objects' pictures on which rejection is calibrated, where none are given."""
_FOR_POWERS: Final = 20
_READING: Final = 0.03
_CUTTING: Final = 0.07
_WINDOWS: Final = 0.12
"""Shares of a training's time, about: pictures are read, objects cut out, background drawn."""
_MINING: Final = 0.35
"""Share of a round's time that mining takes, about."""


def train(
    scenes: Sequence[Scene],
    settings: IcfSettings,
    *,
    name: str,
    label: str,
    seed: int = 0,
    held_out: Sequence[Scene] | None = None,
    trained_on: Sequence[TrainedOn] = (),
    progress: Progress = no_progress,
) -> IcfModel:
    """Train a model; the same scenes, settings and seed give the same model.

    Where the scenes to train on have labels of several classes, so does the model.

    Parameters
    ----------
    scenes
        Crops of objects, scenes with objects, scenes without; each is asked for several times, so
        that a sequence may read its pictures when it is asked.
    name, label
        Of the model, and what it detects.
    held_out
        Further objects, not trained on: `kept_share` of these, and of those trained on, come
        through the calibrated cascade. None: every tenth of the scenes with objects is held out.
    trained_on
        What to note of the data; empty: their fingerprint.
    progress
        May raise `concurrent.futures.CancelledError`.

    Raises
    ------
    DetectorError
        If there is no object to learn or to calibrate on, or no background.
    """
    scenes, held_out = _split(scenes, held_out)
    reading, cutting = part_of(progress, 0.0, _READING), part_of(progress, _READING, _CUTTING)
    survey = _survey(scenes, held_out, reading)
    is_colour = survey.is_colour
    features = draw_features(settings, len(plane_names(settings, is_colour)), seed)
    task = MiningTask(scenes, survey.backgrounds, settings, features, is_colour, seed)
    objects = object_values(_with_objects(scenes, cutting), settings, features, is_colour, seed)
    unseen = object_values(_with_objects(held_out), settings, features, is_colour, seed + 1)
    background = _first_background(task, part_of(progress, _CUTTING, _WINDOWS))
    if not len(objects) or not len(background):
        missing = "object" if not len(objects) else "background"
        raise DetectorError(f"a training needs windows of both kinds; there is no {missing}")
    if not len(unseen):
        raise DetectorError(
            f"no object is left to calibrate the rejection on: there are {len(objects):,} windows "
            "of objects to learn from, and none held out; at least one is needed"
        )
    rounds, background = _rounds(task, objects, background, part_of(progress, _WINDOWS, 0.98))
    progress(0.98, "calibrating")
    return replace(
        task.model(rounds[-1], _calibration(rounds[-1], objects, unseen, settings)),
        name=name,
        label=label,
        settings=settings,
        powers=scaling_powers(_some_pictures(task), settings, is_colour),
        error=np.concatenate([boosting.error for boosting in rounds]),
        round_ends=np.cumsum([len(boosting.error) for boosting in rounds], dtype=np.int32),
        n_objects=len(objects),
        n_background=len(background),
        band=survey.band,
        trained_on=tuple(trained_on) or (TrainedOn(survey.fingerprint),),
        classifier=_classifier(scenes, seed) if survey.n_classes > 1 else None,
    )


def _calibration(
    boosting: BoostingRound,
    objects: NDArray[np.int32],
    unseen: NDArray[np.int32],
    settings: IcfSettings,
) -> Calibration:
    """What lets pass this share of the objects trained on, and of those held out by themselves.

    Boosting drives those trained on apart from the background: alone, they reject too early.
    """
    of_objects, of_unseen = (
        calibrate(boosting.trees.running_sums(values), settings.kept_share, settings.slack)
        for values in (objects, unseen)
    )
    return lower(of_objects, of_unseen)


def _classifier(scenes: Sequence[Scene], seed: int) -> Classifier | None:
    """What tells the classes apart, where the objects are of several."""
    labelled = (scene for scene in _with_objects(scenes) if scene.labels)
    examples = ((scene.picture, scene.boxes, scene.labels) for scene in labelled)
    return train_classifier(examples, seed=seed)


@dataclass(frozen=True)
class _Survey:
    """What is learned of the pictures by reading them once.

    Attributes
    ----------
    is_colour
        Whether all are in colour, and any is not grey.
    fingerprint
        sha256 over pictures and boxes.
    band
        Where the boxes lie.
    backgrounds
        Places of the scenes with background.
    n_classes
        Of the objects to train on.
    """

    is_colour: bool
    fingerprint: str
    band: Band
    backgrounds: list[int]
    n_classes: int


def _split(
    scenes: Sequence[Scene], held_out: Sequence[Scene] | None
) -> tuple[Sequence[Scene], Sequence[Scene]]:
    """Scenes to train on, and those to calibrate on."""
    if held_out is not None:
        return scenes, held_out
    holding = [i for i in range(len(scenes)) if len(scenes[i].boxes)]
    out = set(holding[:: round(1 / HELD_OUT_SHARE)]) if len(holding) > 1 else set()
    return (
        LazyScenes(scenes.__getitem__, [i for i in range(len(scenes)) if i not in out]),
        LazyScenes(scenes.__getitem__, sorted(out)),
    )


def _with_objects(scenes: Sequence[Scene], progress: Progress = no_progress) -> Iterator[Scene]:
    for i in range(len(scenes)):
        progress(i / len(scenes), "cutting out objects")
        scene = scenes[i]
        if len(scene.boxes):
            yield scene


def _survey(scenes: Sequence[Scene], held_out: Sequence[Scene], progress: Progress) -> _Survey:
    """Read everything once."""
    digest = hashlib.sha256()
    is_colour, any_colour = True, False
    classes: set[str] = set()
    rows, heights, backgrounds = [np.empty(0)], [np.empty(0)], []
    for part in (scenes, held_out):
        for i in range(len(part)):
            progress(i / len(part) if part is scenes else 1.0, "reading pictures")
            scene = part[i]
            picture = scene.picture
            is_colour &= picture.ndim == 3
            any_colour = any_colour or has_colour(picture)
            digest.update(f"{picture.shape} {picture.dtype} {scene.has_background}".encode())
            for array in (picture, scene.boxes, scene.ignored):
                digest.update(np.ascontiguousarray(array).tobytes())
            if any(scene.labels):
                digest.update(repr(scene.labels).encode())
                classes.update(scene.labels if part is scenes else ())
            if scene.has_background and part is scenes:
                backgrounds.append(i)
                rows.append((scene.boxes[:, 1] + scene.boxes[:, 3] / 2) / picture.shape[0])
                heights.append(scene.boxes[:, 3] / picture.shape[0])
    band = learn_band(np.concatenate(rows), np.concatenate(heights))
    is_colour &= any_colour
    return _Survey(is_colour, digest.hexdigest(), band, backgrounds, len(classes - {""}))


def _first_background(task: MiningTask, progress: Progress) -> NDArray[np.int32]:
    """Windows of background drawn at random, about as many from each scene."""
    n_scenes = len(task.backgrounds)
    each = -(-task.settings.negatives // max(n_scenes, 1))
    values = [np.empty((0, len(task.features)), np.int32)]
    for n, i in enumerate(task.backgrounds):
        progress(n / n_scenes, "background")
        rng = np.random.default_rng([task.seed, i])
        scene = task.scenes[i]
        windows = random_background(scene, task.settings, task.features, task.is_colour, each, rng)
        values.append(windows)
    return np.concatenate(values)


def _rounds(
    task: MiningTask, objects: NDArray[np.int32], background: NDArray[np.int32], progress: Progress
) -> tuple[list[BoostingRound], NDArray[np.int32]]:
    """What each round gave, and the background of the last.

    Without hard background all rounds learn from the same windows, and only the last one counts.
    """
    settings = task.settings
    numbers = settings.trees_per_round if settings.negatives_per_round else ()
    rounds: list[BoostingRound] = []
    ends = np.cumsum(np.array([0, *settings.trees_per_round]) + 200)
    shares = (ends - ends[0]) / (ends[-1] - ends[0])
    for i, n_trees in enumerate(numbers or settings.trees_per_round[-1:]):
        of_round = part_of(progress, float(shares[i]), float(shares[i + 1]))
        start = 0.0
        if rounds:
            start = _MINING
            hard = mine(task, rounds[-1], objects, part_of(of_round, 0.0, start))
            background = np.concatenate([background, hard])
        boosting = boost(
            np.concatenate([objects, background]),
            np.arange(len(objects) + len(background)) < len(objects),
            n_trees=n_trees,
            feature_share=settings.feature_share,
            patience=settings.patience,
            seed=task.seed + i,
            progress=part_of(of_round, start, 1.0),
        )
        if not len(boosting.trees):
            raise DetectorError("no feature tells the objects from the background: check the boxes")
        rounds.append(boosting)
    return rounds, background


def _some_pictures(task: MiningTask) -> Iterator[NDArray[np.uint8]]:
    """At most 20 scenes with background, evenly spread."""
    for i in task.backgrounds[:: max(1, -(-len(task.backgrounds) // _FOR_POWERS))]:
        yield check_picture(task.scenes[i].picture, task.is_colour)
