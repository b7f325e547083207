"""Conversion of the outputs of common network families to boxes and class scores.

Every reader returns boxes in the network's own format, shape (n, 4), and scores, shape (n, c).
Outputs with a label per box (SSD) give one score per box. `OutputLayout` holds the family's
defaults.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nvcore.subjects.detectors.base import DetectorError

Outputs: TypeAlias = Mapping[str, NDArray[Any]]
"""Outputs of a network by name, in the network's order."""
Size: TypeAlias = tuple[int, int]
"""Width and height, px."""

CELLS_PX: Final = ((8, 16, 32), (8, 16, 32, 64))
"""Cell sides of YOLO networks, px. The second set is for large inputs."""
_ANCHORS: Final = 3
_COCO_CLASSES: Final = 80
"""Number of COCO classes without gaps and background class, as networks with sigmoids have them."""


@dataclass(frozen=True)
class Candidates:
    """Boxes before selection.

    Attributes
    ----------
    box
        Four coordinates of each box, float64, shape (n, 4).
    score
        Score of each class, float64, shape (n, c); shape (n, 1) for labelled boxes.
    label
        Class number of each box, int64, shape (n,). None if `score` has a column for each class.
    """

    box: NDArray[np.float64]
    score: NDArray[np.float64]
    label: NDArray[np.int64] | None = None


@dataclass(frozen=True)
class OutputLayout:
    """Output format and defaults of a network family.

    Attributes
    ----------
    read
        Maps outputs and input size to boxes and scores.
    box, fit, values, colour, activation, unit
        Same as in `OnnxSettings`. Only `unit` may be ``auto``.
    suppresses
        Whether the network itself suppresses overlapping boxes.
    person
        Number of the class "person" for networks trained on COCO.
    threshold
        Usual score threshold.
    """

    read: Callable[[Outputs, Size], Candidates]
    box: str = "cxcywh"
    fit: str = "letterbox"
    values: str = "0..1"
    colour: str = "rgb"
    activation: str = "none"
    unit: str = "pixels"
    suppresses: bool = False
    person: int = 0
    threshold: float = 0.25


def recognise(outputs: Outputs, size: Size, name: str) -> str:
    """Recognise the layout of outputs by their names and shapes.

    Parameters
    ----------
    outputs
        Outputs for any picture.
    size
        Size of the input.
    name
        Name of the model for error messages.

    Raises
    ------
    DetectorError
        If no layout matches, or several may.
    """
    shapes = [array.shape for array in outputs.values()]
    logits = _named(outputs, "logits")
    if logits is not None and _named(outputs, "box") is not None:
        return "rtdetr" if logits.shape[-1:] == (_COCO_CLASSES,) else "detr"
    if len(outputs) >= 3 and _named(outputs, "box") is not None:
        return "ssd"
    shape = shapes[0]
    if len(outputs) == 3 and _by_shape(outputs) is not None:
        return "ssd"
    if len(shape) == 3 and shape[0] == 1:
        _, rows, columns = shape
        n_cells = [cell_count(size, cells) for cells in CELLS_PX]
        if columns >= 6 and rows in n_cells:
            return "yolox"
        if columns >= 6 and rows in [_ANCHORS * n for n in n_cells]:
            return "yolov5"
        if columns == 6:
            return "end_to_end"
        if rows >= 5 and columns > rows:
            return "yolov8"
        if columns >= 6 and rows > columns:
            return "yolov5"
    raise DetectorError(
        f"its outputs ({_shapes(outputs)}) are of no known layout; name it by the setting layout",
        file=name,
    )


def shape_text(array: NDArray[Any]) -> str:
    """Return the shape of an output in the usual notation: (1, 84, 8400)."""
    return f"({', '.join(map(str, array.shape))})"


def _shapes(outputs: Outputs) -> str:
    return ", ".join(f"{key} {shape_text(array)}" for key, array in outputs.items())


