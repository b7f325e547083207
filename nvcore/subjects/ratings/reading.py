"""Reader of ratings: one row for each participant and clip."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.wording import fold_name
from nvcore.inputs.readers.parse.table import TextTable, parse_table

REQUIRED: Final = ("participant", "clip", "rating")
SYSTEM: Final = "system"
DELAY: Final = "delay_s"
"""Column with the seconds from a clip's end to its rating."""
MISSING: Final = ("na", "nan", "-", "\u2013")
RATINGS_FILE: Final = "ratings_simulated.csv"


def read_ratings(path: Path) -> pd.DataFrame:
    """Read ratings from a CSV file (see `parse_ratings`)."""
    return parse_ratings(path.read_bytes(), name=path.name)


def parse_ratings(content: bytes, *, name: str) -> pd.DataFrame:
    """Parse ratings from CSV text with participant, clip, rating, perhaps system and delay_s.

    Fields are separated by comma, semicolon or tab, whichever is most frequent in the first line.
    With semicolons, ratings may have a decimal comma.

    Parameters
    ----------
    content
        ``clip`` is the name of a recording, ``system`` the system whose boxes were shown. A higher
        rating means more annoying. An empty rating is missing. ``delay_s`` is the time from the
        clip's end to the rating, seconds; empty if unknown.
    name
        Name of the file, for messages.

    Returns
    -------
    Columns ``participant``, ``clip``, ``system`` (str; empty: unknown) and ``rating`` (float64;
    NaN: missing), in the file's order; ``delay_s`` (float64, NaN: unknown) if the file has it.
    Participant names that differ only in capitals or spaces are the same, by the first spelling.

    Raises
    ------
    FormatError
        If a column or a field is missing, a rating is not a number, a delay is not a number or
        below 0, the system is given for only some clips, or a participant rates a clip twice.
    """
    return check_ratings(parse_table(content, name=name, what="ratings", required=REQUIRED))


def check_ratings(table: TextTable) -> pd.DataFrame:
    """Check ratings from a table of text, see `parse_ratings`."""
    names = pd.Series(table.texts("participant"), dtype=str)
    names = names.groupby(names.map(fold_name), sort=False).transform("first")
    columns = ["participant", "clip"]
    if SYSTEM in table and (table.fields[SYSTEM] != "").any():  # named in all lines, or in none
        columns.append(SYSTEM)
    table = replace(table, fields=table.fields | {"participant": names.to_numpy(dtype=object)})
    ratings = pd.DataFrame({column: table.texts(column) for column in columns}, dtype=str)
    ratings = ratings.assign(**{SYSTEM: ratings.get(SYSTEM, "")}).astype(str)
    for column, low in (("rating", -np.inf), (DELAY, 0.0)):
        if column in table:
            texts = pd.Series(table.fields[column], dtype=object)
            texts = texts.mask(texts.str.lower().isin(MISSING), "")
            known = replace(table, fields={column: texts.to_numpy(dtype=object)})
            ratings[column] = known.numbers(column, low=low, may_be_empty=True)
    boxes = " with the boxes of {system}" if SYSTEM in columns else ""
    table.unique(columns, "{participant} rates the clip {clip}" + boxes + " a second time")
    return ratings
