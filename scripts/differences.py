"""Compare the files of two runs: byte by byte, except for listed wordings, or by facts only."""

from __future__ import annotations

import csv
import html
import io
import json
import re
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path

from scripts.facts import facts

NUMBER = re.compile(r"\d+(?:\.\d+)?")
JSON_STRING = re.compile(r'(?P<string>"(?:[^"\\]|\\.)*")(?P<colon>\s*:)?')
JSON_BLOCK = re.compile(r'(?<=<script type="application/json">)(.*?)(?=</script>)', re.DOTALL)
JSON_IN_HTML = str.maketrans({"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"})
FIXED_COLUMN = "figure"
"""Column of the reports that programs use as a key. It is never reworded."""

EXCERPT = 70
"""Number of characters to show on either side of the first difference in a line."""
SHOWN = 3
"""Maximum number of lines or facts of a file to show."""

DURATION = r"[\d.,]+ (?:ms|s|min|h)(?: [\d.]+ s)?"
MASKS = tuple((re.compile(name), re.compile(text, re.MULTILINE), by) for name, text, by in (
    # the lines of progress in a log depend on the duration
    (r"\.stderr\.txt", r"^(?:\d+% done|step \d+ of|\S+: [\d,]+ of|reading pictures|stability maps"
     r"|testing the diff|detection curves|evidence frames|the page|studies of|done).*\n", ""),
    (r"\.std(?:err|out)\.txt", rf"\b(in|about) {DURATION}( \(|$)", r"\1 TIME\2"),
    (r"\.std(?:err|out)\.txt", r"\([-\de.,]+ (s a picture|pictures a second)\)", r"(N \1)"),
    (r"\.stderr\.txt", r"^Traceback .*\n(?:(?: .*)?\n)*", "Traceback: "),
    # times of the run itself, such as when the primary measure was chosen
    (r"", r"\d{4}-\d\d-\d\d(?:T| at )\d\d:\d\d(?::\d\d)?", "WHEN"),
    (r"", r"(\bnvcore |\bversion\"?(?: =|:) \")\d+\.\d+\.\d+\w*", r"\1VERSION"),
    # the files themselves are compared
    (r"SHA256SUMS", r"^[0-9a-f]{64}", "HASH"),
))  # fmt: skip
"""Parts that vary by run or version: file names, pattern, and replacement."""


class WordingError(ValueError):
    """Error for an invalid entry of the list of wordings."""


@dataclass(frozen=True)
class Wording:
    """Text of the older program, and its replacement in the newer one."""

    old: str
    new: str

    def __post_init__(self) -> None:
        if not re.search(r"[^\W\d]", self.old):
            raise WordingError(f"{self.old!r}: a wording has a letter at least")
        if NUMBER.findall(self.old) != NUMBER.findall(self.new):
            raise WordingError(f"{self.old!r} -> {self.new!r}: a wording keeps its numbers")


def read_wordings(path: Path) -> tuple[Wording, ...]:
    """Read the list of wordings from a TOML file.

    Raises
    ------
    WordingError
        If an entry has keys other than `old` and `new`, or would change a number.
    """
    try:
        entries = tomllib.loads(path.read_text(encoding="utf-8")).get("wording", [])
        return tuple(Wording(**entry) for entry in entries)
    except TypeError as error:
        raise WordingError(f"{path}: an entry has the keys old and new; {error}") from error


@dataclass
class Rewording:
    """Translation of the older program's texts into the newer one's, counting the wordings used."""

    wordings: tuple[Wording, ...] = ()
    needed: set[Wording] = field(default_factory=set)

    def file(self, name: str, text: str) -> str:
        """Translate the text of a file, depending on its extension."""
        kinds = {".csv": self.csv, ".json": self.json, ".html": self.html}
        return kinds.get(Path(name).suffix, self.text)(text)

    def text(self, text: str, spell: Callable[[str], str] = str) -> str:
        """Translate plain text, or text in which wordings are spelled differently, as in HTML."""
        for wording in self.wordings:
            if spell(wording.old) in text:
                text = text.replace(spell(wording.old), spell(wording.new))
                self.needed.add(wording)
        return text

    def csv(self, text: str) -> str:
        """Translate the cells of CSV, except for header, numbers and the fixed column."""
        line_end = "\r\n" if "\r\n" in text else "\n"
        rows = list(csv.reader(io.StringIO(text, newline="")))
        if _csv_text(rows, line_end) != text or len({len(row) for row in rows}) != 1:
            return text  # not written like the reports, so compared byte by byte
        reworded = [
            [
                cell if column == FIXED_COLUMN or _is_number(cell) else self.text(cell)
                for column, cell in zip(rows[0], row, strict=True)
            ]
            for row in rows[1:]
        ]
        return _csv_text([*rows[:1], *reworded], line_end)

    def json(self, text: str, *, in_html: bool = False) -> str:
        """Translate the strings of JSON, but not its keys."""

        def value(literal: re.Match[str]) -> str:
            string = json.loads(literal["string"])
            reworded = self.text(string)
            if literal["colon"] or reworded == string:
                return literal[0]
            text = json.dumps(reworded, ensure_ascii=in_html)
            return text.translate(JSON_IN_HTML) if in_html else text

        return JSON_STRING.sub(value, text) if self.wordings else text

    def html(self, text: str) -> str:
        """Translate text and attributes of HTML, and the JSON of its figures."""
        parts = JSON_BLOCK.split(text)
        for index, part in enumerate(parts):
            if index % 2:
                parts[index] = self.json(part, in_html=True)
            else:
                parts[index] = self.text(part, _in_markup)
        return "".join(parts)


