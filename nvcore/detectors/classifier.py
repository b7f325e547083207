"""What is in a box: gradients in cells, and one linear model for all classes.

The boxes are a detector's; which limit a sign shows is asked of its content afterwards.

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

from nvcore.detectors.base import Detections, DetectorError, to_8_bits
from nvcore.objects import labels_in_order
from nvcore.pictures import Picture

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float64]

SIDE: Final = 32
"""Pixels to which a box is resized, both ways."""
_CELL: Final = 4
_BINS: Final = 9
N_VALUES: Final = ((SIDE // _CELL - 1) * 2) ** 2 * _BINS
"""Values of a descriptor: blocks of two by two cells, one cell apart."""
MAX_CLASSES: Final = 100
_COPIES: Final = 4
"""Further pictures of each box of a training."""
_MOVED: Final = 0.08
"""Share of its sides by which a copy's box is moved, and of its size by which it grows."""
_LEAST_PX: Final = 16
"""Copies are shrunk at random down to this height, so that small boxes are learned, too."""
_PENALTY: Final = 1e-4
"""Of the squared weights, beside the mean logarithmic loss."""
_STEPS: Final = 60
"""Of the minimisation; more do not read more limits right."""
_CLAHE_CLIP: Final = 4.0
_TILES: Final = (2, 2)


@dataclass(frozen=True, eq=False)
class Classifier:
    """A multinomial linear model of the descriptors of boxes.

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
        """Probability of each class; float64, (n, n_classes), each row sums to 1.

        Parameters
        ----------
        picture
            Grey (h, w) or RGB (h, w, 3), uint8 or uint16.
        boxes
            Left, top, width, height, px; (n, 4). What lies outside the picture repeats its edge.
        """
        grey = to_grey(picture)
        values = describe([box_content(grey, box) for box in boxes])
        probabilities: Floats = softmax(values @ self.weights, axis=1)
        return probabilities

    def labels(self, picture: Picture, detections: Detections) -> NDArray[np.object_]:
        """The most probable class of each detection, of equal ones the first; object, (n,)."""
        boxes = np.stack([detections.x, detections.y, detections.w, detections.h], axis=1)
        best = self.probabilities(picture, boxes).argmax(axis=1)
        labels: NDArray[np.object_] = np.array(self.classes, dtype=object)[best]
        return labels


def train_classifier(
    examples: Iterable[tuple[Picture, Floats, Sequence[str]]], *, seed: int = 0
) -> Classifier | None:
    """Learn the classes of labelled boxes; the same examples and seed give the same classifier.

    Minimised by L-BFGS: the mean logarithmic loss, every class weighing the same, and a penalty of
    the squared weights. So that boxes of a detector are classified as well, which do not fit
    exactly, copies of each box are moved, resized and shrunk.

    Parameters
    ----------
    examples
        Pictures, the boxes in each, (n, 4), and the class of each box; "" says none.

    Returns
    -------
    None where the boxes are of fewer than two classes.

    Raises
    ------
    DetectorError
        If there are more than `MAX_CLASSES`, or more or fewer classes than boxes in a picture.
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
    """The picture in grey levels of 8 bits."""
    levels = to_8_bits(picture)
    return np.asarray(cv2.cvtColor(levels, cv2.COLOR_RGB2GRAY)) if levels.ndim == 3 else levels


def box_content(grey: Bytes, box: Floats, shrunk_to: int = SIDE) -> Bytes:
    """What is in a box, resized to `SIDE` both ways, its contrast equalised.

    Parameters
    ----------
    shrunk_to
        Pixels to which it is resized before, if these are fewer.
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
    """Descriptors of boxes and a 1 after each; float64, (n, N_VALUES + 1)."""
    cell, block = (_CELL, _CELL), (2 * _CELL, 2 * _CELL)
    hog = cv2.HOGDescriptor((SIDE, SIDE), block, cell, cell, _BINS)
    values = np.ones((len(contents), N_VALUES + 1))
    for row, content in enumerate(contents):  # a loop over calls of the library
        values[row, :-1] = np.asarray(hog.compute(content)).ravel()
    return values


def _copies(grey: Bytes, box: Floats, rng: np.random.Generator) -> list[Bytes]:
    """The box moved, resized, and seen from farther away."""
    x, y, w, h = box
    contents = []
    for _ in range(_COPIES):
        dx, dy, growth = rng.uniform(-_MOVED, _MOVED, 3)
        wider, higher = w * (1 + growth), h * (1 + growth)
        moved = np.array(
            [x + (w - wider) / 2 + dx * w, y + (h - higher) / 2 + dy * h, wider, higher]
        )
        shrunk_to = int(rng.integers(_LEAST_PX, 2 * SIDE))  # from SIDE on, two in three: sharp
        contents.append(box_content(grey, moved, shrunk_to))
    return contents


def _resized(content: Bytes, side: int) -> Bytes:
    is_smaller = side < min(content.shape)
    way = cv2.INTER_AREA if is_smaller else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(content, (side, side), interpolation=way))


def _fit(values: Floats, code: NDArray[np.int64], n_classes: int) -> Floats:
    """Weights of the least loss; float64, (n_values, n_classes)."""
    narrow = values.astype(np.float32)  # products in half the time; what is summed stays wide
    share = 1.0 / (n_classes * np.bincount(code, minlength=n_classes)[code])
    target = np.zeros((len(code), n_classes))
    target[np.arange(len(code)), code] = 1.0
    is_weight = np.ones((values.shape[1], 1))
    is_weight[-1] = 0.0  # offsets are free

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
