"""Training: rounds of boosting over object and background windows, with hard negative mining."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.progress import Progress, no_progress, part_of
from nvcore.dataset.provenance import TrainedOn
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.classifier import train_classifier
from nvcore.subjects.detectors.icf.boosting import BoostingRound, boost
from nvcore.subjects.detectors.icf.cascade import Calibration, calibrate, lower
from nvcore.subjects.detectors.icf.channels import (
    check_picture,
    has_colour,
    plane_names,
    scaling_powers,
)
from nvcore.subjects.detectors.icf.detector import IcfDetector, ScoreMap
from nvcore.subjects.detectors.icf.features import Features, draw_features, values_at
from nvcore.subjects.detectors.icf.model import IcfModel
from nvcore.subjects.detectors.icf.regions import Band, learn_band
from nvcore.subjects.detectors.icf.settings import MAX_STRIDE, IcfSettings
from nvcore.subjects.detectors.icf.windows import (
    LazyScenes,
    Scene,
    is_background,
    object_values,
    random_background,
)
from nvcore.subjects.detectors.suppression import staying_boxes

HELD_OUT_SHARE: Final = 0.1
"""Default share of pictures with objects that are held out to calibrate the rejection."""
_FOR_POWERS: Final = 20
_READING: Final = 0.03
_CUTTING: Final = 0.07
_WINDOWS: Final = 0.12
"""Approximate shares of the training time after reading, cutting objects and drawing background."""
_MINING: Final = 0.35
"""Approximate share of a round's time that mining takes."""
_PASSING: Final = 0.98
"""Share of the training objects that pass a round's own trace while it is used for mining."""
_SURPLUS: Final = 1.5
"""Number of windows to find per window needed."""
_STEP: Final = 2
_DIVERSE: Final = 0.6
"""IoU from which two windows count as the same background."""


