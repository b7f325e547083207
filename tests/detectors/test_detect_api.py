"""`nv.detect`: pictures in, a system in a session out."""

from __future__ import annotations

from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from builders import at, make_dataset
from onnx_models import blob_model
from places import SAMPLE

import nvcore as nv


@pytest.fixture
def blobs(tmp_path: Path) -> Path:
    return blob_model(tmp_path / "blobs.onnx", 64, 48)


def test_a_dataset_is_run_and_compared(tmp_path: Path, blobs: Path):
    part = nv.load(SAMPLE, frames=range(40, 61, 10))
    settings = {"threshold": 0.2}
    written = nv.detect(part, blobs, tmp_path / "out", settings=settings, only=["odd_pose"])
    assert (written.name, written.run.n_pictures, written.run.n_without) == ("blobs", 3, 0)
    result = nv.compare(written.session)
    assert (result.x.name, result.y.name) == ("FIR", "blobs")
    assert result.dataset.recordings["name"].tolist() == ["odd_pose"]


def test_a_session_is_as_good(tmp_path: Path, blobs: Path):
    session = nv.read_session(SAMPLE)
    written = nv.detect(session, blobs, tmp_path / "out", name="Blobs", only=["odd_pose"])
    assert written.run.n_pictures == 300
    assert nv.load(written.session).systems == ("FIR", "NIR", "Blobs")


def test_a_cancelled_run_leaves_nothing(tmp_path: Path, blobs: Path):
    def cancel(share: float, _words: str) -> None:
        if share > 0.01:
            raise CancelledError

    with pytest.raises(CancelledError):
        nv.detect(SAMPLE, blobs, tmp_path / "out", progress=cancel, only=["odd_pose"])
    assert not (tmp_path / "out").exists()


def test_tables_in_memory_have_no_pictures(tmp_path: Path, blobs: Path):
    with pytest.raises(nv.NvcoreError, match="expected a session, or a dataset that was loaded"):
        nv.detect(make_dataset([at(0, 50)]), blobs, tmp_path / "out")


def test_a_folder_that_cannot_be_written_to_is_refused_before(tmp_path: Path, blobs: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(nv.NvcoreError, match="cannot be written to; give another folder"):
        nv.detect(SAMPLE, blobs, tmp_path / "file" / "out")
