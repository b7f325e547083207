"""``nvcore train``: from a session to a model that ``nvcore detect`` runs; what is refused."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
from inputs import nvcore
from places import SAMPLE

from nvcore.subjects.detectors.calls.commands import _next_step
from nvcore.subjects.detectors.training import run as run_module

PART = ("--only", "urban_crossing", "--only", "winter_frost", "--every", "15")
QUICK = tuple(
    text
    for setting in (
        *("window_width=20", "window_height=40", "object_width=12", "object_height=32"),
        *("features=150", "least_area=16", "trees_per_round=8,16", "negatives=300"),
        *("negatives_per_round=100", "copies=1", "scales=1,1.5,2.25,3.4"),
    )
    for text in ("--set", setting)
)


def test_from_a_session_to_boxes(tmp_path: Path):
    model = tmp_path / "night.npz"
    ran = nvcore("train", SAMPLE, *PART, *QUICK, "--out", model)
    assert ran.exit_code == 0, ran.output
    lines = ran.stdout.splitlines()
    assert "pictures, one in 15 of the evaluated frames" in lines[0]
    assert lines[1].startswith("held out: 1 of 8 physical objects (")
    assert lines[2].startswith("windows: ")
    assert lines[3].startswith("  round 1: 8 trees, training error ")
    assert lines[4].startswith("  round 2: 16 trees, training error ")
    assert "reach the threshold (0) in a window of their own" in lines[5]
    assert lines[5].endswith("the cascade was calibrated to let 100 % of the held-out ones through")
    assert lines[6].startswith("trained in ")
    assert any(
        re.search(r"^not trained on \d+ boxes? lower than the least height", line) for line in lines
    )
    run_it = f"run it: nvcore detect {SAMPLE} --detector {model} --only "
    last_line = ran.stderr.splitlines()[-1]
    assert last_line.startswith(run_it)
    assert last_line.endswith(f" --out {tmp_path / 'night'}")
    assert last_line.count(" --only ") == 8
    assert not any(name in last_line for name in ("urban_crossing", "winter_frost"))
    out = tmp_path / "night"
    few = ("--only", "odd_pose", "--frames", "100:110:5")
    ran = nvcore("detect", SAMPLE, "--detector", model, *few, "--out", out)
    assert ran.exit_code == 0, ran.output
    described = nvcore("models", model, "--set", "stride=8").stdout.splitlines()
    assert described[0].startswith("night: Integral Channel Features")
    assert "detects: pedestrian" in described
    trained_on = "urban_crossing, frames 0 to 299; winter_frost, frames 0 to 299"
    assert f"trained on: {trained_on}" in described
    assert "window: 20x40 px, with an object of 12x32 px" in described
    of_training = described.index("settings of its training, which cannot be changed:")
    assert described.index("  stride = 8") < of_training < described.index("  features = 150")


def test_the_hint_for_a_first_run_is_a_command_for_a_shell():
    hint = _next_step(Path("my models/night.npz"), Path("it's.toml"), ["a b", "c"])
    command = hint.removeprefix("run it: ")
    words = ["nvcore", "detect", "it's.toml", "--detector", "my models/night.npz"]
    others = ["--only", "a b", "--only", "c"]
    assert shlex.split(command) == [*words, *others, "--out", "my models/night"]
    none_left = _next_step(Path("night.npz"), Path("night.toml"), [])
    assert none_left.startswith("it was trained on all recordings of the session")
    of_folders = _next_step(Path("signs"), None, [])
    assert of_folders == "run it: nvcore detect SESSION --detector signs --out signs_run"


def test_what_is_interrupted_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(run_module, "train", interrupted)
    ran = nvcore("train", SAMPLE, *PART, "--out", tmp_path / "m.npz")
    assert (ran.exit_code, ran.stderr.splitlines()[-1]) == (130, "Stopped.")
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--preset", "cars"), "'cars' is not one of 'pedestrians', 'signs', 'as-in-report'"),
        (("--set", "stride"), "--set: expected KEY=VALUE, found 'stride'"),
        (("--set", "strid=8"), "did you mean 'stride'?"),
        (("--set", "stride=0"), "stride: expected 1 to 256, got 0"),
        (("--only", "nowhere"), "there is no recording 'nowhere'"),
        (("--frames", "0-399"), "0-399: cannot be read as a frame list; expected first:last or"),
        (("--frames", "900:"), "and 5 more have frames 0 to 299"),
        (("--hold-out", "odd_poses"), "did you mean 'odd_pose'?"),
        (("--share", "2"), "share: expected more than 0 and less than 1, got 2"),
        (("--crops", "nowhere"), "Directory 'nowhere' does not exist"),
        (("--out", str(SAMPLE)), "is an input, and would be replaced"),
        (("--out", str(SAMPLE.parent)), "is a folder; give the name of a file"),
    ],
)
def test_bad_input_is_said_before_anything_is_trained(
    options: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def never(*_: Any, **__: Any) -> None:
        raise AssertionError("trained")

    monkeypatch.setattr(run_module, "train", never)
    ran = nvcore("train", SAMPLE, "--out", tmp_path / "m.npz", *options)
    assert ran.exit_code == 2
    assert words in ran.stderr
    assert not any(tmp_path.iterdir())


def test_options_of_a_session_need_one(tmp_path: Path):
    ran = nvcore("train", "--only", "urban_crossing", "--out", tmp_path / "m.npz")
    assert ran.exit_code == 2
    assert "are about a session; name its file" in ran.stderr
    ran = nvcore("train", "--out", tmp_path / "m.npz")
    assert "there is nothing to learn from; name a session, or folders" in ran.stderr
