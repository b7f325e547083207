"""A run written down: a system like any other, with its provenance, in a session."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import nvcore as nv
from nvcore.auditing import audit
from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, TrainedOn, read_provenance
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.detectors.running.run import DetectorRun, RecordingRun
from nvcore.subjects.detectors.running.writing import WrittenRun, outputs, write_detections

ABOUT = About("hog", "HOG", ("pedestrian",), {"stride": 8}, "5f1c", threshold=0.25)


@pytest.fixture
def dataset(tmp_path: Path) -> Dataset:
    (tmp_path / "truth.csv").write_text(
        "recording,frame,x,y,w,h\nnight 1,0,10,10,20,60\nnight 1,9,10,10,20,60\nday,0,5,5,9,30\n"
    )
    (tmp_path / "fir.csv").write_text("recording,frame,x,y,w,h,score\nnight 1,0,10,10,20,60,0.9\n")
    session = tmp_path / "session.toml"
    session.write_text(
        '[defaults]\nsize = "640x480"\nfps = 20\n[truth]\npath = "truth.csv"\n'
        '[[recording]]\nname = "night 1"\ntitle = "Night"\nframes = "0:9"\n'
        '[[system]]\nname = "FIR"\npath = "fir.csv"\nthreshold = 0.5\n'
        "[parameters]\nthreshold_x = 0.75\nalpha = 0.8\n"
    )
    return nv.load(session)


def run_of(about: About = ABOUT, *, with_class: bool = False) -> DetectorRun:
    boxes = pd.DataFrame(
        {"frame": [0, 3], "x": [1.5, 2], "y": [3.0, 4], "w": [5.0, 6], "h": [7.0, 8]}
    ).assign(score=[0.5, 0.125])
    if with_class:
        boxes = boxes.assign(**{"class": ["car", "person"]})
    nothing = boxes[:0]
    return DetectorRun(
        about,
        (
            RecordingRun("Night", boxes, np.arange(10), 10),
            RecordingRun("day", nothing, np.arange(0), 1, "no pictures are named for it"),
        ),
        1.0,
    )


@pytest.fixture
def written(dataset: Dataset, tmp_path: Path) -> WrittenRun:
    about = replace(ABOUT, trained_on=(TrainedOn(recording="night 1", last_frame=4),))
    return write_detections(run_of(about), dataset, tmp_path / "out")


def test_the_session_has_one_system_more_and_everything_it_had(written: WrittenRun):
    loaded = nv.load(written.session)
    assert loaded.systems == ("FIR", "HOG")
    assert loaded.compared() == ("FIR", "HOG")
    params = loaded.params_of()
    assert (params.threshold_x, params.threshold_y, params.alpha) == (0.75, 0.25, 0.8)
    assert loaded.recordings["name"].tolist() == ["Night", "day"]
    assert loaded.system("HOG").x.tolist() == [1.5, 2]
    assert not loaded.left_out.size
    assert [entry.code for entry in loaded.findings if entry.severity == "error"] == []
    made_by = loaded.inputs.set_index("subject")["conversion"]["HOG"]
    assert made_by.endswith("; made by hog (HOG, fingerprint 5f1c)")


def test_the_record_says_how_the_boxes_were_made_and_in_which_frames(
    written: WrittenRun, dataset: Dataset
):
    record = read_provenance(written.provenance, "provenance.json")
    assert (record.about.kind, record.about.settings) == ("hog", {"stride": 8})
    assert record.frames == {"night 1": ((0, 9),)}
    assert record.written_by == f"nvcore {nv.__version__}"
    assert [path.name for path in written.files] == ["Night.csv"]
    made = {*written.files, written.session, written.provenance}
    assert {path.name for path in made} <= {*outputs(dataset)}
    findings = {finding.code: finding for finding in audit(nv.load(written.session))}
    assert findings["frames-not-run"].message == "Not run on 1 of the 11 evaluated frames: day."
    assert findings["trained-on-tested"].count == 5
    assert "other-provenance" not in findings


def test_a_changed_record_boxes_or_no_record_are_noticed(written: WrittenRun):
    before = nv.load(written.session).fingerprint
    text = written.provenance.read_text()
    written.provenance.write_text(text.replace('"stride": 8', '"stride": 16'))
    assert nv.load(written.session).fingerprint != before
    written.provenance.write_text(text)
    written.files[0].write_text(written.files[0].read_text().replace("0.125", "0.625"))
    codes = {finding.code for finding in audit(nv.load(written.session))}
    assert {"other-provenance", "input-changed"} <= codes
    written.provenance.unlink()
    codes = {finding.code for finding in audit(nv.load(written.session))}
    assert "missing-provenance" in codes


def test_classes_are_told_apart_by_the_reader(dataset: Dataset, tmp_path: Path):
    written = write_detections(run_of(with_class=True), dataset, tmp_path / "out")
    assert nv.load(written.session).system("HOG").x.tolist() == [2]


def test_a_second_run_gets_a_number_and_a_chosen_opponent(dataset: Dataset, tmp_path: Path):
    first = write_detections(run_of(), dataset, tmp_path / "first")
    again = nv.load(first.session)
    second = write_detections(run_of(), again, tmp_path / "second", against="HOG")
    assert second.name == "HOG (2)"
    assert nv.load(second.session).compared() == ("HOG", "HOG (2)")


def test_nothing_seen_is_nothing_written(dataset: Dataset, tmp_path: Path):
    run = run_of()
    with pytest.raises(InputError, match=r"has seen no picture\. no pictures are named"):
        write_detections(replace(run, recordings=run.recordings[1:]), dataset, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_without_a_system_the_new_one_is_x(dataset: Dataset, tmp_path: Path):
    session = tmp_path / "session.toml"
    head = session.read_text().partition("[[system]]")[0]
    session.write_text(head)
    alone = load(read_session(session, needs_system=False))
    written = write_detections(run_of(), alone, tmp_path / "out")
    loaded = nv.load(written.session)
    assert (loaded.systems, loaded.compared()) == (("HOG",), ("HOG", None))


def test_limits_that_were_read_count_as_the_speed_signs_of_the_session(tmp_path: Path):
    table = "recording,frame,x,y,w,h,class\nNight,0,10,10,20,20,speed limit 30\n"
    (tmp_path / "truth.csv").write_text(table)
    session = tmp_path / "session.toml"
    session.write_text(
        '[defaults]\nsize = "640x480"\nfps = 20\nframes = "0:9"\n[truth]\npath = "truth.csv"\n'
        '[compare]\nobjects = "speed sign"\n'
    )
    about = About("icf", "signs", ("30", "100"), {}, "5f1c")
    boxes = pd.DataFrame({"frame": [0, 3], "x": 1.0, "y": 3.0, "w": 5.0, "h": 7.0, "score": 0.5})
    run = DetectorRun(
        about,
        (RecordingRun("Night", boxes.assign(**{"class": ["100", "30"]}), np.arange(10), 10),),
        1.0,
    )
    written = write_detections(
        run, load(read_session(session, needs_system=False)), tmp_path / "out"
    )
    again = nv.load(written.session)
    assert again.settings.systems[0].classes == ("30", "100")
    assert again.labels == ("30", "100")
    assert again.system("signs").label.tolist() == [1, 0]
