"""The committed folder is what the generator makes, and is fit for use."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pandas as pd
import pytest
from places import ROOT

from nvcore import sample
from nvcore.sample.ratings import ratings_text, simulate_ratings
from nvcore.sample.writing import csv_text, readme_text, session_text
from nvcore.studies.ratings.reading import RATINGS_FILE

FOLDER = ROOT / "sample_data"
NAMES = [recording.name for recording in sample.all_recordings()]
TABLES = ["truth.csv", "fir.csv", "nir.csv"]


@pytest.fixture(scope="module")
def made() -> dict[str, pd.DataFrame]:
    return sample.tables(sample.all_recordings())


def test_the_committed_files_are_what_the_generator_makes(made: dict[str, pd.DataFrame]) -> None:
    recordings = sample.all_recordings()
    for path in TABLES:
        assert (FOLDER / path).read_bytes() == csv_text(made[path]).encode(), path
    assert (FOLDER / "session.toml").read_text("utf-8") == session_text(recordings)
    assert (FOLDER / "README.md").read_text("utf-8") == readme_text(recordings, made["truth.csv"])
    ratings = ratings_text(simulate_ratings(FOLDER / "session.toml"))
    assert (FOLDER / RATINGS_FILE).read_text("utf-8") == ratings


@pytest.mark.parametrize("name", NAMES)
def test_a_video_has_300_frames_at_20_per_second_and_can_be_entered_every_two(name: str) -> None:
    with av.open(str(FOLDER / f"{name}.mp4")) as container:
        stream = container.streams.video[0]
        is_key = [packet.is_keyframe for packet in container.demux(stream) if packet.size]
        assert (len(is_key), stream.average_rate) == (300, 20)
        assert (stream.width, stream.height) == (640, 480)
    assert np.diff([*np.flatnonzero(is_key), 300]).max() <= 40


def test_the_folder_is_smaller_than_8_megabytes() -> None:
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < 8e6


def test_the_generator_writes_all_files_and_reports_progress(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = sample.all_recordings()[3]
    monkeypatch.setattr(sample, "all_recordings", lambda: (recording,))
    monkeypatch.setattr(
        sample, "pictures", lambda _: iter([np.zeros((480, 640), dtype=np.uint8)] * 3)
    )
    steps: list[tuple[float, str]] = []
    sample.generate(tmp_path / "new", progress=lambda share, name: steps.append((share, name)))
    written = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert written == sorted([*TABLES, "README.md", RATINGS_FILE, "session.toml", "rural_road.mp4"])
    assert steps == [(0.0, "rural_road"), (1.0, "")]
