"""Number tables: the quick and the careful way give the same, faults are named by line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.text import (
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


def source(tmp_path: Path, content: str | bytes) -> SourceFile:
    path = tmp_path / "table.txt"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return SourceFile(path, "drive/table.txt")


def three(file: SourceFile, **options: object):
    return read_numbers(file, **{"n_columns": (3, 4), "what": "a,b,c", **options})


def padded(content: str) -> str:
    """The content with enough good rows behind it for the quick parser to be tried."""
    return content + "7,8,9\n" * MANY


@pytest.mark.parametrize("rows", [1, MANY], ids=["small", "large"])
def test_fields_become_columns_and_absent_columns_are_nan(tmp_path, rows):
    table = three(source(tmp_path, "1,2.5,-3\n" * rows))
    assert [column[0] for column in table.columns[:3]] == [1, 2.5, -3]
    assert np.isnan(table.columns[3]).all()
    assert table.line.tolist() == list(range(1, rows + 1))


@pytest.mark.parametrize("content", ["", "\n", " \n\t\n", "\n" * 5000, "\ufeff"])
def test_a_file_of_nothing_gives_no_rows(tmp_path, content):
    table = three(source(tmp_path, content))
    assert len(table) == 0
    assert [len(column) for column in table.columns] == [0, 0, 0, 0]


@pytest.mark.parametrize("tail", [padded(""), ""], ids=["large", "small"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["LF", "CRLF", "CR"])
def test_every_kind_of_line_end_and_blank_lines_keep_the_line_numbers(tmp_path, end, tail):
    content = ("\n1,2,3\n\n4,5,6\n" + tail).replace("\n", end)
    table = three(source(tmp_path, content))
    assert table.line[:2].tolist() == [2, 4]
    assert table.columns[2][:2].tolist() == [3, 6]
    assert len(table.line) == len(table.columns[0])


@pytest.mark.parametrize(
    "row",
    ["1, 2,\t3", " 1 ,2 ,3 ", '"1","2","3"', "+1,2e0,3.", "\ufeff1,2,3"],
)
@pytest.mark.parametrize("is_large", [False, True])
def test_blanks_quotes_signs_and_the_byte_order_mark_are_no_fault(tmp_path, row, is_large):
    content = padded(row + "\n") if is_large else row
    table = three(source(tmp_path, content))
    assert [column[0] for column in table.columns[:3]] == [1, 2, 3]


@pytest.mark.parametrize("is_large", [False, True])
@pytest.mark.parametrize("field", ["", " ", "nan", "NaN"])
def test_an_empty_field_and_nan_are_passed_on_as_nan(tmp_path, field, is_large):
    content = f"1,{field},3\n"
    table = three(source(tmp_path, padded(content) if is_large else content))
    assert np.isnan(table.columns[1][0])
    assert table.columns[2][0] == 3


def test_rows_of_different_allowed_lengths_are_filled_with_nan(tmp_path):
    table = three(source(tmp_path, padded("1,2,3\n1,2,3,4\n")))
    assert np.isnan(table.columns[3][0])
    assert table.columns[3][1] == 4
    assert len(table) == MANY + 2


@pytest.mark.parametrize("is_large", [False, True])
def test_a_row_of_the_wrong_length_is_named_by_file_and_line(tmp_path, is_large):
    content = "1,2,3\n\n1,2\n"
    with pytest.raises(FormatError, match=r"drive/table\.txt, line 3: expected 3 or 4 fields"):
        three(source(tmp_path, padded(content) if is_large else content))


@pytest.mark.parametrize("wrong", ["person", "1_000", '"1', "0x10", "1;2"])
@pytest.mark.parametrize("is_large", [False, True])
def test_text_where_a_number_belongs_is_named_by_line(tmp_path, wrong, is_large):
    content = f"1,2,3\n1,{wrong},3\n"
    with pytest.raises(FormatError, match=r"line 2: expected numbers \(a,b,c\), found"):
        three(source(tmp_path, padded(content) if is_large else content))


def test_a_quoted_number_with_a_decimal_comma_is_not_two_numbers(tmp_path):
    with pytest.raises(FormatError, match="line 1: expected numbers"):
        three(source(tmp_path, '1,"2,5",3\n'))


def test_a_picture_is_told_from_text(tmp_path):
    with pytest.raises(FormatError, match="found a PNG picture"):
        three(source(tmp_path, b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20))


def test_utf_16_text_is_told_from_utf_8(tmp_path):
    with pytest.raises(FormatError, match="found UTF-16 text: save it as UTF-8"):
        three(source(tmp_path, "1,2,3\n".encode("utf-16")))


def test_a_long_field_is_cut_in_the_error(tmp_path):
    with pytest.raises(FormatError, match=r"x{59}…'$"):
        three(source(tmp_path, f"1,2,{'x' * 5000}\n"))


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
    assert table.line.tolist() == [2]


def test_text_that_is_no_utf_8_is_named_by_the_line_behind_a_byte_order_mark(tmp_path):
    file = source(tmp_path, b"\xef\xbb\xbf1\n2\n\xe4\n")
    with pytest.raises(FormatError, match="line 3: expected UTF-8 text, found byte 0xe4"):
        read_text(file)


def test_text_is_read_without_its_byte_order_mark(tmp_path):
    assert read_text(source(tmp_path, "\ufeffäöü")) == "äöü"


def test_stacked_tables_keep_file_line_and_label(tmp_path):
    one = three(source(tmp_path, "1 a 2\n"), delimiter=" ", label_at=1)
    two = three(source(tmp_path, "\n3 b 4\n5 c 6\n"), delimiter=" ", label_at=1)
    table, file = stacked([one, two])
    assert file.tolist() == [0, 1, 1]
    assert table.line.tolist() == [1, 2, 3]
    assert table.label.tolist() == ["a", "b", "c"]
    assert table.columns[0].tolist() == [1, 3, 5]


@pytest.mark.parametrize("value", [1.5, np.nan, np.inf, 2.0**53, -1e300])
def test_a_number_that_is_not_whole_is_named_by_line(tmp_path, value):
    file = source(tmp_path, "")
    with pytest.raises(FormatError, match="line 9: expected a whole number as frame, found"):
        whole_numbers(np.array([3.0, value]), file, np.array([8, 9]), "frame")


def test_whole_numbers_may_be_written_with_a_point(tmp_path):
    whole = whole_numbers(np.array([3.0, -1.0]), source(tmp_path, ""), np.array([1, 2]), "id")
    assert whole.tolist() == [3, -1]
    assert whole.dtype == np.int64


def test_a_cut_last_line_does_not_tell_the_format():
    assert rows_of_text("1,2\n3,4\n5") == [["1", "2"], ["3", "4"]]
    assert rows_of_text("1,2") == [["1", "2"]]
    assert rows_of_text("\ufeff% x\n\n1  2\n", delimiter=" ", comment="%") == [["1", "2"]]


def test_empty_fields_pass_as_numbers_and_text_does_not():
    assert are_numbers(["1", "", " nan "])
    assert not are_numbers(["1", "person"])


@pytest.mark.parametrize(
    ("field", "expected"), [("3", True), ("3.0", True), ("3.5", False), ("", False), ("a", False)]
)
def test_whole_fields_are_told_from_others(field, expected):
    assert is_whole(field) is expected
