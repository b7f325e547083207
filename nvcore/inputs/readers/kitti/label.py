"""What KITTI's object and tracking labels have in common: classes, corners, 3-D columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from nvcore.inputs.readers.base import ReadOptions
from nvcore.inputs.readers.meaning.classes import (
    ClassChoice,
    ClassRule,
    choose_classes,
    rule_for,
)
from nvcore.inputs.readers.meaning.values import known_distances, levels_of_numbers
from nvcore.inputs.readers.parse.text import NumberTable
from nvcore.schema import NO_TRACK

FIELDS = "type truncated occluded alpha left top right bottom h w l X Y Z ry [score]"
RULE = ClassRule(
    counted=("Pedestrian",),
    ignored=("Person_sitting", "DontCare"),
    left_out=("Cyclist", "Car", "Van", "Truck", "Tram", "Misc"),
    is_benchmark=True,
)
"""As in KITTI's own pedestrian evaluation: a detection on a cyclist is a false alarm there."""
TRACKING_RULE = replace(RULE, ignored=("Person", *RULE.ignored))
"""KITTI's tracking labels call those who sit `Person`; in files of other tools all are `person`."""
CORNERS = "inclusive 0-based corners to x, y, w, h (w = right - left + 1)"
DISTANCE = "camera Z to distance_m (not in front of the camera: unknown)"


def box_of_corners(
    left: np.ndarray, top: np.ndarray, right: np.ndarray, bottom: np.ndarray
) -> tuple[np.ndarray, ...]:
    """x, y, w, h of boxes whose corners are the first and the last pixel inside."""
    return left, top, right - left + 1, bottom - top + 1


def label_boxes(
    table: NumberTable,
    places: pd.DataFrame,
    options: ReadOptions,
    *,
    track: np.ndarray | int = NO_TRACK,
) -> tuple[pd.DataFrame, ClassChoice, list[str]]:
    """Boxes of label rows, what the classes became, and the conversion in words.

    Parameters
    ----------
    table
        Rows whose last columns are those of `FIELDS`, the type as their label.
    places
        Recording and frame of each row.
    options
        `role`, `objects` and `classes` are used.
    track
        Of each row, shape (n,).
    """
    assert table.label is not None
    _, occluded, _, left, top, right, bottom, _, _, _, _, _, z, _, score = table.columns[-15:]
    is_kitti = not {"Pedestrian", "DontCare"}.isdisjoint(table.label)
    rule = TRACKING_RULE if is_kitti and "Person" in table.label else RULE
    choice = choose_classes(table.label, rule_for(rule, table.label, options), options, table.lines)
    facts = [CORNERS, DISTANCE, "occluded 0, 1, 2 kept, 3 = unknown", choice.fact]
    has_score = options.role == "detections"
    if has_score and len(table) and np.isnan(score).all():
        facts.append("no score column: no scores")
    boxes = table.lines.boxes(
        box_of_corners(left, top, right, bottom),
        keep=choice.keep,
        recording=places["recording"].to_numpy(),
        frame=places["frame"].to_numpy(),
        score=score if has_score else np.nan,
        track=track,
        ignore=choice.ignore,
        distance_m=known_distances(z),
        occlusion=levels_of_numbers(occluded),
    )
    return boxes, choice, facts
