"""Interface of all detectors: a picture in, scored boxes out."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import InputError
from nvcore.common.extras import needs
from nvcore.dataset.provenance import About

with needs("detectors", "detectors need"):
    from nvcore.pictures import Picture, stretch
    from nvcore.pictures.stretch import STRETCH

_here = threading.local()


class DetectorError(InputError):
    """Error for a detector, a model or a setting that cannot be used."""


@dataclass(frozen=True)
class Detections:
    """Boxes in one picture, in descending order of confidence.

    Attributes
    ----------
    x, y, w, h
        Left, top, width, height in pixels of the picture, float64, shape (n,).
    score
        Confidence, float64, shape (n,). Its scale depends on the detector.
    label
        Class of each box, one of the detector's `labels`, object, shape (n,). None if the detector
        knows one kind of object only.
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
    """Detector that is ready to run. It is safe to use from any thread."""

    about: About

    def detect(self, picture: Picture) -> Detections:
        """Return the boxes in one picture.

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
    """Return the picture with 8-bit grey levels, as the dashboard shows it.

    Parameters
    ----------
    picture
        uint8 or uint16; 16 bits are stretched between the 0.5th and the 99.8th percentile, so that
        one hot pixel does not darken all others.
    always
        Also stretch 8-bit pictures. By default they stay as they are.
    """
    if picture.dtype == np.uint8 and not always:
        return np.asarray(picture, np.uint8)
    return stretch(picture, *STRETCH)


def one_for_a_picture() -> None:
    """Limit work started by this thread to one thread, as others process pictures in parallel."""
    _here.is_shared = True


def threads_for_a_picture() -> int:
    """Return how many threads the work on one picture may use.

    All cores if this thread has the machine to itself, one if others work on pictures in parallel.
    """
    return 1 if getattr(_here, "is_shared", False) else os.cpu_count() or 1
