"""Mutants of a Python file: one small change each, by the usual mutation operators.

Comparisons (boundary moved, negated), arithmetic, `and`/`or`/`not`, numbers off by one, True/False,
`min`/`max` and other pairs of names, `+=`/`-=`, slice bounds dropped, conditions negated, `break`/
`continue`, returned values. Text and annotations are not mutated, as no test should depend on them:
docstrings and all other texts, annotations, decorators, assertions, ``zip(strict=...)``.
"""

from __future__ import annotations

import ast
import hashlib
import io
import tokenize
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

COMPARISONS = {
    "<": ("<=", ">="),
    "<=": ("<", ">"),
    ">": (">=", "<="),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
    "in": ("not in",),
    "not in": ("in",),
    "is": ("is not",),
    "is not": ("is",),
}
ARITHMETIC = {
    "+": "-", "-": "+", "*": "/", "/": "*", "//": "/", "%": "/", "**": "*",
    "&": "|", "|": "&", "^": "&", "<<": ">>", ">>": "<<",
}  # fmt: skip
PAIRS = (
    ("min", "max"), ("any", "all"), ("minimum", "maximum"), ("fmin", "fmax"), ("floor", "ceil"),
    ("argmin", "argmax"), ("nanmin", "nanmax"), ("idxmin", "idxmax"), ("cummin", "cummax"),
    ("logical_and", "logical_or"), ("startswith", "endswith"), ("lstrip", "rstrip"),
    ("removeprefix", "removesuffix"), ("bisect_left", "bisect_right"), ("ffill", "bfill"),
)  # fmt: skip
SWAPS = {a: b for pair in PAIRS for a, b in (pair, pair[::-1])}
SIDES = {"left": "right", "right": "left", "first": "last", "last": "first"}
"""Keyword values (`side`, `keep`) that select an algorithm instead of being text."""


Key = tuple[str, str, str, int]


@dataclass(frozen=True)
class Mutant:
    """Change of one place: ``source[start:stop]`` becomes `new`.

    Attributes
    ----------
    path
        File path from the root of the project.
    line
        Line of the place, from 1.
    head
        First and last line of the statement around the place, without nested statements.
    scope
        Lines of the function around the place (of the function itself for a default value). None if
        the place runs on import.
    text
        Line of code at the place, without indentation.
    mutation
        Change, as ``old -> new``.
    nth
        Index among equal mutations of equal lines in one file, from 0.
    """

    path: str
    start: int
    stop: int
    new: str
    line: int
    head: tuple[int, int]
    scope: tuple[int, int] | None
    text: str
    mutation: str
    nth: int = 0

    @property
    def key(self) -> Key:
        """Identity of the mutant, which is stable while its line is not edited."""
        return self.path, self.text, self.mutation, self.nth

    def order(self, seed: int) -> str:
        """Return a random sort key that does not change with edits elsewhere."""
        return hashlib.sha256(repr((seed, self.key)).encode()).hexdigest()

    def apply(self, source: str) -> str:
        """Return the mutated source."""
        return source[: self.start] + self.new + source[self.stop :]


