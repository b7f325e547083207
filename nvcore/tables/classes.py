"""Confusion of classes: the truth's class against the system's, counted over matched boxes."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import NO_LABEL
from nvcore.metrics.matching import Matches, match_boxes
from nvcore.metrics.shares import Share, share_of
from nvcore.tables.column import CellKind, Column

CLASS_COLUMNS: Final[tuple[Column, ...]] = (
    Column("system", CellKind.TEXT, "", "Which system it is about: `x` or `y`."),
    Column("truth_class", CellKind.TEXT, "", "Class of the {many} in the truth."),
    Column(
        "read_class",
        CellKind.TEXT,
        "",
        "Class that the system gives the detections which match them.",
        empty="it gives none",
    ),
    Column("n", CellKind.INTEGER, "boxes", "{Many} of the one class matched as the other."),
)
"""Columns of `classes_table`."""


def has_classes(result: Result) -> bool:
    """Whether the truth has several classes and X or Y names some."""
    dataset = result.dataset
    truth = dataset.truth.label[~dataset.truth.ignore]
    return len(np.unique(truth[truth != NO_LABEL])) > 1 and any(
        names_classes(result, system) for _, system in result.sides
    )


def names_classes(result: Result, system: SystemResult) -> bool:
    """Whether any detection of the system has a class."""
    return bool((result.dataset.system(system.name).label != NO_LABEL).any())


def classes_table(result: Result) -> pd.DataFrame:
    """Count matched boxes by the truth's class and the class read, with columns `CLASS_COLUMNS`.

    Combinations without boxes have no row. Boxes are matched as usual, but only by place, whatever
    `match_class` says: the errors in this table are the matches that ``match_class="same"``
    removes. Pedestrians without a class, and systems that name none, have no row.
    """
    parts = [
        _rows(result, letter, system)
        for letter, system in result.sides
        if names_classes(result, system)
    ]
    empty = pd.DataFrame({column.name: pd.Series(dtype=object) for column in CLASS_COLUMNS})
    return pd.concat([empty, *parts], ignore_index=True).astype({"n": "int64"})


def read_share(table: pd.DataFrame, letter: str) -> Share:
    """Return the share of the matches of system "x" or "y" that have the truth's class.

    Parameters
    ----------
    table
        `classes_table`.
    """
    rows = table[table["system"] == letter]
    n = int(rows["n"].sum())
    n_right = int(rows["n"][rows["truth_class"] == rows["read_class"]].sum())
    return share_of(n_right, n)


def _rows(result: Result, letter: str, system: SystemResult) -> pd.DataFrame:
    dataset = result.dataset
    truth, detections = dataset.truth.label, dataset.system(system.name).label
    partner = matches_by_place(result, system).truth_det
    rows = np.flatnonzero((partner >= 0) & (truth != NO_LABEL))
    read = detections[partner[rows]]
    n_labels = len(dataset.labels)
    # a read NO_LABEL stands after all classes
    code = truth[rows].astype(np.int64) * (n_labels + 1) + np.where(read < 0, n_labels, read)
    pairs, counts = np.unique(code, return_counts=True)
    names = np.array([*dataset.labels, None], dtype=object)
    return pd.DataFrame(
        {
            "system": letter,
            "truth_class": names[pairs // (n_labels + 1)],
            "read_class": names[pairs % (n_labels + 1)],
            "n": counts,
        }
    )


def matches_by_place(result: Result, system: SystemResult) -> Matches:
    """Return the matches by place only, whatever `match_class` says."""
    if result.params.match_class == "any":
        return system.matches
    dataset = result.dataset
    return match_boxes(
        dataset.truth,
        dataset.system(system.name),
        dataset.frame_columns,
        replace(result.params, match_class="any"),
        threshold=system.threshold,
    )
