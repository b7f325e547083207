"""Find the worst rows of a scan's results that match a filter.

DuckDB reads Arrow data sets of the Parquet files, opens no file by itself and loads no extension. A
filter is parsed, checked against a whitelist of nodes and rewritten. DuckDB runs the SQL that is
generated from this tree, never the text of the user.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import duckdb
import pandas as pd
import pyarrow as pa
import sqlglot
from sqlglot import exp

from nvcore.common.errors import InputError
from nvcore.common.wording import aligned, did_you_mean, listed, number, one_line, shortened
from nvcore.subjects.fleet.folder import SUMMARY, has_tables, plan_shown, table_of
from nvcore.subjects.fleet.location import LONGEST_REASON, Location
from nvcore.subjects.fleet.plan import Plan
from nvcore.tables.columns import report_columns

MOMENTS: Final[Mapping[str, tuple[str, str, str, str]]] = {
    "encounters": ("severity", "shown_frame", "shown_frame", "shown_s"),
    "events": ("saliency", "first_frame", "first_frame", "start_s"),
    "intervals": ("depth", "worst_frame", "first_frame", "start_s"),
    "episodes": ("duration", "first_frame", "first_frame", "start_s"),
    "recordings": ("severity", "", "", ""),
    "frames": ("similarity", "frame", "frame", "time_s"),
}
"""By table of results: default column to sort by, column of the frame to look at (empty: none),
column of a frame of known time, and column of this time."""

LONGEST_FILTER: Final = 10_000
MOST_NAMED: Final = 12
"""Largest number of columns that an error lists."""
TAG: Final = "tag"

_CONFINED: Final[dict[str, Any]] = {
    "autoinstall_known_extensions": "false",
    "autoload_known_extensions": "false",
    "enable_external_access": "false",
}

NUMBER, TEXT, CLAIM, LIST = "a number", "a text", "true or false", "a list"
_UNIT: Final = r"_(s|px|m|kmh)(?=_[xy]$|$)"
_NUMBER: Final = r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?"
_Term = tuple[str, exp.Expr]
"""Kind of a column, tag, constant or condition, and its expression for DuckDB."""
_Known = Mapping[str, Mapping[str, _Term]]

_JOINS: Final = (exp.And, exp.Or, exp.Not, exp.Paren)
_COMPARISONS: Final = (exp.EQ, exp.NEQ, exp.GT, exp.GTE, exp.LT, exp.LTE)
_ARGUMENTS: Final[Mapping[type, Collection[str]]] = {
    **dict.fromkeys((exp.And, exp.Or, exp.Is, *_COMPARISONS), ("this", "expression")),
    **dict.fromkeys((exp.Like, exp.ILike), ("this", "expression", "negate")),
    **dict.fromkeys((exp.Not, exp.Paren, exp.Neg, exp.Boolean), ("this",)),
    **dict.fromkeys((exp.Null, exp.Star), ()),
    exp.In: ("this", "expressions"),
    exp.Between: ("this", "low", "high"),
    exp.Literal: ("this", "is_string"),
    exp.Column: ("this", "table"),
    exp.Identifier: ("this", "quoted"),
}
"""Whitelist of nodes in a filter, and of their arguments. DuckDB runs whatever passes."""

_TAG_AS: Final = {TEXT: "tag_text", NUMBER: "tag_number", CLAIM: "has_tag"}
"""Macro that looks up a tag, by the kind of value that it is compared with."""
_MACROS: Final = rf"""
CREATE MACRO tag_text(tags, key) AS
    substr(list_filter(tags, lambda tag: starts_with(tag, key || '='))[1], length(key) + 2);
CREATE MACRO tag_number(tags, key) AS
    try_cast(regexp_extract(tag_text(tags, key), '^{_NUMBER}$') AS DOUBLE);
