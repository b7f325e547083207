"""Sessions that the program writes state the reading that was taken; a rerun is the same."""

from __future__ import annotations

import tomllib
from dataclasses import replace

import pandas as pd
import pytest
from field_files import session_of
from inputs import drive, nvcore
from inputs import session_of as session_of_drive

from nvcore.inputs.load import load
from nvcore.inputs.session.changes import stated


def test_a_written_session_states_format_and_layout_of_every_source(tmp_path):
    drive(tmp_path)
    files = ["--truth", tmp_path / "truth.csv", "--x", tmp_path / "fir.csv"]
    files += ["--y", tmp_path / "nir.csv", "--size", "640x480", "--fps", 20]
    nvcore("compare", *files, "--out", tmp_path / "out")
    content = tomllib.loads((tmp_path / "out" / "session.toml").read_text())
    for source in (content["truth"], *content["system"]):
        assert (source["format"], source["boxes"]) == ("csv", "sizes")


@pytest.mark.parametrize("layout", [None, "corners-shares"])
def test_a_session_that_states_its_reading_reads_the_same(tmp_path, layout):
    session = session_of(tmp_path, **({} if layout is None else {"x": layout}))
    x, y = session.systems
    session = replace(session, systems=(replace(x, boxes=layout), y))
    first = load(session)
    again = load(stated(session, first))
    assert again.fingerprint == first.fingerprint
    pd.testing.assert_frame_equal(again.boxes, first.boxes)


def test_another_layout_is_another_fingerprint(tmp_path):
    session = session_of_drive(drive(tmp_path))
    x, y = session.systems
    other = replace(session, systems=(replace(x, boxes="centres"), y))
    assert load(other).fingerprint != load(session).fingerprint


def test_what_is_given_stays(tmp_path):
    session = session_of(tmp_path, x="corners")
    x, y = session.systems
    session = replace(session, systems=(replace(x, boxes="corners"), y))
    assert [source.boxes for source in stated(session, load(session)).systems] == [
        "corners",
        "sizes",
    ]


def test_the_corners_of_a_table_are_stated(tmp_path):
    session = session_of(tmp_path)
    table = pd.read_csv(tmp_path / "x.csv")
    table = table.assign(w=table["x"] + table["w"], h=table["y"] + table["h"])
    table.rename(columns={"x": "x1", "y": "y1", "w": "x2", "h": "y2"}).to_csv(
        tmp_path / "x.csv", index=False
    )
    dataset = load(session)
    again = stated(session, dataset)
    assert again.systems[0].boxes == "corners"
    assert load(again).fingerprint == dataset.fingerprint
