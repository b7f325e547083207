"""What is appended to a store is read again, whole, whoever writes or dies beside it."""

from __future__ import annotations

import json
import multiprocessing
import pickle
import resource
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from builders import Box, make_dataset
from deltalake import DeltaTable, Schema
from object_store import options, troubled
from store_writers import (
    DyingStore,
    Killed,
    append_and_be_killed,
    append_each,
    batch_of,
    recordings,
)

from nvcore.common.errors import FormatError, InputError, StoreError
from nvcore.dataset import Dataset
from nvcore.subjects.fleet import store as store_module
from nvcore.subjects.fleet.ingest import tables_of
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.store import Snapshot, Store
from nvcore.subjects.fleet.tables import SCHEMAS

SPAWN = multiprocessing.get_context("spawn")
WRITES = 8  # files of four tables, and their commits


def content(snapshot: Snapshot) -> pd.DataFrame:
    """All boxes of a store, without when and where they came."""
    names = snapshot.recordings["recording"].tolist()
    return snapshot.read(names, ["truth", "x", "y"])["boxes"].to_pandas()


def check_same(snapshot: Snapshot, dataset: Dataset) -> None:
    """That reading all of it gives the rows of the dataset."""
    systems = dataset.systems
    tables = snapshot.read(dataset.recordings["name"].tolist(), ["truth", *systems])
    frames, boxes = tables["frames"].to_pandas(), tables["boxes"].to_pandas()
    names = dataset.recordings["name"].to_numpy()
    own = dataset.boxes.assign(
        recording=names[dataset.frames["recording"].to_numpy()[dataset.boxes["frame_index"]]],
        frame=dataset.frames["frame"].to_numpy()[dataset.boxes["frame_index"]],
    ).sort_values(["recording", "source"], kind="stable", ignore_index=True)
    own_frames = dataset.frames.assign(name=names[dataset.frames["recording"]])
    own_frames = own_frames.sort_values("name", kind="stable", ignore_index=True)
    assert frames["recording"].tolist() == own_frames["name"].tolist()
    assert boxes["recording"].tolist() == own["recording"].tolist()
    assert boxes["source"].tolist() == np.array(["truth", *systems])[own["source"]].tolist()
    labels = [*dataset.labels, None]
    assert boxes["label"].astype(object).where(boxes["label"].notna(), None).tolist() == [
        labels[code] for code in own["label"]
    ]
    for table, expected in ((frames, own_frames), (boxes, own)):
        for name in set(table) & set(expected) - {"recording", "source", "label"}:
            np.testing.assert_array_equal(table[name], expected[name].to_numpy(), err_msg=name)
    for rows, of in (("recordings", "frames"), ("sources", "boxes")):
        for row in tables[rows].to_pylist():
            stretch = tables[of].slice(row["first_row"], row["n_rows"]).to_pandas()
            assert (stretch["recording"] == row["recording"]).all()


def test_a_dataset_is_read_as_it_was_appended(place: Location):
    full = Box(3, 1.5, 2.5, 10, 20, 7, 0.25, True, 12.5, 1, 0, 0.75)
    truth = [full._replace(frame=frame, label=frame % 3 - 1) for frame in (0, 5, 6, 6)]
    dataset = make_dataset(truth, [full], labels=("zebra", "ant"), n_frames=9, horizon=40)
    dataset = replace(dataset, systems=("A", "none"))
    store = Store(place)
    new, _ = store.append([tables_of(dataset, truth_kind="automatic", labels={"A": "spring"})])
    snapshot = pickle.loads(pickle.dumps(store.snapshot()))
    check_same(snapshot, dataset)
    assert [len(rows) for rows in new.values()] == [1, 3]
    columns = ["source", "kind", "label", "version", "n_rows"]
    assert snapshot.sources[columns].to_numpy().tolist() == [
        ["A", "system", "spring", 1, 1],
        ["none", "system", "", 1, 0],
        ["truth", "automatic", "", 1, 4],
    ]
    row = snapshot.recordings.iloc[0]
    assert [row[name] for name in ("width", "fps", "horizon")] == [100, 10, 40]
    assert row["duration_s"] == pytest.approx(0.9)
    assert np.isnan(row["context"])
    assert len(pickle.dumps(snapshot)) < 1000


