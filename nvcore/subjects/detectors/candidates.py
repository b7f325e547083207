"""Boxes of a picture before threshold and suppression, so that sliders can change both at once.

    boxes = candidates(open_loosened("hog", {"upscale": 2}), picture)
    shown = only(boxes, counting(boxes, about, threshold=0.4, overlap=0.5))

Greedy suppression starts with the most confident box: a box below the threshold never suppresses
one above it. Filtering the candidates therefore gives the detector's own boxes at these settings.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About, Setting
from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import Detections, Detector
from nvcore.subjects.detectors.registry import DETECTORS, kind_named, open_detector
from nvcore.subjects.detectors.suppression import OverlapOf, only, staying

if TYPE_CHECKING:
    from nvcore.subjects.detectors.icf.detector import IcfDetector

MOST: Final = 2000
"""Maximum number of candidates per picture. The most confident ones are kept."""


def open_loosened(text: str | Path, settings: Mapping[str, Setting] | None = None) -> Detector:
    """Open a detector with settings that drop and suppress no box. See `open_detector`."""
    return open_detector(text, {**(settings or {}), **kind_named(text).loosest})


def candidates(detector: Detector, picture: Picture, *, most: int = MOST) -> Detections:
    """Return the most confident boxes of a detector of `open_loosened`. Errors as for `detect`."""
    # ICF suppresses boxes regardless of class, then classifies the remaining ones
    if detector.about.kind == "icf":
        icf = cast("IcfDetector", detector)
        boxes = icf.candidates(icf.score_maps(picture))
    else:
        boxes = detector.detect(picture)
    return only(boxes, np.arange(len(boxes)) < most)


def counting(
    boxes: Detections, about: About, *, threshold: float, overlap: float
) -> NDArray[np.bool_]:
    """Return a mask of the candidates that the detector would report, bool, shape (n,).

    Parameters
    ----------
    boxes
        The most confident first.
    about
        Facts about the detector. Its settings say how overlap is measured.
    threshold
        Lowest score.
    overlap
        Setting `overlap` of the detector.
    """
    is_above: NDArray[np.bool_] = boxes.score >= threshold
    above = only(boxes, is_above)
    is_counting = np.zeros(len(boxes), dtype=bool)
    overlap_of = cast(OverlapOf, about.settings.get("overlap_of", "union"))
    is_counting[is_above] = staying(above, overlap, overlap_of)
    return is_counting


def usual_threshold(about: About) -> float:
    """Return the score threshold that applies unless the user gives another."""
    own = about.settings[DETECTORS[about.kind].threshold]
    return float(own if about.threshold is None else about.threshold)  # type: ignore[arg-type]
