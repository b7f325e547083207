"""Read elements of an XML file one by one, with lines, refusing entities and DTDs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any, Final
from xml.etree.ElementTree import ParseError

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from nvcore.common.errors import FormatError
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.text import MAX_INTEGER

DECLARES: Final = (
    "declares a DTD or entities, which annotations do not need and which are not read: remove the "
    "DOCTYPE"
)
MAX_DEPTH: Final = 32
"""Deepest nesting, far more than any annotation format has."""
_CHUNK: Final = 1 << 16
# atomic groups prevent catastrophic backtracking on many comments
_ROOT = re.compile(r"\s*(?><\?xml[^>]*>\s*)?(?><!--.*?-->\s*)*<(?P<root>[\w:.-]+)", re.DOTALL)


class Element:
    """One element of an XML file.

    Attributes
    ----------
    path
        Tags from the root to this element, such as ``annotations/track/box``.
    attributes
        Its attributes.
    file, line
        The file, and the 1-based line of its start.
    parent
        The element that contains it. None for the root.
    parts
        Pieces of its text, without that of inner elements.
    """

    __slots__ = ("attributes", "file", "line", "parent", "parts", "path")

    def __init__(
        self,
        path: str,
        attributes: dict[str, str],
        file: SourceFile,
        line: int,
        parent: Element | None,
    ):
        self.path = path
        self.file = file
        self.attributes = attributes
        self.line = line
        self.parent = parent
        self.parts: list[str] = []

    @property
    def tag(self) -> str:
        """Name of the element."""
        return self.path.rpartition("/")[2]

    @property
    def text(self) -> str:
        """Text without that of inner elements, stripped."""
        return "".join(self.parts).strip()

    def fault(self, message: str) -> FormatError:
        """Return an error about the element, for the caller to raise."""
        return self.file.fault(message, self.line)

    def number(self, text: str | None, what: str) -> float:
        """Parse a text of the element as a number, NaN if it is empty.

        Raises
        ------
        FormatError
            If it is missing (None) or not a number.
        """
        if text is None:
            raise self.fault(f"expected {what}, found none")
        try:
            if "_" not in text:  # Python's own notation, 1_000
                return float(text)
        except ValueError:
            if not text.strip():
                return float("nan")
        raise self.fault(f"expected a number as {what}, found {text[:60]!r}")

    def whole_number(self, text: str | None, what: str) -> int:
        """Parse a text of the element as a whole number (``3.0`` is one).

        Raises
        ------
        FormatError
            If it is missing (None), empty or not a whole number.
        """
        value = self.number(text, what)
        if not (abs(value) < MAX_INTEGER and value == int(value)):
            raise self.fault(f"expected a whole number as {what}, found {str(text)[:60]!r}")
        return int(value)


class _Collector:
    """Target of the parser that keeps open elements and returns closed ones."""

    def __init__(self, file: SourceFile, root: str):
        self.file, self.root = file, root
        self.expat: Any = None
        self.open: list[Element] = []
        self.closed: list[Element] = []

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.expat.CurrentLineNumber
        if len(self.open) == MAX_DEPTH:
            raise self.file.fault(
                f"expected annotations, found elements nested more than {MAX_DEPTH} deep", line
            )
        parent = self.open[-1] if self.open else None
        if parent is None and tag != self.root:
            raise self.file.fault(
                f"expected <{self.root}> as the outermost element, found <{tag[:60]}>", line
            )
        path = tag if parent is None else f"{parent.path}/{tag}"
        self.open.append(Element(path, attributes, self.file, line, parent))

    def data(self, text: str) -> None:
        # drop line ends and indentation
        if not text.isspace():
            self.open[-1].parts.append(text)

    def end(self, tag: str) -> None:
        del tag
        self.closed.append(self.open.pop())


def root_of(head: str) -> str:
    """Return the name of the root element of an XML file, from its beginning, or empty."""
    match = _ROOT.match(head.removeprefix("\ufeff"))
    return "" if match is None else match["root"]


def read_elements(file: SourceFile, *, root: str) -> Iterator[Element]:
    """Yield the elements of an XML file in the order in which they end, inner ones first.

    The file is read in pieces, so that memory is freed when the caller drops elements.

    Raises
    ------
    InputError
        If the file cannot be opened.
    FormatError
        If it is not well-formed XML, declares a DTD or entities, or has another root element.
    """
    collector = _Collector(file, root)
    parser = DefusedXMLParser(target=collector, forbid_dtd=True)
    collector.expat = parser.parser
    for piece in _pieces(file):
        try:
            if piece:
                parser.feed(piece)
            else:
                parser.close()
        except ParseError as error:
            raise file.fault(
                f"expected XML, found a fault: {str(error).partition(': line')[0]}; is the file "
                "complete?",
                error.position[0],
            ) from error
        except DefusedXmlException as error:
            raise file.fault(DECLARES, collector.expat.CurrentLineNumber) from error
        except (LookupError, ValueError) as error:  # encodings that expat does not support
            raise file.fault(
                f"expected XML in UTF-8, found another encoding: {error}", 1
            ) from error
        closed, collector.closed = collector.closed, []
        yield from closed


def _pieces(file: SourceFile) -> Iterator[bytes]:
    """Yield the file in pieces, then an empty one."""
    with file.open() as stream:
        while piece := stream.read(_CHUNK):
            yield piece
    yield b""


def is_true(text: str | None) -> bool:
    """Whether a flag is set: 1, true, yes."""
    return text is not None and text.strip().casefold() in ("1", "1.0", "true", "yes")


def file_stem(name: str) -> str:
    """Return a file's name without folders and ending."""
    return PurePosixPath(name.replace("\\", "/")).stem
