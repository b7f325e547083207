"""Which frames a detector was trained on: by name, and by the truth under another name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nvcore.auditing.training import trained_rows
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, TrainedOn
from nvcore.dataset.training import trained_part
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from pages import FRAMES, rows, write


def opened(folder: Path) -> Dataset:
    boxes = "".join(f"night,{frame},300,200,40,120,0.9\n" for frame in FRAMES)
    return load(read_session(write(folder, {"one": boxes}, truth=rows(300))))


@pytest.mark.parametrize("recording", ["night", "under another name", ""])
def test_frames_of_the_training_are_known_by_name_or_truth(tmp_path: Path, recording: str):
    dataset = opened(tmp_path)
    part = replace(trained_part(dataset, "night", 5, 9), recording=recording)
    about = About("icf", "model", ("pedestrian",), {}, "", (part,))
    assert np.flatnonzero(trained_rows(dataset, about.trained_on)[0]).tolist() == [5, 6, 7, 8, 9]


def test_another_recording_is_none_of_the_training(tmp_path: Path):
    dataset = opened(tmp_path)
    parts = TrainedOn(recording="day"), TrainedOn(fingerprint="5f1c", first_frame=0, last_frame=9)
    about = About("icf", "model", ("pedestrian",), {}, "", parts)
    assert not trained_rows(dataset, about.trained_on)[0].any()
