"""What files say of a pedestrian beside his box, as text that makes classes of encounters."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any, Final

import numpy as np
import pandas as pd
from pandas.api.types import union_categoricals

from nvcore.schema import CLASS_SEPARATOR, names_as_categories

YES: Final = frozenset({"true", "yes"})
NOTHING: Final = frozenset(
    {"", "false", "no", "none", "nan", "n/a", "unknown", "undefined", "__undefined__"}
)
"""Values of an attribute that say nothing of a pedestrian."""
NO_CLASSES: Final = frozenset(
    {
        *("ignore", "ignored", "iscrowd", "is_crowd", "crowd", "difficult", "dontcare"),
        *("don't care", "score", "confidence", "conf", "occluded", "occlusion", "truncated"),
        *("visibility", "vis_ratio", "rotation", "keyframe", "outside", "source", "id"),
        *("track_id", "target_id", "instance_id", "tracking_id", "distance", "distance_m"),
        "detectability",
    }
)
"""Attributes that are about the box, and what readers use otherwise."""


def class_of(name: str, value: str) -> str:
    """Class that an attribute of an annotator stands for; empty: none.

    A switched-on one is called as the attribute, a choice as what was chosen; numbers are none.

    Examples
    --------
    >>> class_of("with_dog", "true"), class_of("age", "child"), class_of("shirt", "17")
    ('with_dog', 'child', '')
    """
    name, value = name.strip(), value.strip()
    lowered = value.casefold()
    if name.casefold() in NO_CLASSES or lowered in NOTHING:
        return ""
    if lowered in YES:
        return name
    try:
        float(value)
    except ValueError:
        return value
    return ""


def joined_classes(classes: Iterable[str]) -> str:
    """The classes of one box as one text, each once."""
    return CLASS_SEPARATOR.join(dict.fromkeys(name for name in classes if name))


def attributes_of_boxes(
    boxes: pd.DataFrame, texts: Any, missing: Collection[str] = ("",)
) -> pd.DataFrame | None:
    """The attributes of those boxes that have any; columns of `ATTRIBUTE_DTYPES`, each place once.

    Parameters
    ----------
    boxes
        Of a reading.
    texts
        One for each box.
    missing
        Texts that stand for none.
    """
    names = names_as_categories(texts, len(texts))
    is_given = ~names.isin(list(missing)) & ~names.isna()
    if not is_given.any():
        return None
    given = names[is_given].remove_unused_categories()
    table = boxes.loc[is_given, ["file", "line"]].assign(attributes=given)
    return table.drop_duplicates(["file", "line"], ignore_index=True)


def joined_attributes(tables: Sequence[pd.DataFrame | None]) -> pd.DataFrame | None:
    """The attributes of all files; None where none has any."""
    filled = [table for table in tables if table is not None]
    if not filled:
        return None
    texts = union_categoricals([table["attributes"] for table in filled])
    return pd.concat(filled, ignore_index=True).assign(attributes=texts)


def is_ambiguous(file: np.ndarray, line: np.ndarray, texts: np.ndarray) -> np.ndarray:
    """Rows whose line has boxes of different texts, so that a text is of nobody; bool, (n,).

    Parameters
    ----------
    file, line
        Of each row, int64, shape (n,).
    texts
        Object, shape (n,); empty where there is none.
    """
    place = pd.Series(pd.factorize(texts)[0]).groupby([file, line])
    differs: np.ndarray = (place.transform("min") != place.transform("max")).to_numpy()
    return differs
