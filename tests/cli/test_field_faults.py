"""Files that mean another thing than they say never give wrong numbers with exit code 0."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from field_files import session_of
from field_scene import detections, truth
from inputs import nvcore

Change = Callable[[pd.DataFrame], pd.DataFrame]


def numbers_of_all(table: pd.DataFrame) -> pd.DataFrame:
    """Classes by numbers that nobody names."""
    return table.assign(**{"class": table["name"].map({"bicycle": 0, "car": 1, "person": 2})})


FAULTS: dict[str, tuple[Change, str]] = {
    "corners as sizes": (
        lambda t: t.assign(w=t["x"] + t["w"], h=t["y"] + t["h"]),
        "left, top, right, bottom",
    ),
    "centres": (
        lambda t: t.assign(x=t["x"] + t["w"] / 2, y=t["y"] + t["h"] / 2),
        "centre x, centre y",
    ),
    "axes swapped": (
        lambda t: t.rename(columns={"x": "y", "y": "x", "w": "h", "h": "w"}),
        "top, left, height, width",
    ),
    "shares of the picture": (
        lambda t: t.assign(x=t["x"] / 640, y=t["y"] / 480, w=t["w"] / 640, h=t["h"] / 480),
        "shares of the picture",
    ),
    "half the size": (
        lambda t: t.assign(**{name: t[name] / 2 for name in "xywh"}),
        "multiplied by 2",
    ),
    "frames shifted": (lambda t: t.assign(frame=t["frame"] + 5), "--offset-frames-x -5"),
    "frames counted from 1": (lambda t: t.assign(frame=t["frame"] + 1), "--offset-frames-x -1"),
    "fitted into a square input with bars": (
        lambda t: t.assign(x=t["x"] * 0.65, y=t["y"] * 0.65 + 52, w=t["w"] * 0.65, h=t["h"] * 0.65),
        "multiplied by 1.538) and 80.0 px too far down",
    ),
    "every second frame, numbered anew": (
        lambda t: t[t["frame"] % 2 == 0].assign(frame=lambda u: u["frame"] // 2),
        "every second|rate|2 x",
    ),
    "numbers of classes without names": (numbers_of_all, "class"),
}


OF_ALL: dict[str, tuple[Change, str, str]] = {
    "corners as sizes": (
        lambda t: t.assign(w=t["x"] + t["w"], h=t["y"] + t["h"]),
        "they seem to be corners",
        "--boxes=corners",
    ),
    "vertical numbers first": (
        lambda t: t.rename(columns={"x": "y", "y": "x", "w": "h", "h": "w"}),
        "wider than tall",
        "--boxes=sizes-yx",
    ),
    "thousandths of the picture": (
        lambda t: t.assign(x=t["x"] / 0.64, y=t["y"] / 0.48, w=t["w"] / 0.64, h=t["h"] / 0.48),
        "outside the picture",
        "--boxes=sizes-thousandths",
    ),
    "shares of the picture": (
        lambda t: t.assign(x=t["x"] / 640, y=t["y"] / 480, w=t["w"] / 640, h=t["h"] / 480),
        "fractions of the picture",
        "--boxes=sizes-shares",
    ),
    "twice the size that is given": (
        lambda t: t.assign(**{name: t[name] * 2 for name in "xywh"}),
        "outside the picture",
        "--size=1280x960",
    ),
}
"""Faults that truth and systems share, so that all fit one another, and what mends them."""


@pytest.mark.parametrize("fault", OF_ALL)
def test_a_fault_of_all_sources_is_an_error_that_names_what_mends_it(tmp_path: Path, fault: str):
    change, named, remedy = OF_ALL[fault]
    for name, table in {"truth": truth(), "x": detections("x"), "y": detections("y")}.items():
        table = table[table["name"] == "person"].astype(dict.fromkeys("xywh", float))
        change(table).drop(columns="name").to_csv(tmp_path / f"{name}.csv", index=False)
    files = [f"--{name}={tmp_path / name}.csv" for name in ("truth", "x", "y")]
    result = nvcore("compare", *files, "--size", "640x480", "--fps", 10)
    assert result.exit_code == 1
    assert named in " ".join(result.output.split())
    assert nvcore("compare", *files, "--size", "640x480", "--fps", 10, remedy).exit_code == 0


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_of_both_systems_gives_no_exit_code_0_and_is_named(tmp_path: Path, fault: str):
    change, named = FAULTS[fault]
    session_of(tmp_path)
    for name in "xy":
        table = detections(name)
        if fault != "numbers of classes without names":
            table = table[table["name"] == "person"]
        change(table).drop(columns="name").to_csv(tmp_path / f"{name}.csv", index=False)
    files = [f"--{name}={tmp_path / name}.csv" for name in ("truth", "x", "y")]
    result = nvcore("compare", *files, "--size", "640x480", "--fps", 10)
    assert result.exit_code != 0
    assert any(part in " ".join(result.output.split()) for part in named.split("|"))


def test_the_scene_itself_is_right(tmp_path: Path):
    session_of(tmp_path)
    files = [f"--{name}={tmp_path / name}.csv" for name in ("truth", "x", "y")]
    assert len(truth()) == 230
    assert nvcore("compare", *files, "--size", "640x480", "--fps", 10).exit_code == 0
