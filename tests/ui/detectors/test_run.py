"""A run's system beside those of an upload: named as its sender knows files, not as the machine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from inputs import drive, session_of

from nvcore.dataset.provenance import About
from nvcore.inputs.load import load
from nvcore.subjects.detectors.running.run import DetectorRun, RecordingRun
from nvcore.subjects.detectors.running.writing import write_detections
from ui.session.uploads import ANNOTATION_FOLDERS
from ui.subjects.detectors.confined import DetectorSpec
from ui.subjects.detectors.run import RunSettings, differences_of, with_system
from ui.subjects.detectors.trial import Levels
from ui.views.export.session import inputs_beside, portable_session

ABOUT = About("hog", "HOG", ("pedestrian",), {"stride": 8}, "5f1c")


def test_the_system_of_an_upload_lies_beside_its_files(tmp_path: Path):
    folder = drive(tmp_path / "upload-1" / "x" / ANNOTATION_FOLDERS)
    session = session_of(folder, "truth.csv", "fir.csv", "nir.csv")
    dataset = load(session)
    boxes = pd.DataFrame(
        {"frame": [0], "x": [1.0], "y": [2.0], "w": [9.0], "h": [20.0], "score": [0.5]}
    )
    name = dataset.recordings["name"].iloc[0]
    frames = dataset.frame_columns.frame[dataset.frame_columns.rows_of(0)].astype(np.int64)
    run = DetectorRun(ABOUT, (RecordingRun(name, boxes, frames, len(frames)),), 1.0)
    target = folder / "detector-3" / ANNOTATION_FOLDERS
    target.mkdir(parents=True)
    written = write_detections(run, dataset, target, threshold=0.4)
    x, y = dataset.systems
    extended = with_system(dataset.settings, dataset, written, x=x)
    assert (extended.x, extended.y) == (x, "HOG")
    assert extended.only == (name,)  # the other recording was not run
    assert [system.name for system in extended.systems] == [x, y, "HOG"]
    system = extended.systems[2]
    assert system.path == (f"detector-3/annotations/data/{written.files[0].name}",)
    assert (system.threshold, system.provenance) == (
        0.4, "detector-3/annotations/data/provenance.json",
    )  # fmt: skip
    again = load(extended)
    assert len(again.system("HOG")) == 1
    assert again.provenance["HOG"] is not None
    beside = inputs_beside(portable_session(extended, is_upload=True))
    assert written.files[0].name in beside
    assert not any(str(tmp_path) in path for path in beside)


def test_what_is_set_in_another_way_since_the_run_began_is_named():
    spec = DetectorSpec("hog", "", (("stride", 16),))
    started = RunSettings(spec, ("a", "b"), Levels(-0.5, 0.5))
    assert differences_of(started, started) == []
    now = RunSettings(DetectorSpec("hog", "", (("person_box", True),)), ("a",), Levels(0.25, 0.5))
    assert differences_of(started, now) == [
        "person box", "stride", "threshold −0.5 (now 0.25)", "recordings",
    ]  # fmt: skip
    other = started._replace(spec=DetectorSpec("hog:daimler"))
    assert differences_of(started, other) == ["another detector"]
