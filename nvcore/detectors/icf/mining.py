"""Hard background: the windows that a round of training takes for objects, for the next round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.icf.boosting import BoostingRound
from nvcore.detectors.icf.cascade import Calibration, calibrate
from nvcore.detectors.icf.channels import plane_names
from nvcore.detectors.icf.detector import IcfDetector, ScoreMap
from nvcore.detectors.icf.features import Features, values_at
from nvcore.detectors.icf.model import IcfModel
from nvcore.detectors.icf.settings import MAX_STRIDE, IcfSettings
from nvcore.detectors.icf.windows import Scene, is_background
from nvcore.detectors.suppression import staying_boxes
from nvcore.progress import Progress

_PASSING: Final = 0.98
"""Share of the training's objects that a round's own trace lets pass while it is mined with."""
_SURPLUS: Final = 1.5
"""Windows that are found for each one that is wanted."""
_STEP: Final = 2
_DIVERSE: Final = 0.6
"""IoU from which two windows are one and the same background."""


@dataclass(frozen=True, eq=False)
class MiningTask:
    """What all steps of one training share; `backgrounds` are the scenes with background."""

    scenes: Sequence[Scene]
    backgrounds: Sequence[int]
    settings: IcfSettings
    features: Features
    is_colour: bool
    seed: int

    def model(self, boosting: BoostingRound, calibration: Calibration) -> IcfModel:
        """A model of these trees, without a name, to look for hard background."""
        boosting, used = _only_used(boosting)
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
            trees=boosting.trees,
            calibration=calibration,
            powers=np.zeros(len(plane_names(self.settings, self.is_colour))),
            error=boosting.error,
            round_ends=np.array([len(boosting.error)], np.int32),
            n_objects=0,
            n_background=0,
            seed=self.seed,
        )


def mine(
    task: MiningTask, boosting: BoostingRound, objects: NDArray[np.int32], progress: Progress
) -> NDArray[np.int32]:
    """Background that the trees take for objects: the most confident windows that are found.

    Scenes are visited in random order, until there are half as many more windows as are wanted:
    a first round, with its few trees, is wrong about many. Every other window is looked at, both
    ways: what is taken for an object is so in neighbouring windows, too.

    Parameters
    ----------
    objects
        Feature values of the training's objects; what few of them reach is not looked at.

    Returns
    -------
    Feature values, int32, (n, n_features); n is at most `negatives_per_round`.
    """
    calibration = calibrate(boosting.trees.running_sums(objects), _PASSING)
    detector = IcfDetector(task.model(boosting, calibration))
    most = task.settings.negatives_per_round
    rng = np.random.default_rng([task.seed, len(boosting.trees)])
    order = rng.permutation(np.array(task.backgrounds, np.int64))
    each = max(10, most // 40, -(-2 * most // max(len(order), 1)))
    windows = [_nothing(task)]
    n_windows = 0
    for n, i in enumerate(order):
        progress(max(n / len(order), n_windows / (_SURPLUS * most)), "looking for hard background")
        windows.append(_hardest(detector, task.scenes[int(i)], task, each))
        n_windows += len(windows[-1].score)
        if n_windows >= _SURPLUS * most:
            break
    hard = _joined(windows)
    return hard.values[np.argsort(-hard.score, kind="stable")[:most]]


@dataclass(frozen=True, eq=False)
class _Hard:
    """Windows of background: boxes (4, n), scores (n,), values (n, n_features)."""

    boxes: NDArray[np.float64]
    score: NDArray[np.float64]
    values: NDArray[np.int32]

    def at(self, index: NDArray[np.int64]) -> _Hard:
        return _Hard(self.boxes[:, index], self.score[index], self.values[index])


def _nothing(task: MiningTask) -> _Hard:
    return _Hard(np.empty((4, 0)), np.empty(0), np.empty((0, len(task.features)), np.int32))


def _joined(parts: Sequence[_Hard]) -> _Hard:
    return _Hard(
        np.concatenate([part.boxes for part in parts], axis=1),
        np.concatenate([part.score for part in parts]),
        np.concatenate([part.values for part in parts]),
    )


def _differing(
    boxes: NDArray[np.float64], score: NDArray[np.float64], most: int
) -> NDArray[np.int64]:
    """Indices of the most confident boxes that differ in place."""
    order = np.argsort(-score, kind="stable")[: 50 * most]
    return order[staying_boxes(boxes[:, order], _DIVERSE)][:most]


def _hardest(detector: IcfDetector, scene: Scene, task: MiningTask, most: int) -> _Hard:
    """The most confident windows of a scene's background that differ in place."""
    parts: dict[float, _Hard] = {}
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
        parts[level.scale] = _Hard(boxes[:, index], score[index], values)

    detector.score_maps(scene.picture, look)
    whole = _joined([_nothing(task), *(parts[scale] for scale in sorted(parts))])
    return whole.at(_differing(whole.boxes, whole.score, most))


def _only_used(boosting: BoostingRound) -> tuple[BoostingRound, NDArray[np.int64]]:
    """The trees with their features renumbered, and which of the pool these are."""
    used, index = np.unique(boosting.trees.feature, return_inverse=True)
    feature = index.reshape(boosting.trees.feature.shape).astype(np.int32)
    return replace(boosting, trees=replace(boosting.trees, feature=feature)), used.astype(np.int64)
