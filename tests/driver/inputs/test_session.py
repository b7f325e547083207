"""What a session says of the driver: read, refused, renamed, written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from inputs import write

from nvcore.common.errors import SessionError
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.report.protect_inputs import files_read
from nvcore.subjects.driver.inputs.session import DriverTable

HEAD = '[truth]\npath = "gt.csv"\n[[system]]\npath = "fir.csv"\n'
KEYS = 'visible = "v.mp4"\nvisible_map = [1.5, 2, 8, -12.5]\nlight = "lux.csv"\ngaze = "gaze.csv"\n'
TABLE = '[driver]\ndetectability = "d.csv"\nprovenance = "d.json"\n'
FULL = f'{HEAD}{TABLE}[[recording]]\nname = "urban"\n{KEYS}'


def read(folder: Path, text: str) -> Session:
    return read_session(write(folder / "session.toml", text))


def test_the_keys_of_a_recording_and_the_table_are_read(tmp_path: Path):
    session = read(tmp_path, FULL)
    assert session.driver == DriverTable("d.csv", "d.json")
    assert session.recordings == (
        RecordingEntry(
            "urban",
            visible="v.mp4",
            visible_map=(1.5, 2.0, 8.0, -12.5),
            light="lux.csv",
            gaze="gaze.csv",
        ),
    )


def test_a_session_that_says_nothing_of_the_driver_knows_nothing(tmp_path: Path):
    session = read(tmp_path, HEAD)
    assert session.driver == DriverTable(None)
    assert "driver" not in write_session(session, version="1", fingerprint="2")


def test_what_is_written_has_absolute_paths_and_reads_back(tmp_path: Path):
    session = read(tmp_path, FULL)
    text = write_session(session, version="1", fingerprint="2")
    again = read(tmp_path / "far", text)
    assert again.driver.detectability == str(tmp_path / "d.csv")
    entry = again.recordings[0]
    assert (entry.visible, entry.light, entry.gaze) == tuple(
        str(tmp_path / name) for name in ("v.mp4", "lux.csv", "gaze.csv")
    )
    assert entry.visible_map == (1.5, 2.0, 8.0, -12.5)
    assert write_session(again, version="1", fingerprint="2") == text


def test_its_files_are_among_those_that_are_read(tmp_path: Path):
    session = read(tmp_path, FULL)
    names = {"v.mp4", "lux.csv", "gaze.csv", "d.csv", "d.json"}
    assert names <= set(session.paths())
    assert {tmp_path / name for name in names} <= set(files_read(session))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("visible_map = [1, 1, 0]", "visible_map: expected four numbers"),
        ("visible_map = [0, 1, 0, 0]", "visible_map: expected two positive scales"),
        ("visible_map = [1, 1, nan, 0]", "visible_map: expected two positive scales"),
        ("visible_map = [1, 101, 0, 0]", "scales of at most 100"),
        ("visible_map = [1, 1, 0, -1e9]", "offsets of at most 100000 px"),
        ("visible = 3", "visible: expected a text"),
        ('gaze = "a\\u0000b"', "gaze: expected a path"),
    ],
)
def test_what_cannot_be_is_refused_with_the_key(tmp_path: Path, text: str, words: str):
    with pytest.raises(SessionError, match=words):
        read(tmp_path, f'{HEAD}[[recording]]\nname = "urban"\n{text}\n')


def test_an_unknown_key_of_the_table_is_refused_with_the_near_ones(tmp_path: Path):
    with pytest.raises(SessionError, match="did you mean 'detectability'"):
        read(tmp_path, f'{HEAD}[driver]\ndetectabilty = "d.csv"\n')
    with pytest.raises(SessionError, match="expected a file, found nothing"):
        read(tmp_path, f'{HEAD}[driver]\ndetectability = ""\n')


def test_renaming_paths_leaves_what_is_not_named(tmp_path: Path):
    session = replace(read(tmp_path, HEAD), recordings=(RecordingEntry("a", light="lux.csv"),))
    renamed = session.with_paths(lambda path: f"x/{path}", folder=tmp_path)
    assert renamed.recordings == (RecordingEntry("a", light="x/lux.csv"),)
    assert renamed.driver == DriverTable(None)