def test_only_what_is_asked_for_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(store_module, "GROUP_ROWS", 20)  # recordings of 30 frames are split
    names = [f"r{number}" for number in range(6)]
    dataset = recordings(*names)
    store = Store(tmp_path)
    store.append([tables_of(dataset)])
    snapshot = store.snapshot()
    check_same(snapshot, dataset)
    (file,) = (tmp_path / "boxes").glob("*.parquet")
    groups = []
    read = pq.ParquetFile.read_row_groups

    def counting(self: pq.ParquetFile, of: list[int], **more: object) -> object:
        groups.append(len(of))
        return read(self, of, **more)

    monkeypatch.setattr(pq.ParquetFile, "read_row_groups", counting)
    tables = snapshot.read(["r3", "r1"], ["y", "x"])
    assert sum(groups) < pq.ParquetFile(file).num_row_groups
    boxes = tables["boxes"].to_pandas()
    pairs = boxes[["recording", "source"]].drop_duplicates().to_numpy().tolist()
    assert pairs == [["r1", "y"], ["r1", "x"], ["r3", "y"], ["r3", "x"]]
    whole = content(snapshot)
    for (recording, source), part in boxes.groupby(["recording", "source"], observed=True):
        own = whole[(whole["recording"] == recording) & (whole["source"] == source)]
        np.testing.assert_array_equal(part["x"], own["x"])
    empty = snapshot.read([], [])
    assert not any(len(empty[name]) for name in ("recordings", "sources", "frames", "boxes"))
    assert empty["boxes"].schema == tables["boxes"].schema


def test_a_changed_source_is_a_new_version_and_the_same_one_is_none(tmp_path: Path):
    store = Store(tmp_path)
    store.append(batch_of("a", "b"))
    before = store.snapshot()
    files = sorted(tmp_path.rglob("*"))
    again, older = store.append(batch_of("b", "a"))
    assert [len(rows) for rows in again.values()] == [0, 0]
    assert not older
    assert sorted(tmp_path.rglob("*")) == files
    store.append([tables_of(recordings("a", seed=1), labels={"x": "second"})])
    now = store.snapshot()
    assert content(before).equals(content(Snapshot(before.location, before.versions)))
    versions = now.sources.groupby(["recording", "source"])["version"].max()
    assert versions["a"].tolist() == [2, 2, 2]
    assert versions["b"].tolist() == [1, 1, 1]
    one, two = (now.read(["a"], [asked])["boxes"].to_pandas() for asked in ("x@1", "x@second"))
    assert one["source"].unique().tolist() == ["x@1"]
    np.testing.assert_array_equal(
        one["x"], content(before).query("recording == 'a' and source == 'x'")["x"]
    )
    assert not np.array_equal(one["x"], two["x"])
    np.testing.assert_array_equal(now.read(["a"], ["x"])["boxes"]["x"], two["x"])
    assert now.pick("x@2")["recording"].tolist() == ["a"]
    # the frame rate was corrected: another recording, with the boxes that it had
    corrected = recordings("b", fps=25.0)
    new, _ = store.append([tables_of(corrected)])
    assert [len(rows) for rows in new.values()] == [1, 0]
    check_same(store.snapshot(), corrected)
    assert store.snapshot().pick("x")["version"].tolist() == [2, 1]
    assert len([*(tmp_path / "boxes").glob("*.parquet")]) == 2
    for asked, words in (
        ("z", "there is no source 'z'; there are truth, x and y"),
        ("x@3", "there is no version '3' of 'x'; there are 1 to 2, and second"),
    ):
        with pytest.raises(InputError, match=words):
            now.pick(asked)
    with pytest.raises(InputError, match="there is no recording 'c'"):
        now.read(["a", "c"], ["x"])


def test_what_came_last_is_the_newest_whatever_the_clock_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    days = iter(range(28, 0, -1))
    clock = SimpleNamespace(now=lambda zone: datetime(2026, 1, next(days), tzinfo=zone))
    monkeypatch.setattr(store_module, "datetime", clock)
    first, second = recordings("a", fps=20.0), recordings("a", fps=25.0, seed=1)
    for given, asks, newest, version in (
        (first, False, first, 1), (second, False, second, 2), (first, False, second, 2),
        (first, True, first, 1), (first, True, first, 1), (second, True, second, 2),
    ):  # fmt: skip
        Store(tmp_path).append([tables_of(given)], newest=asks)
        check_same(Store(tmp_path).snapshot(), newest)
        assert Store(tmp_path).snapshot().recordings["fps"].item() == newest.recordings["fps"][0]
        assert Store(tmp_path).snapshot().pick("x")["version"].tolist() == [version]
    assert [len([*(tmp_path / of).glob("*.parquet")]) for of in ("boxes", "sources")] == [2, 4]


