"""The examples of docs/groups.md run, and print what is shown."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from inputs import nvcore
from places import ROOT

PAGE = (ROOT / "docs" / "groups.md").read_text(encoding="utf-8")
TABLE = re.compile(r"`(\w+\.csv)`:\n\n```text\n(.*?)```", re.DOTALL)
COMMAND = re.compile(r"```console\nnvcore (.*?)\n```\n\n```text\n(.*?)```", re.DOTALL)
CODE = re.compile(r"```python\n(.*?)```\n\n```text\n(.*?)```", re.DOTALL)


@pytest.fixture(autouse=True)
def tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, text in TABLE.findall(PAGE):
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("command", "shown"), COMMAND.findall(PAGE))
def test_a_command_prints_the_lines_that_are_shown(command: str, shown: str):
    ran = nvcore(*shlex.split(command))
    assert ran.exit_code == 0, ran.output
    lines = shown.splitlines()
    assert [line for line in ran.stdout.splitlines() if line in lines] == lines


@pytest.mark.parametrize(("code", "shown"), CODE.findall(PAGE))
def test_a_call_prints_what_is_shown(code: str, shown: str, capsys: pytest.CaptureFixture[str]):
    exec(code, {})
    assert capsys.readouterr().out == shown


def test_there_are_examples_of_each_kind():
    assert len(TABLE.findall(PAGE)) == len(COMMAND.findall(PAGE)) == 2
    assert len(CODE.findall(PAGE)) == 1
