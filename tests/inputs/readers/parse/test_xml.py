"""XML element by element, and what must not be in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from reader_files import source

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.xml import read_elements, root_of

BILLION_LAUGHS = (
    '<!DOCTYPE a [<!ENTITY l0 "ha">'
    + "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 10))
    + "]><a>&l9;</a>"
)


def elements(folder: Path, content: bytes | str) -> list[tuple[str, int, str]]:
    file = source(folder, content, "a.xml")
    return [(element.path, element.line, element.text) for element in read_elements(file, root="a")]


def test_elements_end_from_the_inside_out_with_their_lines(tmp_path: Path) -> None:
    assert elements(tmp_path, "<a>\n<b> x <c/>y</b>\n</a>") == [
        ("a/b/c", 2, ""),
        ("a/b", 2, "x y"),
        ("a", 1, ""),
    ]


def test_lines_are_right_beyond_the_first_piece(tmp_path: Path) -> None:
    read = elements(tmp_path, "<a>\n" + "<b/>\n" * 50_000 + "</a>")
    assert [element[1] for element in read[:-1]] == list(range(2, 50_002))


@pytest.mark.parametrize(
    "content",
    [
        BILLION_LAUGHS,
        '<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/hostname">]><a>&x;</a>',
        '<!DOCTYPE a SYSTEM "http://example.org/a.dtd"><a/>',
    ],
    ids=["a billion laughs", "an external entity", "an external DTD"],
)
def test_entities_and_dtds_are_refused(tmp_path: Path, content: str) -> None:
    with pytest.raises(FormatError, match=r"a\.xml, line 1: declares a DTD or entities"):
        elements(tmp_path, content)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("<!-- x -->\n<html><body/></html>", "line 2: expected <a> .*found <html>"),
        ("", "line 1: expected XML, found a fault: no element found"),
        ("<a>\n<b>\n</a>", "line 3: .*mismatched tag"),
        ("<a>\n<b/>", "line 2: .*no element found"),
        ("<a>&nbsp;</a>", "line 1: .*undefined entity"),
        (b"\x00\x01\x02", "line 1: "),
        (b'<?xml version="1.0" encoding="klingon"?><a/>', "line 1: "),
        (b'<?xml version="1.0" encoding="shift_jis"?><a/>', "line 1: .*another encoding"),
        ("<a>" * 5000, "line 1: .*nested more than 32 deep"),
    ],
)
def test_what_is_no_xml_is_named_with_its_line(
    tmp_path: Path, content: bytes | str, message: str
) -> None:
    with pytest.raises(FormatError, match=r"a\.xml, " + message):
        elements(tmp_path, content)


def test_a_file_that_is_not_there_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"b\.xml: cannot be opened"):
        list(read_elements(SourceFile(tmp_path / "b.xml", "b.xml"), root="a"))


@pytest.mark.parametrize(
    ("head", "root"),
    [
        ("<a>", "a"),
        ('\ufeff<?xml version="1.0"?>\n<!-- <b> --><!---->\n<a x="1">', "a"),
        ("", ""),
        ("1,2,3", ""),
        ("<!DOCTYPE a><a>", ""),
    ],
)
def test_the_root_is_told_from_the_beginning(head: str, root: str) -> None:
    assert root_of(head) == root


def test_many_comments_do_not_slow_the_search_for_the_root() -> None:
    # with a pattern that backtracks this would take longer than the universe has
    assert root_of("<!---->" * 9000 + "x") == ""
