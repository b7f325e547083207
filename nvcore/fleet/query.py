"""The worst rows of a scan's results, chosen by a filter that is parsed and never run as SQL.

DuckDB has the tables as data sets of Arrow (the Parquet files that their Delta logs list), opens
no file by itself and loads no extension. A filter becomes a tree of DuckDB's expressions, each part
of which is an operation that is known here, a column that is there, or a constant.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, Final

import duckdb
import pandas as pd
import pyarrow as pa
import sqlglot
from duckdb import CaseExpression, Expression
from duckdb import ColumnExpression as Column
from duckdb import ConstantExpression as Constant
from duckdb import FunctionExpression as Function
from duckdb import LambdaExpression as Lambda
from sqlglot import exp
from sqlglot.errors import SqlglotError

from nvcore.errors import InputError
from nvcore.fleet.folder import SUMMARY, has_tables, plan_shown, table_of
from nvcore.fleet.location import LONGEST_REASON, Location
from nvcore.fleet.plan import Plan
from nvcore.tables.columns import report_columns
from nvcore.wording import aligned, did_you_mean, listed, number, one_line, shortened

MOMENTS: Final[Mapping[str, tuple[str, str, str, str]]] = {
    "encounters": ("severity", "shown_frame", "shown_frame", "shown_s"),
    "events": ("saliency", "first_frame", "first_frame", "start_s"),
    "intervals": ("depth", "worst_frame", "first_frame", "start_s"),
    "episodes": ("duration", "first_frame", "first_frame", "start_s"),
    "recordings": ("severity", "", "", ""),
    "frames": ("similarity", "frame", "frame", "time_s"),
}
"""By table of results: what is worst in it, by default; the frame to look at (empty: none); a frame
whose time is known, and the column of that."""

LONGEST_FILTER: Final = 10_000
MOST_NAMED: Final = 12
"""Columns that an error names."""
TAG: Final = "tag"
OF_RECORDING: Final = "recording"
"""Before the dot, where a column is that of the recordings though the table has one, too."""

NUMBER, TEXT, CLAIM, LIST = "a number", "a text", "true or false", "a list"
_UNIT: Final = r"_(s|px|m|kmh)(?=_[xy]$|$)"
_NUMBER: Final = r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?"

_COMPARISONS: Final[Mapping[type, Callable[[Any, Any], Expression]]] = {
    exp.EQ: operator.eq,
    exp.NEQ: operator.ne,
    exp.GT: operator.gt,
    exp.GTE: operator.ge,
    exp.LT: operator.lt,
    exp.LTE: operator.le,
}
_ARGUMENTS: Final[Mapping[type, Collection[str]]] = {
    **dict.fromkeys((exp.And, exp.Or, exp.Is, *_COMPARISONS), ("this", "expression")),
    **dict.fromkeys((exp.Like, exp.ILike), ("this", "expression", "negate")),
    **dict.fromkeys((exp.Not, exp.Paren, exp.Neg, exp.Boolean), ("this",)),
    exp.Null: (),
    exp.In: ("this", "expressions"),
    exp.Between: ("this", "low", "high"),
    exp.Literal: ("this", "is_string"),
    exp.Column: ("this", "table"),
    exp.Identifier: ("this", "quoted"),
}
"""All that a filter may consist of: the nodes, and what each of them may have."""


@dataclass(frozen=True, eq=False)
class Top:
    """The worst rows of a table of results.

    Attributes
    ----------
    table
        The worst first: recording; the frame to look at and its time_s, where the table is not
        that of the recordings; the other columns of the table.
    by
        Columns that it is sorted by; of both systems by the worse.
    results
        Where the table is from.
    """

    table: pd.DataFrame
    by: tuple[str, ...]
    results: str

    def __str__(self) -> str:
        return "\n".join(aligned(self.cells())) if len(self.table) else "no row fits"

    @property
    def frames(self) -> list[int | None]:
        """Frame to look at of each row; None: the table has none."""
        if "frame" not in self.table:
            return [None] * len(self.table)
        return [None if pd.isna(frame) else int(frame) for frame in self.table["frame"]]

    def cells(self) -> list[tuple[str, ...]]:
        """What it shows, as cells of text; names of columns first."""
        forms = {"frame": "d", "time_s": ".2f", **dict.fromkeys(self.by, ".4g"), "track": "d"}
        names = ["recording", *forms, "system", "category"]
        names = [name for name in dict.fromkeys(names) if name in self.table]
        shown = self.table[names].astype(object).where(self.table[names].notna(), None)
        rows = [
            [
                number(value, forms[name]) if name in forms else one_line(str(value))
                for name, value in zip(names, row, strict=True)
            ]
            for row in shown.itertuples(index=False)
        ]
        return [tuple(names), *map(tuple, rows)]


def worst(
    results: Location,
    table: str = "encounters",
    *,
    by: str | None = None,
    where: str = "",
    n: int = 20,
    is_reversed: bool = False,
) -> Top:
    """The worst rows of a table of a scan's results.

    Parameters
    ----------
    results
        Where the scan has written.
    table
        One of `MOMENTS`.
    by
        A column, with or without its unit and the letter of a system: ``severity`` is the larger of
        ``severity_s_x`` and ``severity_s_y``; None: by default of the table.
    where
        See `Filter`; empty: all rows.
    n
        Largest number of rows. Of equal ones those come first whose recording does, by its name.
    is_reversed
        Whether the best come first.

    Raises
    ------
    InputError
        If there are no results, no such table or column, or the filter cannot be used.
    """
    its_plan = plan_shown(results)
    rows = _dataset(results, table, its_plan)
    recordings = rows if table == "recordings" else _dataset(results, "recordings", its_plan)
    own = dict(zip(rows.schema.names, rows.schema.types, strict=True))
    of_recordings = dict(zip(recordings.schema.names, recordings.schema.types, strict=True))
    usual, frame, timed, time_s = MOMENTS[table]
    columns = _columns_by(by or usual, own)
    filtered = Filter(where, own, of_recordings) if where.strip() else None
    asked = ["recording", *dict.fromkeys(["fps", *(filtered.asks if filtered else ())])]
    with duckdb.connect(":memory:", config=_CONFINED) as connection:
        facts = connection.from_arrow(recordings).project(
            *(Column(name).alias(f"{OF_RECORDING}.{name}") for name in asked)
        )
        if filtered is not None:
            _check_keys(filtered.keys, facts)
        recording = Column("recording")
        chosen = connection.from_arrow(rows).join(
            facts, recording == Column(f"{OF_RECORDING}.recording"), "left"
        )
        if filtered is not None:
            chosen = chosen.filter(filtered.expression)
        is_low_better = _is_low_better(table, columns[0])
        worse = "greatest" if is_low_better else "least"
        value = Column(columns[0])
        if len(columns) > 1:
            value = Function(worse, *map(Column, columns))
        order = value.desc() if is_low_better != is_reversed else value.asc()
        ties = [Column(name) for name in ("recording", timed, "track", "system") if name in own]
        chosen = chosen.filter(value.isnotnull()).sort(order, *ties).limit(n)
        try:
            answer = chosen.to_arrow_table()
        except duckdb.Error as error:
            reason = one_line(shortened(str(error), LONGEST_REASON))
            raise InputError(f"cannot be asked ({reason})", file=results.uri) from error
    found = answer.to_pandas(types_mapper={pa.int64(): pd.Int64Dtype()}.get)
    moments = {"recording": found.pop("recording")}
    if frame:
        moments["frame"] = found[frame]
        moments["time_s"] = found[time_s] + (found[frame] - found[timed]) / found["recording.fps"]
    left = found.drop(columns=[name for name in found if name in moments or "." in name])
    return Top(pd.concat([pd.DataFrame(moments), left], axis=1), columns, results.uri)


def results_in(location: Location) -> Location:
    """Where results of a scan are: there, or in the one folder below that has some.

    Raises
    ------
    InputError
        If there are none, or several.
    """
    if has_tables(location):
        return location
    paths = [entry.path.rpartition("/") for entry in location.list()]
    folders = [folder for folder, _, name in paths if name == SUMMARY]
    if len(folders) != 1:
        parts = {folder.partition("/")[0] for folder, _, _ in paths}
        names = listed(folders, most=MOST_NAMED) if folders else "none"
        if not folders and "plans" in parts:
            names = "one that is not finished; run it again to go on"
        elif not folders and "sources" in parts:
            names = "a store; scan it first"
        raise InputError(
            f"expected results of a scan that is finished, found {names}", file=location.uri
        )
    return location.child(folders[0])


_CONFINED: Final[dict[str, Any]] = {
    "autoinstall_known_extensions": "false",
    "autoload_known_extensions": "false",
    "enable_external_access": "false",
}


def _dataset(results: Location, table: str, its_plan: Plan | None) -> Any:
    """Open a table of the results as a data set of Arrow, of verified files."""
    if table not in MOMENTS:
        raise InputError(did_you_mean(table, MOMENTS, f"the tables are {listed([*MOMENTS])}"))
    if its_plan is None or not (
        has_tables(results) and (table != "frames" or its_plan.params.frames)
    ):
        raise InputError(
            "there is no such table of results; is the scan finished, and was it asked for?",
            file=results.child(table).uri,
        )
    return table_of(results, its_plan, table)


def _columns_by(name: str, own: Mapping[str, pa.DataType]) -> tuple[str, ...]:
    """Columns that a name means: itself, or without its unit, or those of both systems."""
    known: dict[str, tuple[str, ...]] = {}
    numbers = [column for column, of in own.items() if _kind(of) == NUMBER]
    for column in numbers:
        pair = column, f"{column[:-2]}_y"
        if column.endswith("_x") and pair[1] in own:
            known |= dict.fromkeys((column[:-2], re.sub(_UNIT, "", column[:-2])), pair)
    for column in numbers:
        known |= dict.fromkeys((re.sub(_UNIT, "", column), column), (column,))
    if name not in known:
        names = listed([*dict.fromkeys(known)], most=MOST_NAMED)
        raise InputError(
            f"there is no column of numbers {one_line(shortened(name, 60))}; "
            f"{did_you_mean(name, known, f'there are {names}')}"
        )
    return known[name]


def _is_low_better(table: str, column: str) -> bool:
    """Whether large values are bad; so is of what is neither good nor bad the most."""
    better = {of.name: of.better for of in report_columns().get(f"{table}.csv", ())}
    return better.get(column.removeprefix("sum_")) != "high"


def _check_keys(keys: Collection[str], facts: duckdb.DuckDBPyRelation) -> None:
    """Refuse keys of tags that no recording has: one that is misspelt would give no rows."""
    if not keys:
        return
    tags = Function("unnest", Column(f"{OF_RECORDING}.tags")).alias("tag")
    rows = facts.project(tags).distinct().fetchall()
    known = sorted({str(tag).partition("=")[0] for (tag,) in rows})
    for key in keys:
        if key not in known:
            names = f"the tags are {listed(known, most=MOST_NAMED)}" if known else "there are none"
            raise _fault(
                f"no recording has a tag {one_line(shortened(key, 60))}; "
                f"{did_you_mean(key, known, names)}"
            )


@dataclass(frozen=True)
class _Term:
    """A column, a tag or a constant: what it is, and the expression of it.

    Of a tag `key` is the key, and it becomes what it is compared with: a text, a number, a claim.
    """

    kind: str
    expression: Expression
    shown: str
    key: str | None = None

    def taken_as(self, kind: str) -> Expression:
        if self.key is None or kind == TEXT:
            return self.expression
        if kind == NUMBER:
            is_number = Function("regexp_full_match", self.expression, Constant(_NUMBER))
            return CaseExpression(is_number, self.expression.cast(duckdb.sqltypes.DOUBLE))
        tags, key = Column(f"{OF_RECORDING}.tags"), Constant(self.key)
        return Function("list_contains", tags, key) | self.expression.isnotnull()


class Filter:
    """A condition on the rows of a table, and what of the recordings it asks for.

    Parameters
    ----------
    text
        Such as ``tag.road = 'rural' and n_frames > 10``: ``and``, ``or``, ``not``, comparisons,
        ``in``, ``between``, ``like``, ``is null``, numbers, texts in single quotes, columns.
        ``tag.night`` are recordings with the tag ``night``, ``tag.road`` is the text behind
        ``road=`` in a tag, ``recording.n_frames`` the column of the recordings.
    own, of_recordings
        Names and types of the columns of the table, and of those of the recordings.

    Attributes
    ----------
    expression
        For DuckDB, of which columns of the recordings are named ``recording.<column>``.
    asks
        Names of these.
    keys
        Of the tags that are asked for.

    Raises
    ------
    InputError
        If it is anything else, or a column is not there, or compared with what it is not.
    """

    def __init__(
        self,
        text: str,
        own: Mapping[str, pa.DataType],
        of_recordings: Mapping[str, pa.DataType],
    ):
        self._own, self._of_recordings = own, of_recordings
        self.asks: dict[str, None] = {}
        self.keys: dict[str, None] = {}
        if len(text) > LONGEST_FILTER:
            raise _fault(f"expected at most {LONGEST_FILTER:,} characters, found {len(text):,}")
        try:
            # of a statement only what is a condition is parsed
            tree = sqlglot.parse_one(text, into=exp.Condition, dialect="duckdb")
            self.expression: Expression = self._condition(tree)
        except SqlglotError as error:
            found = getattr(error, "errors", None) or [{"col": 0, "description": str(error)}]
            what = str(found[0]["description"]).partition(".")[0].lower()
            raise _fault(f"cannot be read at character {found[0]['col']}: {what}") from error
        except RecursionError as error:
            raise _fault("expected fewer conditions and brackets") from error

    def _condition(self, node: exp.Expr) -> Expression:
        _check(node)
        if isinstance(node, exp.Paren):
            return self._condition(node.this)
        if isinstance(node, exp.Not):
            return ~self._condition(node.this)
        if isinstance(node, exp.And):
            return self._condition(node.this) & self._condition(node.expression)
        if isinstance(node, exp.Or):
            return self._condition(node.this) | self._condition(node.expression)
        if type(node) in _COMPARISONS:
            return _COMPARISONS[type(node)](*self._alike(node.this, node.expression))
        if isinstance(node, exp.In) and node.expressions:
            value, *choices = self._alike(node.this, *node.expressions)
            is_one: Expression = value.isin(*choices)
            return is_one
        if isinstance(node, exp.Between):
            value, *ends = self._alike(node.this, node.args["low"], node.args["high"])
            return value.between(*ends)
        if isinstance(node, exp.Like | exp.ILike):
            value, pattern = self._alike(node.this, node.expression, kind=TEXT)
            name = "like_escape" if isinstance(node, exp.Like) else "ilike_escape"
            is_like = Function(name, value, pattern, Constant("\\"))
            return ~is_like if node.args.get("negate") else is_like
        if isinstance(node, exp.Is):
            _check(node.expression)
            if isinstance(node.expression, exp.Null):
                return ~self._term(node.this).expression.isnotnull()
            value, other = self._alike(node.this, node.expression, kind=CLAIM)
            return (value == other) & value.isnotnull()
        term = self._term(node)
        if term.kind not in (CLAIM, TAG):
            raise _fault(f"expected a condition, found {term.shown}, which is {term.kind}")
        return term.taken_as(CLAIM)

    def _alike(self, *nodes: exp.Expr, kind: str | None = None) -> list[Expression]:
        """Expressions of what is compared, which has to be of one kind."""
        terms = [self._term(node) for node in nodes]
        kinds = [term.kind for term in terms if term.kind != TAG]
        kind = kind or next(iter(kinds), TEXT)
        for term in terms:
            if term.kind not in (kind, TAG):
                quotes = " in single quotes" if kind == TEXT else ""
                raise _fault(f"{terms[0].shown}: expected {kind}{quotes}, found {term.shown}")
        return [term.taken_as(kind) for term in terms]

    def _term(self, node: exp.Expr) -> _Term:
        _check(node)
        shown = _shown(node)
        if isinstance(node, exp.Paren):
            return self._term(node.this)
        if isinstance(node, exp.Boolean):
            return _Term(CLAIM, Constant(bool(node.this)), shown)
        if isinstance(node, exp.Literal) and node.is_string:
            return _Term(TEXT, Constant(node.this), shown)
        sign, number = (-1, node.this) if isinstance(node, exp.Neg) else (1, node)
        _check(number)
        is_number = isinstance(number, exp.Literal) and re.fullmatch(_NUMBER, number.this)
        if is_number and not number.is_string:
            value = float(number.this)
            is_exact = value.is_integer() and abs(value) < 2**53
            return _Term(NUMBER, Constant(sign * (int(value) if is_exact else value)), shown)
        is_named = all(isinstance(part, exp.Identifier) for part in node.args.values() if part)
        if not (isinstance(node, exp.Column) and is_named):
            raise _fault(f"expected a column, a number or a text, found {shown}")
        return self._column(node.name, node.table, is_quoted=node.this.quoted)

    def _column(self, name: str, table: str, *, is_quoted: bool) -> _Term:
        shown = one_line(shortened(f"{table}.{name}" if table else name, 60))
        if table == TAG:
            self.asks["tags"] = self.keys[name] = None
            return _Term(TAG, _text_of_tag(name), shown, name)
        if table not in ("", OF_RECORDING):
            raise _fault(
                f"{shown}: before the dot there is {TAG} or {OF_RECORDING}, as in tag.night"
            )
        is_own = not table and name in self._own
        kinds = self._own if is_own else self._of_recordings
        if name not in kinds:
            known = [*({} if table else self._own), *self._of_recordings]
            columns = listed([*dict.fromkeys(known)], most=MOST_NAMED)
            hint = did_you_mean(name, known, f"the columns are {columns}")
            aside = "a text stands in single quotes" if is_quoted else "a tag is written tag.NAME"
            raise _fault(f"there is no column {shown} ({aside}); {hint}")
        kind = _kind(kinds[name])
        if kind == LIST:
            raise _fault(f"{shown} is a list; for tags, name one of them, as in tag.night")
        if not is_own:
            self.asks[name] = None
        column = Column(name if is_own else f"{OF_RECORDING}.{name}")
        return _Term(kind, column, shown)


def _text_of_tag(key: str) -> Expression:
    """What stands behind ``key=`` in a recording's tags; null: nothing does."""
    start = f"{key}="
    is_it = Lambda("tag", Function("starts_with", Column("tag"), Constant(start)))
    tags = Function("list_filter", Column(f"{OF_RECORDING}.tags"), is_it)
    first = Function("list_extract", tags, Constant(1))
    return Function("substr", first, Constant(len(start) + 1))


def _kind(of: pa.DataType) -> str:
    if pa.types.is_boolean(of):
        return CLAIM
    if pa.types.is_integer(of) or pa.types.is_floating(of):
        return NUMBER
    return LIST if pa.types.is_nested(of) else TEXT


def _check(node: exp.Expr) -> None:
    """Refuse what a filter may not consist of."""
    allowed = _ARGUMENTS.get(type(node))
    has = [name for name, value in node.args.items() if value not in (None, [], False)]
    if allowed is None or not {*has} <= {*allowed}:
        raise _fault(
            f"found {_shown(node)}; expected conditions with and, or, not, = <> < <= > >=, "
            "in (...), between, like, is null"
        )


def _shown(node: exp.Expr) -> str:
    return one_line(shortened(re.sub(r"\s+", " ", node.sql("duckdb", comments=False)), 60))


def _fault(message: str) -> InputError:
    return InputError(f"filter: {message}")
