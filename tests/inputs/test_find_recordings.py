"""Recordings of a delivery, by name or by their pictures."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from inputs import drive, session_of

from nvcore.dataset import Dataset
from nvcore.inputs.find_recordings import find_recordings
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry


@pytest.fixture
def dataset(tmp_path: Path) -> Dataset:
    """Recordings "urban", shown as "town", with a video, and "rural" with a folder of pictures."""
    session = session_of(drive(tmp_path))
    (tmp_path / "town.mp4").write_bytes(b"a video")
    (tmp_path / "road").mkdir()
    for frame in range(2):
        (tmp_path / "road" / f"{frame}.png").write_bytes(b"picture %d" % frame)
    entries = (
        RecordingEntry("urban", title="town", pictures="town.mp4"),
        RecordingEntry("rural", pictures="road"),
    )
    return load(replace(session, recordings=entries))


def delivery(tmp_path: Path, **names: str) -> Path:
    """A folder of NIR's detections, a file for each recording under another name."""
    folder = tmp_path / "delivery"
    folder.mkdir()
    head, *lines = (tmp_path / "fir.csv").read_text(encoding="utf-8").splitlines()
    for old, new in names.items():
        of = [line.partition(",")[2] for line in lines if line.startswith(old)]
        text = "\n".join([head.partition(",")[2], *of, ""])
        (folder / f"{new}.csv").write_text(text, encoding="utf-8")
    return folder


def test_one_file_is_found_by_names_also_by_those_of_the_data(tmp_path: Path, dataset: Dataset):
    found = find_recordings(tmp_path / "fir.csv", dataset)
    assert found == (("urban", "town", "name"), ("rural", "rural", "name"))


def test_a_folder_of_other_names_is_found_by_the_same_pictures(tmp_path: Path, dataset: Dataset):
    folder = delivery(tmp_path, urban="drive_a", rural="drive_b")
    assert [of.recording for of in find_recordings(folder, dataset)] == [None, None]
    shutil.copy(tmp_path / "town.mp4", folder / "drive_a.mp4")
    shutil.copytree(tmp_path / "road", folder / "drive_b")
    found = find_recordings(folder, dataset)
    assert set(found) == {("drive_a", "town", "pictures"), ("drive_b", "rural", "pictures")}
    (folder / "drive_b" / "1.png").write_bytes(b"another picture")
    assert ("drive_b", None, None) in find_recordings(folder, dataset)


def test_the_only_recording_is_the_only_one_of_the_data(tmp_path: Path, dataset: Dataset):
    folder = delivery(tmp_path, urban="drive_a")
    assert find_recordings(folder, dataset.only(names="town")) == (("drive_a", "town", "only one"),)
