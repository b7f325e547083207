"""Ratings from CSV files: what is read, and what is refused with its line."""

import numpy as np
import pandas as pd
import pytest
from inputs import write

from nvcore.common.errors import FormatError
from nvcore.subjects.ratings.reading import parse_ratings, read_ratings


@pytest.mark.parametrize(
    ("content", "rows"),
    [
        (
            "participant,clip,rating\nP1,A,3\nP1,B,\nP2,A,1.5",
            [("P1", "A", "", 3), ("P1", "B", "", None), ("P2", "A", "", 1.5)],
        ),
        ("Rating, Clip ,system,participant\n7,A,FIR,P1", [("P1", "A", "FIR", 7)]),
        (
            "participant;clip;rating\nP1;A;1,5\nP1;B;2.5\nP1;C;",
            [("P1", "A", "", 1.5), ("P1", "B", "", 2.5), ("P1", "C", "", None)],
        ),
        ("participant\tclip\trating\nP1\tA\t3", [("P1", "A", "", 3)]),
        (
            "participant,clip,rating\nAnna  K,A,3\nanna k,B,4\nBob,A,1",
            [("Anna  K", "A", "", 3), ("Anna  K", "B", "", 4), ("Bob", "A", "", 1)],
        ),
    ],
)
def test_reads_any_order_of_columns_and_separator_and_spelling_of_a_name(content, rows):
    table = parse_ratings(content.encode(), name="r.csv")
    expected = pd.DataFrame(rows, columns=["participant", "clip", "system", "rating"])
    pd.testing.assert_frame_equal(table, expected.astype({"rating": float}), check_dtype=False)


def test_reads_the_time_to_the_rating_where_the_file_has_it(tmp_path):
    lines = ("participant;clip;rating;delay_s", "P1;A;3;2,5", "P1;B;4;")
    delay_s = read_ratings(write(tmp_path / "r.csv", *lines))["delay_s"]
    np.testing.assert_array_equal(delay_s, [2.5, np.nan])
    without = read_ratings(write(tmp_path / "q.csv", "participant,clip,rating", "P1,A,3"))
    assert "delay_s" not in without


@pytest.mark.parametrize(
    ("lines", "line", "words"),
    [
        (["participant,clip,rating", "P1,A,3", "P1,A,4"], 3, "a second time"),
        (["participant,clip,rating", "P1,A,3", "P1,B,much"], 3, "'much'"),
        (["participant,clip,rating", "P1,A,inf"], 2, "'inf'"),
        (["participant,clip,rating,delay_s", "P1,A,3,2", "P1,B,3,soon"], 3, "'soon'"),
        (
            ["participant,clip,rating,delay_s", "P1,A,3,-2"],
            2,
            "delay_s: expected 0 or more, found -2",
        ),
        (["participant,clip,rating", ",A,3"], 2, "participant is empty"),
        (["person,clip,rating", "P1,A,3"], 1, "participant is missing"),
        (["person:clip:rating", "P1:A:3"], 1, "clip and rating are missing"),
        (["participant,clip,system,rating", "P1,A,X,3", "", "P1,A,3"], 4, "found 3"),
        (["participant,clip,rating", "P1,A,3,4"], 2, "expected 3 fields"),
        (["participant,clip,system,rating", "P1,A,X,3", "P1,B,,3"], 3, "system is empty"),
        (["participant,clip,rating", "anna,A,3", "Anna ,A,4"], 3, "anna rates the clip A a second"),
    ],
)
def test_says_what_is_wrong_and_in_which_line(tmp_path, lines, line, words):
    with pytest.raises(FormatError) as caught:
        read_ratings(write(tmp_path / "r.csv", *lines))
    assert caught.value.line == line
    assert words in caught.value.message


@pytest.mark.parametrize("content", [b"", b"\x89PNG\r\n\x1a\n\x00\xff\xfe", b'a,b\n"1'])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "r.csv"
    path.write_bytes(content)
    with pytest.raises(FormatError):
        read_ratings(path)


def test_a_column_that_is_there_twice_is_refused():
    with pytest.raises(FormatError, match="several columns rating"):
        parse_ratings(b"participant,clip,rating,Rating\nA,a,1,2\n", name="r.csv")


def test_blank_lines_are_skipped_and_counted(tmp_path):
    path = write(tmp_path / "r.csv", "participant,clip,rating", "", "P1,A,3", ",,", "P1,B,x")
    with pytest.raises(FormatError) as caught:
        read_ratings(path)
    assert caught.value.line == 5


def test_columns_without_end_are_refused():
    with pytest.raises(FormatError, match="expected 100 columns at the most, found 1,000,001"):
        parse_ratings(b"a," * 1_000_000 + b"\n", name="r.csv")
