"""Small CSV tables with a header: fields by name, and errors with their line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.readers.parse.table import TextTable, parse_table, read_table


def parsed(text: str, *required: str) -> TextTable:
    return parse_table(text.encode(), name="a.csv", what="lamps", required=required)


def test_fields_are_read_by_the_names_of_their_columns():
    table = parsed(" Name ,lux,lit\n\n'=2, 1.5 ,yes\nb,,0\n", "lux", "name")
    assert len(table) == 2
    assert "lit" in table
    assert "colour" not in table
    assert table.texts("name").tolist() == ["=2", "b"]  # no apostrophe, as a spreadsheet shows it
    np.testing.assert_array_equal(table.numbers("lux", may_be_empty=True), [1.5, np.nan])
    assert table.flags("lit").tolist() == [True, False]
    assert table.lines.tolist() == [3, 4]


@pytest.mark.parametrize(("separator", "comma"), [(";", ","), ("\t", "."), (",", ".")])
def test_the_commonest_separator_of_the_header_counts(separator: str, comma: str):
    table = parsed(f"name{separator}lux\na{separator}1{comma}5\n")
    assert table.numbers("lux").tolist() == [1.5]


@pytest.mark.parametrize("text", ["", "x", "nan", "1_000", "1e999", "1,5"])
def test_what_is_no_number_is_refused_with_its_line(text: str):
    with pytest.raises(FormatError, match=r"a\.csv, line 3: lux: expected a number"):
        parsed(f"name\tlux\na\t1\nb\t{text}\n").numbers("lux")


def test_numbers_outside_their_range_are_refused():
    table = parsed("name,lux\na,7\n")
    with pytest.raises(FormatError, match="line 2: lux: expected 0 to 5, found 7"):
        table.numbers("lux", low=0, high=5)
    with pytest.raises(FormatError, match="line 2: lux: expected 8 or more, found 7"):
        table.numbers("lux", low=8)


def test_whole_numbers_flags_and_texts_are_checked():
    table = parsed("name,n\n,1.5\n")
    with pytest.raises(FormatError, match=r"line 2: n: expected a whole number, found 1\.5"):
        table.whole_numbers("n")
    with pytest.raises(FormatError, match=r"line 2: n: expected 1 or 0, found '1\.5'"):
        table.flags("n")
    with pytest.raises(FormatError, match="line 2: name is empty"):
        table.texts("name")
    assert table.texts("name", may_be_empty=True).tolist() == [""]


def test_rows_that_are_there_twice_are_refused():
    table = parsed("name,n\na,1\na,2\na,1\n")
    with pytest.raises(FormatError, match="line 4: a has 1 twice"):
        table.unique(("name", "n"), "{name} has {n} twice")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", r"this is no CSV table of lamps \(it is empty\)"),
        ("name,colour\n", "line 1: a table of lamps has the columns lux, name; lux is missing"),
        ("name,lux,Lux\n", "line 1: there are several columns lux"),
        ("name,lux\na,1,2\n", "line 2: expected 2 fields, as in the first line; found 3"),
        (",".join(["x"] * 101), "line 1: expected 100 columns at the most, found 101"),
        ('name,lux\n"a,1\n', "this is no CSV table of lamps"),
    ],
)
def test_what_is_no_such_table_is_refused(text: str, told: str):
    with pytest.raises(FormatError, match=told):
        parsed(text, "lux", "name")


def test_a_file_is_read_and_named(tmp_path: Path):
    file = tmp_path / "lamps.csv"
    file.write_bytes(b"\xef\xbb\xbfname\na\n")
    assert read_table(file, what="lamps", required=("name",)).texts("name").tolist() == ["a"]
    with pytest.raises(InputError, match=r"gone\.csv: cannot be opened"):
        read_table(tmp_path / "gone.csv", what="lamps", required=())
    file.write_bytes(b"\x89PNG\r\n\xff")
    with pytest.raises(FormatError, match=r"lamps\.csv: this is no CSV table of lamps"):
        read_table(file, what="lamps", required=())
