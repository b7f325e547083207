"""Tables as Parquet: typed columns, nulls for missing values."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd
import pyarrow as pa


def to_parquet_bytes(tables: pd.DataFrame | Iterable[pd.DataFrame]) -> bytes:
    """Return a table as Zstandard-compressed Parquet. Equal tables give equal bytes.

    Missing values (NaN, None) are null. Repeated texts are stored once.

    Parameters
    ----------
    tables
        A table, or at least one part of a table, in order. The index is not written. Object columns
        hold text or missing values.
    """
    import pyarrow.parquet as pq

    parts = iter([tables] if isinstance(tables, pd.DataFrame) else tables)
    content = pa.BufferOutputStream()
    table = _arrow(next(parts))
    texts = [field.name for field in table.schema if pa.types.is_string(field.type)]
    # numbers seldom repeat, so a dictionary would only take time
    options = {"compression": "zstd", "use_dictionary": texts or False}
    with pq.ParquetWriter(content, table.schema, **options) as writer:
        writer.write_table(table)
        for part in parts:
            writer.write_table(_arrow(part))
    packed: bytes = content.getvalue().to_pybytes()
    return packed


def _arrow(table: pd.DataFrame) -> pa.Table:
    columns = [_column(table.iloc[:, i]) for i in range(table.shape[1])]
    return pa.Table.from_arrays(columns, names=[str(name) for name in table.columns])


def _column(column: pd.Series) -> pa.Array:
    if column.dtype == object:
        return pa.array(column.where(column.notna(), None), pa.string(), from_pandas=True)
    values = pa.array(column, from_pandas=True)
    if pa.types.is_dictionary(values.type) or pa.types.is_large_string(values.type):
        return values.cast(pa.string())
    return values
