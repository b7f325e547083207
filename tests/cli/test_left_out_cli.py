"""What is left out of the files stands in the first lines, whatever command reads them."""

from __future__ import annotations

import pytest
from field_files import session_of
from field_scene import truth
from inputs import nvcore

from nvcore.inputs.load import load
from nvcore.tables.inputs import inputs_table


@pytest.mark.parametrize("command", [["compare", "--full"], ["check"]], ids=" ".join)
def test_classes_left_out_stand_below_their_source(tmp_path, command):
    session_of(tmp_path)
    truth().rename(columns={"name": "class"}).to_csv(tmp_path / "truth.csv", index=False)
    files = [f"--{name}={tmp_path / name}.csv" for name in ("truth", "x", "y")]
    result = nvcore(*command, *files, "--size", "640x480", "--fps", 10)
    first, second, third, *_ = result.output.splitlines()
    assert first.startswith("truth: ")
    assert second == "  left out: car (80), bicycle (40)"
    assert third.startswith("x: ")


def test_the_table_of_inputs_has_what_is_left_out(tmp_path):
    session = session_of(tmp_path)
    truth().rename(columns={"name": "class"}).to_csv(tmp_path / "truth.csv", index=False)
    assert inputs_table(load(session))["left_out"].tolist() == ["car (80), bicycle (40)", "", ""]
