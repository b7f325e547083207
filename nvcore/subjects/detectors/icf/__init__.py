"""Integral Channel Features: a sliding window, boosted trees over sums of rectangles, a cascade.

    model = train(scenes, SIGNS, name="signs", label="speed sign")
    write_model(model, Path("signs.npz"))
    boxes = read_model(Path("signs.npz")).detect(picture)

References
----------
P. Dollár, Z. Tu, P. Perona, S. Belongie: Integral channel features, BMVC 2009; L. Bourdev,
J. Brandt: Robust object detection via soft cascade, CVPR 2005.
"""

from __future__ import annotations

from pathlib import Path

from nvcore.common.output.files import write_whole
from nvcore.subjects.detectors.icf.detector import IcfDetector
from nvcore.subjects.detectors.icf.model import FORMAT, IcfModel, from_bytes, to_bytes
from nvcore.subjects.detectors.icf.settings import AS_IN_REPORT, PEDESTRIANS, SIGNS, IcfSettings
from nvcore.subjects.detectors.icf.training import train
from nvcore.subjects.detectors.icf.windows import Scene

__all__ = [
    "AS_IN_REPORT",
    "PEDESTRIANS",
    "SIGNS",
    "IcfDetector",
    "IcfModel",
    "IcfSettings",
    "Scene",
    "read_model",
    "train",
    "write_model",
]


def read_model(path: Path) -> IcfDetector:
    """Open the detector of a model file.

    Raises
    ------
    DetectorError
        If the file cannot be read, is damaged, or is not a model of this kind.
    """
    return IcfDetector(from_bytes(FORMAT.read(path), path.name))


def write_model(model: IcfModel, path: Path) -> None:
    """Write a model to a file atomically. Such files usually end in ``.npz``.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_whole(path, to_bytes(model))
