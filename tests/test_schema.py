from __future__ import annotations

import numpy as np
import pytest

from nvcore.dataset.schema import (
    BOX_DTYPES,
    DATASET_BOX_DTYPES,
    FRAME_DTYPES,
    NO_TRACK,
    READING_DTYPES,
    UNKNOWN_OCCLUSION,
    conform,
)


def test_what_is_not_given_is_unknown() -> None:
    row = conform({"x": [1.0]}, BOX_DTYPES, n_rows=1).iloc[0]
    assert row["x"] == 1
    assert np.isnan(row["score"])
    assert np.isnan(row["distance_m"])
    assert row["track"] == NO_TRACK
    assert row["occlusion"] == UNKNOWN_OCCLUSION
    assert not row["ignore"]
    assert row["line"] == 0


@pytest.mark.parametrize("dtypes", [READING_DTYPES, DATASET_BOX_DTYPES, FRAME_DTYPES])
def test_an_empty_table_keeps_its_columns_and_dtypes(dtypes: dict[str, str]) -> None:
    table = conform({}, dtypes, n_rows=0)
    assert {name: str(dtype) for name, dtype in table.dtypes.items()} == dtypes


def test_a_scalar_fills_its_column() -> None:
    table = conform({"track": 7, "ignore": True}, BOX_DTYPES, n_rows=3)
    assert table["track"].tolist() == [7, 7, 7]
    assert table["ignore"].tolist() == [True, True, True]


def test_columns_stand_in_the_order_of_the_schema_with_its_dtypes() -> None:
    table = conform({"h": [2], "x": [1], "track": [3.0]}, BOX_DTYPES, n_rows=1)
    assert {name: str(dtype) for name, dtype in table.dtypes.items()} == BOX_DTYPES
    assert list(table) == list(BOX_DTYPES)


def test_a_column_outside_the_schema_is_our_own_mistake() -> None:
    with pytest.raises(AssertionError, match="confidence"):
        conform({"confidence": [1.0]}, BOX_DTYPES, n_rows=1)
