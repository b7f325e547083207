"""Reader of ratings: one row for each participant and clip."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.errors import FormatError
from nvcore.inputs.readers.parse.table import read_rows
from nvcore.output.csv_text import without_safeguard
from nvcore.people.participants import fold_name

REQUIRED: Final = ("participant", "clip", "rating")
SYSTEM: Final = "system"
DELAY: Final = "delay_s"
"""Column with the seconds from a clip's end to its rating."""
MISSING: Final = frozenset({"", "na", "nan", "-", "\u2013"})


def read_ratings(path: Path) -> pd.DataFrame:
    """Ratings from a CSV file; see `parse_ratings`."""
    return parse_ratings(path.read_bytes(), name=path.name)


def parse_ratings(content: bytes, *, name: str) -> pd.DataFrame:
    """Ratings from CSV text with the columns participant, clip, rating, perhaps system and delay_s.

    Fields are separated by comma, semicolon or tab, whichever is commonest in the first line. With
    semicolons, ratings may have a decimal comma.

    Parameters
    ----------
    content
        ``clip`` is the name of a recording; ``system`` the one whose boxes were shown. A higher
        rating means more annoying. An empty rating is a missing one. ``delay_s`` is the time from
        the clip's end to the rating, seconds; empty: not known.
    name
        Name of the file, for messages.

    Returns
    -------
    Columns ``participant``, ``clip``, ``system`` (str; empty: unknown) and ``rating`` (float64;
    NaN: missing), in the file's order; ``delay_s`` (float64, NaN: not known) if the file has it.
    Participants whose names differ in capitals or spaces only
    are one, by the first spelling.

    Raises
    ------
    FormatError
        If a column or a field is missing, a rating is no number, a delay is none or below 0, the
        system is given for some clips only, or a participant rates a clip twice.
    """
    rows, lines, separator = read_rows(content, name=name, what="ratings")
    table = pd.DataFrame(rows[1:], columns=rows[0], dtype=object)
    return check_ratings(table, name=name, lines=lines[1:], has_decimal_comma=separator == ";")


def check_ratings(
    table: pd.DataFrame,
    *,
    name: str,
    lines: np.ndarray | None = None,
    has_decimal_comma: bool = False,
) -> pd.DataFrame:
    """Ratings from a table of text, otherwise like `parse_ratings`.

    Parameters
    ----------
    lines
        Number of each row, for messages; None: from 1.
    """
    table = table.set_axis([str(column).strip().lower() for column in table.columns], axis=1)
    absent = [column for column in REQUIRED if column not in table]
    if absent:
        raise FormatError(
            f"the columns {', '.join(REQUIRED)} are needed, separated by commas, semicolons or "
            f"tabs; {', '.join(absent)} is missing, found "
            f"{', '.join(map(str, table.columns[:8]))}",
            file=name,
            line=1,
        )
    known = (*REQUIRED, SYSTEM, DELAY)
    if twice := [column for column in known if (table.columns == column).sum() > 1]:
        raise FormatError(f"there are several columns {twice[0]}", file=name, line=1)
    line = np.arange(1, len(table) + 1) if lines is None else lines
    texts = [*REQUIRED[:2], *([SYSTEM] if SYSTEM in table else [])]
    ratings = pd.DataFrame(
        {column: table[column].astype(str).str.strip().map(without_safeguard) for column in texts}
    ).astype(str)
    ratings[SYSTEM] = ratings.get(SYSTEM, pd.Series("", index=ratings.index, dtype=str))
    ratings["participant"] = _one_spelling(ratings["participant"])
    for column, what in (("rating", "a rating"), (DELAY, "a delay, in seconds,")):
        if column in table:
            text = table[column].astype(str).str.strip()
            text = text.str.replace(",", ".") if has_decimal_comma else text
            ratings[column] = _numbers(text, name, line, what=what)
    _check(ratings, name, line)
    return ratings


def _one_spelling(names: pd.Series) -> pd.Series:
    """Every name as it is first spelt."""
    first = names.groupby(names.map(fold_name), sort=False).transform("first")
    return first.where(names != "", names)


def _numbers(text: pd.Series, file: str, line: np.ndarray, *, what: str) -> np.ndarray:
    is_missing = text.str.lower().isin(MISSING)
    numbers = pd.to_numeric(text.where(~is_missing), errors="coerce").to_numpy(dtype=float)
    wrong = np.flatnonzero(~is_missing.to_numpy() & ~np.isfinite(numbers))
    if len(wrong):
        raise FormatError(
            f"{what} is a number, or empty where it is missing; found {text.iloc[wrong[0]]!r}",
            file=file,
            line=int(line[wrong[0]]),
        )
    return numbers


def _check(ratings: pd.DataFrame, file: str, line: np.ndarray) -> None:
    for name in REQUIRED[:2]:
        empty = np.flatnonzero((ratings[name] == "").to_numpy())
        if len(empty):
            raise FormatError(f"the {name} is empty", file=file, line=int(line[empty[0]]))
    if DELAY in ratings:
        early = np.flatnonzero((ratings[DELAY] < 0).to_numpy())
        if len(early):
            raise FormatError(
                f"a rating comes after the clip's end: {DELAY} is "
                f"{ratings[DELAY].iloc[early[0]]:g}, expected 0 or more",
                file=file,
                line=int(line[early[0]]),
            )
    is_silent = (ratings[SYSTEM] == "").to_numpy()
    if is_silent.any() and not is_silent.all():
        raise FormatError(
            "the system is empty, while other lines name it: name it in all or in none",
            file=file,
            line=int(line[np.argmax(is_silent)]),
        )
    twice = np.flatnonzero(ratings.duplicated(["participant", "clip", SYSTEM]).to_numpy())
    if len(twice):
        row = ratings.iloc[twice[0]]
        with_boxes = f" with the boxes of {row[SYSTEM]}" if row[SYSTEM] else ""
        raise FormatError(
            f"{row['participant']} rates the clip {row['clip']}{with_boxes} a second time",
            file=file,
            line=int(line[twice[0]]),
        )


RATINGS_FILE: Final = "ratings_simulated.csv"
