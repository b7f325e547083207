"""Outputs of the common families of networks as boxes, scores of classes.

Every reader returns boxes as the network has them, shape (n, 4), and scores, shape (n, c); what is
given by label alone (SSD) as scores of its own class. `OutputLayout` says what is usual beside.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import DetectorError

Outputs: TypeAlias = Mapping[str, NDArray[Any]]
"""Outputs of a network by name, in its order."""
Size: TypeAlias = tuple[int, int]
"""Width and height, px."""

CELLS_PX: Final = ((8, 16, 32), (8, 16, 32, 64))
"""Sides of the cells of YOLO networks; the second for large inputs."""
_ANCHORS: Final = 3
_COCO_CLASSES: Final = 80
"""Without the gaps in COCO's numbers, and without a class for nothing: a sigmoid for each."""


@dataclass(frozen=True)
class Candidates:
    """Boxes before any is chosen.

    Attributes
    ----------
    box
        Four numbers of each, float64, shape (n, 4).
    score
        Of each class, float64, shape (n, c); of labelled boxes shape (n, 1).
    label
        Number of the class of each box, int64, shape (n,); None: `score` has a column for each.
    """

    box: NDArray[np.float64]
    score: NDArray[np.float64]
    label: NDArray[np.int64] | None = None


@dataclass(frozen=True)
class OutputLayout:
    """How a family lays out its outputs, and what is usual for it.

    Attributes
    ----------
    read
        (outputs, size of the input) -> boxes and scores.
    box, fit, values, colour, activation, unit
        As in `OnnxSettings`, none of them ``auto`` but the unit.
    suppresses
        Whether the network suppresses by itself.
    person
        Number of the class "person" where it was trained on COCO.
    threshold
        Score from which on a box usually counts.
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
    """The layout of these outputs, by their names and shapes.

    Parameters
    ----------
    outputs
        Of any picture.
    size
        Of the input.
    name
        Of the model, for the error.

    Raises
    ------
    DetectorError
        If it is none of them, or may be several.
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
    """The shape of an output as models' documents write it: (1, 84, 8400)."""
    return f"({', '.join(map(str, array.shape))})"


def _shapes(outputs: Outputs) -> str:
    return ", ".join(f"{key} {shape_text(array)}" for key, array in outputs.items())


def cell_count(size: Size, cells: Sequence[int]) -> int:
    """Cells of these sides in an input of this size."""
    width, height = size
    return sum((width // side) * (height // side) for side in cells)


def _rows(outputs: Outputs, least: int) -> NDArray[np.float64]:
    """The only output, or the first, as rows with at least so many columns."""
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
    for side in cells:  # three or four
        across, down = np.meshgrid(np.arange(size[0] // side), np.arange(size[1] // side))
        corners.append(side * np.column_stack([across.ravel(), down.ravel()]))
        sides.append(np.full(across.size, side))
    corner, cell = np.concatenate(corners), np.concatenate(sides)[:, np.newaxis]
    with np.errstate(over="ignore"):  # what is not finite is dropped later
        box = np.hstack([rows[:, :2] * cell + corner, np.exp(rows[:, 2:4]) * cell])
    return Candidates(box, rows[:, 4:5] * rows[:, 5:])


def _end_to_end(outputs: Outputs, _size: Size) -> Candidates:
    rows = _rows(outputs, 6)
    return Candidates(rows[:, :4], rows[:, 4:5], _labels(rows[:, 5]))


def _labels(numbers: NDArray[Any]) -> NDArray[np.int64]:
    """Numbers of classes as whole numbers; -1 where they are none."""
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
    """Boxes, scores and labels by shape and type; None: they cannot be told apart."""
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
    """The first output with this word in its name."""
    return next((array for name, array in outputs.items() if word in name.lower()), None)


def activated(score: NDArray[np.float64], activation: str) -> NDArray[np.float64]:
    """Scores as probabilities; by ``softmax`` without the last class, which is nothing."""
    if activation == "none":
        return score
    with np.errstate(over="ignore"):
        if activation == "sigmoid":
            return 1 / (1 + np.exp(-score))
        powers = np.exp(score - score.max(axis=1, keepdims=True, initial=-np.inf))
    shares: NDArray[np.float64] = powers / powers.sum(axis=1, keepdims=True)
    return shares[:, :-1]


def corners(box: NDArray[np.float64], form: str) -> NDArray[np.float64]:
    """Boxes of any form (`OnnxSettings.box`) as left, top, right, bottom; shape (n, 4)."""
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
"""What is usual for each layout."""
