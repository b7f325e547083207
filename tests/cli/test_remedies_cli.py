"""Ways on name what the user can change: flags, or keys of the session file that was given."""

from __future__ import annotations

import pytest
from field_files import session_of
from field_scene import truth
from inputs import nvcore

from nvcore.inputs.session.toml import write_session


@pytest.fixture
def session_file(tmp_path):
    session = session_of(tmp_path)
    kinds = truth().replace({"name": {"bicycle": "child"}}).rename(columns={"name": "class"})
    kinds.to_csv(tmp_path / "truth.csv", index=False)
    path = tmp_path / "session.toml"
    path.write_text(write_session(session, version="", fingerprint=""))
    return path


def test_a_finding_names_the_key_of_the_session_file(session_file):
    result = nvcore("check", session_file)
    assert 'Write classes = ["person", "child"] under [truth] of the session file.' in result.output
    assert "--classes" not in result.output


def test_an_error_names_the_key_of_the_session_file(session_file):
    numbers = truth().assign(score=0.5).rename(columns={"track": "class"}).drop(columns="name")
    numbers.to_csv(session_file.parent / "y.csv", index=False)
    result = nvcore("check", session_file)
    assert result.exit_code == 2
    assert 'Write classes = ["NAMES"] under [[system]] "y" of the session file.' in result.stderr


def test_what_names_of_pictures_are_is_said_of_one_source(tmp_path):
    for name in ("truth", "x"):
        (tmp_path / name).mkdir()
        for i in range(3):
            stem = f"a{i + 5}" if name == "truth" else f"b{i}"
            (tmp_path / name / f"{stem}.txt").write_text("0 0.5 0.5 0.1 0.3\n")
    files = [f"--{name}={tmp_path / name}" for name in ("truth", "x")]
    options = ["--size", "640x480", "--fps", 10, "--frame-names-truth", "order"]
    result = nvcore("check", *files, *options)
    assert result.exit_code == 0, result.output
    assert "No detection has a score." in result.output  # else: all lie outside the listed frames