def test_a_note_on_an_older_version_leaves_the_newest_one(tmp_path: Path):
    store, first, second = Store(tmp_path), recordings("a"), recordings("a", seed=1)
    for dataset in (first, second):
        store.append([tables_of(dataset)])
    before = store.snapshot().recordings
    store.append([tables_of(first, labels={"x": "old"}, truth_kind="automatic")])
    snapshot = store.snapshot()
    check_same(snapshot, second)
    assert snapshot.recordings.equals(before)
    assert snapshot.pick("x@old")["version"].tolist() == [1]
    assert snapshot.sources.query("source == 'truth'")["kind"].tolist() == [
        "automatic",
        "annotated",
    ]


def test_the_other_version_of_a_recording_is_newest_if_asked_for_one_source(tmp_path: Path):
    store, old, new = Store(tmp_path), recordings("a"), recordings("a", fps=25.0)
    for dataset in (old, new):
        store.append([tables_of(dataset)])
    store.append([tables_of(old)], newest=True)
    check_same(store.snapshot(), old)
    assert store.snapshot().recordings["fps"].tolist() == [10]


@pytest.mark.parametrize("name", ["recordings", "sources", "frames", "boxes"])
def test_a_log_without_its_newest_commit_is_an_error(tmp_path: Path, name: str):
    store = Store(tmp_path)
    store.append(batch_of("a"))
    store.append(batch_of("b"))
    (tmp_path / name / "_delta_log" / f"{2:020}.json").unlink()
    for use in (Store(tmp_path).snapshot, lambda: Store(tmp_path).append(batch_of("a"))):
        with pytest.raises(StoreError, match=rf"{name}/_delta_log: version 2 .* is missing"):
            use()
    (tmp_path / "versions.json").write_text("[]")
    with pytest.raises(StoreError, match=r"versions.json: is damaged; delete it"):
        Store(tmp_path).snapshot()
    (tmp_path / "versions.json").unlink()
    if name == "recordings":  # that sources refer to others is noticed without the file, too
        with pytest.raises(StoreError, match="recordings/_delta_log: a commit is missing"):
            _ = Store(tmp_path).snapshot().recordings
    Store(tmp_path).append(batch_of("b"))
    check_same(Store(tmp_path).snapshot(), recordings("b"))


def test_versions_that_are_behind_the_tables_are_no_error(tmp_path: Path):
    store = Store(tmp_path)
    store.append(batch_of("a"))
    earlier = (tmp_path / "versions.json").read_bytes()
    store.append(batch_of("b"))
    (tmp_path / "versions.json").write_bytes(earlier)  # as if the writer was killed before
    assert store.snapshot().recordings["recording"].tolist() == ["a", "b"]


def test_a_store_without_columns_that_were_added_later_is_read_and_appended_to(tmp_path: Path):
    Store(tmp_path).append(batch_of("a"))
    for name, column in (("recordings", "parameters"), ("sources", "amends")):
        [file] = (tmp_path / name).glob("*.parquet")
        size = file.stat().st_size
        pq.write_table(pq.read_table(file).drop_columns([column]), file)
        commit = tmp_path / name / "_delta_log" / f"{1:020}.json"
        commit.write_text(commit.read_text().replace(f":{size}", f":{file.stat().st_size}"))
        log = tmp_path / name / "_delta_log" / f"{0:020}.json"
        lines = [json.loads(line) for line in log.read_text().splitlines()]
        [facts] = [line["metaData"] for line in lines if "metaData" in line]
        schema = json.loads(facts["schemaString"])
        schema["fields"] = [of for of in schema["fields"] if of["name"] != column]
        facts["schemaString"] = json.dumps(schema)
        log.write_text("\n".join(map(json.dumps, lines)))
    Store(tmp_path).append(batch_of("b"))
    snapshot = Store(tmp_path).snapshot()
    check_same(snapshot, recordings("a"))
    assert snapshot.recordings["parameters"].tolist() == ["", ""]
    assert len(DeltaTable(tmp_path / "sources").to_pandas()) == 6


def test_what_came_with_another_version_of_its_recording_is_left_out(tmp_path: Path):
    store, dataset = Store(tmp_path), recordings("a", "b")
    store.append([tables_of(dataset)])
    larger = recordings("a", width=1280.0)
    alone = replace(larger, systems=("x",), boxes=larger.boxes[larger.boxes["source"] < 2])
    store.append([tables_of(alone)])
    now = store.snapshot()
    assert [now.pick(source)["recording"].tolist() for source in ("truth", "x", "y", "y@1")] == [
        *(["a", "b"], ["a", "b"], ["b"], ["b"])
    ]
    store.append([tables_of(larger)])
    check_same(store.snapshot(), larger)