@dataclass(frozen=True, eq=False)
class _Task:
    """Values that all steps of one training share. `backgrounds` are the scenes with background."""

    scenes: Sequence[Scene]
    backgrounds: Sequence[int]
    settings: IcfSettings
    features: Features
    is_colour: bool
    seed: int

    def model(self, boosting: BoostingRound, calibration: Calibration) -> IcfModel:
        """Return a model of these trees and their features for mining hard background."""
        used, index = np.unique(boosting.trees.feature, return_inverse=True)
        feature = index.reshape(boosting.trees.feature.shape).astype(np.int32)
        return IcfModel(
            name="in training",
            label="object",
            settings=replace(
                self.settings,
                cascade="calibrated",
                stride=min(_STEP * self.settings.stride, MAX_STRIDE),
                scales_between=0,
                region=(),
                use_band=False,
                proposals="none",
            ),
            is_colour=self.is_colour,
            features=self.features[used],
            trees=replace(boosting.trees, feature=feature),
            calibration=calibration,
            powers=np.zeros(len(plane_names(self.settings, self.is_colour))),
            error=boosting.error,
            round_ends=np.array([len(boosting.error)], np.int32),
            n_objects=0,
            n_background=0,
            seed=self.seed,
        )


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
    """Train a model. Equal scenes, settings and seeds give equal models.

    If the training scenes have labels of several classes, the model gets a classifier.

    Parameters
    ----------
    scenes
        Crops of objects, scenes with objects, scenes without. Each one is requested several times,
        so a lazy sequence may read its pictures on request.
    name, label
        Name of the model, and kind of object that it detects.
    held_out
        Further objects that are not trained on. The share `kept_share` of these, and of the objects
        trained on, passes the calibrated cascade. None: hold out every tenth scene with objects.
    trained_on
        Description of the data to record. Empty: their fingerprint.
    progress
        May raise `concurrent.futures.CancelledError`.

    Raises
    ------
    DetectorError
        If there is no object to learn or to calibrate on, or no background.
    """
    scenes, held_out = _split(scenes, held_out)
    reading, cutting = part_of(progress, 0.0, _READING), part_of(progress, _READING, _CUTTING)
    is_colour, fingerprint, band, backgrounds, n_classes = _survey(scenes, held_out, reading)
    features = draw_features(settings, len(plane_names(settings, is_colour)), seed)
    task = _Task(scenes, backgrounds, settings, features, is_colour, seed)
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
    # boosting separates training objects from background so well that they alone reject too early
    calibrations = (
        calibrate(rounds[-1].trees.running_sums(values), settings.kept_share, settings.slack)
        for values in (objects, unseen)
    )
    some = backgrounds[:: max(1, -(-len(backgrounds) // _FOR_POWERS))]
    pictures = (check_picture(scenes[i].picture, is_colour) for i in some)
    labelled = (scene for scene in _with_objects(scenes) if scene.labels)
    examples = ((scene.picture, scene.boxes, scene.labels) for scene in labelled)
    return replace(
        task.model(rounds[-1], lower(*calibrations)),
        name=name,
        label=label,
        settings=settings,
        powers=scaling_powers(pictures, settings, is_colour),
        error=np.concatenate([boosting.error for boosting in rounds]),
        round_ends=np.cumsum([len(boosting.error) for boosting in rounds], dtype=np.int32),
        n_objects=len(objects),
        n_background=len(background),
        band=band,
        trained_on=tuple(trained_on) or (TrainedOn(fingerprint),),
        classifier=train_classifier(examples, seed=seed) if n_classes > 1 else None,
    )


def _split(
    scenes: Sequence[Scene], held_out: Sequence[Scene] | None
) -> tuple[Sequence[Scene], Sequence[Scene]]:
    """Return the scenes to train on and the scenes to calibrate on."""
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


def _survey(
    scenes: Sequence[Scene], held_out: Sequence[Scene], progress: Progress
) -> tuple[bool, str, Band, list[int], int]:
    """Read all scenes once.

    Returns
    -------
    Whether all pictures are in colour and any is not grey; sha256 over pictures and boxes; band of
    the boxes; indices of the scenes with background; number of classes to train on.
    """
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
    return is_colour, digest.hexdigest(), band, backgrounds, len(classes - {""})


def _first_background(task: _Task, progress: Progress) -> NDArray[np.int32]:
    """Draw background windows at random, about equally many from each scene."""
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
    task: _Task, objects: NDArray[np.int32], background: NDArray[np.int32], progress: Progress
) -> tuple[list[BoostingRound], NDArray[np.int32]]:
    """Run all rounds of boosting and return their results and the background of the last one.

    Without hard background all rounds would use the same windows, so only the last one runs.
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
            hard = _mine(task, rounds[-1], objects, part_of(of_round, 0.0, start))
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


def _mine(
    task: _Task, boosting: BoostingRound, objects: NDArray[np.int32], progress: Progress
) -> NDArray[np.int32]:
    """Find hard background: the windows that the trees most confidently take for objects.

    Scenes are visited in random order until half as many more windows as wanted are found. A first
    round has few trees and is wrong about many windows, so this is soon the case. Only every other
    row and column of windows is evaluated, because neighbouring windows get similar confidences.

    Parameters
    ----------
    objects
        Feature values of the training objects. Windows that reach less than nearly all of them
        are skipped.

    Returns
    -------
    Feature values, int32, (n, n_features), with n at most `negatives_per_round`.
    """
    calibration = calibrate(boosting.trees.running_sums(objects), _PASSING)
    detector = IcfDetector(task.model(boosting, calibration))
    most = task.settings.negatives_per_round
    rng = np.random.default_rng([task.seed, len(boosting.trees)])
    order = rng.permutation(np.array(task.backgrounds, np.int64))
    each = max(10, most // 40, -(-2 * most // max(len(order), 1)))
    found = [(np.empty(0), np.empty((0, len(task.features)), np.int32))]
    n_windows = 0
    for n, i in enumerate(order):
        progress(max(n / len(order), n_windows / (_SURPLUS * most)), "looking for hard background")
        found.append(_hardest(detector, task.scenes[int(i)], task, each))
        n_windows += len(found[-1][0])
        if n_windows >= _SURPLUS * most:
            break
    score, values = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return values[np.argsort(-score, kind="stable")[:most]]


def _hardest(
    detector: IcfDetector, scene: Scene, task: _Task, most: int
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Return scores and values of the most confident background windows in different places."""
    nothing = np.empty((4, 0)), np.empty(0), np.empty((0, len(task.features)), np.int32)
    parts = {0.0: nothing}
    settings = detector.model.settings

    def look(score_map: ScoreMap, sums: NDArray[np.int32]) -> None:
        level = score_map.level
        row, column = np.nonzero(~np.isnan(score_map.score))
        boxes = level.boxes(row, column, settings)
        score = score_map.score[row, column]
        index = np.flatnonzero(is_background(boxes, scene))
        index = index[_differing(boxes[:, index], score[index], most)]
        base = (row[index] * (level.width + 1) + column[index]) * settings.stride
        values = values_at(sums, base, task.features)
        parts[level.scale] = boxes[:, index], score[index], values

    detector.score_maps(scene.picture, look)
    boxes, scores, values = zip(*(parts[scale] for scale in sorted(parts)), strict=True)
    score = np.concatenate(scores)
    index = _differing(np.concatenate(boxes, axis=1), score, most)
    return score[index], np.concatenate(values)[index]


def _differing(
    boxes: NDArray[np.float64], score: NDArray[np.float64], most: int
) -> NDArray[np.int64]:
    """Return the indices of the most confident boxes in different places."""
    order = np.argsort(-score, kind="stable")[: 50 * most]
    return order[staying_boxes(boxes[:, order], _DIVERSE)][:most]