CREATE MACRO has_tag(tags, key) AS list_contains(tags, key) OR tag_text(tags, key) IS NOT NULL;
CREATE MACRO is_same(value, other) AS value = other AND value IS NOT NULL;
"""


@dataclass(frozen=True, eq=False)
class Top:
    """The worst rows of a table of results.

    `table` has the recording, the frame to look at and its time_s (except for recordings), and the
    other columns. It is sorted by the columns `by`, by the worse of both systems if there are two.
    `results` is the URI of the results.
    """

    table: pd.DataFrame
    by: tuple[str, ...]
    results: str

    def __str__(self) -> str:
        forms = {"frame": "d", "time_s": ".2f", **dict.fromkeys(self.by, ".4g"), "track": "d"}
        names = dict.fromkeys(["recording", *forms, "system", "category"])
        shown = self.table.astype(object).where(self.table.notna(), None)
        columns = [
            [name, *(number(of, forms[name]) if name in forms else str(of) for of in shown[name])]
            for name in names
            if name in shown
        ]
        return "\n".join(aligned(zip(*columns, strict=True))) if len(shown) else "no row fits"

    @property
    def frames(self) -> list[int | None]:
        """Frame to look at for each row, None for rows without one."""
        frames = self.table.get("frame", [None] * len(self.table))
        return [None if pd.isna(frame) else int(frame) for frame in frames]


def worst(
    results: Location,
    table: str = "encounters",
    *,
    by: str | None = None,
    where: str = "",
    n: int = 20,
    is_reversed: bool = False,
) -> Top:
    """Return the worst rows of a table of a scan's results, or the best if `is_reversed`.

    `table`, `by`, `where` and `n` are those of `nvcore.top`. Rows with the same value are sorted by
    the name of the recording.

    Raises
    ------
    InputError
        If there are no results, no such table or column, or the filter cannot be used.
    """
    its_plan = plan_shown(results)
    rows = _dataset(results, table, its_plan)
    recordings = rows if table == "recordings" else _dataset(results, "recordings", its_plan)
    own, of_recordings = (
        {field.name: _term_of(field, name) for field in of.schema}
        for name, of in (("own", rows), ("recording", recordings))
    )
    names = {"": own | of_recordings | own, "recording": of_recordings}
    condition = _condition(where, names) if where.strip() else None
    usual, frame, timed, time_s = MOMENTS[table]
    columns = _columns_by(by or usual, [name for name, (kind, _) in own.items() if kind == NUMBER])
    better = {of.name: of.better for of in report_columns().get(f"{table}.csv", ())}
    is_low_better = better.get(columns[0].removeprefix("sum_")) != "high"
    value = exp.func("greatest" if is_low_better else "least", *(own[of][1] for of in columns))
    ties = [own[of][1] for of in ("recording", timed, "track", "system") if of in own]
    moments = {"recording": "own.recording"}
    if frame:
        moments["frame"] = f"own.{frame}"
        moments["time_s"] = f"own.{time_s} + (own.{frame} - own.{timed}) / recording.fps"
    query = (
        exp.select(*(f"{of} AS {name}" for name, of in moments.items()))
        .select(*(term for name, (_, term) in own.items() if name not in moments))
        .from_("own")
        .join("recording", on="own.recording = recording.recording", join_type="left")
        .where(value.is_(exp.null()).not_(), condition)
        .order_by(exp.Ordered(this=value, desc=is_low_better != is_reversed))
        .order_by(*ties)
        .limit(n)
    )
    with duckdb.connect(":memory:", config=_CONFINED) as connection:
        connection.register("own", rows)
        connection.register("recording", recordings)
        connection.execute(_MACROS)
        try:
            if condition is not None:
                _check_tags(condition, connection)
            answer = connection.sql(query.sql("duckdb", comments=False)).to_arrow_table()
        except duckdb.Error as error:
            reason = one_line(shortened(str(error), LONGEST_REASON))
            raise InputError(f"cannot be asked ({reason})", file=results.uri) from error
    found = answer.to_pandas(types_mapper={pa.int64(): pd.Int64Dtype()}.get)
    return Top(found, columns, results.uri)


def results_in(location: Location) -> Location:
    """Return the location of a scan's results: this one, or the only folder below it with results.

    Raises
    ------
    InputError
        If there are no results, or several.
    """
    if has_tables(location):
        return location
    paths = [entry.path.rpartition("/") for entry in location.list()]
    folders = [folder for folder, _, name in paths if name == SUMMARY]
    if len(folders) == 1:
        return location.child(folders[0])
    parts = {folder.partition("/")[0] for folder, _, _ in paths}
    found = listed(folders, most=MOST_NAMED) or "none"
    if not folders and "plans" in parts:
        found = "one that is not finished; run it again to go on"
    elif not folders and "sources" in parts:
        found = "a store; scan it first"
    raise InputError(
        f"expected results of a scan that is finished, found {found}", file=location.uri
    )


def _dataset(results: Location, table: str, its_plan: Plan | None) -> Any:
    """Open a table of the results as an Arrow data set of verified files."""
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


def _columns_by(name: str, numbers: Collection[str]) -> tuple[str, ...]:
    """Resolve a name to its column, also without unit, or to the columns of both systems."""
    named = {re.sub(_UNIT, "", column): column for column in numbers} | {of: of for of in numbers}
    pairs = [of[:-2] for of in named if of.endswith("_x") and f"{of[:-2]}_y" in named]
    if name in named:
        return (named[name],)
    if name in pairs:
        return named[f"{name}_x"], named[f"{name}_y"]
    message = f"there is no column of numbers {one_line(shortened(name, 60))}"
    raise _unknown(message, name, [*pairs, *named], "there are")


def _condition(text: str, known: _Known) -> exp.Expr:
    """Check and translate a condition such as ``tag.road = 'rural' and n_frames > 10``.

    `known` are columns by prefix before the dot (empty or ``recording``) and by name.
    """
    if len(text) > LONGEST_FILTER:
        raise _fault(f"expected at most {LONGEST_FILTER:,} characters, found {len(text):,}")
    try:
        # parse only a condition, not a statement
        tree = sqlglot.parse_one(text, into=exp.Condition, dialect="duckdb")
        for node in tree.walk(bfs=False):
            has = {name for name, value in node.args.items() if value not in (None, [], False)}
            if type(node) not in _ARGUMENTS or not has <= {*_ARGUMENTS[type(node)]}:
                raise _fault(
                    f"found {_shown(node)}; expected conditions with and, or, not, "
                    "= <> < <= > >=, in (...), between, like, is null"
                )
        return _rewritten(exp.paren(tree, copy=False), known)[1]
    except sqlglot.errors.SqlglotError as error:
        found = getattr(error, "errors", None) or [{"col": 0, "description": str(error)}]
        what = str(found[0]["description"]).partition(".")[0].lower()
        if what.startswith("required keyword"):  # the message names a class of the parser
            what = "a column or value is missing"
        raise _fault(f"cannot be read at character {found[0]['col']}: {what}") from error
    except RecursionError as error:
        raise _fault("expected fewer conditions and brackets") from error


def _rewritten(node: exp.Expr, known: _Known) -> _Term:
    """Translate a condition or term for DuckDB, replacing operands in place."""
    is_join = isinstance(node, _JOINS)
    if not isinstance(node, (*_JOINS, exp.Predicate)) or node.args.get("expressions") == []:
        return _term(node, known)
    is_like = isinstance(node, exp.Like | exp.ILike)
    is_null = isinstance(node, exp.Is) and isinstance(node.expression, exp.Null)
    is_same = isinstance(node, exp.Is) and not is_null
    parts = node.flatten() if isinstance(node, exp.Connector) else node.iter_expressions()
    operands = [of.unnest() for of in parts if not (is_null and isinstance(of, exp.Null))]
    terms = [_rewritten(of, known) if is_join else _term(of, known) for of in operands]
    wanted = TEXT if is_like else CLAIM if is_join or is_same else None
    kind = wanted or next((of for of, _ in terms if of != TAG), TEXT)
    for operand, (of, term) in zip(operands, terms, strict=True):
        if of not in (kind, TAG) and is_join:
            raise _fault(f"expected a condition, found {_shown(operand)}, which is {of}")
        if of not in (kind, TAG):
            quotes = " in single quotes" if kind == TEXT else ""
            first, found = _shown(operands[0]), _shown(operand)
            raise _fault(f"{first}: expected {kind}{quotes}, found {found}")
        operand.replace(exp.func(_TAG_AS[kind], *term.expressions) if of == TAG else term)
    if is_like:
        name = f"{'not_' if node.args.get('negate') else ''}{node.key}_escape"
        return CLAIM, exp.func(name, node.this, node.expression, exp.Literal.string("\\"))
    return CLAIM, exp.func("is_same", node.this, node.expression) if is_same else node


def _term(node: exp.Expr, known: _Known) -> _Term:
    if isinstance(node, exp.Boolean):
        return CLAIM, node
    if isinstance(node, exp.Literal) and node.is_string:
        return TEXT, node
    sign, digits = (-1, node.this) if isinstance(node, exp.Neg) else (1, node)
    if digits.is_number and re.fullmatch(_NUMBER, digits.name):
        value = sign * float(digits.name)
        if value.is_integer() and abs(value) < 2**53:
            return NUMBER, exp.Literal.number(int(value))
        # DuckDB would read 0.1 as a decimal
        return NUMBER, exp.cast(exp.Literal.string(repr(value)), "double")
    is_named = all(isinstance(part, exp.Identifier) for part in node.args.values() if part)
    shown, name = _shown(node), node.name
    if not (isinstance(node, exp.Column) and is_named):
        raise _fault(f"expected a column, a number or a text, found {shown}")
    if node.table == TAG:
        return TAG, exp.func(TAG, exp.column("tags", "recording"), exp.Literal.string(name))
    if node.table not in known:
        raise _fault(f"{shown}: before the dot there is tag or recording, as in tag.night")
    names = known[node.table]
    if name not in names:
        is_text = node.this.quoted
        aside = "a text stands in single quotes" if is_text else "a tag is written tag.NAME"
        message = f"filter: there is no column {shown} ({aside})"
        raise _unknown(message, name, names, "the columns are")
    kind, term = names[name]
    if kind == LIST:
        raise _fault(f"{shown} is a list; for tags, name one of them, as in tag.night")
    return kind, term.copy()


def _check_tags(condition: exp.Expr, connection: duckdb.DuckDBPyConnection) -> None:
    """Refuse tag keys that no recording has, since a misspelt key would match nothing."""
    calls = condition.find_all(exp.Anonymous)
    keys = [of.expressions[1].name for of in calls if of.name in _TAG_AS.values()]
    if not keys:
        return
    tags = connection.sql("SELECT DISTINCT unnest(tags) FROM recording").fetchall()
    known = sorted({str(tag).partition("=")[0] for (tag,) in tags})
    for key in keys:
        if key not in known:
            message = f"filter: no recording has a tag {one_line(shortened(key, 60))}"
            raise _unknown(message, key, known, "the tags are")


def _term_of(field: pa.Field, table: str) -> _Term:
    kind = LIST if pa.types.is_nested(field.type) else TEXT
    if pa.types.is_boolean(field.type):
        kind = CLAIM
    if pa.types.is_integer(field.type) or pa.types.is_floating(field.type):
        kind = NUMBER
    return kind, exp.column(field.name, table, quoted=True)


def _shown(node: exp.Expr) -> str:
    return one_line(shortened(re.sub(r"\s+", " ", node.sql("duckdb", comments=False)), 60))


def _fault(message: str) -> InputError:
    return InputError(f"filter: {message}")


def _unknown(message: str, name: str, known: Iterable[str], are: str) -> InputError:
    """Return an error that suggests a similar known name and lists the known names."""
    sentence = f"{are} {listed([*known], most=MOST_NAMED) or 'none'}"
    return InputError(f"{message}; {did_you_mean(name, known, sentence)}")
