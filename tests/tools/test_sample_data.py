"""The committed folder is what the generator makes, and is fit for use."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from places import ROOT

from nvcore.common.progress import Progress
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.ratings.reading import RATINGS_FILE
from tools import sample
from tools.sample import __main__ as program
from tools.sample.camera import FPS
from tools.sample.ratings import ratings_text, simulate_ratings
from tools.sample.study import writing as study_writing
from tools.sample.study.scenes import Scene, all_scenes
from tools.sample.study.trials import N_SUBJECTS, TRIALS_FILE
from tools.sample.study.trials import TRUTH_FILE as STUDY_TRUTH_FILE
from tools.sample.visible.recordings import GLOWS, light_file, light_text, visible_file
from tools.sample.visible.view import VISIBLE_SIZE, visible_map
from tools.sample.writing import csv_text, readme_text, session_text

FOLDER = ROOT / "sample_data"
NAMES = [recording.name for recording in sample.all_recordings()]
TABLES = ["truth.csv", "fir.csv", "nir.csv", "nir2.csv"]


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
    for recording in recordings:
        if recording.name in GLOWS:
            assert (FOLDER / light_file(recording)).read_text("utf-8") == light_text(recording)


def test_the_readme_explains_every_file() -> None:
    readme = (FOLDER / "README.md").read_text("utf-8")
    for path in FOLDER.iterdir():
        known = path.name
        for name in NAMES:
            known = known.replace(name, "<recording>")
        assert known == "README.md" or f"`{known}" in readme, path.name


@pytest.mark.parametrize("name", GLOWS)
def test_a_visible_video_has_the_frames_of_the_thermal_one_in_colour(name: str) -> None:
    recording = next(r for r in sample.all_recordings() if r.name == name)
    with av.open(str(FOLDER / visible_file(recording))) as container:
        stream = container.streams.video[0]
        assert (stream.frames, stream.average_rate) == (300, 20)
        assert (stream.width, stream.height) == VISIBLE_SIZE
        first = next(container.decode(stream)).to_ndarray(format="rgb24").astype(float)
    assert np.abs(first[..., 0] - first[..., 2]).mean() > 5


@pytest.mark.parametrize("name", ["urban_sidewalk", "rural_child"])
def test_a_visible_video_turns_dark_where_its_light_sensor_does(name: str) -> None:
    with av.open(str(FOLDER / f"{name}_visible.mp4")) as container:
        road = [
            float(frame.to_ndarray(format="gray")[420:, 300:660].mean())
            for frame in container.decode(video=0)
        ]
    lux = pd.read_csv(FOLDER / f"{name}_light.csv")
    dark = int(lux["time_s"][lux["lux"] < 20].min() * FPS)
    assert min(road[:40]) > 1.6 * max(road[dark + FPS :])


def test_the_session_names_visible_pictures_and_light_sensor() -> None:
    entries = {entry.name: entry for entry in read_session(FOLDER / "session.toml").recordings}
    assert [name for name, entry in entries.items() if entry.visible] == [
        name for name in NAMES if name in GLOWS
    ]
    entry = entries["rural_child"]
    assert (entry.visible, entry.light) == ("rural_child_visible.mp4", "rural_child_light.csv")
    assert entry.visible_map == visible_map()


@pytest.mark.parametrize("name", NAMES)
def test_a_video_has_300_frames_at_20_per_second_and_can_be_entered_every_two(name: str) -> None:
    with av.open(str(FOLDER / f"{name}.mp4")) as container:
        stream = container.streams.video[0]
        is_key = [packet.is_keyframe for packet in container.demux(stream) if packet.size]
        assert (len(is_key), stream.average_rate) == (300, 20)
        assert (stream.width, stream.height) == (640, 480)
    assert np.diff([*np.flatnonzero(is_key), 300]).max() <= 40


def test_the_folder_is_smaller_than_11_megabytes() -> None:
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < 11e6


def test_the_generator_writes_all_files_and_reports_progress(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = sample.all_recordings()[3]
    monkeypatch.setattr(sample, "all_recordings", lambda: (recording,))
    monkeypatch.setattr(
        sample, "pictures", lambda _: iter([np.zeros((480, 640), dtype=np.uint8)] * 3)
    )
    monkeypatch.setattr(sample, "write_study", lambda _: None)
    monkeypatch.setattr(sample, "write_speed_signs", lambda _: None)
    steps: list[tuple[float, str]] = []
    sample.generate(tmp_path / "new", progress=lambda share, name: steps.append((share, name)))
    written = sorted(path.name for path in (tmp_path / "new").iterdir())
    assert written == sorted([*TABLES, "README.md", RATINGS_FILE, "session.toml", "rural_road.mp4"])
    assert steps == [(0.0, "rural_road"), (1 / 3, "study"), (2 / 3, "speed_signs"), (1.0, "")]


def test_the_generator_writes_visible_pictures_and_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = next(r for r in sample.all_recordings() if r.name == "rural_child")
    scene = next(all_scenes())
    nobody = np.zeros((540, 960, 3), dtype=np.uint8)
    monkeypatch.setattr(sample, "all_recordings", lambda: (recording,))
    monkeypatch.setattr(sample, "pictures", lambda _: iter([nobody[:480, :640, 0]] * 3))
    monkeypatch.setattr(sample, "write_speed_signs", lambda _: None)
    monkeypatch.setattr(sample, "visible_pictures", lambda *_: iter([nobody] * 3))
    monkeypatch.setattr(Scene, "pictures", lambda _: (nobody, nobody))
    monkeypatch.setattr(
        study_writing, "all_scenes", lambda: iter([scene, replace(scene, number=2)])
    )
    sample.generate(tmp_path)
    expected = {"rural_child_visible.mp4", "rural_child_light.csv", "study", TRIALS_FILE}
    assert expected <= {path.name for path in tmp_path.iterdir()}
    assert sorted(path.name for path in (tmp_path / "study").iterdir()) == [
        *("boxes.csv", "study_01.jpg", "study_02.jpg")
    ]
    trials = pd.read_csv(tmp_path / TRIALS_FILE)
    assert len(trials) == N_SUBJECTS * 2 * 6
    assert pd.read_csv(tmp_path / STUDY_TRUTH_FILE)["probability"].eq(0).all()


def test_the_program_tells_its_progress(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def generate(folder: Path, *, progress: Progress) -> None:
        progress(0.25, folder.name)

    monkeypatch.setattr(program, "generate", generate)
    result = CliRunner().invoke(program.main, [str(tmp_path / "new")])
    assert (result.exit_code, result.stderr) == (0, " 25% new\n")
