"""OpenCV's people detectors: histograms of oriented gradients with a linear classifier.

Windows keep their scores, which OpenCV's own grouping would drop.

References
----------
N. Dalal, B. Triggs: Histograms of Oriented Gradients for Human Detection. CVPR 2005.
M. Enzweiler, D. M. Gavrila: Monocular Pedestrian Detection: Survey and Experiments. PAMI 2009.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from nvcore.common.extras import needs
from nvcore.dataset.provenance import About, Setting
from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import (
    Detections,
    DetectorError,
    threads_for_a_picture,
    to_8_bits,
)
from nvcore.subjects.detectors.settings import setting, settings_from
from nvcore.subjects.detectors.suppression import sorted_detections, suppress

with needs("detectors", "detectors need"):
    import cv2

CLASSIFIERS: Final = {
    "inria": "INRIA's people, windows of 64 x 128 px",
    "daimler": "Daimler's pedestrians, windows of 48 x 96 px: for smaller ones",
}
_WINDOWS: Final = {"inria": (64, 128), "daimler": (48, 96)}
_WEIGHTS: Final[dict[str, Callable[[], Any]]] = {
    "inria": cv2.HOGDescriptor.getDefaultPeopleDetector,
    "daimler": cv2.HOGDescriptor.getDaimlerPeopleDetector,
}
_BLOCK_PX: Final = 8
BODY_SHARE: Final = 0.75
"""Share of a window's height that the person takes, for both classifiers: 96/128 and 72/96 px."""
BODY_ASPECT: Final = 0.41
"""Width over height of a pedestrian's box, as in the benchmarks."""
_MOST_LEVELS: Final = 64
"""Maximum number of pyramid levels that OpenCV accepts."""
MOST_PIXELS: Final = 1 << 26
"""Maximum number of pixels of an enlarged picture."""


@dataclass(frozen=True)
class HogSettings:
    """Settings of OpenCV's people detectors."""

    classifier: str = setting("inria", "Which of OpenCV's classifiers.", choices=CLASSIFIERS)
    hit_threshold: float = setting(
        0.0, "Windows with a lower score are dropped at once.", low=-10, high=10
    )
    stride: int = setting(
        8, "Step of the window, px; a multiple of 8.", low=8, high=64, multiple_of=_BLOCK_PX
    )
    scale_step: float = setting(
        1.05, "Factor from one size of the picture to the next.", low=1.01, high=2
    )
    upscale: float = setting(
        1.0, "Enlarges the picture first, for people smaller than the window.", low=0.25, high=4
    )
    padding: int = setting(8, "Margin added around the picture, px.", low=0, high=64)
    overlap: float = setting(
        0.5, "A box goes if its IoU with a more confident one is above this.", low=0, high=1
    )
    person_box: bool = setting(
        True,
        "Whether boxes are those of the person (3/4 of the window's height, 0.41 as wide); else "
        "the windows, margin and all.",
    )
    stretch_8_bit: bool = setting(
        False, "Whether grey levels of 8-bit pictures are stretched, too, as 16-bit ones always."
    )