def _csv_text(rows: list[list[str]], line_end: str) -> str:
    stream = io.StringIO(newline="")
    csv.writer(stream, lineterminator=line_end).writerows(rows)
    return stream.getvalue()


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _in_markup(text: str) -> str:
    """Escape text like the template engine."""
    return html.escape(text).replace("&quot;", "&#34;").replace("&#x27;", "&#39;")


def compare_files(name: str, old: bytes, new: bytes, rewording: Rewording | None) -> str | None:
    """Describe the first difference of two files, or return None if they are the same.

    Parameters
    ----------
    name
        Name of the file. Its extension decides which parts may be reworded.
    old, new
        Output of the older and the newer program.
    rewording
        Wordings that may differ. None: any wording may, and only facts are compared.
    """
    if old == new:
        return None
    try:
        old_text, new_text = old.decode(), new.decode()
    except UnicodeDecodeError:
        index = next(
            (i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b),
            min(len(old), len(new)),
        )
        return f"byte {index} ({len(old)} and {len(new)} bytes)"
    old_text, new_text = masked(name, old_text), masked(name, new_text)
    if rewording is None:
        return _different_facts(facts(name, old_text), facts(name, new_text))
    reworded = rewording.file(name, old_text)
    return None if reworded == new_text else _different_lines(reworded, new_text)


def masked(name: str, text: str) -> str:
    """Mask the parts of a file that `MASKS` lists."""
    for names, pattern, by in MASKS:
        if names.search(name):
            text = pattern.sub(by, text)
    return text


def _different_facts(old: dict[str, str], new: dict[str, str]) -> str | None:
    places = [place for place in old | new if old.get(place) != new.get(place)]
    shown = [
        f"\n  - {place}: {_excerpt(old.get(place), new.get(place))}"
        f"\n  + {place}: {_excerpt(new.get(place), old.get(place))}"
        for place in places[:SHOWN]
    ]
    return f"{len(places)} of {len(old)} facts" + "".join(shown) if places else None


def _different_lines(old: str, new: str) -> str:
    lines = zip_longest(old.splitlines(keepends=True), new.splitlines(keepends=True))
    pairs = [(number, a, b) for number, (a, b) in enumerate(lines, start=1) if a != b]
    shown = [f"line {i}\n  - {_excerpt(a, b)}\n  + {_excerpt(b, a)}" for i, a, b in pairs[:SHOWN]]
    more = [f"and {len(pairs) - SHOWN:,} more lines"] if len(pairs) > SHOWN else []
    return "\n  ".join([*shown, *more])


def _excerpt(line: str | None, other: str | None) -> str:
    """Return an excerpt of a line around its first difference from the other one."""
    if line is None:
        return "(nothing)"
    pairs = enumerate(zip(line, other or "", strict=False))
    first = next((i for i, (a, b) in pairs if a != b), min(len(line), len(other or "")))
    low, high = max(first - EXCERPT, 0), first + EXCERPT
    excerpt = repr(line[low:high])[1:-1]
    return ("…" if low else "") + excerpt + ("…" if high < len(line) else "")


def compare_folders(old: Path, new: Path, rewording: Rewording | None) -> Iterator[tuple[str, str]]:
    """Yield each file that differs with the place of the difference, sorted by name."""
    names = {
        path.relative_to(folder).as_posix()
        for folder in (old, new)
        for path in folder.rglob("*")
        if path.is_file()
    }
    for name in sorted(names):
        sides = old / name, new / name
        if not sides[0].is_file():
            yield name, "only the newer program writes it"
        elif not sides[1].is_file():
            yield name, "only the older program writes it"
        else:
            old_bytes, new_bytes = (side.read_bytes() for side in sides)
            where = compare_files(name, old_bytes, new_bytes, rewording)
            if where is not None:
                yield name, where
