"""Readers of trials, and of what is known of their pictures."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.driver.features import FEATURE_KEYS
from nvcore.driver.inputs.study_tables import (
    BOX,
    LARGEST,
    LONGEST_S,
    PEDESTRIAN,
    TRIAL_COLUMNS,
    check_pedestrians,
    picture_boxes,
)
from nvcore.inputs.readers.parse.table import read_table

SIMULATED: Final = "simulated"
"""Device of trials that no person took."""


def read_trials(path: Path) -> pd.DataFrame:
    """Trials from a CSV file, a row for each picture shown to a subject.

    The columns are `TRIAL_COLUMNS`, in any order, separated by commas, semicolons or tabs.
    ``adaptation_asked_s`` is the time from the change of light to the picture's appearance,
    ``adaptation_measured_s`` what it was by the clock. ``touch_x`` and ``touch_y`` are in pixels of
    the picture, and empty where ``not_seen`` is 1. ``adaptation_measured_s``, ``response_s`` and
    ``device`` may be empty.

    Returns
    -------
    The columns in the order of `TRIAL_COLUMNS`, and ``line``: text, whole numbers (int64), seconds
    and pixels (float64, NaN: empty), ``not_seen`` as bool.

    Raises
    ------
    InputError
        If the file cannot be opened, a column is missing, a field is not of its kind, a touch
        stands beside ``not_seen`` or neither is there, or a subject has a picture twice at one
        time; with the line.
    """
    table = read_table(path, what="trials", required=TRIAL_COLUMNS)
    seconds = partial(table.numbers, low=0.0, high=LONGEST_S)
    values = partial(table.numbers, low=-LARGEST, high=LARGEST)
    trials = pd.DataFrame(
        {
            "subject": table.texts("subject"),
            **{name: table.whole_numbers(name) for name in ("run", "position", "order")},
            **{name: table.texts(name) for name in PEDESTRIAN},
            "adaptation_asked_s": seconds("adaptation_asked_s"),
            "adaptation_measured_s": seconds("adaptation_measured_s", may_be_empty=True),
            "touch_x": values("touch_x", may_be_empty=True),
            "touch_y": values("touch_y", may_be_empty=True),
            "response_s": seconds("response_s", may_be_empty=True),
            "not_seen": table.flags("not_seen"),
            "device": table.texts("device", may_be_empty=True),
            "line": table.lines,
        }
    )
    has_touch = trials[["touch_x", "touch_y"]].notna()
    not_seen = trials["not_seen"].to_numpy()
    is_wrong = np.where(not_seen, has_touch.any(axis=1), ~has_touch.all(axis=1))
    if is_wrong.any():
        row = int(np.argmax(is_wrong))
        expected = "no touch where not_seen is 1" if not_seen[row] else "touch_x and touch_y"
        raise table.fault(row, f"expected {expected}; or change not_seen")
    shown = trials[["subject", *PEDESTRIAN, "adaptation_asked_s"]]
    twice = shown.duplicated().to_numpy()
    if twice.any():
        row = int(np.argmax(twice))
        trial = shown.iloc[row]
        first = int(np.argmax((shown == trial).all(axis=1)))
        raise table.repeated(
            row,
            first,
            f"{trial['subject']} is shown the picture {trial['image']} after "
            f"{trial['adaptation_asked_s']:g} s a second time",
        )
    return trials


def read_features(path: Path) -> tuple[pd.DataFrame, pd.DataFrame | None]:
    """Features of the pedestrians in the pictures, as ``nvcore driver features`` writes them.

    Returns
    -------
    ``image``, ``pedestrian`` and the features by their keys (float64, NaN: undefined); and the
    boxes, as of `picture_boxes`, if the file has them.

    Raises
    ------
    InputError
        If the file cannot be opened or is no such table, or a pedestrian stands there twice; with
        the line.
    """
    table = read_table(path, what="features", required=(*PEDESTRIAN, *FEATURE_KEYS))
    check_pedestrians(table)
    values = partial(table.numbers, low=-LARGEST, high=LARGEST, may_be_empty=True)
    features = pd.DataFrame(
        {name: table.texts(name) for name in PEDESTRIAN}
        | {name: values(name) for name in FEATURE_KEYS}
    )
    return features, picture_boxes(table) if all(name in table for name in BOX) else None