class Hog:
    """Detector around one of OpenCV's people detectors. See `base.Detector`."""

    def __init__(self, settings: HogSettings):
        self.settings = settings
        values: dict[str, Setting] = asdict(settings)
        name = settings.classifier
        self._size = _WINDOWS[name]
        self._weights = np.asarray(_WEIGHTS[name](), dtype=np.float32)
        digest = hashlib.sha256(self._weights.astype("<f4").tobytes())
        digest.update(json.dumps(values, sort_keys=True).encode())
        self.about = About(
            kind="hog",
            name="HOG" if name == "inria" else f"HOG {name.capitalize()}",
            labels=("pedestrian",),
            settings=values,
            fingerprint=digest.hexdigest(),
        )
        # as in OpenCV's own example: INRIA's with gamma correction, Daimler's without
        is_plain = name == "inria"
        sizes = () if is_plain else (self._size, (16, 16), (8, 8), (8, 8), 9)
        self._descriptor = cv2.HOGDescriptor(*sizes)
        self._descriptor.setSVMDetector(self._weights)

    def detect(self, picture: Picture) -> Detections:
        """Return the boxes in one picture (see `Detector.detect`)."""
        settings = self.settings
        prepared = to_8_bits(picture, always=settings.stretch_8_bit)
        height, width = picture.shape[:2]
        enlarged = round(width * settings.upscale), round(height * settings.upscale)
        if enlarged[0] * enlarged[1] > MOST_PIXELS:
            raise DetectorError(
                f"upscale: a picture of {width} x {height} px enlarged {settings.upscale:g} times "
                f"has more than {MOST_PIXELS:,} pixels"
            )
        if enlarged != (width, height):
            prepared = cv2.resize(prepared, enlarged, interpolation=cv2.INTER_LINEAR)
        window_width, window_height = self._size
        margin = 2 * settings.padding
        if enlarged[0] + margin < window_width or enlarged[1] + margin < window_height:
            return sorted_detections(np.empty((0, 4)), np.empty(0))
        boxes, score = self._windows(prepared)
        if settings.person_box:  # the person is in the middle of the window
            x, y, w, h = boxes.T
            high = BODY_SHARE * h
            wide = BODY_ASPECT * high
            boxes = np.column_stack([x + 0.5 * (w - wide), y + 0.5 * (h - high), wide, high])
        # the margin of a window may lie outside the picture
        ends = np.clip(np.hstack([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]]), 0, enlarged * 2)
        boxes = np.hstack([ends[:, :2], ends[:, 2:] - ends[:, :2]])
        boxes = boxes * np.tile([width / enlarged[0], height / enlarged[1]], 2)
        return suppress(sorted_detections(boxes, score), settings.overlap)

    def _windows(self, picture: Picture) -> tuple[np.ndarray, np.ndarray]:
        """Return windows of all sizes, px of the picture, (n, 4), and their scores, (n,).

        The picture is shrunk as long as a window fits. The windows are those of OpenCV's
        `detectMultiScale`, which however mixes up the scores of windows when two of its threads end
        at the same time.
        """
        height, width = picture.shape[:2]
        first, *others = (self.settings.scale_step**level for level in range(_MOST_LEVELS))
        scales = [first] + [
            scale
            for scale in others
            if round(width / scale) >= self._size[0] and round(height / scale) >= self._size[1]
        ]
        with ThreadPoolExecutor(threads_for_a_picture()) as pool:
            levels = [*pool.map(lambda scale: self._level(picture, scale), scales)]
        boxes, scores = zip(*levels, strict=True)
        return np.concatenate(boxes), np.concatenate(scores)

    def _level(self, picture: Picture, scale: float) -> tuple[np.ndarray, np.ndarray]:
        """Return windows, px of the given picture, and scores at one scale."""
        settings, (height, width) = self.settings, picture.shape[:2]
        size = round(width / scale), round(height / scale)
        if size != (width, height):
            picture = cv2.resize(picture, size, interpolation=cv2.INTER_LINEAR_EXACT)
        corners, scores = self._descriptor.detect(
            picture,
            hitThreshold=settings.hit_threshold,
            winStride=(settings.stride, settings.stride),
            padding=(settings.padding, settings.padding),
        )
        corner = np.asarray(corners, dtype=np.float64).reshape(-1, 2)
        sides = np.tile(self._size, (len(corner), 1))
        boxes: np.ndarray = np.rint(np.column_stack([corner, sides]) * scale)
        return boxes, np.asarray(scores, dtype=np.float64).reshape(-1)


def open_hog(variant: str, given: Mapping[str, Setting]) -> Hog:
    """Open the detector ``hog`` or ``hog:daimler``.

    Parameters
    ----------
    variant
        Text after the colon. Empty: the setting `classifier`, or its default.

    Raises
    ------
    DetectorError
        If there is no such classifier, or a setting cannot be used.
    """
    if variant and given.get("classifier", variant) != variant:
        raise DetectorError(
            f"classifier: hog:{variant} is that of {variant}, found {given['classifier']!r}; "
            "name the detector hog, or leave the setting out"
        )
    return Hog(
        settings_from(HogSettings, {**given, **({"classifier": variant} if variant else {})})
    )
