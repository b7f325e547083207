"""A dataset as the tables of a store, as ingest writes them."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from nvcore.dataset import Dataset
from nvcore.fleet.results import typed
from nvcore.fleet.tables import BOXES, FRAMES, RECORDINGS, SOURCES

NOW = datetime(2026, 1, 1, tzinfo=UTC)
Tables = dict[str, pa.Table]


def tables_of(dataset: Dataset, thresholds: Mapping[str, float] = {}) -> Tables:
    """All recordings and sources, sorted as in a store; thresholds by the systems' names."""
    names = dataset.recordings["name"].tolist()
    sources = ["truth", *dataset.systems]
    frames = dataset.frames
    boxes = dataset.boxes.copy()
    recording = frames["recording"].to_numpy()[boxes["frame_index"]]
    boxes["recording"] = np.array(names, dtype=object)[recording]
    boxes["frame"] = frames["frame"].to_numpy()[boxes["frame_index"]]
    boxes["number"] = boxes["source"]
    boxes["source"] = np.array(sources, dtype=object)[boxes["source"]]
    labels = np.array([*dataset.labels, None], dtype=object)
    boxes["label"] = labels[boxes["label"]]
    key = ["file", "line"]
    texts = dataset.attributes.set_index(key)["attributes"].astype(object)
    own = texts.reindex(pd.MultiIndex.from_frame(boxes[key])).to_numpy()
    boxes["attributes"] = np.where(boxes["number"] == 0, own, None)
    boxes = boxes.sort_values(["recording", "number"], kind="stable")
    objects = [dataset.objects.singular, dataset.objects.plural]
    recordings = dataset.recordings.rename(columns={"name": "recording"}).assign(
        sha256=[hashlib.sha256(name.encode()).hexdigest() for name in names],
        ingested_at=NOW,
        pictures="",
        objects=[objects] * len(names),
        tags=[[*tags] for tags in dataset.recordings["tags"]],
        source="",
    )
    listed = frames.assign(recording=np.array(names, dtype=object)[frames["recording"]])
    rows = [
        {"recording": name, "source": source, "sha256": f"{name} {source}", "label": "",
         "kind": "system" if source in dataset.systems else "annotated",
         "threshold": thresholds.get(source)}
        for name in names for source in sources
    ]  # fmt: skip
    return {
        "recordings": typed(recordings.sort_values("recording"), RECORDINGS),
        "sources": typed(pd.DataFrame(rows), SOURCES),
        "frames": typed(listed.sort_values(["recording", "frame"]), FRAMES),
        "boxes": typed(boxes, BOXES),
    }


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
