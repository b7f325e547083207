"""Reader of ratings: one row for each participant and clip."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.csvtext import without_safeguard
from nvcore.errors import FormatError

REQUIRED: Final = ("participant", "clip", "rating")
SYSTEM: Final = "system"
MOST_ROWS: Final = 1_000_000
MISSING: Final = frozenset({"", "na", "nan", "-", "\u2013"})


def read_ratings(path: Path) -> pd.DataFrame:
    """Ratings from a CSV file; see `parse_ratings`."""
    return parse_ratings(path.read_bytes(), name=path.name)


def parse_ratings(content: bytes, *, name: str) -> pd.DataFrame:
    """Ratings from CSV text with the columns participant, clip, rating, and perhaps system.

    Parameters
    ----------
    content
        ``clip`` is the name of a recording; ``system`` the one whose boxes were shown. A higher
        rating means more annoying. An empty rating is a missing one.
    name
        Of the file, for messages.

    Returns
    -------
    Columns ``participant``, ``clip``, ``system`` (str; empty: not said) and ``rating`` (float64;
    NaN: missing), in the file's order.

    Raises
    ------
    FormatError
        If a column is missing, a rating is no number, or a participant rates a clip twice.
    """
    try:
        table = pd.read_csv(BytesIO(content), dtype=str, keep_default_na=False, nrows=MOST_ROWS + 1,
                            encoding="utf-8-sig", skipinitialspace=True)  # fmt: skip
    except (UnicodeDecodeError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise FormatError(f"this is no CSV table of ratings ({error})", file=name) from error
    return check_ratings(table, name=name, first_line=2)


def check_ratings(table: pd.DataFrame, *, name: str, first_line: int = 1) -> pd.DataFrame:
    """Ratings from a table of text; else as `parse_ratings`.

    Parameters
    ----------
    first_line
        Number of the first row, for messages.
    """
    table = table.set_axis([str(column).strip().lower() for column in table.columns], axis=1)
    lacking = [column for column in REQUIRED if column not in table]
    if lacking:
        raise FormatError(
            f"the columns {', '.join(REQUIRED)} are needed; {', '.join(lacking)} is missing, found "
            f"{', '.join(map(str, table.columns[:8]))}",
            file=name, line=1,
        )  # fmt: skip
    if twice := [column for column in (*REQUIRED, SYSTEM) if (table.columns == column).sum() > 1]:
        raise FormatError(f"there are several columns {twice[0]}", file=name, line=1)
    if len(table) > MOST_ROWS:
        raise FormatError(f"more than {MOST_ROWS:,} ratings", file=name)
    texts = [*REQUIRED[:2], *([SYSTEM] if SYSTEM in table else [])]
    ratings = pd.DataFrame(
        {column: table[column].str.strip().map(without_safeguard) for column in texts}
    )
    ratings[SYSTEM] = ratings.get(SYSTEM, "")
    ratings["rating"] = _numbers(table["rating"].str.strip(), name, first_line)
    _check(ratings, name, first_line)
    return ratings


def _numbers(text: pd.Series, file: str, first_line: int) -> np.ndarray:
    is_missing = text.str.lower().isin(MISSING)
    numbers = pd.to_numeric(text.where(~is_missing), errors="coerce").to_numpy(dtype=float)
    wrong = np.flatnonzero(~is_missing.to_numpy() & ~np.isfinite(numbers))
    if len(wrong):
        raise FormatError(
            f"a rating is a number, or empty where it is missing; found {text.iloc[wrong[0]]!r}",
            file=file, line=int(wrong[0]) + first_line,
        )  # fmt: skip
    return numbers


def _check(ratings: pd.DataFrame, file: str, first_line: int) -> None:
    for name in REQUIRED[:2]:
        empty = np.flatnonzero((ratings[name] == "").to_numpy())
        if len(empty):
            raise FormatError(f"the {name} is empty", file=file, line=int(empty[0]) + first_line)
    twice = np.flatnonzero(ratings.duplicated(["participant", "clip", SYSTEM]).to_numpy())
    if len(twice):
        row = ratings.iloc[twice[0]]
        shown = f" with the boxes of {row[SYSTEM]}" if row[SYSTEM] else ""
        raise FormatError(
            f"{row['participant']} rates the clip {row['clip']}{shown} a second time",
            file=file, line=int(twice[0]) + first_line,
        )  # fmt: skip
