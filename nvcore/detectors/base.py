"""What every detector offers, whatever it is made of: a picture in, boxes with scores out."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About
from nvcore.errors import InputError
from nvcore.extras import needs

with needs("detectors", "detectors need"):
    from nvcore.pictures import Picture, stretch
    from nvcore.pictures.stretch import STRETCH

_here = threading.local()


class DetectorError(InputError):
    """A detector, its model or its settings cannot be used."""


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


def to_8_bits(picture: Picture, *, always: bool = False) -> NDArray[np.uint8]:
    """The picture with grey levels of 8 bits, as the dashboard shows it.

    Parameters
    ----------
    picture
        uint8 or uint16; 16 bits are stretched between the 0.5th and the 99.8th percentile, so that
        one hot pixel does not darken all others.
    always
        Whether 8 bits are stretched, too; else they stay as they are.
    """
    if picture.dtype == np.uint8 and not always:
        return np.asarray(picture, np.uint8)
    return stretch(picture, *STRETCH)


def one_for_a_picture() -> None:
    """From now on what this thread begins takes no further thread: others work beside it."""
    _here.is_shared = True


def threads_for_a_picture() -> int:
    """How many threads the work on a picture may take that this thread begins.

    All cores if the picture is alone, one where others are beside it.
    """
    return 1 if getattr(_here, "is_shared", False) else os.cpu_count() or 1