class Places(ast.NodeVisitor):
    """Collector of ``(start, stop, new, statement, scope)`` of every mutation of one file."""

    def __init__(self, source: str) -> None:
        self.source = source
        lines = source.splitlines(keepends=True)
        self.lines = lines
        self.begins = [0]
        for line in lines:
            self.begins.append(self.begins[-1] + len(line))
        self.tokens = [
            (self.begins[t.start[0] - 1] + t.start[1], self.begins[t.end[0] - 1] + t.end[1])
            for t in tokenize.generate_tokens(io.StringIO(source).readline)
            if t.type in (tokenize.OP, tokenize.NAME)
        ]
        self.statement: ast.stmt = ast.Pass()
        self.scope: tuple[int, int] | None = None
        self.places: list[tuple[int, int, str, ast.stmt, tuple[int, int] | None]] = []
        self.visit(ast.parse(source))

    def offset(self, line: int, column: int) -> int:
        """Return the index in the source. `column` counts bytes, as in `ast`."""
        return self.begins[line - 1] + len(self.lines[line - 1].encode()[:column].decode())

    def span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        start = self.offset(node.lineno, node.col_offset)
        return start, self.offset(node.end_lineno, node.end_col_offset)

    def add(self, start: int, stop: int, new: str) -> None:
        self.places.append((start, stop, new, self.statement, self.scope))

    def replace(self, node: ast.expr | ast.stmt, new: str) -> None:
        self.add(*self.span(node), new)

    def operator(self, left: ast.expr, right: ast.expr) -> tuple[int, int, str]:
        """Return position and text of the operator between two operands, ignoring parentheses."""
        first = bisect_left(self.tokens, (self.span(left)[1], 0))
        last = bisect_left(self.tokens, (self.span(right)[0], 0))
        between = [t for t in self.tokens[first:last] if self.source[t[0] : t[1]] not in "()"]
        start, stop = between[0][0], between[-1][1]
        return start, stop, " ".join(self.source[start:stop].split())

    # --- statements -----------------------------------------------------------------------

    def visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.stmt):
            outer, self.statement = self.statement, node
            super().visit(node)
            self.statement = outer
        else:
            super().visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        outer, self.scope = self.scope, (node.body[0].lineno, node.end_lineno or node.lineno)
        for default in [*node.args.defaults, *node.args.kw_defaults]:
            if default is not None:
                self.visit(default)
        for statement in node.body:
            self.visit(statement)
        self.scope = outer

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        for statement in node.body:
            self.visit(statement)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_Assert(self, node: ast.Assert) -> None:
        """Skip assertions, which have no effect on results."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Skip text."""

    def visit_Return(self, node: ast.Return) -> None:
        if node.value is not None:
            if not (isinstance(node.value, ast.Constant) and node.value.value is None):
                self.replace(node.value, "None")
            self.visit(node.value)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        start, stop, text = self.operator(node.target, node.value)
        if text[:-1] in ARITHMETIC and not is_text(node.value):
            self.add(start, stop, ARITHMETIC[text[:-1]] + "=")
        self.generic_visit(node)

    def visit_Break(self, node: ast.Break) -> None:
        self.replace(node, "continue")

    def visit_Continue(self, node: ast.Continue) -> None:
        self.replace(node, "break")

    def visit_If(self, node: ast.If) -> None:
        if not (isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"):
            self.condition(node.test)
            self.generic_visit(node)

    def visit_While(self, node: ast.While) -> None:
        self.condition(node.test)
        self.generic_visit(node)

    # --- expressions ----------------------------------------------------------------------

    def condition(self, test: ast.expr) -> None:
        """Negate a condition that no other operator negates."""
        if isinstance(test, (ast.Name, ast.Attribute, ast.Call, ast.Subscript, ast.NamedExpr)):
            self.replace(test, f"not ({self.source[slice(*self.span(test))]})")

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self.condition(node.test)
        self.generic_visit(node)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        for test in node.ifs:
            self.condition(test)
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, right in zip([node.left, *node.comparators], node.comparators, strict=False):
            start, stop, text = self.operator(left, right)
            for new in COMPARISONS[text]:
                self.add(start, stop, new)
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        start, stop, text = self.operator(node.left, node.right)
        is_type = text == "|" and self.scope is None
        if text in ARITHMETIC and not (is_text(node.left) or is_text(node.right) or is_type):
            self.add(start, stop, ARITHMETIC[text])
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        for left, right in zip(node.values, node.values[1:], strict=False):
            start, stop, text = self.operator(left, right)
            self.add(start, stop, "or" if text == "and" else "and")
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        start = self.span(node)[0]
        length = 4 if isinstance(node.op, ast.Not) else 1
        self.add(start, start + length, "")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool):
            self.replace(node, str(not node.value))
        elif isinstance(node.value, (int, float)):
            self.replace(node, repr(node.value + 1))

    def visit_Slice(self, node: ast.Slice) -> None:
        for bound in (node.lower, node.upper):
            if bound is not None and not isinstance(bound, ast.Constant):
                self.replace(bound, "")
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        function = node.func
        if isinstance(function, ast.Name) and function.id in SWAPS:
            self.replace(function, SWAPS[function.id])
        for keyword in node.keywords:
            value = keyword.value
            if keyword.arg in ("side", "keep") and isinstance(value, ast.Constant):
                if value.value in SIDES:
                    self.replace(value, repr(SIDES[value.value]))
            elif keyword.arg != "strict":
                self.visit(value)
        self.visit(function)
        for argument in node.args:
            self.visit(argument)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if node.attr in SWAPS and isinstance(node.ctx, ast.Load):
            stop = self.span(node)[1]
            self.add(stop - len(node.attr), stop, SWAPS[node.attr])
        self.generic_visit(node)


def is_text(node: ast.expr) -> bool:
    """Whether an operand is a text as written."""
    if isinstance(node, ast.BinOp):
        return is_text(node.left) or is_text(node.right)
    return isinstance(node, ast.JoinedStr) or (
        isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes))
    )


def head_of(statement: ast.stmt) -> tuple[int, int]:
    """Return the first and last line of a statement without nested statements."""
    body = getattr(statement, "body", None)
    last = body[0].lineno - 1 if body else statement.end_lineno or statement.lineno
    return statement.lineno, max(statement.lineno, last)


def shortened(text: str) -> str:
    """Return code as one line, with the middle left out if it is long."""
    line = " ".join(text.split())
    return line if len(line) <= 40 else f"{line[:28]} ... {line[-7:]}"


def mutants_of(root: Path, path: str) -> Iterator[Mutant]:
    """Yield every mutant of one file, in order."""
    source = (root / path).read_text("utf-8")
    places = Places(source)
    times: Counter[tuple[str, str]] = Counter()
    for start, stop, new, statement, scope in sorted(places.places, key=lambda p: p[:3]):
        line = source.count("\n", 0, start) + 1
        text = places.lines[line - 1].strip()
        mutation = f"{shortened(source[start:stop])} -> {shortened(new)}".strip()
        nth = times[text, mutation]
        yield Mutant(path, start, stop, new, line, head_of(statement), scope, text, mutation, nth)
        times[text, mutation] += 1
