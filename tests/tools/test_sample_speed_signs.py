"""The second sample: its files are what the generator makes, and are fit for use."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
from places import SAMPLE

from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from tools.sample import speed_signs
from tools.sample.speed_signs import DRIVES, files, write_speed_signs

FOLDER = SAMPLE.parent / "speed_signs"


def test_the_committed_files_are_what_the_generator_makes():
    made = files()
    assert {path.name for path in FOLDER.iterdir()} == {
        *made,
        *(f"{drive.recording.name}.mp4" for drive in DRIVES),
    }
    for path, text in made.items():
        assert (FOLDER / path).read_bytes() == text.encode(), path


def test_the_generator_writes_the_videos_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    black = np.zeros((360, 640, 3), dtype=np.uint8)
    monkeypatch.setattr(speed_signs, "visible_pictures", lambda *_, **__: iter([black] * 2))
    write_speed_signs(tmp_path)
    assert {path.name for path in (tmp_path / "speed_signs").iterdir()} == {
        path.name for path in FOLDER.iterdir()
    }


@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: drive.recording.name)
def test_a_sign_is_drawn_where_its_box_is(drive: speed_signs.Drive):
    truth = speed_signs.tables()["truth.csv"]
    own = truth[truth["recording"] == drive.recording.name]
    box = own[own["w"] > 30].iloc[0]
    with av.open(str(FOLDER / f"{drive.recording.name}.mp4")) as container:
        stream = container.streams.video[0]
        assert (stream.frames, stream.width, stream.height) == (300, 640, 360)
        pictures = [frame.to_ndarray(format="gray") for frame in container.decode(stream)]
    rows, columns = (
        slice(int(box[a] - box[s] // 2), int(box[a] + box[s] * 1.5)) for a, s in ("yh", "xw")
    )
    patch = pictures[int(box["frame"])][rows, columns].astype(float)
    n_rows, n_columns = patch.shape
    inner = patch[n_rows // 4 : 3 * n_rows // 4, n_columns // 4 : 3 * n_columns // 4]
    assert inner.std() > 20  # ink on white
    assert inner.max() > 1.2 * np.median(patch[:, : n_columns // 8])


def test_the_session_opens_without_a_finding_that_forbids_anything():
    dataset = load(read_session(FOLDER / "session.toml"))
    assert dataset.labels == ("30", "50", "80", "end of speed limit")
    assert not [finding for finding in dataset.findings if finding.severity != "note"]
    assert not dataset.frames["speed_kmh"].isna().any()
