"""Read tables of groups: values of persons or drives by condition, or means, SD and n."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.common.arguments.groups import GroupArguments, Scale
from nvcore.common.errors import InputError, ParameterError
from nvcore.common.wording import did_you_mean, fold_name, listed
from nvcore.inputs.readers.parse.table import TextTable, parse_table, read_table
from nvcore.inputs.readers.parse.text import number_of
from nvcore.notes import Note

SUMMARY: Final = ("n", "mean", "sd")
"""Columns beside ``condition`` that identify a table of means and SD."""
LABELS: Final = ("participant", "condition", "kind", "run", "trial", "order")
"""Columns that are never the measure."""
TIME_UNITS: Final = ("_s", "_ms", "_min")
MOST_COUNT: Final = 99
"""Largest integer that is taken for a count. Larger ones are measurements."""
MOST_CONDITIONS: Final = 10
"""Maximum number of conditions. More have 55 or more pairs, too many to read."""
MOST_ROWS: Final = 10_000
LARGEST: Final = 1e12
"""Largest number. Squares of larger ones leave no precision for small ones."""


class GroupTable(NamedTuple):
    """Table of groups as read: values by person or drive, or summaries.

    Attributes
    ----------
    rows
        ``participant`` ("" if missing), ``condition`` and ``value``, in file order; or of summaries
        ``condition``, ``n``, ``mean`` and ``sd`` (NaN for n = 1) as typed in.
    measure, scale
        The compared column (empty: summaries), and the kind of its numbers.
    notes
        Notes on the input and its conversion.
    """

    rows: pd.DataFrame
    measure: str
    scale: Scale
    notes: tuple[Note, ...]

    @property
    def conditions(self) -> list[str]:
        """Conditions in the order of the file."""
        return [*self.rows["condition"].unique()]


def read_groups(asked: GroupArguments, text: TextTable | None = None) -> GroupTable:
    """Read values, or means and SD, depending on the columns of the table.

    Values: ``condition``, the measure, and if known ``participant``. A drive may have a row for
    each ``kind`` of counted objects: counts of one participant, condition and ``run`` (if the
    column exists) are added. An empty value is missing. Participant names that differ in capitals
    or spaces only are the same. Summaries: ``condition,n,mean,sd``.

    Parameters
    ----------
    text
        The table if already read. None: read that of `asked`.

    Raises
    ------
    InputError
        If the table cannot be used, with file and line.
    ParameterError
        If there is no such column, condition, participant or kind.
    """
    if text is not None:
        return _read(text, asked)
    if not isinstance(asked.table, pd.DataFrame):
        text = read_table(Path(asked.table), what="groups", required=["condition"])
        return _read(text, asked)
    content = BytesIO()
    asked.table.to_csv(content, index=False)
    try:
        text = parse_table(content.getvalue(), name="table", what="groups", required=["condition"])
        return _read(replace(text, lines=np.arange(len(text)) + 2), asked)
    except InputError as error:  # rows of a table count from 0, but the header is line 1
        where = f", row {error.line - 2}" if error.line is not None and error.line > 1 else ""
        raise InputError(error.message, file=f"table{where}") from error


def _read(text: TextTable, asked: GroupArguments) -> GroupTable:
    if not 0 < len(text) <= MOST_ROWS:
        found = f"expected 1 to {MOST_ROWS:,} rows below the header, found {len(text):,}"
        raise InputError(found, file=text.name)
    is_summary = asked.measure is None and all(name in text for name in SUMMARY)
    read = _summaries(text, asked) if is_summary else _values(text, asked)
    if len(read.conditions) > MOST_CONDITIONS:
        found = f"expected {MOST_CONDITIONS} conditions at most, found {len(read.conditions):,}"
        raise InputError(found, file=text.name)
    return read


def _summaries(text: TextTable, asked: GroupArguments) -> GroupTable:
    for name in ("scale", "kind", "rename", "leave_out"):
        if getattr(asked, name):
            raise ParameterError(f"{name}: is about values, and these are means and SD")
    n = text.whole_numbers("n", low=1)
    sd = text.numbers("sd", low=0, high=LARGEST, may_be_empty=True)
    is_alone = n == 1
    if (lacking := np.isnan(sd) & ~is_alone).any():
        raise text.fault(int(np.argmax(lacking)), "sd is empty, which it is for n = 1 alone")
    text.unique(["condition"], "the condition {condition} is there a second time")
    table = pd.DataFrame({"condition": text.texts("condition"), "n": n})
    table = table.assign(
        mean=text.numbers("mean", low=-LARGEST, high=LARGEST), sd=np.where(is_alone, np.nan, sd)
    )
    return GroupTable(table, "", "numbers", (Note("groups.summaries", n_conditions=len(table)),))


def _values(text: TextTable, asked: GroupArguments) -> GroupTable:
    measure, others = _measure(text, asked.measure)
    value = text.numbers(measure, low=-LARGEST, high=LARGEST, may_be_empty=True)
    scale = asked.scale or _scale_of(measure, value)
    is_wrong = np.zeros(len(text), dtype=bool)
    if scale == "times":
        is_wrong = value <= 0
    elif scale == "counts":
        is_wrong = (value < 0) | (value % 1 > 0)
    if is_wrong.any():
        expected = "a time above 0" if scale == "times" else "a count, a whole number from 0"
        row = int(np.argmax(is_wrong))
        raise text.fault(row, f"{measure}: expected {expected}, found {value[row]:g}")
    rows = pd.DataFrame({"participant": "", "condition": text.texts("condition"), "value": value})
    if "participant" in text:
        names = pd.Series(text.texts("participant"))
        rows["participant"] = names.groupby(names.map(fold_name)).transform("first")
    notes = [Note("groups.not_chosen", names=others)] if others else []
    if "kind" in text and scale == "counts":
        n_rows = len(rows)
        rows = _drives(text, rows, asked.kind)
        if len(rows) < n_rows:
            notes.append(Note("groups.joined", n=n_rows - len(rows)))
    elif asked.kind is not None:
        raise ParameterError("kind: expected counts, with a column kind")
    rows, done = _chosen(rows, asked)
    is_missing = rows["value"].isna()
    if is_missing.any():
        notes.append(Note("groups.missing", n=int(is_missing.sum())))
    rows = rows[~is_missing].reset_index(drop=True)
    first = Note(
        "groups.values",
        n=len(rows),
        measure=measure,
        n_conditions=rows["condition"].nunique(),
        scale=scale,
    )
    return GroupTable(rows, measure, scale, (first, *notes, *done))


def _measure(text: TextTable, wanted: str | None) -> tuple[str, tuple[str, ...]]:
    """Choose the column to compare, and list the other columns of numbers."""
    columns = [column for column in text.fields if column not in LABELS]
    if wanted is not None:
        return _known([wanted.strip().lower()], columns, "measure")[0], ()

    def has_numbers(column: str) -> bool:
        first = next((field for field in text.fields[column] if field), "")
        return number_of(first.replace(",", ".") if text.has_decimal_comma else first) is not None

    columns = [column for column in columns if has_numbers(column)]
    if not columns:
        expected = "expected participant,condition,value or condition,n,mean,sd"
        raise InputError(f"no column has numbers to compare; {expected}", file=text.name, line=1)
    chosen = "value" if "value" in columns else columns[0]
    return chosen, tuple(column for column in columns if column != chosen)


def _scale_of(measure: str, value: np.ndarray) -> Scale:
    """Classify numbers as times, counts or others by their column's name and their values."""
    if measure.endswith(TIME_UNITS):
        return "times"
    known = value[~np.isnan(value)]
    is_count = (known >= 0) & (known <= MOST_COUNT) & (known % 1 == 0)
    return "counts" if len(known) and is_count.all() else "numbers"