def cell_count(size: Size, cells: Sequence[int]) -> int:
    """Return the number of cells with these sides in an input of this size."""
    width, height = size
    return sum((width // side) * (height // side) for side in cells)


def _rows(outputs: Outputs, least: int) -> NDArray[np.float64]:
    """Return the only or first output as rows with at least `least` columns."""
    array = next(iter(outputs.values()))
    if array.ndim != 3 or array.shape[0] != 1 or array.shape[2] < least:
        raise DetectorError(
            f"expected an output (1, n, {least} or more), found {shape_text(array)}; is it another "
            "layout?"
        )
    return np.asarray(array[0], dtype=np.float64)


def _yolov5(outputs: Outputs, _size: Size) -> Candidates:
    rows = _rows(outputs, 6)
    return Candidates(rows[:, :4], rows[:, 4:5] * rows[:, 5:])


def _yolov8(outputs: Outputs, _size: Size) -> Candidates:
    turned = {key: np.moveaxis(array, -1, -2) for key, array in outputs.items() if array.ndim == 3}
    rows = _rows(turned or outputs, 5)
    return Candidates(rows[:, :4], rows[:, 4:])


def _yolox(outputs: Outputs, size: Size) -> Candidates:
    rows = _rows(outputs, 6)
    for cells in CELLS_PX:
        if cell_count(size, cells) == len(rows):
            break
    else:
        raise DetectorError(
            f"expected {cell_count(size, CELLS_PX[0]):,} rows for {size[0]} x {size[1]} "
            f"px, found {len(rows):,}; is it another layout?"
        )
    corners, sides = [], []
    for side in cells:  # three or four sizes
        across, down = np.meshgrid(np.arange(size[0] // side), np.arange(size[1] // side))
        corners.append(side * np.column_stack([across.ravel(), down.ravel()]))
        sides.append(np.full(across.size, side))
    corner, cell = np.concatenate(corners), np.concatenate(sides)[:, np.newaxis]
    with np.errstate(over="ignore"):  # infinite values are dropped later
        box = np.hstack([rows[:, :2] * cell + corner, np.exp(rows[:, 2:4]) * cell])
    return Candidates(box, rows[:, 4:5] * rows[:, 5:])


def _end_to_end(outputs: Outputs, _size: Size) -> Candidates:
    rows = _rows(outputs, 6)
    return Candidates(rows[:, :4], rows[:, 4:5], _labels(rows[:, 5]))


def _labels(numbers: NDArray[Any]) -> NDArray[np.int64]:
    """Return class numbers as integers, -1 where they are not valid."""
    values = np.asarray(numbers, dtype=np.float64)
    is_class = (values >= 0) & (values < 1 << 20)
    return np.where(is_class, np.where(is_class, values, 0).astype(np.int64), -1)


def _ssd(outputs: Outputs, _size: Size) -> Candidates:
    named = [_named(outputs, word) for word in ("box", "score", "label")]
    named[2] = _named(outputs, "class") if named[2] is None else named[2]
    parts = _by_shape(outputs) if any(part is None for part in named) else named
    if parts is None:
        raise DetectorError(
            "expected outputs named boxes, scores and labels, or (n, 4), (n) and whole numbers (n)"
        )
    box, score, label = (np.asarray(part) for part in parts)
    if box.shape[-1:] != (4,) or score.size != label.size or box.size != 4 * score.size:
        shapes = ", ".join(map(shape_text, (box, score, label)))
        raise DetectorError(f"expected n boxes, scores and labels, found {shapes}")
    return Candidates(
        box.reshape(-1, 4).astype(np.float64),
        score.reshape(-1, 1).astype(np.float64),
        _labels(label.reshape(-1)),
    )


def _by_shape(outputs: Outputs) -> list[NDArray[Any] | None] | None:
    """Identify boxes, scores and labels by shape and type. None if they are ambiguous."""
    arrays = list(outputs.values())
    boxes = [a for a in arrays if a.shape[-1:] == (4,) and a.ndim > 1]
    labels = [a for a in arrays if a.dtype.kind in "iu" and a.shape[-1:] != (4,)]
    scores = [a for a in arrays if a.dtype.kind == "f" and not any(a is box for box in boxes)]
    if not len(boxes) == len(labels) == len(scores) == 1:
        return None
    return [boxes[0], scores[0], labels[0]]


def _detr(outputs: Outputs, _size: Size) -> Candidates:
    logits, box = _named(outputs, "logits"), _named(outputs, "box")
    is_one = logits is not None and logits.ndim == 3 and logits.shape[0] == 1
    if logits is None or box is None or not is_one or box.shape != (*logits.shape[:2], 4):
        raise DetectorError(
            f"expected outputs logits (1, n, c) and boxes (1, n, 4), found {_shapes(outputs)}"
        )
    return Candidates(box[0].astype(np.float64), logits[0].astype(np.float64))


def _named(outputs: Outputs, word: str) -> NDArray[Any] | None:
    """Return the first output with this word in its name."""
    return next((array for name, array in outputs.items() if word in name.lower()), None)


def activated(score: NDArray[np.float64], activation: str) -> NDArray[np.float64]:
    """Convert scores to probabilities. ``softmax`` drops the last class, which is background."""
    if activation == "none":
        return score
    with np.errstate(over="ignore"):
        if activation == "sigmoid":
            return 1 / (1 + np.exp(-score))
        powers = np.exp(score - score.max(axis=1, keepdims=True, initial=-np.inf))
    shares: NDArray[np.float64] = powers / powers.sum(axis=1, keepdims=True)
    return shares[:, :-1]


def corners(box: NDArray[np.float64], form: str) -> NDArray[np.float64]:
    """Convert boxes of any form (`OnnxSettings.box`) to left, top, right, bottom, shape (n, 4)."""
    a, b, c, d = box.T
    if form == "cxcywh":
        return np.column_stack([a - c / 2, b - d / 2, a + c / 2, b + d / 2])
    if form == "xywh":
        return np.column_stack([a, b, a + c, b + d])
    return np.column_stack([b, a, d, c]) if form == "yxyx" else box


_OF_TRANSFORMERS: Final[dict[str, Any]] = {
    "fit": "stretch", "unit": "shares", "suppresses": True, "threshold": 0.5
}  # fmt: skip
PRESETS: Final[dict[str, OutputLayout]] = {
    "yolov5": OutputLayout(_yolov5),
    "yolov8": OutputLayout(_yolov8),
    "yolox": OutputLayout(_yolox, fit="corner", values="0..255", colour="bgr"),
    "end_to_end": OutputLayout(_end_to_end, box="xyxy", suppresses=True),
    "ssd": OutputLayout(
        _ssd, box="xyxy", fit="stretch", unit="auto", suppresses=True, person=1, threshold=0.5
    ),
    "detr": OutputLayout(
        _detr, values="imagenet", activation="softmax", person=1, **_OF_TRANSFORMERS
    ),
    "rtdetr": OutputLayout(_detr, activation="sigmoid", **_OF_TRANSFORMERS),
}
"""Defaults of each layout."""
