"""Names, types and units of tables, and encounter categories with a description each.

Every table of the program consists of these columns. Column names and categories are only defined
here.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum, StrEnum
from typing import Any, Final

import numpy as np
import pandas as pd

NO_TRACK: Final = -1
"""Value of `track` for a box that belongs to no track (shown as empty)."""

UNKNOWN_OCCLUSION: Final = -1
"""Value of `occlusion` if unknown (shown as empty)."""

NO_LABEL: Final = -1
"""Value of `label` for a box of unknown class."""

CLASS_SEPARATOR: Final = ";"
"""Separator of several classes of one pedestrian."""

TABLE_ENDING: Final = " (table)"
"""Suffix of the name of an input that is a table in memory. Its rows are counted from 0."""

SAME_S: Final = 1e-6
"""Tolerance for equal times, seconds: smaller differences are rounding errors."""
KMH: Final = 3.6
"""Kilometres per hour in one metre per second."""

EDGE_PX: Final = 1.0
"""Maximum distance from the picture's edge at which a box counts as cut off there."""

TRUTH: Final = 0
"""Value of `source` for ground truth. System number i (0-based) has source i + 1."""

BOX_DTYPES: Final[dict[str, str]] = {
    "x": "float64",  # left edge, px, 0-based, continuous
    "y": "float64",  # top edge, px
    "w": "float64",  # width, px
    "h": "float64",  # height, px
    "score": "float64",  # detector's confidence, any scale; NaN: none given
    "track": "int64",  # NO_TRACK if none
    "ignore": "bool",  # truth only: detecting it is neither right nor wrong
    "distance_m": "float64",  # metres from the camera; NaN: unknown
    "occlusion": "int8",  # 0 none, 1 partial, 2 heavy; UNKNOWN_OCCLUSION
    "label": "int32",  # place among the labels of the reading or the dataset; NO_LABEL
    "detectability": "float64",  # truth only: 0..1, would the driver see it; NaN: unknown
    "file": "int32",  # index into the files of the reading or the dataset
    "line": "int32",  # 1-based line (or 1-based record) in that file
}
"""Columns that every box has, from the reader to the analysis."""

READING_DTYPES: Final[dict[str, str]] = {"recording": "category", "frame": "int64", **BOX_DTYPES}
"""Boxes as a reader returns them: recording by name, frame by the recording's own number."""

DATASET_BOX_DTYPES: Final[dict[str, str]] = {
    "frame_index": "int64",  # row of the frames table
    "source": "int16",  # TRUTH or system number + 1
    **BOX_DTYPES,
    "detectability_sd": "float64",  # standard deviation of the estimate; NaN: unknown
    "is_outside": "bool",  # True if estimated outside the range of the training
    "is_adapted": "bool",  # True if for adapted eyes, without a known change of light before
}
"""Boxes of a `Dataset`, sorted by source, then frame_index, then file order."""

DETECTABILITY_COLUMNS: Final = ("detectability", "detectability_sd", "is_outside", "is_adapted")
"""Columns on the driver's view of each box. If they are unknown throughout, these columns take no
memory, as no kernel reads them then."""

FRAME_DTYPES: Final[dict[str, str]] = {
    "recording": "int32",  # row of the recordings table
    "frame": "int64",  # the recording's own frame number
    "time_s": "float64",  # seconds since the recording's first listed frame
    "step_s": "float64",  # seconds to the next listed frame (last one: the median gap)
    "speed_kmh": "float64",  # speed of the car from a series; NaN: none, or no value here
}

RECORDING_DTYPES: Final[dict[str, str]] = {
    "name": "object",
    "width": "float64",  # px
    "height": "float64",  # px
    "fps": "float64",  # frames per second
    "horizon": "float64",  # row of the horizon, px; NaN: unknown
    "context": "float64",  # traffic: 0 urban to 1 rural; NaN: not stated
    "speed_kmh": "float64",  # speed of the car if no series states it; NaN: not stated
    "tags": "object",  # words for selecting recordings, tuple of str
    "unit": "object",  # group: a drive, a route, a car; empty: none
}

ATTRIBUTE_DTYPES: Final[dict[str, str]] = {
    "file": "int32",  # as in the table of boxes
    "line": "int32",  # as in the table of boxes
    "attributes": "category",  # statements of the truth on the pedestrian in this frame; not empty
}
"""Texts of the truth's boxes, if any, identified by file and line."""

LEFT_OUT_DTYPES: Final[dict[str, str]] = {
    "subject": "object",  # truth or the name of a system
    "recording": "object",
    "frame": "int64",
    "file": "int32",
    "line": "int32",
    "reason": "object",
    "x": "float64",
    "y": "float64",
    "w": "float64",
    "h": "float64",
}
"""Rows of the inputs that could not be assigned."""


class Category(StrEnum):
    """Venn category of an encounter: which systems detect it."""

    BOTH = "both"
    X_ONLY = "x_only"
    Y_ONLY = "y_only"
    NEITHER = "neither"
    DISTANT = "distant"


