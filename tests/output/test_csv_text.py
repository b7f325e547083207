from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nvcore.common.output.csv_text import (
    round_significant,
    spreadsheet_safe,
    to_csv_bytes,
    without_safeguard,
)


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@sum", "\tx", "\rx", "'=1"])
def test_a_text_that_a_spreadsheet_would_run_gets_an_apostrophe(text):
    assert spreadsheet_safe(text) == "'" + text


@pytest.mark.parametrize("text", ["", "V000", "a=b", "it's", "'quoted'"])
def test_a_harmless_text_stays_as_it_is(text):
    assert spreadsheet_safe(text) == text


@given(st.text(alphabet="'=+-@\t\rab"))
def test_taking_the_safeguard_off_gives_the_text_back(text):
    assert without_safeguard(spreadsheet_safe(text)) == text


def test_missing_values_are_empty_and_booleans_are_digits():
    table = pd.DataFrame(
        {
            "a": [1.5, np.nan],
            "b": pd.array([1, None], dtype="Int64"),
            "c": [True, False],
            "d": ["x", None],
            "e": pd.array([True, None], dtype="boolean"),
            "f": pd.Categorical(["k", None]),
            "g": [None, None],
        }
    )
    assert to_csv_bytes(table) == b"a,b,c,d,e,f,g\n1.5,1,1,x,1,k,\n,,0,,,,\n"


@pytest.mark.parametrize(
    ("columns", "text"),
    [
        ({"=a": ['say "hi", you', "-x", "two\nlines"]},
         '\'=a\n"say ""hi"", you"\n\'-x\n"two\nlines"\n'),
        ({"a": [-1.5], "b": [-2]}, "a,b\n-1.5,-2\n"),  # a negative number is no formula
        ({"a": ["Größe"]}, "a\nGröße\n"),
        ({"a": [], "b": []}, "a,b\n"),
        ({"a": [1234.123456, -0.0]}, "a\n1234.123456\n0\n"),
    ],
)  # fmt: skip
def test_texts_are_quoted_and_neutralised_and_numbers_written_plainly(columns, text):
    assert to_csv_bytes(pd.DataFrame(columns)) == text.encode()


def test_header_can_be_left_out_and_missing_named():
    table = pd.DataFrame({"a": [np.nan, 1.0]})
    assert to_csv_bytes(table, header=False, missing="nan") == b"nan\n1\n"


def test_rows_beyond_one_portion_are_all_written():
    table = pd.DataFrame({"a": np.arange(450_000), "b": "t"})
    back = pd.read_csv(io.BytesIO(to_csv_bytes(table)))
    pd.testing.assert_frame_equal(back, table, check_dtype=False)


@given(st.floats(allow_nan=False, allow_infinity=False, min_value=-1e300, max_value=1e300))
def test_floats_have_ten_significant_digits(value):
    # half a unit of the last digit, and what the product with a power of ten rounds
    written = float(round_significant(np.array([value]), 10)[0])
    assert written == pytest.approx(value, rel=5.0001e-10, abs=5e-324)
    assert len(repr(written).split("e")[0].replace("-", "").replace(".", "").strip("0")) <= 10


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=5))
def test_without_a_limit_of_digits_numbers_come_back_exactly(values):
    lines = to_csv_bytes(pd.DataFrame({"a": values}), digits=None).decode().split()[1:]
    assert [float(line) for line in lines] == values