def _drives(text: TextTable, rows: pd.DataFrame, kind: str | None) -> pd.DataFrame:
    """Sum the counts of each drive over all kinds of objects, or take one kind only."""
    kinds = pd.Series(text.fields["kind"])
    if kind is not None:  # a person who drove without any of this kind has a count of 0
        is_meant = kinds == _known([kind], kinds, "kind")[0]
        rows = rows.assign(value=rows["value"].where(is_meant, 0.0))
    run = text.fields["run"] if "run" in text else np.full(len(text), "")
    key = ["participant", "condition", "run"]
    if "participant" not in text and "run" not in text:
        return rows  # nothing tells the rows of one drive
    rows = rows.assign(run=run, kind=kinds)
    if (twice := rows.duplicated([*key, "kind"]).to_numpy()).any():
        message = "this drive has a row of this kind already; number drives in a column run"
        raise text.fault(int(np.argmax(twice)), message)
    drives = rows.groupby(key, sort=False)["value"]
    return drives.agg(lambda counts: counts.sum(skipna=False)).reset_index()


def _chosen(rows: pd.DataFrame, asked: GroupArguments) -> tuple[pd.DataFrame, list[Note]]:
    """Select rows and rename conditions as asked, and return notes on the changes."""
    notes = []
    rename: Mapping[str, str] = asked.rename or {}
    _known(rename, rows["condition"], "rename")
    folded = {fold_name(name): name for name in rows["participant"]}
    gone = [folded[name] for name in _known(map(fold_name, asked.leave_out), folded, "leave_out")]
    dropped = [condition for condition, name in rename.items() if not name]
    if gone or dropped:
        notes.append(Note("groups.left_out", names=[*dropped, *gone]))
    rows = rows[~rows["participant"].isin(gone) & ~rows["condition"].isin(dropped)]
    for name in dict.fromkeys(name for name in rename.values() if name):
        own = [condition for condition, new in rename.items() if new == name]
        notes.append(Note("groups.renamed", names=own, name=name))
    return rows.assign(condition=rows["condition"].replace(dict(rename))), notes


def _known(names: Iterable[str], known: Iterable[str], argument: str) -> Sequence[str]:
    """Return the names if all of them are known.

    Raises
    ------
    ParameterError
        If one is not.
    """
    there, asked = [*dict.fromkeys(known)], [*names]
    for name in asked:
        if name not in there:
            choice = f"there is {listed(there, most=12) or 'none'}"
            raise ParameterError(f"{argument}: no {name!r}; {did_you_mean(name, there, choice)}")
    return asked
