"""Extract facts (names, keys and numbers) from the program's output, ignoring prose.

A fact is a place and its value. Two files state the same if their facts are equal.

- CSV: the columns, in any order, the number of rows, and every cell. JSON and TOML: every key with
  its value. Texts in a column or under a key of `PROSE` count only as present or absent.
- JUnit: the counts of every suite, and the outcome and the stated numbers of every case.
- HTML: anchors, pictures, lengths of bars, rows of tables, X, Y and their difference in tiles, and
  the traces of charts except for the texts under `PROSE_OF_CHARTS`.
- Printed text and Markdown: rows of tables, and lines that are a number, such as an exit code.
- `SHA256SUMS`: the names.

In a row of a table for people, a cell of `SENTENCE` words or more is prose. In any other cell,
numbers are facts, as are names with a digit or an underscore, but other words are not.
"""

from __future__ import annotations

import csv
import html
import io
import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

PROSE = frozenset((
    "advice", "doubt", "example", "label", "message", "mcnemar_note", "method", "note",
    "notes", "reason",
    "sentences",
))  # fmt: skip
PROSE_OF_CHARTS = frozenset({"hovertemplate", "hovertext", "name", "text", "ticktext", "title"})
SENTENCE = 5

WORD = re.compile(r"\b[^\W\d_]{2,}\b")
NUMBER_OR_NAME = re.compile(r"[-+−]?[\w,./]*[\d_][\w,./%]*(?<![,.])")
BETWEEN_CELLS = re.compile(r"\s*\|\s*|\s{2,}")
IN_HTML = re.compile(
    r'\bid="(?P<anchor>[^"]+)"|(?P<row><tr\b)|<(?P<tag>t[dh])\b[^>]*>(?P<cell>.*?)</(?P=tag)>'
    r'|<img src="(?P<picture>[^"]*)|\bstyle="(?P<bar>[^"]*)'
    r'|<span class="(?P<tile>(?:x|y|diff)\b[^>]*>(?:<i>.</i>)?[^<]+)</span>'
    r'|<script type="application/json">(?P<chart>.*?)</script>',
    re.DOTALL,
)

Facts = Iterator[tuple[str, str]]


def facts(name: str, text: str) -> dict[str, str]:
    """Return the facts of a file by place. The extension of its name determines the format."""
    kinds = {".csv": _csv, ".json": _json, ".toml": _toml, ".xml": _junit, ".html": _html}
    if Path(name).name == "SHA256SUMS":
        return {line.split()[-1]: "" for line in text.splitlines()}
    try:
        return dict(kinds.get(Path(name).suffix, _rows)(text))
    except (ValueError, ElementTree.ParseError):  # the output is empty or an error instead
        return dict(_rows(text))


def _csv(text: str) -> Facts:
    header, *rows = list(csv.reader(io.StringIO(text, newline=""))) or [[]]
    yield "columns", " ".join(sorted(header))
    yield "rows", str(len(rows))
    for number, row in enumerate(rows, start=1):
        for column, cell in zip(header, row, strict=True):
            yield f"row {number}, {column}", _any(cell) if column in PROSE else cell


def _json(text: str) -> Facts:
    return _tree(json.loads(text), PROSE)


def _toml(text: str) -> Facts:
    return _tree(tomllib.loads(text), frozenset())


def _tree(value: Any, prose: frozenset[str], place: str = "") -> Facts:
    if not value or not isinstance(value, dict | list):
        yield place, json.dumps(value, default=str)
        return
    for key, item in value.items() if isinstance(value, dict) else enumerate(value):
        if key in prose:
            yield f"{place}.{key}", _any(item)
        else:
            yield from _tree(item, prose, f"{place}.{key}")


def _junit(text: str) -> Facts:
    root = ElementTree.fromstring(text)
    for number, suite in enumerate(root.iter("testsuite"), start=1):
        counts = [suite.get(name) for name in ("tests", "failures", "errors")]
        yield f"suite {number}", " ".join(map(str, counts))
    for case in root.iter("testcase"):
        failed = "failed" if case.find("failure") is not None else "passed"
        numbers = {number for part in case.itertext() for number in NUMBER_OR_NAME.findall(part)}
        yield case.get("name", ""), " ".join([failed, *sorted(numbers)])


def _html(text: str) -> Facts:
    anchor, row, item = "", 0, 0
    for match in IN_HTML.finditer(text):
        kind = str(match.lastgroup)
        value = match[kind]
        item += 1
        if kind == "anchor":
            anchor, row, item = value, 0, 0
            yield f"#{anchor}", ""
        elif kind == "row":
            row, item = row + 1, 0
        elif kind == "chart":
            yield from _tree(json.loads(value)["data"], PROSE_OF_CHARTS, f"#{anchor}")
        else:
            if kind == "cell":
                value = _numbers(html.unescape(re.sub("<[^>]*>", " ", value)))
            yield f"#{anchor}, row {row}, {kind} {item}", value


def _rows(text: str) -> Facts:
    number = 0
    for line in text.splitlines():
        cells = BETWEEN_CELLS.split(line.strip())
        values = [_numbers(cell) for cell in cells]
        if set(values) - {"", "…"} and (len(cells) > 1 or cells == values):
            number += 1
            yield f"row {number}", " | ".join(values)


def _numbers(cell: str) -> str:
    """Return numbers and names of a cell for people, or "…" if it has only words."""
    tokens = NUMBER_OR_NAME.findall(cell) if len(WORD.findall(cell)) < SENTENCE else []
    return " ".join(tokens).replace("−", "-") or _any(cell.strip())


def _any(prose: object) -> str:
    return "…" if prose else ""
