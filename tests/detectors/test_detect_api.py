"""`nv.detect`: pictures in, a system in a session out."""

from __future__ import annotations

from concurrent.futures import CancelledError
from pathlib import Path

import pytest
from builders import at, make_dataset
from onnx_models import blob_model
from places import SAMPLE

import nvcore as nv


@pytest.fixture(scope="module")
def blobs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return blob_model(tmp_path_factory.mktemp("model") / "blobs.onnx", 64, 48)


def test_a_dataset_is_run_and_compared(tmp_path: Path, blobs: Path):
    part = nv.load(SAMPLE, frames=range(40, 61, 10))
    settings = {"threshold": 0.2}
    written = nv.detect(part, blobs, tmp_path / "out", settings=settings, only=["odd_pose"])
    assert (written.name, written.run.n_pictures, written.run.n_without) == ("blobs", 3, 0)
    result = nv.compare(written.session)
    assert (result.x.name, result.y.name) == ("FIR", "blobs")
    assert result.dataset.recordings["name"].tolist() == ["odd_pose"]


def test_what_was_run_is_printed_as_the_command_prints_it(tmp_path: Path, blobs: Path):
    trained_on = ("odd_pose=:99", "elsewhere")
    part = {"only": "odd_pose", "frames": range(60, 39, -10), "n_threads": 1}
    written = nv.detect(SAMPLE, blobs, tmp_path / "out", trained_on=trained_on, **part)
    n_boxes = written.run.n_boxes
    assert repr(written) == f"<WrittenRun of blobs: {tmp_path}/out/session.toml>"
    assert repr(written.run.recordings[0]).startswith("<RecordingRun of odd_pose: ")
    lines = str(written).splitlines()
    assert lines[0].startswith(f"{n_boxes} boxes in 3 pictures of 1 recording, in ")
    assert lines[1] == "trained on: odd_pose, frames 0 to 99; elsewhere"
    assert lines[2] == f"written to {tmp_path}/out as blobs"
    with pytest.raises(nv.NvcoreError, match="expected a recording, or frames of it as odd_pose="):
        nv.detect(SAMPLE, blobs, tmp_path / "out", trained_on="odd_pose=0-99")
    with pytest.raises(nv.NvcoreError, match="expected a recording or a fingerprint"):
        nv.detect(SAMPLE, blobs, tmp_path / "out", trained_on=[""])
    with pytest.raises(nv.NvcoreError, match="loaded already: give frames= to load"):
        nv.detect(nv.load(SAMPLE), blobs, tmp_path / "out", frames=":99")


def test_frames_without_a_picture_are_said_with_the_pictures_there_are(tmp_path: Path, blobs: Path):
    with pytest.raises(
        nv.NvcoreError, match=r"\(300 pictures in odd_pose.mp4\)\. By .* odd_pose has"
    ):
        nv.detect(SAMPLE, blobs, tmp_path / "out", only="odd_pose", frames="900:910")


def test_scores_of_a_detector_that_was_run_here_are_on_its_own_scale(tmp_path: Path):
    run = {"settings": {"scale_step": 1.3, "hit_threshold": -1}, "frames": "40:42"}
    written = nv.detect(SAMPLE, "hog:daimler", tmp_path / "out", only="urban_crossing", **run)
    assert min(part.boxes["score"].min() for part in written.run.recordings) < 0
    findings = nv.audit(written.session)
    assert not [finding for finding in findings if finding.code == "unusual-scores"]


def test_a_session_is_as_good(tmp_path: Path, blobs: Path):
    part = {"only": ["odd_pose"], "frames": "40:42"}
    written = nv.detect(nv.read_session(SAMPLE), blobs, tmp_path / "out", name="Blobs", **part)
    assert written.run.n_pictures == 3
    assert nv.load(written.session).systems == ("FIR", "NIR", "NIR 2", "Blobs")


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


def test_inputs_are_never_written_over(tmp_path: Path, blobs: Path):
    session = tmp_path / "session.toml"
    text = SAMPLE.read_text().replace('path = "', f'path = "{SAMPLE.parent}/')
    session.write_text(text.replace('pictures = "', f'pictures = "{SAMPLE.parent}/'))
    before = session.read_bytes()
    with pytest.raises(nv.NvcoreError, match=r"session\.toml: is an input, and would be replaced"):
        nv.detect(session, blobs, tmp_path, only=["odd_pose"])
    assert session.read_bytes() == before


def test_only_files_of_an_earlier_run_go(tmp_path: Path, blobs: Path):
    out, part = tmp_path / "out", nv.load(SAMPLE, frames=range(40, 61, 10))
    nv.detect(part, blobs, out, only=["odd_pose", "urban_groups"])
    (out / "odd_pose.csv").write_text("frame,x,y,w,h\n")  # somebody's own by now
    written = nv.detect(part, blobs, out, only=["rural_road"])
    assert sorted(path.name for path in out.glob("*.csv")) == ["odd_pose.csv", "rural_road.csv"]
    assert [path.name for path in written.files] == ["rural_road.csv"]
