"""The committed folder is what the generator makes, and is fit for use."""

from __future__ import annotations

import tomllib
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


@pytest.mark.parametrize("path", TABLES)
def test_a_committed_table_is_what_the_generator_makes(
    made: dict[str, pd.DataFrame], path: str
) -> None:
    assert (FOLDER / path).read_bytes() == csv_text(made[path]).encode()


def test_one_recording_gives_the_same_tables_twice() -> None:
    recording = sample.all_recordings()[3]
    one, two = sample.tables([recording]), sample.tables([recording])
    assert [csv_text(one[path]) for path in TABLES] == [csv_text(two[path]) for path in TABLES]


def test_the_committed_session_and_readme_are_what_the_generator_makes(
    made: dict[str, pd.DataFrame],
) -> None:
    recordings = sample.all_recordings()
    assert (FOLDER / "session.toml").read_text("utf-8") == session_text(recordings)
    assert (FOLDER / "README.md").read_text("utf-8") == readme_text(recordings, made["truth.csv"])


def test_the_committed_ratings_are_what_the_generator_makes() -> None:
    made = ratings_text(simulate_ratings(FOLDER / "session.toml"))
    assert (FOLDER / RATINGS_FILE).read_text("utf-8") == made


def test_the_session_names_files_that_exist() -> None:
    session = tomllib.loads((FOLDER / "session.toml").read_text("utf-8"))
    paths = [session["truth"]["path"]]
    paths += [system["path"] for system in session["system"]]
    paths += [recording["pictures"] for recording in session["recording"]]
    assert [path for path in paths if not (FOLDER / path).is_file()] == []


@pytest.mark.parametrize("name", NAMES)
def test_a_video_has_300_frames_at_20_per_second(name: str) -> None:
    with av.open(str(FOLDER / f"{name}.mp4")) as container:
        stream = container.streams.video[0]
        n_packets = sum(packet.size > 0 for packet in container.demux(stream))
        assert (n_packets, stream.average_rate) == (300, 20)
        assert (stream.width, stream.height) == (640, 480)


@pytest.mark.parametrize("name", NAMES)
def test_a_video_can_be_entered_every_two_seconds(name: str) -> None:
    with av.open(str(FOLDER / f"{name}.mp4")) as container:
        stream = container.streams.video[0]
        keys = [index for index, packet in enumerate(container.demux(stream)) if packet.is_keyframe]
    assert max(np.diff([*keys, 300])) <= 40


def test_the_folder_is_smaller_than_8_megabytes() -> None:
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < 8e6


@pytest.mark.parametrize("path", TABLES)
def test_every_box_lies_inside_the_picture(made: dict[str, pd.DataFrame], path: str) -> None:
    table = made[path]
    assert (table[["x", "y"]] >= 0).all(axis=None)
    assert (table[["w", "h"]] > 0).all(axis=None)
    assert (table["x"] + table["w"] <= 640).all()
    assert (table["y"] + table["h"] <= 480).all()


def test_a_track_has_one_box_a_frame(made: dict[str, pd.DataFrame]) -> None:
    assert not made["truth.csv"].duplicated(["recording", "frame", "track"]).any()


def test_truth_boxes_are_at_least_8_pixels_high_where_the_picture_does_not_cut_them(
    made: dict[str, pd.DataFrame],
) -> None:
    table = made["truth.csv"]
    whole = (table["y"] > 0) & (table["y"] + table["h"] < 480)
    assert table[whole]["h"].min() >= 7.5


def test_both_systems_have_scores_on_both_sides_of_the_threshold(
    made: dict[str, pd.DataFrame],
) -> None:
    for path in ("fir.csv", "nir.csv"):
        share = (made[path]["score"] >= 0.5).mean()
        assert 0.3 < share < 0.95


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