def test_a_store_whose_files_were_partitioned_is_read_and_appended_to(tmp_path: Path):
    for name in ("frames", "boxes"):
        schema = pa.schema([*SCHEMAS[name], ("unit", pa.string())])
        DeltaTable.create(tmp_path / name, Schema.from_arrow(schema), partition_by=["unit"])
    for name in "ab":
        Store(tmp_path).append(batch_of(name))
    check_same(Store(tmp_path).snapshot(), recordings("b"))
    table = DeltaTable(tmp_path / "boxes").to_pandas()
    assert sorted(set(table["recording"])) == ["a", "b"]
    assert table["unit"].isna().all()


def test_hostile_names_are_names_alone(place: Location):
    names = [
        "../../x",
        "a\"b'c; DROP TABLE boxes",
        "two\nlines",
        "/etc/passwd",
        "ä\u202e\0",
        "n" * 10_000,
    ]
    dataset = replace(recordings(*names), systems=("x@2", "../truth\n"))
    store = Store(place)
    store.append([tables_of(dataset)])
    check_same(store.snapshot(), dataset)
    tops = {entry.path.partition("/")[0] for entry in place.list()}
    assert tops == {"recordings", "sources", "frames", "boxes", "versions.json"}
    if place.path:
        assert {path.name for path in place.path.parent.iterdir()} == {place.path.name}
    table = DeltaTable(f"{place.uri}/boxes", storage_options=place.delta_options)
    assert sorted(set(table.to_pandas()["recording"])) == sorted(names)
    bad = replace(dataset, systems=("\ud800", "y"))
    with pytest.raises(InputError, match="a name is not valid UTF-8"):
        tables_of(bad)


def test_writers_at_once_lose_nothing_of_each_other(place: Location, tmp_path: Path):
    ours, theirs = ([f"{who}{number}" for number in range(4)] for who in ("own", "their"))
    writers = [
        SPAWN.Process(target=append_each, args=(place, tmp_path / names[0], "both", *names, "both"))
        for names in (ours, theirs)
    ]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert (tmp_path / ours[0]).exists()
    assert (tmp_path / theirs[0]).exists()
    snapshot = Store(place).snapshot()
    assert snapshot.recordings["recording"].tolist() == sorted([*ours, *theirs, "both"])
    assert snapshot.sources["version"].unique().tolist() == [1]
    check_same(snapshot, recordings("both"))
    check_same(snapshot, recordings("their3"))


def test_a_writer_that_dies_leaves_nothing_that_is_seen(tmp_path: Path):
    location = Location(tmp_path / "store")

    def end() -> None:
        raise Killed

    for n in range(WRITES):  # also of the first ones, that make the store
        with pytest.raises(Killed):
            DyingStore(Location(tmp_path / f"new{n}"), n, end).append(batch_of("a"))
        assert Store(tmp_path / f"new{n}").snapshot().recordings.empty
    Store(location).append(batch_of("a"))
    before = Store(location).snapshot()
    boxes = [Box(50, 1, 2, 3, 4)], [Box(9, 1, 2, 3, 4, score=1)]
    longer = make_dataset(*boxes, n_frames=60)
    longer = replace(longer, recordings=longer.recordings.assign(name="a"))
    for n in range(WRITES):  # another version of what is there, with other frames
        with pytest.raises(Killed):
            DyingStore(Location(location.uri), n, end).append([tables_of(longer)])
        now = Store(location).snapshot()
        assert now.recordings.equals(before.recordings)
        assert now.sources.equals(before.sources)
        assert content(now).equals(content(before))
    new, _ = Store(location).append([tables_of(longer)])
    assert [len(rows) for rows in new.values()] == [0, 3]  # the recording was there, unseen
    now = Store(location).snapshot()
    assert now.sources["version"].max() == 2
    check_same(now, longer)


def test_after_a_killed_process_the_next_one_goes_on(place: Location):
    Store(place).append(batch_of("a"))
    before = content(Store(place).snapshot())
    for n in (3, WRITES - 1):
        process = SPAWN.Process(target=append_and_be_killed, args=(place, n, "a", "b"))
        process.start()
        process.join()
        assert process.exitcode == -9
        assert content(Store(place).snapshot()).equals(before)
    Store(place).append(batch_of("a", "b", seed=1))
    snapshot = Store(place).snapshot()
    check_same(snapshot, recordings("b", seed=1))
    assert snapshot.sources.groupby(["recording", "source"]).size().tolist() == [2] * 3 + [1] * 3


