"""Tables of a store and of results: divided, joined and compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

Tables = dict[str, pa.Table]


def only(tables: Tables, names: Sequence[str]) -> Tables:
    """Those recordings, in the order of the names."""
    return {
        name: pa.concat_tables([table.filter(pc.equal(table["recording"], of)) for of in names])
        for name, table in tables.items()
    }


def joined(parts: Sequence[Tables]) -> Tables:
    """Results of several batches as one, by recording."""
    tables = {}
    for name in parts[0]:
        table = pa.concat_tables([part[name] for part in parts])
        names = np.array(table["recording"].to_pylist(), dtype=object)
        tables[name] = table.take(np.argsort(names, kind="stable"))
    return tables


def assert_same(tables: Tables, others: Tables) -> None:
    """Equal to the bit, column by column."""
    assert [*tables] == [*others]
    for name, table in tables.items():
        other = others[name]
        assert table.schema.equals(other.schema, check_metadata=True), name
        for column in table.column_names:
            assert table[column].equals(other[column]), f"{name}: {column}"
