"""ICF detector: runs a trained model over pictures."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from queue import Empty, SimpleQueue
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About
from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import Detections, threads_for_a_picture
from nvcore.subjects.detectors.icf.cascade import floors
from nvcore.subjects.detectors.icf.channels import (
    Bytes,
    PyramidLevel,
    channel_sets,
    check_picture,
    integral_images,
    levels,
    planes_of,
)
from nvcore.subjects.detectors.icf.features import corner_offsets, has_differences
from nvcore.subjects.detectors.icf.kernels import scan
from nvcore.subjects.detectors.icf.model import IcfModel, fingerprint
from nvcore.subjects.detectors.icf.regions import open_windows, red_sums
from nvcore.subjects.detectors.suppression import suppress

KIND: Final = "icf"


@dataclass(frozen=True, eq=False)
class ScoreMap:
    """Results for all windows of a picture at one scale.

    Attributes
    ----------
    level
        Picture at that scale.
    score
        Confidence of each window, NaN if it was rejected or skipped; float64, (rows, columns). The
        window in row r and column c starts at pixel (c, r) * stride.
    depth
        Number of trees that each window passed, 0 if skipped; int32, (rows, columns).
    """

    level: PyramidLevel
    score: NDArray[np.float64]
    depth: NDArray[np.int32]

    @property
    def n_windows(self) -> int:
        """Number of windows that were evaluated."""
        return int(np.count_nonzero(self.depth))

    @property
    def n_features(self) -> int:
        """Number of features that were evaluated, two for each tree of each window."""
        return 2 * int(self.depth.sum(dtype=np.int64))


Look = Callable[[ScoreMap, NDArray[np.int32]], None]


class IcfDetector:
    """Trained model that is ready to run. It is safe to use from any thread.

    Attributes
    ----------
    model
        Model with the settings of this run.
    about
        Description of the detector for records and displays.
    """

    def __init__(self, model: IcfModel) -> None:
        self.model = model
        # settings may name colours even if the model is grey
        channels = channel_sets(model.settings, model.is_colour)
        self.about = About(
            kind=KIND,
            name=model.name,
            labels=model.labels,
            settings=model.settings.in_words() | {"channels": " ".join(channels)},
            fingerprint=fingerprint(model),
            trained_on=tuple(model.trained_on),
        )
        self._buffers: SimpleQueue[NDArray[np.int32]] = SimpleQueue()

    def run_with(self, **changes: Any) -> IcfDetector:
        """Return the same detector with other settings. Errors as for `IcfModel.run_with`."""
        return IcfDetector(self.model.run_with(**changes))

    def detect(self, picture: Picture) -> Detections:
        """Return the boxes in one picture, at or above the threshold, after suppression.

        Suppression ignores classes. If the model has a classifier, it then labels each remaining
        box.

        Parameters
        ----------
        picture
            Grey (h, w) or RGB (h, w, 3), uint8 or uint16.

        Raises
        ------
        DetectorError
            If the array is not such a picture, is grey but the model needs colour, or is too large.
        """
        settings = self.model.settings
        boxes = self.candidates(self.score_maps(picture))
        boxes = suppress(boxes, settings.overlap, settings.overlap_of)
        return self.classified(picture, boxes)

    def classified(self, picture: Picture, boxes: Detections) -> Detections:
        """Label the boxes with their classes if the model has a classifier."""
        classifier = self.model.classifier
        if classifier is None:
            return boxes
        return replace(boxes, label=classifier.labels(picture, boxes))

    def score_maps(self, picture: Picture, look: Look | None = None) -> list[ScoreMap]:
        """Return the confidence of every window, one map per scale. Errors as for `detect`.

        Parameters
        ----------
        look
            Called with each map and its integral images, from several threads. The integral images
            are overwritten afterwards.
        """
        picture = check_picture(picture, self.model.is_colour)
        groups = levels(picture.shape[1], picture.shape[0], self.model.settings)
        red = red_sums(picture, self.model.settings)
        with ThreadPoolExecutor(threads_for_a_picture()) as pool:
            maps = pool.map(lambda group: list(self._maps(picture, group, red, look)), groups)
            return [score_map for of_group in maps for score_map in of_group]

    def candidates(self, maps: Sequence[ScoreMap]) -> Detections:
        """Return the boxes of all windows at or above the threshold, before suppression."""
        settings = self.model.settings
        boxes, scores = [np.empty((4, 0))], [np.empty(0)]
        for score_map in maps:
            row, column = np.nonzero(score_map.score >= settings.threshold)
            boxes.append(score_map.level.boxes(row, column, settings))
            scores.append(score_map.score[row, column])
        (x, y, w, h), score = np.concatenate(boxes, axis=1), np.concatenate(scores)
        order = np.argsort(-score, kind="stable")
        return Detections(x[order], y[order], w[order], h[order], score[order])

    def _maps(
        self,
        picture: Bytes,
        group: tuple[PyramidLevel, ...],
        red: NDArray[np.int32] | None,
        look: Look | None,
    ) -> Iterator[ScoreMap]:
        model, settings = self.model, self.model.settings
        lowest, restarts = floors(settings, model.calibration)
        for level, planes in planes_of(picture, group, settings, model.powers):
            buffer = self._buffer(len(planes) * (level.width + 1) * (level.height + 1))
            sums = integral_images(planes, buffer)
            size = picture.shape[1], picture.shape[0]
            is_open = open_windows(level, size, settings, model.band, red)
            score, depth = np.empty(is_open.shape), np.empty(is_open.shape, np.int32)
            corners = corner_offsets(model.features, level.width, level.height)
            scan(
                0, len(is_open), sums.reshape(-1), level.width + 1, settings.stride,
                corners[model.trees.feature.reshape(-1)], model.trees.threshold.reshape(-1),
                has_differences(model.features), model.trees.leaves, lowest, restarts,
                is_open, score, depth,
            )  # fmt: skip
            score_map = ScoreMap(level, score, depth)
            if look is not None:
                look(score_map, sums)
            self._buffers.put(buffer)
            yield score_map

    def _buffer(self, size: int) -> NDArray[np.int32]:
        """Return reusable memory for integral images. Allocation costs more than the sums."""
        with contextlib.suppress(Empty):
            if len(buffer := self._buffers.get_nowait()) >= size:
                return buffer
        return np.empty(size, np.int32)