def test_a_full_disk_is_told_and_what_was_there_stays(tmp_path: Path):
    store = Store(tmp_path / "store")
    store.append(batch_of("a"))
    before = content(store.snapshot())
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2000, hard))
    try:
        with pytest.raises(StoreError, match=r"store/.* cannot be written \(.*large"):
            store.append(batch_of("b"))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert content(Store(tmp_path / "store").snapshot()).equals(before)
    store.append(batch_of("b"))
    check_same(store.snapshot(), recordings("b"))


def test_a_damaged_or_missing_file_is_named(tmp_path: Path):
    store = Store(tmp_path)
    store.append(batch_of("a"))
    (file,) = (tmp_path / "boxes").glob("*.parquet")
    good = file.read_bytes()
    for bad in (good[:200], b"PAR1" + bytes(len(good) - 8) + b"PAR1", b""):
        file.write_bytes(bad)
        with pytest.raises(FormatError, match=rf"{file.name}: is damaged"):
            store.snapshot().read(["a"], ["x"])["boxes"]
    file.write_bytes(good)
    column = pq.ParquetFile(file).metadata.row_group(0).column(3)
    flipped = bytearray(good)
    flipped[column.dictionary_page_offset + column.total_compressed_size - 3] ^= 1
    file.write_bytes(flipped)
    with pytest.raises(FormatError, match=rf"{file.name}: is damaged"):
        store.snapshot().read(["a"], ["truth", "x", "y"])["boxes"]
    file.unlink()
    store.append(batch_of("a"))  # does not write the file again
    with pytest.raises(InputError, match=rf"{file.name}: is missing in the store"):
        store.snapshot().read(["a"], ["x"])["boxes"]
    with pytest.raises(InputError, match="there is no store here"):
        Store(tmp_path / "elsewhere").snapshot()


def test_what_is_said_anew_of_a_version_is_taken(tmp_path: Path):
    store, dataset = Store(tmp_path), recordings("a", "b")

    def sources(**said: Any) -> pd.DataFrame:
        store.append([tables_of(dataset, **said)])
        rows = store.snapshot().sources
        assert rows["version"].tolist() == [1] * 6
        return rows[["label", "kind"]].apply(tuple, axis=1).tolist()[:3]

    assert sources() == [("", "annotated"), ("", "system"), ("", "system")]
    before = store.snapshot().sources["ingested_at"].tolist()
    assert sources(labels={"x": "spring"})[1] == ("spring", "system")
    assert sources()[1] == ("spring", "system")
    assert sources(truth_kind="automatic")[0] == ("", "automatic")
    assert sources(labels={"x": "May"}) == [("", "automatic"), ("May", "system"), ("", "system")]
    assert sources(truth_kind="annotated")[0] == ("", "annotated")
    for label in ("spring", "May"):  # two models may have detected the same
        assert store.snapshot().pick(f"x@{label}")["recording"].tolist() == ["a", "b"]
    assert store.snapshot().sources["ingested_at"].tolist() == before
    assert len([*(tmp_path / "boxes").glob("*.parquet")]) == 1
    with pytest.raises(InputError, match="there is no version '' of 'x'"):
        store.snapshot().pick("x@")


def test_a_folder_of_results_is_no_store(tmp_path: Path):
    (tmp_path / "plans").mkdir()
    (tmp_path / "plans" / "a.json").write_text("{}")
    with pytest.raises(InputError, match="holds results of a scan; name another folder"):
        Store(tmp_path).append(batch_of("a"))
    assert not (tmp_path / "sources").exists()


def test_a_server_that_refuses_and_cuts_costs_attempts_alone(bucket: Location, s3: str):
    with troubled(s3) as (url, done):
        store = Store(Location(bucket.uri, options(url)))
        names = ["r0", "r1"]
        for name in names:
            for _ in range(20):
                try:
                    store.append(batch_of(name))
                    break
                except StoreError:  # the answer to a commit was lost: it is made again
                    continue
        snapshot = store.snapshot()
        check_same(snapshot, recordings("r1"))
        assert content(Store(bucket).snapshot()).equals(content(snapshot))
    assert snapshot.recordings["recording"].tolist() == names
    assert snapshot.sources["version"].unique().tolist() == [1]
    assert min(done.values()) > 5


def test_other_programs_read_the_tables_as_they_stand(tmp_path: Path):
    Store(tmp_path).append([tables_of(recordings("b", "a"))])
    tables = {name: DeltaTable(tmp_path / name) for name in ("frames", "boxes", "sources")}
    boxes = tables["boxes"].to_pandas()
    assert boxes["recording"].is_monotonic_increasing
    assert boxes["distance_m"].isna().all()
    actions = pa.table(tables["boxes"].get_add_actions(flatten=True)).to_pylist()
    assert [of["num_records"] for of in actions] == [len(boxes)]
