"""Parquet is read as plain CSV of the same columns; hostile files are bad input."""

from __future__ import annotations

import tracemalloc
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from inputs import drive, flags, nvcore
from reader_files import rows, source

from nvcore.common.errors import FormatError, NvcoreError
from nvcore.inputs.readers import detect_format, parquet
from nvcore.inputs.readers.base import Reading, ReadOptions, Role, SourceFile
from nvcore.inputs.readers.csv import FORMAT as PLAIN_CSV
from nvcore.inputs.readers.parquet import decoder as parquet_decoder
from nvcore.inputs.readers.parquet.decoder import ParquetTable, RefusedError

BOX: dict[str, Any] = {"frame": [1, 2], "x": [1.5, 2.0], "y": [0, 1], "w": [9, 9], "h": [20, 30]}


def table(folder: Path, name: str = "night.parquet", **columns: Any) -> SourceFile:
    """A file of two boxes with these columns beside or in place of theirs."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.table(BOX | columns), path)
    return SourceFile(path, name)


def read(file: SourceFile, role: Role = "truth", **options: Any) -> Reading:
    file_format = detect_format([file], role)
    assert file_format is parquet.FORMAT
    return file_format.read([file], ReadOptions(role=role, **options))


def decoded(path: Path, **limits: int) -> dict[int, pa.ChunkedArray]:
    """All columns, in this process: with other limits than those of every file."""
    table = ParquetTable(path.read_bytes())
    given = {"ratio": 200, "ratio_from": 1 << 26, "unpacked": 1 << 31, "text": 1 << 14}
    return table.columns(range(len(table.names)), given | limits)


def refusal(file: SourceFile) -> str:
    with pytest.raises(FormatError) as error:
        parquet.read([file], ReadOptions())
    return str(error.value)


def test_every_column_of_plain_csv_is_read(tmp_path: Path):
    file = table(
        tmp_path,
        recording=["b", "a"],
        track=pa.array([None, 7]),
        ignore=[True, False],
        distance_m=pa.array([12.5, None]),
        occlusion=pa.array([2, None], pa.int8()),
        operator=["jo", "jo"],
    )
    reading = read(file)
    assert rows(reading.boxes, "recording frame x y w h track ignore distance_m occlusion") == [
        ["b", 1, 1.5, 0, 9, 20, -1, True, 12.5, 2],
        ["a", 2, 2, 1, 9, 30, 7, False, None, -1],
    ]
    assert "columns left unused: operator" in reading.conversion


def test_it_is_read_as_the_csv_file_of_the_same_rows(tmp_path: Path):
    drive(tmp_path)
    for name, role in (("truth", "truth"), ("fir", "detections")):
        plain = SourceFile(tmp_path / f"{name}.csv", f"{name}.csv")
        frame = pa.csv.read_csv(plain.path)
        pq.write_table(frame, tmp_path / f"{name}.parquet")
        theirs = PLAIN_CSV.read([plain], ReadOptions(role=role))
        ours = read(SourceFile(tmp_path / f"{name}.parquet", f"{name}.parquet"), role)
        without_line = [column for column in ours.boxes if column != "line"]
        assert ours.boxes[without_line].equals(theirs.boxes[without_line])
        assert ours.boxes["line"].tolist() == (theirs.boxes["line"] - 1).tolist()
        assert ours.conversion == theirs.conversion


def test_the_terminal_names_boxes_by_their_row(tmp_path: Path):
    drive(tmp_path)
    for path in tmp_path.glob("*.csv"):
        pq.write_table(pa.csv.read_csv(path), path.with_suffix(".parquet"))
    given = (text.replace(".csv", ".parquet") for text in flags(tmp_path, "--json"))
    run = nvcore("compare", *given)
    assert "fir.parquet, row 0, recording urban, frame 0" in run.stderr


@pytest.mark.parametrize(
    "values",
    [
        pa.array([1, 2], pa.uint8()),
        pa.array([1, 2], pa.float16()),
        pa.array([Decimal("1"), Decimal("2")]),
        pa.array(["1", "2"]),
        pa.array(["1", "2"], pa.large_string()),
        pa.array(["1", "2"]).dictionary_encode(),
        pa.array([1, 2]).dictionary_encode(),
    ],
    ids=lambda values: str(values.type).partition("<")[0],
)
def test_numbers_of_any_type_are_numbers(tmp_path: Path, values: pa.Array):
    assert read(table(tmp_path, x=values)).boxes["x"].tolist() == [1, 2]


def test_without_a_column_for_it_the_file_s_name_is_the_recording(tmp_path: Path):
    reading = read(table(tmp_path, "drives/night.parquet"))
    assert reading.recordings["name"].tolist() == ["night"]


def test_scores_and_an_empty_table_are_read_as_detections(tmp_path: Path):
    assert read(table(tmp_path, score=[0.5, None]), "detections").boxes["score"].iloc[0] == 0.5
    path = tmp_path / "none.parquet"
    pq.write_table(pa.table(BOX).slice(0, 0), path)
    assert len(read(SourceFile(path, "none.parquet"), "detections").boxes) == 0


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"frame": [1, None]}, "row 1: expected a whole number as frame, found nan"),
        ({"frame": [1.5, 2]}, "row 0: expected a whole number as frame, found 1.5"),
        ({"x": ["1", "wide"]}, "row 1: expected a number as x, found 'wide'"),
        ({"ignore": ["0", "maybe"]}, "row 1: expected 0, 1, true or false as ignore"),
        ({"recording": ["a", None]}, "row 1: expected the name of a recording, found an empty"),
        ({"x": [[1.0], [2.0]]}, "numbers or text in column x, found list<element: double>"),
        ({"x": [{"a": 1}, {"a": 2}]}, "expected numbers or text in column x, found struct<"),
        ({"frame": pa.array([1, 2], pa.timestamp("s"))}, "in column frame, found timestamp[ms]"),
        ({"x": pa.array([b"1", b"2"])}, "in column x, found binary"),
    ],
    ids=lambda value: value[:40] if isinstance(value, str) else "",
)
def test_what_is_no_box_is_named_with_its_row(tmp_path: Path, columns: dict[str, Any], words: str):
    message = refusal(table(tmp_path, **columns))
    assert message.startswith("night.parquet: ")
    assert words in message


def test_a_missing_column_is_named(tmp_path: Path):
    pq.write_table(pa.table({"frame": [1], "left": [1.0], "top": [1.0]}), tmp_path / "a.parquet")
    message = refusal(SourceFile(tmp_path / "a.parquet", "a.parquet"))
    assert "found frame, left, top; missing: w, h" in message


def test_a_table_of_waymo_is_named(tmp_path: Path):
    names = ("key.frame_timestamp_micros", "[CameraBoxComponent].box.center.x")
    pq.write_table(pa.table({name: [1.0] for name in names}), tmp_path / "a.parquet")
    message = refusal(SourceFile(tmp_path / "a.parquet", "a.parquet"))
    assert "it is a table of the Waymo Open Dataset, which is not read: keep" in message


def test_a_column_that_is_there_twice_is_refused(tmp_path: Path):
    arrays = [pa.array([1])] * 6
    double = pa.Table.from_arrays(arrays, names=["frame", "x", "x", "y", "w", "h"])
    pq.write_table(double, tmp_path / "a.parquet")
    assert "expected one column x, found 2" in refusal(SourceFile(tmp_path / "a.parquet", "a"))


def test_many_rows_in_a_small_file_are_no_matter_and_very_many_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    n = 150_000
    same = {name: np.zeros(n, np.int64) for name in ("frame", "x", "y")}
    columns = same | {"w": np.ones(n), "h": np.ones(n), "class": ["person" * 20] * n}
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table(columns), path)
    assert path.stat().st_size < 50_000
    monkeypatch.setattr(parquet, "RATIO_FROM_BYTES", 1 << 23)
    assert len(read(SourceFile(path, "a.parquet")).boxes) == n
    monkeypatch.setattr(parquet, "RATIO_FROM_BYTES", 1 << 20)
    assert "declares 150,000 rows, which would take 0.0 GiB" in refusal(SourceFile(path, "a"))


@pytest.mark.parametrize("group", [None, 10])
def test_texts_count_and_a_very_long_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, group: int | None
):
    n = 100
    numbers = {name: np.ones(n) for name in ("frame", "x", "y", "w", "h")}
    names = [f"{i:03}" + "a" * 9_997 for i in range(n)]  # of 10 kB each, 1 MB in all
    path = tmp_path / "a.parquet"
    way: dict[str, Any] = {"compression": "zstd", "use_dictionary": False, "row_group_size": group}
    pq.write_table(pa.table(numbers | {"recording": names}), path, **way)
    file = SourceFile(path, "a.parquet")
    assert read(file).boxes["recording"].tolist() == names
    monkeypatch.setattr(parquet, "RATIO_FROM_BYTES", 500_000)
    monkeypatch.setattr(parquet, "MAX_RATIO", 5)
    assert "declares 100 rows, which would take" in refusal(file)
    monkeypatch.setattr(parquet_decoder, "_text_bytes", lambda *_: 0)  # a file that does not tell
    with pytest.raises(RefusedError, match="takes more than"):
        decoded(path, ratio=5, ratio_from=500_000)
    monkeypatch.undo()
    pq.write_table(pa.table(numbers | {"recording": ["a" * 20_000] * n}), path)
    assert "expected texts of at most 16,384 bytes, found one of 20,000" in refusal(file)


def test_texts_that_grow_as_they_are_decoded_are_refused_before_all_of_them_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    # each text is stored as what it has more than the one before: 4 MB in some kB of one row group
    n = 2000
    numbers = {name: np.ones(n) for name in ("frame", "x", "y", "w", "h")}
    path = tmp_path / "a.parquet"
    names = ["a" * 2000 + f"{i:04}" for i in range(n)]
    ways = dict.fromkeys(numbers, "PLAIN") | {"recording": "DELTA_BYTE_ARRAY"}
    table = pa.table(numbers | {"recording": names})
    pq.write_table(table, path, use_dictionary=False, column_encoding=ways)
    file = SourceFile(path, "a.parquet")
    assert path.stat().st_size < 100_000
    assert read(file).boxes["recording"].tolist() == names
    monkeypatch.setattr(parquet_decoder, "TEXTS_AT_ONCE", 50)
    before = pa.default_memory_pool()
    pool = pa.proxy_memory_pool(before)
    pa.set_memory_pool(pool)
    try:
        with pytest.raises(RefusedError, match="takes more than"):
            decoded(path, ratio=5, ratio_from=500_000)
    finally:
        pa.set_memory_pool(before)
    assert pool.max_memory() < 2_000_000


def test_rows_that_the_file_as_a_whole_does_not_tell_of_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    n = 1_200_000
    path = tmp_path / "a.parquet"
    pq.write_table(pa.table({name: np.ones(n) for name in ("frame", "x", "y", "w", "h")}), path)
    # the number of all rows, as Thrift writes it, becomes 10; those of the two row groups stay
    content, stored, lie = path.read_bytes(), b"\x80\xbe\x92\x01", b"\x94\x80\x80\x00"
    assert content.count(stored) == 1
    path.write_bytes(content.replace(stored, lie))
    assert pq.read_metadata(path).num_rows == 10
    monkeypatch.setattr(parquet, "RATIO_FROM_BYTES", 1 << 20)
    assert "declares 1,200,000 rows" in refusal(SourceFile(path, "a.parquet"))


GOOD = pa.BufferOutputStream()
pq.write_table(pa.table(BOX | {"recording": ["a", "b"], "score": [0.5, 0.25]}), GOOD)
CONTENT = GOOD.getvalue().to_pybytes()


@settings(
    max_examples=150, deadline=None, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(
    place=st.integers(4, len(CONTENT) - 1),
    piece=st.sampled_from(
        [b"", b"\x00", b"\xff" * 4, b"\x7f", b"\xff" * 12, b"\x80\x80\x80\x80\x08"]
    ),
    cut=st.integers(0, 6),
)
def test_a_damaged_table_is_read_or_refused(tmp_path: Path, place: int, piece: bytes, cut: int):
    content = CONTENT[:place] + piece + CONTENT[place + cut :]
    file = source(tmp_path, content, "a.parquet")
    try:
        n_boxes, message = len(parquet.read([file], ReadOptions()).boxes), ""
    except NvcoreError as error:
        n_boxes, message = 0, str(error)
    assert n_boxes <= 2
    assert not message or message.startswith("a.parquet: ")


def repeated(folder: Path, column: str, text: str, n: int) -> SourceFile:
    """A file with one text in all of its rows, stored once."""
    columns: dict[str, Any] = {name: np.ones(n) for name in BOX}
    once = pa.DictionaryArray.from_arrays(pa.array(np.zeros(n, np.int32)), pa.array([text]))
    path = folder / "a.parquet"
    pq.write_table(pa.table(columns | {column: once}), path, compression="zstd")
    assert path.stat().st_size < 50_000
    return SourceFile(path, "a.parquet")


@pytest.mark.parametrize("column", ["id", "recording", "class", "attributes", "picture", "x"])
@pytest.mark.parametrize("role", ["truth", "detections"])
def test_a_text_counts_as_often_as_it_stands_there(tmp_path: Path, column: str, role: Role):
    file = repeated(tmp_path, column, "a" * 16_000, 150_000)
    with pytest.raises(FormatError, match=rf"a\.parquet: repeats texts in column {column} so"):
        parquet.read([file], ReadOptions(role=role))


@pytest.mark.parametrize(("column", "text"), [("id", "a" * 16_000), ("score", " " * 16_000)])
def test_a_text_of_many_rows_is_not_written_out_to_learn_its_number(
    tmp_path: Path, column: str, text: str
):
    file = repeated(tmp_path, column, text, 20_000)
    options = ReadOptions(role="detections")
    parquet.read([file], options)  # what is loaded once is not counted
    before = pa.default_memory_pool()
    pool = pa.proxy_memory_pool(before)
    pa.set_memory_pool(pool)
    tracemalloc.start()
    try:
        assert len(parquet.read([file], options).boxes) == 20_000
        peak = tracemalloc.get_traced_memory()[1] + pool.max_memory()
    finally:
        tracemalloc.stop()
        pa.set_memory_pool(before)
    assert peak < 100_000_000  # all of them are 320 MB


@pytest.fixture(scope="module")
def aborting(tmp_path_factory: pytest.TempPathFactory) -> SourceFile:
    """A file that aborts Arrow: a length in the footer, 2 before, is 109."""
    folder = tmp_path_factory.mktemp("aborting")
    pq.write_table(pa.table({name: [1.0, None] for name in BOX}), folder / "whole.parquet")
    content = (folder / "whole.parquet").read_bytes()
    start = len(content) - 8 - int.from_bytes(content[-8:-4], "little")
    for place in range(start, len(content) - 8):
        if content[place] == 2:
            changed = content[:place] + b"\x6d" + content[place + 1 :]
            file = source(folder, changed, "damaged.parquet")
            try:
                parquet.read([file], ReadOptions())
            except FormatError as error:
                if "ends the program that decodes it" in str(error):
                    return file
    raise AssertionError("no file aborts Arrow")


def test_a_file_that_aborts_arrow_is_refused_by_name_and_the_next_one_is_read(
    tmp_path: Path, aborting: SourceFile
):
    assert refusal(aborting).startswith("damaged.parquet: expected a whole Parquet table")
    assert len(read(table(tmp_path)).boxes) == 2


def test_a_comparison_with_such_a_file_ends_as_with_other_bad_input(
    tmp_path: Path, aborting: SourceFile
):
    damaged = str(aborting.path)
    given = [damaged if text.endswith("fir.csv") else text for text in flags(drive(tmp_path))]
    assert damaged in given
    run = nvcore("compare", *given)
    assert run.exit_code == 2
    assert "damaged.parquet: expected a whole Parquet table" in run.stderr


def test_texts_that_are_no_utf_8_are_refused(tmp_path: Path):
    whole = table(tmp_path, recording=["pedestrian", "pedestrian"])
    content = whole.path.read_bytes().replace(b"pedestrian", b"p\xe9destrian"[:10])
    file = source(tmp_path, content, "a.parquet")
    assert "a.parquet: expected a whole Parquet table, found a fault: " in refusal(file)


def test_columns_of_different_lengths_are_refused(tmp_path: Path):
    columns = pa.table(BOX | {"recording": ["a", "b"], "id": ["p", None]})
    way: dict[str, Any] = {"use_dictionary": False, "write_statistics": False}
    pq.write_table(columns, tmp_path / "a.parquet", compression="none", **way)
    content = (tmp_path / "a.parquet").read_bytes()
    messages = set()
    for place in range(4, content.index(b"schema")):  # among them a page's count of rows
        if content[place] == 0:
            file = source(tmp_path, content[:place] + b"\x02" + content[place + 1 :], "a.parquet")
            try:
                parquet.read([file], ReadOptions())
            except FormatError as error:
                messages.add(str(error))
    assert any("fault: column recording has 0 rows, column frame 2" in text for text in messages)