CATEGORY_WORDS: Final = {
    Category.BOTH: "both",
    Category.X_ONLY: "only X",
    Category.Y_ONLY: "only Y",
    Category.NEITHER: "neither",
    Category.DISTANT: "distant",
}
CATEGORY_TEXT: Final[dict[Category, str]] = {
    Category.BOTH: "Both systems detected the {one}.",
    Category.X_ONLY: "Only X detected the {one}.",
    Category.Y_ONLY: "Only Y detected the {one}.",
    Category.NEITHER: "Neither system detected the {one}.",
    Category.DISTANT: "The {one} never came near enough to count.",
}


class MissClass(StrEnum):
    """Way in which a system fails in one encounter."""

    NEVER = "never"
    LATE = "late"
    DROPOUT = "dropout"
    LOST_EARLY = "lost_early"
    BRIEF = "brief"
    NONE = "none"


MISS_CLASS_TEXT: Final[dict[MissClass, str]] = {
    MissClass.NEVER: "Not detected in any frame that counts.",
    MissClass.LATE: "First matched too long after the {one} came near enough to count.",
    MissClass.DROPOUT: "Detected, lost for too long, detected again.",
    MissClass.LOST_EARLY: "Lost too long before the {one} was too far to count again.",
    MissClass.BRIEF: "Detected in too few frames that count, in none of the other ways.",
    MissClass.NONE: "Detected without a failure worth naming.",
}


class TruthState(IntEnum):
    """Outcome of a truth box for one system."""

    NOT_JUDGED = 0
    """The truth ignores it: detecting it is neither right nor wrong."""
    MISSED = 1
    """A pedestrian without a detection."""
    MATCHED = 2
    """A pedestrian with a detection."""


class DetectionState(IntEnum):
    """Outcome of a detection."""

    BELOW = 0
    """Its score is below the threshold."""
    MATCHED = 1
    """Matched to a pedestrian."""
    FALSE_ALARM = 2
    """Neither matched nor absorbed."""
    ABSORBED = 3
    """On an ignore region: counts for nothing."""


def categories_of(codes: np.ndarray, names: Any) -> pd.Categorical[Any]:
    """Return a column of names from indices into a list of unique names. -1: missing."""
    column: pd.Categorical[Any] = pd.Categorical.from_codes(codes, categories=names)
    return column


def integers_of(values: np.ndarray, is_known: np.ndarray) -> Any:
    """Return a column of integers, with unknown ones marked as missing."""
    # floats cannot represent large ids such as timestamps
    return pd.arrays.IntegerArray(values.astype(np.int64), ~is_known)


def names_as_categories(names: Any, n_rows: int) -> pd.Categorical[Any]:
    """Return a column that stores each repeated name once, without comparing rows as text.

    Parameters
    ----------
    names
        One name for all rows, or one for each, as text or already as categories.
    n_rows
        Number of rows.
    """
    if isinstance(names, str):
        return categories_of(np.zeros(n_rows, np.int8), [names])
    if isinstance(getattr(names, "dtype", None), pd.CategoricalDtype):
        return pd.Categorical(names)
    codes, unique = pd.factorize(np.asarray(names, dtype=object))
    return categories_of(codes, unique)


def conform(
    columns: dict[str, object],
    dtypes: dict[str, str],
    *,
    n_rows: int,
    repeat: Callable[[Any, int], np.ndarray] | None = None,
) -> pd.DataFrame:
    """Return a table with exactly the columns of `dtypes`, filling absent ones with "unknown".

    Parameters
    ----------
    columns
        Arrays of length `n_rows`, or scalars, by column name.
    dtypes
        Column names and dtypes of the table, such as `READING_DTYPES`.
    n_rows
        Number of rows. An empty table keeps its columns and dtypes.
    repeat
        Function that makes a column of a scalar. None: with memory for each row, as kernels need.

    Raises
    ------
    AssertionError
        If a column is not part of the schema.
    """
    assert set(columns) <= set(dtypes), set(columns) - set(dtypes)
    unknown = {
        "track": NO_TRACK,
        "occlusion": UNKNOWN_OCCLUSION,
        "label": NO_LABEL,
        "ignore": False,
        "is_outside": False,
        "is_adapted": False,
    }
    table: dict[str, Any] = {}
    for name, dtype in dtypes.items():
        fallback = unknown.get(name, np.nan if dtype == "float64" else 0)
        value = columns.get(name, fallback)
        if dtype == "category":
            table[name] = names_as_categories(columns.get(name, []), n_rows)
            continue
        if np.ndim(value) == 0:  # type: ignore[arg-type]
            scalar = np.asarray(value).astype(dtype)
            fill = np.broadcast_to if name in DETECTABILITY_COLUMNS else repeat
            value = np.full(n_rows, scalar) if fill is None else fill(scalar, n_rows)
        table[name] = np.asarray(value).astype(dtype, copy=False)
    return pd.DataFrame(table, copy=False)
