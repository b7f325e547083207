"""The commands of docs/tutorial.md run one after the other, and print what is shown."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from places import ROOT

from nvcore.cli import main

TEXT = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
STEPS = re.findall(r"```console\n(.*?)```(?:\n\n```text\n(.*?)```)?", TEXT, re.DOTALL)


def run(line: str) -> str:
    """Run a command of ours; return what it prints, errors last."""
    done = CliRunner().invoke(main, shlex.split(line)[1:], prog_name="nvcore")
    assert done.exit_code in {0, 1, 2}, done.output
    return done.stdout + done.stderr


def test_the_commands_of_the_tutorial_print_what_is_shown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    subprocess.run([sys.executable, "-c", example], check=True)
    assert len(STEPS) > 5
    for commands, shown in STEPS:
        ours, loop, rest = commands.partition("for ")
        printed = "".join(map(run, ours.splitlines()))
        subprocess.run(["sh", "-ec", loop + rest], check=True)
        for part in shown.split("...\n"):
            assert part in printed, commands


def test_the_session_that_the_tutorial_opens_has_been_written():
    names = re.findall(r"nvcore (?:app|compare) (\w+)/session\.toml", TEXT)
    assert names
    assert {f"--out {name}" for name in names} <= set(re.findall(r"--out \w+", TEXT))
