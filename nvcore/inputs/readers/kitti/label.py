"""What KITTI's object and tracking labels have in common: classes, corners, 3-D columns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.inputs.readers.base import ReadOptions, SourceFile, reading_boxes
from nvcore.inputs.readers.meaning.classes import ClassChoice, ClassRule, choose_classes
from nvcore.inputs.readers.meaning.occlusion import levels_of_numbers
from nvcore.inputs.readers.parse.text import NumberTable

FIELDS = "type truncated occluded alpha left top right bottom h w l X Y Z ry [score]"
RULE = ClassRule(
    counted=("Pedestrian",),
    ignored=("Person", "Person_sitting", "DontCare"),
    left_out=("Cyclist", "Car", "Van", "Truck", "Tram", "Misc"),
)
"""As in KITTI's own pedestrian evaluation: a detection on a cyclist is a false alarm there."""
CORNERS = "inclusive 0-based corners to x, y, w, h (w = right - left + 1)"
DISTANCE = "camera Z to distance_m (not in front of the camera: unknown)"


def corner_columns(
    left: np.ndarray, top: np.ndarray, right: np.ndarray, bottom: np.ndarray
) -> dict[str, object]:
    """x, y, w, h of boxes whose corners are the first and the last pixel inside."""
    return {"x": left, "y": top, "w": right - left + 1, "h": bottom - top + 1}


def distance_of(z: np.ndarray) -> np.ndarray:
    """Distance in metres from the camera's Z; NaN where the files say -1000, -1 or the like."""
    with np.errstate(invalid="ignore"):
        return np.where(z > 0, z, np.nan)


def label_boxes(
    table: NumberTable,
    options: ReadOptions,
    *,
    files: Sequence[SourceFile],
    file: np.ndarray,
    recording: np.ndarray,
    frame: np.ndarray,
    track: np.ndarray | None = None,
) -> tuple[pd.DataFrame, ClassChoice, list[str]]:
    """Boxes of label rows, what the classes became, and the conversion in words.

    Parameters
    ----------
    table
        Rows whose last columns are those of `FIELDS`, the type as their label.
    options
        `role` and `classes` are used.
    files
        The files of the reading.
    file, recording, frame, track
        Of each row, shape (n,); no tracks where `track` is None.
    """
    assert table.label is not None
    _, occluded, _, left, top, right, bottom, _, _, _, _, _, z, _, score = table.columns[-15:]
    choice = choose_classes(table.label, RULE, options, files=files, file=file, line=table.line)
    columns: dict[str, object] = {
        "recording": recording,
        "frame": frame,
        **corner_columns(left, top, right, bottom),
        "ignore": choice.ignore,
        "distance_m": distance_of(z),
        "occlusion": levels_of_numbers(occluded),
        "file": file,
        "line": table.line,
    }
    facts = [CORNERS, DISTANCE, "occluded 0, 1, 2 kept, 3 = unknown", choice.fact]
    if track is not None:
        columns["track"] = track
    if options.role == "detections":
        columns["score"] = score
        if len(table) and np.isnan(score).all():
            facts.append("no score column: no scores")
    boxes = reading_boxes(len(table), **columns)[choice.keep].reset_index(drop=True)
    return boxes, choice, facts
