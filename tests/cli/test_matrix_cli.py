"""``nvcore matrix``: every two systems, printed and as files, and what is bad input."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
from inputs import drive, flags, nvcore


def three(folder: Path) -> Path:
    """The systems of `drive`, and NIR once more at a threshold that leaves nothing."""
    drive(folder)
    text = '[defaults]\nsize = "640x480"\nfps = 20\n[truth]\npath = "truth.csv"\n'
    for name, file, threshold in (("FIR", "fir", 0.5), ("NIR", "nir", 0.5), ("none", "nir", 0.95)):
        text += f'[[system]]\nname = "{name}"\npath = "{file}.csv"\nthreshold = {threshold}\n'
    (folder / "three.toml").write_text(text)
    return folder / "three.toml"


def test_every_two_systems_are_printed_each_at_its_own_threshold(tmp_path: Path):
    ran = nvcore("matrix", three(tmp_path))
    assert ran.exit_code == 0, ran.output
    assert "3 systems, 3 pairs, 2 encounters; each system at its own threshold" in ran.stdout
    assert "FIR - NIR: Nothing is claimed: 6 recordings are needed for a p." in ran.stdout
    rows = [line.split() for line in ran.stdout.splitlines()]
    assert ["NIR", "0.5", "0.025", "50.0", "%"] in [row[:5] for row in rows]
    assert ["none", "0.95", "0", "0.0", "%"] in [row[:5] for row in rows]


def test_json_stands_alone_and_flags_move_x_alone(tmp_path: Path):
    ran = nvcore("matrix", three(tmp_path), "--threshold-x", "0.8", "--alpha", "0.8", "--json")
    assert ran.exit_code == 0, ran.output
    assert "Audit: " in ran.stderr
    content = json.loads(ran.stdout)
    assert content["parameters"]["alpha"] == 0.8
    assert {row["system"]: row["threshold"] for row in content["systems"]} == {
        "FIR": 0.8,
        "NIR": 0.5,
        "none": 0.95,
    }


def test_out_is_a_folder_with_csv_and_json(tmp_path: Path):
    ran = nvcore("matrix", three(tmp_path), "--out", tmp_path / "pairs")
    assert ran.exit_code == 0, ran.output
    assert "written to " in ran.stderr
    table = pd.read_csv(tmp_path / "pairs" / "matrix.csv")
    assert table[["x", "y", "x_only", "y_only"]].to_numpy().tolist() == [
        ["FIR", "NIR", 1, 0],
        ["FIR", "none", 2, 0],
        ["NIR", "none", 1, 0],
    ]
    assert (tmp_path / "pairs" / "matrix.json").exists()


def test_inputs_are_not_replaced(tmp_path: Path):
    folder = drive(tmp_path)
    (folder / "nir.csv").rename(folder / "matrix.csv")
    arguments = [argument.replace("nir.csv", "matrix.csv") for argument in flags(folder)]
    ran = nvcore("matrix", *arguments, "--out", folder)
    assert ran.exit_code == 2
    assert "is an input, and would be replaced" in ran.output


def test_the_folder_of_another_command_is_refused_before_anything_is_read(tmp_path: Path):
    folder = drive(tmp_path)
    out = tmp_path / "report"
    assert nvcore("compare", *flags(folder), "--out", out).exit_code == 0
    (folder / "truth.csv").write_text("nothing that can be read")
    ran = nvcore("matrix", *flags(folder), "--out", out)
    assert ran.exit_code == 2
    assert "of another command (by its SHA256SUMS); give another folder" in ran.stderr


def test_one_system_is_bad_input(tmp_path: Path):
    folder = drive(tmp_path)
    ran = nvcore("matrix", "--truth", folder / "truth.csv", "--x", folder / "fir.csv")
    assert ran.exit_code == 2
    assert "give a session file, or --truth, --x and --y" in ran.output
