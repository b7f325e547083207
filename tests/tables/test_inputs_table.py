"""What was read, source by source."""

from __future__ import annotations

from pathlib import Path

from builders import at, make_dataset
from inputs import drive, session_of

from nvcore.inputs.load import load
from nvcore.tables.inputs import inputs_table, left_out_table


def test_a_source_is_one_row_with_its_files_and_boxes(tmp_path: Path):
    table = inputs_table(load(session_of(drive(tmp_path))))
    assert table["subject"].tolist() == ["truth", "fir", "nir"]
    assert table["n_files"].tolist() == [1, 1, 1]
    assert table["first_file"].str.endswith(("truth.csv", "fir.csv", "nir.csv")).all()
    assert table["format"].tolist() == ["csv"] * 3
    assert table["n_boxes"].tolist() == [40, 40, 11]


def test_data_made_in_memory_have_no_inputs():
    table = inputs_table(make_dataset([at(0, 50)]))
    assert table.empty
    assert "n_boxes" in table


def test_rows_that_could_not_be_placed_are_counted_by_reason(tmp_path: Path):
    drive(tmp_path)
    with (tmp_path / "nir.csv").open("a") as stream:
        stream.write("urban,500,100,200,40,100,0.6\nurban,501,100,200,40,100,0.6\n")
        stream.write("urban,3,100,200,0,100,0.6\n")
    table = left_out_table(load(session_of(tmp_path)))
    assert set(table.itertuples(index=False, name=None)) == {
        ("nir", "frame not listed", 2), ("nir", "no area", 1),
    }  # fmt: skip


def test_where_every_row_is_placed_nothing_is_left_out(tmp_path: Path):
    assert left_out_table(load(session_of(drive(tmp_path)))).empty
