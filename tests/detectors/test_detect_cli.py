"""``nvcore detect`` and ``nvcore models``: from pictures to a verdict, and what is refused."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from inputs import nvcore
from onnx_models import blob_model
from places import SAMPLE

from nvcore.common.output.files import refuse_other_run
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.detectors.base import Detector
from nvcore.subjects.detectors.icf import IcfSettings
from nvcore.subjects.detectors.registry import SAMPLE_MODEL, open_detector
from nvcore.subjects.detectors.running import run as run_module
from nvcore.subjects.driver.estimators.model_file import SAMPLE_ESTIMATOR

QUICK = ("--detector", "hog:daimler", "--set", "scale_step=1.3")
PART = ("--only", "urban_crossing", "--frames", "40:80:8")


@pytest.fixture(scope="module")
def blobs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return blob_model(tmp_path_factory.mktemp("model") / "blobs.onnx", 64, 48)


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory, blobs: Path) -> tuple[Result, Path]:
    """A run of a model that knows some of the frames, and its folder."""
    out = tmp_path_factory.mktemp("ran") / "out"
    trained = ("--trained-on", "urban_crossing=:55", "--trained-on", "elsewhere")
    return nvcore("detect", SAMPLE, "--detector", blobs, *PART, *trained, "--out", out), out


def test_from_pictures_to_a_verdict(tmp_path: Path):
    out = tmp_path / "hog"
    ran = nvcore("detect", SAMPLE, *QUICK, *PART, "--threshold", "1", "--out", out)
    assert ran.exit_code == 0, ran.output
    assert "6 pictures of 1 recording on" in ran.stderr
    assert "about" in ran.stderr
    assert "boxes in 6 pictures of 1 recording" in ran.stdout
    assert f"compare: nvcore compare {out / 'session.toml'}" in ran.stderr
    compared = nvcore("compare", out / "session.toml")
    assert compared.exit_code == 0, compared.output
    assert "Y = HOG Daimler, score >= 1" in compared.stdout
    assert "In short" in compared.stdout


def test_the_same_run_gives_the_same_files(tmp_path: Path, ran: tuple[Result, Path], blobs: Path):
    more = ("--threads", 1, "--out", tmp_path / "out")
    again = nvcore("detect", SAMPLE, "--detector", blobs, *PART, *more)
    assert again.exit_code == 0, again.output
    files = [(out / "urban_crossing.csv").read_bytes() for out in (ran[1], tmp_path / "out")]
    assert files[0] == files[1]
    assert files[0].count(b"\n") > 1


def test_what_it_was_trained_on_is_said_before_and_fails_the_gate(ran: tuple[Result, Path]):
    detected, out = ran
    assert detected.exit_code == 0, detected.output
    first = detected.stderr.splitlines()[0]
    assert first.startswith("Trained on 2 of the 6 evaluated frames: urban_crossing.")
    record = json.loads((out / "provenance.json").read_bytes())
    assert record["detector"]["trained_on"] == [
        {"recording": "urban_crossing", "last_frame": 55},
        {"recording": "elsewhere"},
    ]
    gate = nvcore("gate", out / "session.toml", "--rule", "encounters >= 0")
    assert gate.exit_code == 1
    assert "audit_errors is 1" in gate.output


def test_a_session_without_a_system_is_enough(tmp_path: Path, blobs: Path):
    session = tmp_path / "session.toml"
    head, _, _ = SAMPLE.read_text().partition("[[system]]")
    session.write_text(head.replace('"truth.csv"', f'"{SAMPLE.parent / "truth.csv"}"').replace(
        'pictures = "', f'pictures = "{SAMPLE.parent}/'
    ))  # fmt: skip
    refused = nvcore("detect", session, "--detector", blobs, *PART, "--out", tmp_path)
    assert refused.exit_code == 2
    assert "session.toml: is an input, and would be replaced" in refused.stderr
    first, second = tmp_path / "first", tmp_path / "second"
    ran = nvcore("detect", session, "--detector", blobs, *PART, "--name", "A", "--out", first)
    assert ran.exit_code == 0, ran.output
    assert f"a second system: nvcore detect {first / 'session.toml'} ..." in ran.stderr
    more = ("--set", "threshold=0.1", "--name", "B", "--out", second)
    ran = nvcore("detect", first / "session.toml", "--detector", blobs, *more)
    assert ran.exit_code == 0, ran.output
    session = read_session(second / "session.toml")
    assert (session.x, session.y) == ("A", "B")


def test_what_is_interrupted_leaves_nothing(
    tmp_path: Path, blobs: Path, monkeypatch: pytest.MonkeyPatch
):
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(run_module, "run_detector", interrupted)
    out = tmp_path / "out"
    ran = nvcore("detect", SAMPLE, "--detector", blobs, *PART, "--out", out)
    assert (ran.exit_code, ran.stderr.splitlines()[-1]) == (130, "Stopped.")
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--detector", "hogg"), "there is no such detector or file; did you mean 'hog'?"),
        (("--detector", "hog", "--set", "stride"), "--set: expected KEY=VALUE, found 'stride'"),
        (("--detector", "hog", "--set", "strid=8"), "did you mean 'stride'?"),
        (("--detector", "hog", "--only", "nowhere"), "there is no recording 'nowhere'"),
        (("--detector", "hog", "--against", "HOG"), "there is no system 'HOG'; there are FIR, NIR"),
        (("--detector", "hog", "--name", "FIR"), "there is a system 'FIR' already"),
        (("--detector", str(SAMPLE)), "is text, no model"),
        (("--detector", "icf"), "icf is a kind of them, and needs a model; built in are hog"),
    ],
)
def test_bad_input_is_said_before_anything_runs(
    options: tuple[str, ...], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def never(_detector: Detector, *_: Any, **__: Any) -> None:
        raise AssertionError("ran")

    monkeypatch.setattr(run_module, "run_detector", never)
    ran = nvcore("detect", SAMPLE, "--out", tmp_path / "out", *options)
    assert ran.exit_code == 2
    assert words in ran.stderr
    assert not (tmp_path / "out").exists()


def test_a_session_without_pictures_says_what_to_do(folder: Path):
    (folder / "session.toml").write_text(
        '[defaults]\nsize = "640x480"\nfps = 20\n[truth]\npath = "truth.csv"\n'
    )
    ran = nvcore("detect", folder / "session.toml", "--detector", "hog", "--out", folder / "out")
    assert ran.exit_code == 2
    assert "no evaluated frame has a picture; name the pictures of each recording" in ran.stderr


def test_a_folder_of_another_command_is_not_mixed(tmp_path: Path, ran: tuple[Result, Path]):
    out = shutil.copytree(ran[1], tmp_path / "out")
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    again = nvcore("compare", SAMPLE, *PART, "--out", out)
    assert again.exit_code == 2
    assert "holds provenance.json, urban_crossing.csv of another command" in again.stderr
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    names = "a" * 300, "../../etc", "/etc/passwd", ""  # a file of somebody else
    (out / "SHA256SUMS").write_text("".join(f"0  {name}\n" for name in names))
    refuse_other_run(out, [])


def test_the_detectors_are_listed():
    ran = nvcore("models")
    assert ran.exit_code == 0
    assert "hog:daimler    trained on Daimler's pedestrians" in ran.stdout
    assert "icf: Integral Channel Features" in ran.stdout


def test_a_model_is_described_with_its_settings(blobs: Path):
    ran = nvcore("models", blobs, "--set", "threshold=0.2")
    assert ran.exit_code == 0
    lines = ran.stdout.splitlines()
    assert lines[0] == "blobs: a network of one's own in ONNX (.onnx), run by ONNX Runtime"
    assert lines[1] == "detects: person"
    assert "trained on: not known" in lines
    assert "  threshold = 0.2" in lines
    assert "      Boxes with a lower score are dropped. 0 to 1." in lines


def test_every_setting_of_a_training_is_explained():
    ran = nvcore("models", "icf")
    assert ran.exit_code == 0
    assert "\n  slack = 0\n      How far below the least sum" in ran.stdout
    assert "\n  window_width = 32\n" in ran.stdout
    named = re.findall(r"^  (\w+) = ", ran.stdout, re.MULTILINE)
    assert named == [spec.name for spec in fields(IcfSettings)]


def test_a_model_of_grey_pictures_says_so():
    ran = nvcore("models", "icf:sample")
    assert "\npictures: grey\n" in ran.stdout
    assert "\n  channels = grey magnitude orientations\n" in ran.stdout
    about = open_detector("icf:sample").about  # which the record of a run holds
    assert about.settings["channels"] == "grey magnitude orientations"


def test_an_estimator_is_described_and_no_detector(tmp_path: Path):
    ran = nvcore("models", "sample")
    assert ran.exit_code == 0
    assert "trained on: 4,896 trials by a simulated observer, not by people" in ran.stdout
    assert "\n    single    " in ran.stdout
    flags = ("--detector", SAMPLE_ESTIMATOR, "--out", tmp_path / "out")
    ran = nvcore("detect", SAMPLE, *flags)
    assert ran.exit_code == 2
    assert "it is an estimator of what the driver sees, which nvcore driver estimate" in ran.stderr
    ran = nvcore("driver", "estimate", SAMPLE, "--model", SAMPLE_MODEL, "--out", tmp_path / "out")
    assert ran.exit_code == 2
    assert "it is a detector of pedestrians or signs, which nvcore detect takes" in ran.stderr


def test_settings_without_a_detector_are_a_mistake():
    ran = nvcore("models", "--set", "a=1")
    assert ran.exit_code == 2
    assert "--set is about a model; name it" in ran.stderr
