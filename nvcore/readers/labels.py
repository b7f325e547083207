"""Labels of formats that leave them to the annotator (CVAT, Pascal VOC, YOLO with names)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np
import pandas as pd

from nvcore.readers.base import ReadOptions
from nvcore.readers.classes import ClassRule

COUNTED: Final = ("pedestrian", "person")
"""Labels that are pedestrians, unless the classes are named."""
IGNORED: Final = ("people", "cyclist", "rider", "person?", "ignore", "dontcare")
"""Labels of what looks like a pedestrian: detecting it is neither right nor wrong."""
_MAX_NAMED: Final = 8


def free_labels(found: Iterable[str], options: ReadOptions) -> ClassRule:
    """The rule for labels that annotators chose: any other label is known and left out.

    Where the classes are named, the usual pedestrian labels that are not among them are ignore
    regions.

    Parameters
    ----------
    found
        Labels in the files, used or only declared.
    options
        `classes` is used.
    """
    counted: tuple[str, ...] = COUNTED
    ignored: tuple[str, ...] = IGNORED
    if options.classes is not None:
        counted, ignored = (), COUNTED + IGNORED
    usual = {name.casefold() for name in COUNTED + IGNORED}
    others = {name for name in found if name.casefold() not in usual}
    return ClassRule(counted=counted, ignored=ignored, left_out=tuple(sorted(others)))


def concerns_pedestrians(label: str, options: ReadOptions) -> bool:
    """Whether boxes of the label are counted or ignored."""
    names = COUNTED + IGNORED + (options.classes or ())
    return label.casefold() in {name.casefold() for name in names}


def left_out(label: np.ndarray, keep: np.ndarray) -> str:
    """The labels that were left out with their numbers of boxes, in words; empty for none.

    Parameters
    ----------
    label
        Label of each box, object, shape (n,).
    keep
        Whether it stays, bool, shape (n,).
    """
    counts = pd.Series(label[~keep], dtype=object).value_counts()
    if counts.empty:
        return ""
    counts = counts.sort_index().sort_values(ascending=False, kind="stable")
    named = [f"{name} ({n})" for name, n in counts.iloc[:_MAX_NAMED].items()]
    if len(counts) > _MAX_NAMED:
        rest = counts.iloc[_MAX_NAMED:]
        named.append(f"{len(rest)} more labels ({rest.sum()})")
    return f"left out: {', '.join(named)}"
