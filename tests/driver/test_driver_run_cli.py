"""``nvcore driver features``: from the command line to the files."""

from __future__ import annotations

import csv
import hashlib
import json
import re
from pathlib import Path

import click
import numpy as np
import pytest
from driver_estimators import estimator
from inputs import nvcore
from picture_files import write_picture
from places import SAMPLE

from nvcore.subjects.driver.calls.commands import features
from nvcore.subjects.driver.estimators import write_estimator
from nvcore.subjects.driver.features import FeatureSettings
from nvcore.subjects.driver.features.feature_record import about_features
from nvcore.subjects.driver.illumination import LightSettings

IMAGES_HEAD = "image,pedestrian,x,y,w,h\n"


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_features_of_a_session_are_written_with_how_they_were_made(tmp_path: Path):
    result = nvcore(
        *("driver", "features", SAMPLE, "--out", tmp_path / "out", "--only", "urban_crossing"),
        *("--frames", "40:60", "--surround", "3", "--fixation", "0.5,0.4"),
    )
    assert result.exit_code == 0, result.output
    assert "105 boxes in 21 pictures" in result.stdout
    assert "Fixation assumed: 50 % across and 40 % down the picture." in result.stdout
    rows = rows_of(tmp_path / "out" / "features.csv")
    assert len(rows) == 105
    assert rows[0]["recording"] == "urban_crossing"
    record = json.loads((tmp_path / "out" / "driver.json").read_text())
    assert record["settings"]["features"]["surround"] == 3.0
    assert record["recordings"][0]["n_boxes"] == 105
    content = (tmp_path / "out" / "features.csv").read_bytes()
    assert record["files"] == {"features.csv": hashlib.sha256(content).hexdigest()}


def small_session(folder: Path) -> Path:
    """A session of two recordings of three frames; pictures and size of the second are missing."""
    rows = [f"{name},{frame},20,10,8,16" for name in ("near", "far") for frame in range(3)]
    (folder / "truth.csv").write_text("\n".join(["recording,frame,x,y,w,h", *rows]) + "\n")
    for frame in range(3):
        write_picture(folder / "near" / f"{frame}.png", np.zeros((48, 64, 3), np.uint8))
    path = folder / "session.toml"
    path.write_text(
        '[defaults]\nfps = 4\n[truth]\npath = "truth.csv"\n[[recording]]\nname = "near"\n'
        'width = 64\nheight = 48\nframes = "0:2"\npictures = "near"\n'
        '[[recording]]\nname = "far"\nframes = "0:2"\n'
    )
    return path


def test_recordings_that_are_not_asked_for_need_no_facts(tmp_path: Path):
    flags = ("driver", "features", small_session(tmp_path), "--out", tmp_path / "out")
    result = nvcore(*flags)
    assert result.exit_code == 2
    assert "far" in result.stderr
    assert "The pictures near have --size 64x48" in result.stderr
    result = nvcore(*flags, "--only", "near", "--frames", "1:2")
    assert result.exit_code == 0, result.output
    assert [row["frame"] for row in rows_of(tmp_path / "out" / "features.csv")] == ["1", "2"]


def test_the_session_file_is_never_replaced(tmp_path: Path):
    session, model = small_session(tmp_path), tmp_path / "driver.npz"
    write_estimator(estimator(), model)
    before = session.read_bytes()
    flags = ("--only", "near", "--model", model, "--out", tmp_path)
    result = nvcore("driver", "estimate", session, *flags)
    assert result.exit_code == 2
    assert "session.toml: is an input, and would be replaced" in result.stderr
    assert session.read_bytes() == before


def test_features_of_pictures_are_written_into_a_file(tmp_path: Path):
    write_picture(tmp_path / "study" / "park.png", np.zeros((48, 64, 3), np.uint8))
    (tmp_path / "boxes.csv").write_text(IMAGES_HEAD + "park.png,1,20,10,8,16\n")
    out = tmp_path / "features.csv"
    flags = ("--images", tmp_path / "study", "--boxes", tmp_path / "boxes.csv", "--out", out)
    result = nvcore("driver", "features", *flags)
    assert result.exit_code == 0, result.output
    assert "1 pedestrian in 1 picture" in result.stdout
    assert rows_of(out)[0]["luminance_sd"] == "0"
    assert about_features(out)[0] == FeatureSettings()


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ((), "give a session file, or --images with --boxes"),
        (("--boxes", "boxes.csv"), "give a session file, or --images"),
        (("--images", "."), "--images and --boxes belong together"),
        ((SAMPLE, "--boxes", "b.csv"), "--images and --boxes belong together"),
        (
            ("--images", ".", "--boxes", "b.csv", "--only", "a"),
            "--only, --tag, --frames, --size and --fps are about a session",
        ),
        ((SAMPLE, "--surround", "1"), "surround: expected 1.1 to 10, found 1"),
        ((SAMPLE, "--fixation", "2,0"), "fixation: expected x as a share of the picture"),
        ((SAMPLE, "--fixation", "a"), "expected two numbers"),
        ((SAMPLE, "--only", "nowhere"), "there is no recording 'nowhere'"),
    ],
)
def test_what_cannot_be_done_is_said(tmp_path: Path, flags: tuple[object, ...], words: str):
    result = nvcore("driver", "features", *flags, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert words in " ".join(result.stderr.split())
    assert not (tmp_path / "out").exists()


def test_inputs_are_never_replaced(tmp_path: Path):
    write_picture(tmp_path / "study" / "park.png", np.zeros((48, 64, 3), np.uint8))
    boxes = tmp_path / "boxes.csv"
    boxes.write_text(IMAGES_HEAD + "park.png,1,20,10,8,16\n")
    flags = ("--images", tmp_path / "study", "--boxes", boxes, "--out", boxes)
    result = nvcore("driver", "features", *flags)
    assert result.exit_code == 2
    assert "is an input, and would be replaced" in result.stderr
    assert boxes.read_text().startswith(IMAGES_HEAD)


def test_the_estimator_of_the_sample_has_a_name(tmp_path: Path):
    flags = ("--only", "rural_child", "--frames", "100:101", "--out", tmp_path / "seen")
    result = nvcore("driver", "estimate", SAMPLE, "--model", "sample", *flags)
    assert result.exit_code == 0, result.output
    assert "simulated subjects" in result.stdout
    assert (tmp_path / "seen" / "detectability.csv").is_file()


def test_a_model_that_is_none_is_refused_before_pictures_are_read(tmp_path: Path):
    (tmp_path / "driver.npz").write_text("no model")
    flags = ("--model", tmp_path / "driver.npz", "--out", tmp_path / "out")
    result = nvcore("driver", "estimate", SAMPLE, *flags)
    assert result.exit_code == 2
    assert "driver.npz: is not an estimator that nvcore driver train wrote" in result.stderr
    assert not (tmp_path / "out").exists()


def test_the_help_states_the_defaults_of_the_settings():
    defaults = {**vars(FeatureSettings()), **vars(LightSettings())}
    stated = {
        option.name: float(re.search(r"Default: ([\d.]+?)\.?$", option.help or "")[1])  # type: ignore[index]
        for option in features.params
        if isinstance(option, click.Option) and option.name in defaults
    }
    assert stated == defaults
