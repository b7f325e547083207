"""Tables of a store and of results: made of a dataset, divided, joined and compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from nvcore.dataset import Dataset
from nvcore.fleet import ingest
from nvcore.fleet.tables import SOURCES

Tables = dict[str, pa.Table]


def tables_of(dataset: Dataset, thresholds: Mapping[str, float] = {}) -> Tables:
    """All recordings and sources as ingest has them, with thresholds by the systems' names."""
    tables = ingest.tables_of(dataset)
    place = SOURCES.get_field_index("threshold")
    own = [thresholds.get(name) for name in tables["sources"]["source"].to_pylist()]
    values = pa.array(own, SOURCES.field(place).type)
    return tables | {"sources": tables["sources"].set_column(place, SOURCES.field(place), values)}


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
