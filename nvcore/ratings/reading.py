"""Reader of ratings: one row for each participant and clip."""

from __future__ import annotations

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
    """Ratings from a CSV file with the columns participant, clip, rating, and perhaps system.

    Parameters
    ----------
    path
        ``clip`` is the name of a recording; ``system`` the one whose boxes were shown. A higher
        rating means more annoying. An empty rating is a missing one.

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
        table = pd.read_csv(path, dtype=str, keep_default_na=False, nrows=MOST_ROWS + 1,
                            encoding="utf-8-sig", skipinitialspace=True)  # fmt: skip
    except (UnicodeDecodeError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        raise FormatError(f"this is no CSV table of ratings ({error})", file=path.name) from error
    table.columns = [str(name).strip().lower() for name in table.columns]
    lacking = [name for name in REQUIRED if name not in table]
    if lacking:
        raise FormatError(
            f"the columns {', '.join(REQUIRED)} are needed; {', '.join(lacking)} is missing, found "
            f"{', '.join(map(str, table.columns[:8]))}",
            file=path.name, line=1,
        )  # fmt: skip
    if len(table) > MOST_ROWS:
        raise FormatError(f"more than {MOST_ROWS:,} ratings", file=path.name)
    names = [*REQUIRED[:2], *([SYSTEM] if SYSTEM in table else [])]
    ratings = pd.DataFrame({name: table[name].str.strip().map(without_safeguard) for name in names})
    ratings[SYSTEM] = ratings.get(SYSTEM, "")
    ratings["rating"] = _numbers(table["rating"].str.strip(), path.name)
    _check(ratings, path.name)
    return ratings


def _numbers(text: pd.Series, file: str) -> np.ndarray:
    is_missing = text.str.lower().isin(MISSING)
    numbers = pd.to_numeric(text.where(~is_missing), errors="coerce").to_numpy(dtype=float)
    wrong = np.flatnonzero(~is_missing.to_numpy() & ~np.isfinite(numbers))
    if len(wrong):
        raise FormatError(
            f"a rating is a number, or empty where it is missing; found {text.iloc[wrong[0]]!r}",
            file=file, line=int(wrong[0]) + 2,
        )  # fmt: skip
    return numbers


def _check(ratings: pd.DataFrame, file: str) -> None:
    for name in REQUIRED[:2]:
        empty = np.flatnonzero((ratings[name] == "").to_numpy())
        if len(empty):
            raise FormatError(f"the {name} is empty", file=file, line=int(empty[0]) + 2)
    twice = np.flatnonzero(ratings.duplicated(["participant", "clip", SYSTEM]).to_numpy())
    if len(twice):
        row = ratings.iloc[twice[0]]
        shown = f" with the boxes of {row[SYSTEM]}" if row[SYSTEM] else ""
        raise FormatError(
            f"{row['participant']} rates the clip {row['clip']}{shown} a second time",
            file=file, line=int(twice[0]) + 2,
        )  # fmt: skip
