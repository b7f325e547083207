"""Data page: the same table before opening, with what is proposed where the files do not say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.errors import InputError
from nvcore.inputs.session import RecordingEntry
from ui.data.file_check import FileCheck
from ui.data.missing_inputs import MissingInputs
from ui.data.recordings.edited import blank, changes_in, filled
from ui.data.recordings.editor import edit
from ui.widgets.text import plain

COLUMNS: Final = (
    "name",
    "width",
    "height",
    "fps",
    "context",
    "speed_kmh",
    "horizon",
    "tags",
    "unit",
)


@dataclass(frozen=True)
class TypedRecordings:
    """What a person typed of recordings that are not open yet, by name; or why it cannot be."""

    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    trouble: str = ""


def draw(
    place: str,
    truth: FileCheck | None,
    rows: Mapping[str, RecordingEntry],
    facts: MissingInputs,
    sizes: Mapping[str, tuple[int, int]],
) -> TypedRecordings:
    """The table of several recordings of which the files do not say all.

    Parameters
    ----------
    place
        Part of the page.
    truth
        What the files of the ground truth are.
    rows
        Of a table of recordings that was sent.
    facts
        What was filled in for all of them.
    sizes
        Where their boxes end, if that differs.
    """
    if truth is None or truth.reading is None or len(truth.recordings) < 2:
        return TypedRecordings()
    proposed = propose(truth, rows, facts, sizes)
    with st.expander("Size, frame rate and tags by recording", expanded=bool(sizes)):
        st.caption("As proposed; click a cell to change it. Empty: nothing is known.")
        key = f"recordings_{place}_{hash(tuple(truth.recordings))}"
        after = edit(proposed, key=key, columns=COLUMNS, disabled=("name",))
        try:
            return TypedRecordings(changes_in(proposed, after, {}))
        except InputError as error:
            st.error(plain(error), icon=":material/error:")
            return TypedRecordings(
                trouble="The table of the recordings cannot be used: the reason stands below it."
            )


def propose(
    truth: FileCheck,
    rows: Mapping[str, RecordingEntry],
    facts: MissingInputs,
    sizes: Mapping[str, tuple[int, int]],
) -> pd.DataFrame:
    """What is going to be used of each: by its files, its row, its boxes' edge, or as for all."""
    assert truth.reading is not None
    table = blank(truth.recordings)
    for name in ("width", "height", "fps"):
        table[name] = truth.reading.recordings[name].to_numpy(dtype=float)
    known = {name: replace(row, title=None) for name, row in rows.items()}
    table, _ = filled(table, {name: known[name] for name in truth.recordings if name in known})
    for number, name in enumerate(("width", "height")):
        edges = {recording: float(size[number]) for recording, size in sizes.items()}
        of_all = np.nan if facts.size is None else float(facts.size[number])
        table[name] = table[name].fillna(table["name"].map(edges)).fillna(of_all)
    table["fps"] = table["fps"].fillna(np.nan if facts.fps is None else facts.fps)
    return table
