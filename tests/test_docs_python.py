"""The Python examples of docs/python.md and README run, and print what is shown."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from places import ROOT

BLOCK = re.compile(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", re.DOTALL)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the sample recordings, in which the examples may write."""
    (tmp_path / "sample_data").symlink_to(ROOT / "sample_data", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", ["docs/python.md", "README.md"])
def test_the_python_examples_run_one_after_the_other(
    page: str, project: Path, capsys: pytest.CaptureFixture[str]
):
    blocks = BLOCK.findall((ROOT / page).read_text(encoding="utf-8"))
    assert blocks
    names: dict[str, object] = {}
    for code, shown in blocks:
        exec(code, names)
        printed = capsys.readouterr().out
        if shown:
            assert printed == shown, code
    assert (project / "report" / "summary.json").is_file()


def test_the_readme_shows_what_compare_prints_of_the_sample_recordings():
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```text\n(X = .*?)\n```", page, re.DOTALL)
    shown = shown.replace(".venv/bin/nvcore", "nvcore")  # as it was called
    assert f"{shown}\n" == (ROOT / "tests" / "golden" / "compare.txt").read_text(encoding="utf-8")
