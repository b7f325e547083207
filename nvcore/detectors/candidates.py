"""Boxes of a picture before threshold and suppression, so that both can be moved at once.

    boxes = candidates(open_loosened("hog", {"upscale": 2}), picture)
    shown = only(boxes, counting(boxes, about, threshold=0.4, overlap=0.5))

Greedy suppression begins with the most confident box: a box below the threshold never suppresses
one above it. So the boxes that count are those that the detector gives with these settings.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About, Setting
from nvcore.detectors.base import Detections, Detector
from nvcore.detectors.registry import DETECTORS, kind_named, open_detector
from nvcore.detectors.suppression import OverlapOf, only, staying
from nvcore.pictures import Picture

if TYPE_CHECKING:
    from nvcore.detectors.icf.detector import IcfDetector

MOST: Final = 2000
"""Boxes of a picture that are kept, the most confident ones."""


def open_loosened(text: str | Path, settings: Mapping[str, Setting] | None = None) -> Detector:
    """The detector that drops and suppresses no box; see `open_detector`."""
    return open_detector(text, {**(settings or {}), **kind_named(text).loosest})


def candidates(detector: Detector, picture: Picture, *, most: int = MOST) -> Detections:
    """The most confident boxes of a detector that `open_loosened` opened; errors as `detect`."""
    if detector.about.kind == "icf":  # classes do not suppress: it reads them of what is left
        icf = cast("IcfDetector", detector)
        boxes = icf.candidates(icf.score_maps(picture))
    else:
        boxes = detector.detect(picture)
    return only(boxes, np.arange(len(boxes)) < most)


def counting(
    boxes: Detections, about: About, *, threshold: float, overlap: float
) -> NDArray[np.bool_]:
    """Which candidates the detector would give, bool, shape (n,).

    Parameters
    ----------
    boxes
        The most confident first.
    about
        The detector: how it measures overlap.
    threshold
        Lowest score.
    overlap
        The detector's setting of that name.
    """
    is_above: NDArray[np.bool_] = boxes.score >= threshold
    above = only(boxes, is_above)
    is_counting = np.zeros(len(boxes), dtype=bool)
    overlap_of = cast(OverlapOf, about.settings.get("overlap_of", "union"))
    is_counting[is_above] = staying(above, overlap, overlap_of)
    return is_counting


def usual_threshold(about: About) -> float:
    """The score from which on a detector's boxes count, unless the user gives another."""
    own = about.settings[DETECTORS[about.kind].threshold]
    return float(own if about.threshold is None else about.threshold)  # type: ignore[arg-type]
