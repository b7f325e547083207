"""Tables as Parquet: typed columns, nulls for what is missing."""

from __future__ import annotations

import pandas as pd
import pyarrow as pa


def to_parquet_bytes(table: pd.DataFrame) -> bytes:
    """The table as Parquet, packed by Zstandard; the same table gives the same bytes.

    Missing values (NaN, None) are null. Texts that repeat are stored once.

    Parameters
    ----------
    table
        Its index is not written. Columns of objects hold text, or nothing.
    """
    import pyarrow.parquet as pq

    columns = [_column(table.iloc[:, i]) for i in range(table.shape[1])]
    content = pa.BufferOutputStream()
    names = [str(name) for name in table.columns]
    pq.write_table(pa.Table.from_arrays(columns, names=names), content, compression="zstd")
    packed: bytes = content.getvalue().to_pybytes()
    return packed


def _column(column: pd.Series) -> pa.Array:
    if column.dtype == object or isinstance(column.dtype, pd.CategoricalDtype):
        texts = column.astype(object)
        return pa.array(texts.where(texts.notna(), None), pa.string(), from_pandas=True)
    values = pa.array(column, from_pandas=True)
    return values.cast(pa.string()) if pa.types.is_large_string(values.type) else values
