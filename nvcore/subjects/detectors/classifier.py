"""Classifier for the content of a box: gradient histograms and one linear model for all classes.

A detector finds the boxes. The classifier then reads, for example, the limit on a speed sign.

References
----------
N. Dalal, B. Triggs: Histograms of oriented gradients for human detection, CVPR 2005.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import log_softmax, softmax

from nvcore.pictures import Picture
from nvcore.settings.objects import labels_in_order
from nvcore.subjects.detectors.base import Detections, DetectorError, to_8_bits

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]

SIDE: Final = 32
"""Side of the square to which the content of a box is resized, px."""
_CELL: Final = 4
_BINS: Final = 9
N_VALUES: Final = ((SIDE // _CELL - 1) * 2) ** 2 * _BINS
"""Values of a descriptor: blocks of two by two cells, one cell apart."""
MAX_CLASSES: Final = 100
_COPIES: Final = 4
"""Number of additional, distorted copies of each training box."""
_MOVED: Final = 0.08
"""Maximum shift of a copy as a share of its sides, and maximum growth as a share of its size."""
_LEAST_PX: Final = 16
"""Minimum height of randomly shrunk copies, so that the model also learns small boxes."""
_PENALTY: Final = 1e-4
"""Factor of the squared weights in the loss, which is the mean log loss plus this penalty."""
_STEPS: Final = 60
"""Maximum number of minimisation steps. More steps do not improve the reading of limits."""
_CLAHE_CLIP: Final = 4.0
_TILES: Final = (2, 2)


@dataclass(frozen=True, eq=False)
class Classifier:
    """Multinomial linear model over the descriptors of boxes.

    Attributes
    ----------
    classes
        At least two names, each once.
    weights
        float64, (N_VALUES + 1, n_classes); the last row is the offset of each class.
    """

    classes: tuple[str, ...]
    weights: Floats

    def probabilities(self, picture: Picture, boxes: Floats) -> Floats:
        """Return the probability of each class, float64, (n, n_classes). Each row sums to 1.

        Parameters
        ----------
        picture
            Grey (h, w) or RGB (h, w, 3), uint8 or uint16.
        boxes
            Left, top, width, height, px; (n, 4). Edge pixels are repeated outside the picture.
        """
        grey = to_grey(picture)
        values = describe([box_content(grey, box) for box in boxes])
        probabilities: Floats = softmax(values @ self.weights, axis=1)
        return probabilities

    def labels(self, picture: Picture, detections: Detections) -> NDArray[np.object_]:
        """Return the most probable class of each detection, object, (n,). The first wins ties."""
        boxes = np.stack([detections.x, detections.y, detections.w, detections.h], axis=1)
        best = self.probabilities(picture, boxes).argmax(axis=1)
        labels: NDArray[np.object_] = np.array(self.classes, dtype=object)[best]
        return labels


def train_classifier(
    examples: Iterable[tuple[Picture, Floats, Sequence[str]]], *, seed: int = 0
) -> Classifier | None:
    """Train a classifier on labelled boxes. Equal examples and seeds give equal classifiers.

    L-BFGS minimises the mean log loss, with equal total weight for every class, plus a penalty on
    the squared weights. Boxes of a detector do not fit exactly, so each box is also learned in
    copies that are shifted, resized and shrunk.

    Parameters
    ----------
    examples
        Pictures, the boxes in each, (n, 4), and the class of each box. "" marks a box without
        class.

    Returns
    -------
    None if the boxes have fewer than two classes.

    Raises
    ------
    DetectorError
        If there are more than `MAX_CLASSES`, or the numbers of boxes and classes in a picture
        differ.
    """
    rng = np.random.default_rng(seed)
    contents: list[Bytes] = []
    labels: list[str] = []
    for picture, boxes, names in examples:
        if len(names) != len(boxes):
            raise DetectorError(f"a picture has {len(boxes)} boxes and {len(names)} classes")
        named = [(box, name) for box, name in zip(boxes, names, strict=True) if name]
        if not named:
            continue
        grey = to_grey(picture)
        for box, name in named:
            contents += [box_content(grey, box), *_copies(grey, box, rng)]
            labels += [name] * (1 + _COPIES)
    classes = labels_in_order(labels)
    if len(classes) < 2:
        return None
    if len(classes) > MAX_CLASSES:
        raise DetectorError(f"boxes of {len(classes)} classes; expected at most {MAX_CLASSES}")
    place = {name: number for number, name in enumerate(classes)}
    return Classifier(
        classes, _fit(describe(contents), np.array([place[name] for name in labels]), len(classes))
    )


def to_grey(picture: Picture) -> Bytes:
    """Convert a picture to 8-bit grey levels."""
    levels = to_8_bits(picture)
    return np.asarray(cv2.cvtColor(levels, cv2.COLOR_RGB2GRAY)) if levels.ndim == 3 else levels


def box_content(grey: Bytes, box: Floats, shrunk_to: int = SIDE) -> Bytes:
    """Crop a box, resize it to `SIDE` x `SIDE` pixels and equalise its contrast.

    Parameters
    ----------
    shrunk_to
        Side to which the content is shrunk first, px, if smaller than `SIDE`.
    """
    x, y, w, h = box
    left, top = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
    right, bottom = (
        max(left + 1, int(np.floor(x + w + 0.5))),
        max(top + 1, int(np.floor(y + h + 0.5))),
    )
    columns = np.clip(np.arange(left, right), 0, grey.shape[1] - 1)
    rows = np.clip(np.arange(top, bottom), 0, grey.shape[0] - 1)
    content = grey[rows[:, None], columns]
    if shrunk_to < SIDE:
        content = _resized(content, shrunk_to)
    clahe = cv2.createCLAHE(_CLAHE_CLIP, _TILES)
    return np.asarray(clahe.apply(_resized(content, SIDE)))


def describe(contents: Sequence[Bytes]) -> Floats:
    """Return the descriptor of each box, followed by a 1, float64, (n, N_VALUES + 1)."""
    cell, block = (_CELL, _CELL), (2 * _CELL, 2 * _CELL)
    hog = cv2.HOGDescriptor((SIDE, SIDE), block, cell, cell, _BINS)
    values = np.ones((len(contents), N_VALUES + 1))
    for row, content in enumerate(contents):  # the loop calls OpenCV once per box
        values[row, :-1] = np.asarray(hog.compute(content)).ravel()
    return values


def _copies(grey: Bytes, box: Floats, rng: np.random.Generator) -> list[Bytes]:
    """Return copies of a box: shifted, resized, and shrunk as if seen from farther away."""
    x, y, w, h = box
    contents = []
    for _ in range(_COPIES):
        dx, dy, growth = rng.uniform(-_MOVED, _MOVED, 3)
        wider, higher = w * (1 + growth), h * (1 + growth)
        moved = np.array(
            [x + (w - wider) / 2 + dx * w, y + (h - higher) / 2 + dy * h, wider, higher]
        )
        # values from SIDE on, about two in three, leave the copy sharp
        shrunk_to = int(rng.integers(_LEAST_PX, 2 * SIDE))
        contents.append(box_content(grey, moved, shrunk_to))
    return contents


def _resized(content: Bytes, side: int) -> Bytes:
    is_smaller = side < min(content.shape)
    way = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(content, (side, side), interpolation=way))


def _fit(values: Floats, code: NDArray[np.int64], n_classes: int) -> Floats:
    """Return the weights with minimum loss, float64, (n_values, n_classes)."""
    narrow = values.astype(np.float32)  # float32 products take half the time; sums stay float64
    share = 1.0 / (n_classes * np.bincount(code, minlength=n_classes)[code])
    target = np.zeros((len(code), n_classes))
    target[np.arange(len(code)), code] = 1.0
    is_weight = np.ones((values.shape[1], 1))
    is_weight[-1] = 0.0  # offsets are not penalised

    def loss(flat: Floats) -> tuple[float, Floats]:
        weights = flat.reshape(values.shape[1], n_classes)
        log_probability = log_softmax((narrow @ weights.astype(np.float32)).astype(float), axis=1)
        penalty = _PENALTY * float((is_weight * weights**2).sum())
        cost = -float((share[:, None] * target * log_probability).sum()) + penalty
        residual = share[:, None] * (np.exp(log_probability) - target)
        slope = narrow.T @ residual.astype(np.float32) + 2 * _PENALTY * is_weight * weights
        return cost, slope.ravel()

    start = np.zeros(values.shape[1] * n_classes)
    best = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": _STEPS})
    weights: Floats = best.x.reshape(values.shape[1], n_classes)
    return weights
