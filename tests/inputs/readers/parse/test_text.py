"""Number tables: the quick and the careful way give the same, faults are named by line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import reader_files

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.readers.base import Lines, SourceFile
from nvcore.inputs.readers.parse import text
from nvcore.inputs.readers.parse.text import (
    TextLayout,
    are_numbers,
    is_whole,
    read_numbers,
    read_text,
    rows_of_text,
    stacked,
    whole_numbers,
)

MANY = 500
"""Rows that make a file large enough for the quick parser."""


def source(folder: Path, content: str | bytes) -> SourceFile:
    return reader_files.source(folder, content, "drive/table.txt")


NO_NUMBERS = ["person", "1_000", '"1', "0x10", "1;2"]


def three(file: SourceFile, **options: object):
    return read_numbers(file, TextLayout(**{"n_columns": (3, 4), "what": "a,b,c", **options}))


def padded(content: str) -> str:
    """The content with enough good rows behind it for the quick parser to be tried."""
    return content + "7,8,9\n" * MANY


@pytest.mark.parametrize("rows", [1, MANY], ids=["small", "large"])
def test_fields_become_columns_and_absent_columns_are_nan(tmp_path, rows):
    table = three(source(tmp_path, "1,2.5,-3\n" * rows))
    assert [column[0] for column in table.columns[:3]] == [1, 2.5, -3]
    assert np.isnan(table.columns[3]).all()
    assert table.lines.line.tolist() == list(range(1, rows + 1))


@pytest.mark.parametrize("content", ["", "\n", " \n\t\n", "\n" * 5000, "\ufeff"])
def test_a_file_of_nothing_gives_no_rows(tmp_path, content):
    table = three(source(tmp_path, content))
    assert len(table) == 0
    assert [len(column) for column in table.columns] == [0, 0, 0, 0]


@pytest.mark.parametrize(
    "tail", [padded(""), padded("").rstrip(), ""], ids=["large", "open", "small"]
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["LF", "CRLF", "CR"])
def test_every_kind_of_line_end_and_blank_lines_keep_the_line_numbers(tmp_path, end, tail):
    content = ("\n1,2,3\n\n4,5,6\n" + tail).replace("\n", end)
    table = three(source(tmp_path, content))
    assert table.lines.line[:2].tolist() == [2, 4]
    assert table.columns[2][:2].tolist() == [3, 6]
    assert len(table.lines.line) == len(table.columns[0])


@pytest.mark.parametrize("tail", [padded(""), ""], ids=["large", "small"])
@pytest.mark.parametrize(
    ("row", "second"),
    [
        ("1, 2,\t3", 2),
        (" 1 ,2 ,3 ", 2),
        ('"1","2","3"', 2),
        ("+1,2e0,3.", 2),
        ("\ufeff1,2,3", 2),
        ("1,,3", np.nan),
        ("1, ,3", np.nan),
        ("1,nan,3", np.nan),
        ("1,NaN,3", np.nan),
    ],
)
def test_blanks_quotes_signs_empty_fields_and_the_byte_order_mark_are_no_fault(
    tmp_path, row, second, tail
):
    table = three(source(tmp_path, f"{row}\n{tail}"))
    np.testing.assert_array_equal([column[0] for column in table.columns[:3]], [1, second, 3])


def test_rows_of_different_allowed_lengths_are_filled_with_nan(tmp_path):
    table = three(source(tmp_path, padded("1,2,3\n1,2,3,4\n")))
    np.testing.assert_array_equal(table.columns[3][:2], [np.nan, 4])
    assert len(table) == MANY + 2


@pytest.mark.parametrize("tail", [padded(""), ""], ids=["large", "small"])
@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,2", r"3 or 4 fields"),
        *((f"1,{wrong},3", r"numbers \(a,b,c\), found") for wrong in NO_NUMBERS),
        ('1,"2,5",3', "numbers"),  # a decimal comma
        (f"1,2,{'x' * 5000}", r"numbers .*x{59}…'$"),
    ],
)
def test_a_row_of_the_wrong_length_or_with_text_is_named_by_file_and_line(
    tmp_path, row, words, tail
):
    with pytest.raises(FormatError, match=rf"drive/table\.txt, line 3: expected {words}"):
        three(source(tmp_path, f"1,2,3\n\n{row}\n{tail}"))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20, "found a PNG picture"),
        ("1,2,3\n".encode("utf-16"), "found UTF-16 text: save it as UTF-8"),
    ],
)
def test_what_is_no_utf_8_text_is_called_what_it_is(tmp_path, content, words):
    with pytest.raises(FormatError, match=words):
        three(source(tmp_path, content))


def test_a_missing_file_is_named(tmp_path):
    file = SourceFile(tmp_path / "absent.txt", "drive/absent.txt")
    with pytest.raises(InputError, match=r"drive/absent\.txt: cannot be opened"):
        three(file)


@pytest.mark.parametrize("rows", [1, MANY], ids=["small", "large"])
@pytest.mark.parametrize("blank", [" ", "  ", "\t", " \t "])
def test_any_white_space_separates_and_ends_a_row(tmp_path, rows, blank):
    row = blank.join(["7", "Car", "2.5"]) + blank + "\n"
    table = three(source(tmp_path, row * rows), delimiter=" ", label_at=1)
    assert table.label.tolist() == ["Car"] * rows
    assert table.columns[0].tolist() == [7] * rows
    assert table.columns[1].tolist() == [2.5] * rows
    assert np.isnan(table.columns[2]).all()


def test_comment_lines_are_passed_over_and_counted(tmp_path):
    table = three(source(tmp_path, "% version=3\n1 2 3\n"), delimiter=" ", comment="%")
    assert table.lines.line.tolist() == [2]


def test_text_that_is_no_utf_8_is_named_by_the_line_behind_a_byte_order_mark(tmp_path):
    file = source(tmp_path, b"\xef\xbb\xbf1\n2\n\xe4\n")
    with pytest.raises(FormatError, match="line 3: expected UTF-8 text, found byte 0xe4"):
        read_text(file)


def test_text_is_read_without_its_byte_order_mark(tmp_path):
    assert read_text(source(tmp_path, "\ufeffäöü")) == "äöü"


def test_stacked_tables_keep_file_line_and_label(tmp_path):
    above = three(source(tmp_path, "1 a 2\n"), delimiter=" ", label_at=1)
    below = three(source(tmp_path, "\n3 b 4\n5 c 6\n"), delimiter=" ", label_at=1)
    table = stacked([above, below])
    assert table.lines.file.tolist() == [0, 1, 1]
    assert table.lines.line.tolist() == [1, 2, 3]
    assert table.label.tolist() == ["a", "b", "c"]
    assert table.columns[0].tolist() == [1, 3, 5]


@pytest.mark.parametrize("value", [1.5, np.nan, np.inf, 2.0**53, -1e300, -(2.0**63), -(2.0**53)])
def test_a_number_that_is_not_whole_is_named_by_line(tmp_path, value):
    file = source(tmp_path, "")
    with pytest.raises(FormatError, match="line 9: expected a whole number as frame, found"):
        whole_numbers(np.array([3.0, value]), Lines.of(file, np.array([8, 9])), "frame")


def test_whole_numbers_may_be_written_with_a_point(tmp_path):
    lines = Lines.of(source(tmp_path, ""), np.array([1, 2]))
    whole = whole_numbers(np.array([3.0, -1.0]), lines, "id")
    assert whole.tolist() == [3, -1]
    assert whole.dtype == np.int64


def test_a_cut_last_line_does_not_tell_the_format():
    assert rows_of_text("1,2\n3,4\n5") == [["1", "2"], ["3", "4"]]
    assert rows_of_text("1,2") == [["1", "2"]]
    assert rows_of_text("\ufeff\n1  2\n", delimiter=" ") == [["1", "2"]]


def test_empty_fields_pass_as_numbers_and_text_does_not():
    assert are_numbers(["1", "", " nan "])
    assert not are_numbers(["1", "person"])


@pytest.mark.parametrize(
    ("field", "expected"), [("3", True), ("3.0", True), ("3.5", False), ("", False), ("a", False)]
)
def test_whole_fields_are_told_from_others(field, expected):
    assert is_whole(field) is expected


@pytest.mark.parametrize("odd", ["7,8,9,10", " 7 , 8,\t9", "\n7,8,9", "7,,9"])
def test_one_odd_line_in_many_is_read_as_if_all_were_read_by_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, odd: str
):
    rows = [f"{row},{row + 1},{row + 2}" for row in range(MANY)]
    file = source(tmp_path, "\n".join([*rows, odd, *rows]) + "\n")
    slow = three(file)
    monkeypatch.setattr(text, "_ODD_BLOCK", 100)
    quick = three(file)
    np.testing.assert_array_equal(np.stack(quick.columns), np.stack(slow.columns))
    np.testing.assert_array_equal(quick.lines.line, slow.lines.line)
    assert quick.lines.line[-1] == 2 * MANY + 1 + odd.count("\n")


def test_a_fault_behind_many_lines_is_named_by_its_line_and_the_lines_before_are_read_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(text, "_ODD_BLOCK", 100)
    by_line = []
    careful = text._careful  # how many lines are read one by one

    def counted(part: str, *arguments: object) -> object:
        by_line.append(part.count("\n"))
        return careful(part, *arguments)

    monkeypatch.setattr(text, "_careful", counted)
    rows = [f"{row},{row + 1},{row + 2}" for row in range(MANY)]
    with pytest.raises(FormatError, match=rf"line {MANY + 1}: .*'a'"):
        three(source(tmp_path, "\n".join([*rows, "1,a,3", *rows])))
    assert sum(by_line) < 100
