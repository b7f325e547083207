"""What every detector offers, whatever it is made of: a picture in, boxes with scores out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nvcore.pictures import Picture

Setting = bool | int | float | str | None
"""A value of a detector's settings, as JSON has it."""


@dataclass(frozen=True)
class Detections:
    """Boxes in one picture, the most confident first.

    Attributes
    ----------
    x, y, w, h
        Left, top, width, height in pixels of the picture, float64, shape (n,).
    score
        Confidence, float64, shape (n,); its scale is the detector's own.
    label
        What each box is, one of the detector's `labels`, object, shape (n,); None: the detector
        knows one kind of object.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    w: NDArray[np.float64]
    h: NDArray[np.float64]
    score: NDArray[np.float64]
    label: NDArray[np.object_] | None = None

    def __len__(self) -> int:
        return len(self.score)


@dataclass(frozen=True)
class TrainedOn:
    """A recording, or a part of it, on which a detector was trained.

    Attributes
    ----------
    fingerprint
        sha256 of what it was trained on: boxes and pictures, as hexadecimal digits.
    recording
        Name of the recording; empty: crops and scenes of no recording.
    first_frame, last_frame
        The frames, both included; None: the whole recording.
    """

    fingerprint: str
    recording: str = ""
    first_frame: int | None = None
    last_frame: int | None = None


@dataclass(frozen=True)
class About:
    """What a detector is, to be told apart from others and written beside its results.

    Attributes
    ----------
    kind
        Key in the registry: ``icf``, ``hog``, ``onnx``.
    name
        Of the model, for people.
    labels
        What it detects: ``("pedestrian",)``.
    settings
        All settings that its boxes depend on, by name.
    fingerprint
        sha256 over model and settings, as hexadecimal digits: equal if and only if the boxes are.
    trained_on
        What is known of its training; empty: nothing.
    """

    kind: str
    name: str
    labels: tuple[str, ...]
    settings: Mapping[str, Setting]
    fingerprint: str
    trained_on: Sequence[TrainedOn] = field(default=())


class Detector(Protocol):
    """A detector that is ready to run; any thread may use it."""

    about: About

    def detect(self, picture: Picture) -> Detections:
        """Boxes in one picture.

        Parameters
        ----------
        picture
            Grey (h, w) or RGB (h, w, 3), uint8 or uint16.

        Raises
        ------
        DetectorError
            If the detector cannot work on such a picture.
        """
        ...
