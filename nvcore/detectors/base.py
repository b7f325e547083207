"""What every detector offers, whatever it is made of: a picture in, boxes with scores out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About, Setting, TrainedOn
from nvcore.extras import needs

with needs("detectors", "detectors need"):
    from nvcore.pictures import Picture

__all__ = ["About", "Detections", "Detector", "Setting", "TrainedOn"]


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
