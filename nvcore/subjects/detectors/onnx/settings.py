"""Settings of an ONNX network: preparation of its input and format of its output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from nvcore.subjects.detectors.settings import setting

AUTO: Final = "auto"

LAYOUTS: Final[Mapping[str, str]] = {
    AUTO: "by the names and shapes of the outputs",
    "yolov5": "YOLOv5, v7: (1, n, 5 + c), centre and size, objectness, classes",
    "yolov8": "YOLOv8, v9, 11: (1, 4 + c, n), centre and size, classes",
    "yolox": "YOLOX: (1, n, 5 + c), not yet decoded: cells of 8, 16 and 32 px",
    "end_to_end": "YOLOv10 and others that suppress: (1, n, 6), corners, score, class",
    "ssd": "torchvision, SSD: boxes, labels, scores",
    "detr": "DETR: logits (1, n, c), the last of them nothing, boxes (1, n, 4) as shares",
    "rtdetr": "RT-DETR: logits (1, n, c) of classes by themselves, boxes (1, n, 4) as shares",
}
FITS: Final[Mapping[str, str]] = {
    AUTO: "as usual for the layout",
    "letterbox": "as large as fits, in the middle",
    "corner": "as large as fits, in the upper left corner",
    "stretch": "both sides to the network's size",
}
VALUES: Final[Mapping[str, str]] = {
    AUTO: "as usual for the layout",
    "0..1": "grey levels / 255",
    "0..255": "grey levels as they are",
    "imagenet": "less the mean of ImageNet's colours, by their spread",
}
BOXES: Final[Mapping[str, str]] = {
    AUTO: "as usual for the layout",
    "cxcywh": "centre and size",
    "xyxy": "left, top, right, bottom",
    "yxyx": "top, left, bottom, right",
    "xywh": "left, top, width, height",
}
UNITS: Final[Mapping[str, str]] = {
    AUTO: "shares where none is above 1.5",
    "pixels": "pixels of the network's input",
    "shares": "shares of its sides",
}
ACTIVATIONS: Final[Mapping[str, str]] = {
    AUTO: "as usual for the layout",
    "none": "they are probabilities",
    "sigmoid": "each class by itself",
    "softmax": "over all classes, the last of them nothing",
}
COLOURS: Final[Mapping[str, str]] = {AUTO: "as usual for the layout", "rgb": "RGB", "bgr": "BGR"}


@dataclass(frozen=True)
class OnnxSettings:
    """Settings of a custom network. For `auto` see `nvcore.subjects.detectors.onnx.layouts`."""

    layout: str = setting(AUTO, "How its output is laid out.", choices=LAYOUTS)
    width: int = setting(0, "Width of its input, px; 0: its own, else 640.", low=0, high=8192)
    height: int = setting(0, "Height of its input, px; 0: its own, else 640.", low=0, high=8192)
    fit: str = setting(AUTO, "How a picture is brought to that size.", choices=FITS)
    fill: int = setting(114, "Grey level around the picture.", low=0, high=255)
    values: str = setting(AUTO, "What grey levels become.", choices=VALUES)
    colour: str = setting(AUTO, "Order of the colours.", choices=COLOURS)
    box: str = setting(AUTO, "What the four numbers of a box are.", choices=BOXES)
    unit: str = setting(AUTO, "Unit of these numbers.", choices=UNITS)
    activation: str = setting(AUTO, "What is still to be done to scores.", choices=ACTIVATIONS)
    classes: str = setting(
        "",
        "Classes that count, names or numbers with commas. Default: person or pedestrian, else the "
        "number of a person in COCO.",
    )
    names: str = setting("", "Names of the classes with commas, where the model has none.")
    threshold: float = setting(0.05, "Boxes with a lower score are dropped.", low=0, high=1)
    overlap: float = setting(
        -1.0,
        "A box goes if its IoU with a more confident one is above this; below 0: 0.5, or none "
        "where the network suppresses by itself.",
        low=-1,
        high=1,
    )
    stretch_8_bit: bool = setting(
        False, "Whether grey levels of 8-bit pictures are stretched, too, as 16-bit ones always."
    )
    threads: int = setting(
        1, "Threads for one picture; several pictures run side by side.", low=1, high=64
    )
