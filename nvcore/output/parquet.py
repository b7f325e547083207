"""Tables as Parquet: typed columns, nulls for what is missing."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd
import pyarrow as pa


def to_parquet_bytes(tables: pd.DataFrame | Iterable[pd.DataFrame]) -> bytes:
    """The table as Parquet, packed by Zstandard; the same table gives the same bytes.

    Missing values (NaN, None) are null. Texts that repeat are stored once.

    Parameters
    ----------
    tables
        A table, or its parts one after another, at least one; their index is not written. Columns
        of objects hold text, or nothing.
    """
    import pyarrow.parquet as pq

    parts = iter([tables] if isinstance(tables, pd.DataFrame) else tables)
    content = pa.BufferOutputStream()
    table = _arrow(next(parts))
    texts = [field.name for field in table.schema if pa.types.is_string(field.type)]
    # numbers seldom repeat: a dictionary of them takes time
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
