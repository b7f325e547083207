"""HTML reports as tests read them: text, tables and elements."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

from nvcore.comparison.compare import Result
from nvcore.inputs.session import Session
from nvcore.report.html import write_html_report


class Page(HTMLParser):
    """Text, tables, and elements of a page."""

    def __init__(self, content: str):
        super().__init__()
        self.tags: list[str] = []
        self.tables: dict[str, list[list[str]]] = {}
        self.words: list[str] = []
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self._caption = ""
        self._inside: list[str] = []
        self.feed(content)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self._inside.append(tag)
        if tag == "table":
            self._caption = ""
        if tag == "tr":
            self.tables[self._caption].append([])
        if tag in ("td", "th"):
            self.tables[self._caption][-1].append("")
        if tag == "script":
            self.scripts.append((dict(attrs), ""))

    def handle_endtag(self, tag: str) -> None:
        while self._inside and self._inside.pop() != tag:
            pass

    def handle_data(self, text: str) -> None:
        inside = self._inside[-1] if self._inside else ""
        if inside == "script":
            self.scripts[-1] = (self.scripts[-1][0], self.scripts[-1][1] + text)
            return
        if inside == "caption":
            self._caption = text
            self.tables[text] = []
        elif inside in ("td", "th"):
            self.tables[self._caption][-1][-1] += text
        self.words.append(text)

    @property
    def text(self) -> str:
        return " ".join(self.words)

    def row(self, caption: str, first: str) -> list[str]:
        """The cells of the row that begins so."""
        (found,) = [row for row in self.tables[caption] if row[0] == first]
        return found[1:]

    def charts(self) -> dict[int, dict]:
        return {
            i: json.loads(text)
            for i, (attrs, text) in enumerate(self.scripts)
            if attrs.get("type") == "application/json" and '"data"' in text
        }


def written(path: Path, result: Result, session: Session, findings=(), **options) -> str:
    write_html_report(result, session, findings, path, **options)
    return path.read_text(encoding="utf-8")
