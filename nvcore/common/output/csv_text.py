"""Tables as CSV text: deterministic, fast, and harmless in a spreadsheet.

The text is assembled from pyarrow's columns. With a float format, pandas takes seven times as long
(200,000 rows of six floats), and pyarrow's own writer quotes every text and cannot limit digits.
"""

from __future__ import annotations

import re
from typing import Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

DIGITS: Final = 10
"""Significant digits of a float in a report (as ``%.10g``): 1e-6 px is kept up to 1e4 px."""

_ROWS_AT_ONCE = 200_000
_FORMULA = re.compile(r"'*[=+\-@\t\r\n]")


def _scalar(text: str) -> pa.Scalar:
    return pa.scalar(text, pa.large_string())


def spreadsheet_safe(text: str) -> str:
    """Escape text that a spreadsheet would run as a formula, with a leading apostrophe.

    Examples
    --------
    >>> spreadsheet_safe("=1+1"), spreadsheet_safe("V000")
    ("'=1+1", 'V000')
    """
    return "'" + text if _FORMULA.match(text) else text


def without_safeguard(text: str) -> str:
    """Undo `spreadsheet_safe`.

    Examples
    --------
    >>> without_safeguard("'=1+1"), without_safeguard("'quoted'")
    ('=1+1', "'quoted'")
    """
    return text[1:] if text.startswith("'") and _FORMULA.match(text, 1) else text


def to_csv_bytes(
    table: pd.DataFrame, *, digits: int | None = DIGITS, header: bool = True, missing: str = ""
) -> bytes:
    r"""Return a table as UTF-8 CSV with commas and LF line ends. Equal tables give equal bytes.

    Missing values (NaN, None, NaT) are empty, booleans 1 and 0, floats ``%.{digits}g``. Text that a
    spreadsheet would run as a formula gets a leading apostrophe.

    Parameters
    ----------
    table
        Table without its index, which is not written.
    digits
        Significant digits of floats, 1..15. None: as many as needed to read back the same number.
    header
        Whether the first line holds the column names.
    missing
        Text for missing values, for formats that have no empty fields.

    Examples
    --------
    >>> to_csv_bytes(pd.DataFrame({"frame": [1, 2], "score": [0.5, None]}))
    b'frame,score\n1,0.5\n2,\n'
    """
    parts = []
    if header:
        parts.append((",".join(_cell(str(name)) for name in table.columns) + "\n").encode())
    columns = [table.iloc[:, i] for i in range(table.shape[1])]
    for start in range(0, len(table) if columns else 0, _ROWS_AT_ONCE):
        texts = [
            _texts(column.iloc[start : start + _ROWS_AT_ONCE], digits, missing)
            for column in columns
        ]
        texts[-1] = pc.binary_join_element_wise(texts[-1], _scalar("\n"), _scalar(""))
        rows = pc.binary_join_element_wise(*texts, _scalar(","))
        # the array's memory holds the lines one after another, as the file needs them
        parts.append(rows.buffers()[2].to_pybytes())
    return b"".join(parts)


def round_significant(values: np.ndarray, digits: int) -> np.ndarray:
    """Round float64 values to significant digits. NaN, infinities and 0 stay as they are."""
    with np.errstate(divide="ignore", invalid="ignore"):
        places = digits - 1 - np.floor(np.log10(np.abs(values)))
    places = np.where(values == 0, 0, places)
    # powers of ten up to 10**22 are exact, so the quotient is the number nearest to the text
    is_near = np.abs(places) <= 22
    places = np.where(is_near, places, 0)
    up, down = 10.0 ** np.maximum(places, 0), 10.0 ** np.maximum(-places, 0)
    result = np.where(is_near, np.rint(values * up / down) / up * down, values)
    for i in np.flatnonzero(~is_near & np.isfinite(values)):  # rare: below 1e-12, above 1e31
        result[i] = float(f"{values[i]:.{digits}g}")
    return result + 0.0  # avoids negative zero


def _texts(column: pd.Series, digits: int | None, missing: str) -> pa.Array:
    """Return the cells of a column as text."""
    if isinstance(column.dtype, pd.CategoricalDtype):
        column = column.astype(object)
    if pd.api.types.is_float_dtype(column.dtype):
        values = column.to_numpy(dtype=float, na_value=np.nan)
        values = values + 0.0 if digits is None else round_significant(values, digits)
        texts = pa.array(values, from_pandas=True).cast(pa.large_string())
    elif pd.api.types.is_bool_dtype(column.dtype):
        texts = pa.array(column, from_pandas=True).cast(pa.int8()).cast(pa.large_string())
    elif pd.api.types.is_integer_dtype(column.dtype):
        texts = pa.array(column, from_pandas=True).cast(pa.large_string())
    else:
        texts = _other_texts(column)
    return pc.fill_null(texts, _scalar(missing))


def _other_texts(column: pd.Series) -> pa.Array:
    """Return the cells of a text or mixed column, converting every distinct value once."""
    codes, unique = pd.factorize(column.astype(object), use_na_sentinel=True)
    cells = pa.array([_cell(value) for value in unique], pa.large_string())
    return cells.take(pa.array(codes, mask=codes < 0))


def _cell(value: object) -> str:
    text = spreadsheet_safe(value) if isinstance(value, str) else str(value)
    if any(sign in text for sign in ',"\n\r'):
        return '"' + text.replace('"', '""') + '"'
    return text
