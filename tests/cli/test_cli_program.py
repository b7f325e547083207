"""The program as a whole: how it starts, its help, and that nothing it prints can be forged."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import click
import pytest
from inputs import FACTS, drive, nvcore
from places import ROOT

from nvcore import __version__
from nvcore.cli import main
from nvcore.cli.options import flag_of
from nvcore.params import SETTINGS


def test_help_starts_without_numpy():
    code = "import nvcore.cli, sys; print('numpy' in sys.modules, 'pandas' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert run.stdout == "False False\n", run.stderr


def test_python_dash_m_nvcore_is_the_command_line():
    run = subprocess.run([sys.executable, "-m", "nvcore", "--version"], capture_output=True,
                         text=True, cwd=ROOT)  # fmt: skip
    assert (run.returncode, run.stdout) == (0, f"nvcore, version {__version__}\n")


def test_bad_input_to_the_process_gives_no_traceback(tmp_path: Path):
    run = subprocess.run([sys.executable, "-m", "nvcore", "compare", tmp_path / "no.toml"],
                         capture_output=True, text=True, cwd=ROOT)  # fmt: skip
    assert run.returncode == 2
    assert run.stderr.startswith("Error: ")
    assert run.stderr.count("\n") == 1


@pytest.mark.skipif(sys.platform == "win32", reason="no such file names there")
def test_a_path_with_control_characters_is_printed_harmlessly(tmp_path: Path):
    folder = drive(tmp_path / "drive")
    evil = folder / "a\x1bc\nX = forged<b>.csv"
    (folder / "fir.csv").rename(evil)
    result = nvcore("compare", "--truth", folder / "truth.csv", "--x", evil,
                    "--y", folder / "nir.csv", *FACTS)  # fmt: skip
    assert result.exit_code == 0
    assert "X = a\\x1bc\\nX = forged<b>, all scores" in result.stdout
    assert "\x1b" not in result.output
    assert not any(line.startswith("X = forged") for line in result.output.splitlines())
    result = nvcore("compare", tmp_path / "no\x1b[31m\nError: forged.toml")
    assert "no\\x1b[31m\\nError: forged.toml: cannot be opened" in result.stderr
    assert result.stderr.count("\n") == 1


def headings(command: str) -> dict[str, list[str]]:
    """Flags of a command by the heading that they stand under."""
    found: dict[str, list[str]] = {}
    heading = ""
    for line in nvcore(command, "--help").stdout.splitlines():
        if re.fullmatch(r"[A-Z][\w ]+:", line):
            heading = line.rstrip(":")
        flag = re.match(r"  (?:-h, )?(--[a-z-]+)", line)
        if flag:
            found.setdefault(heading, []).append(flag[1])
    return found


def test_every_parameter_stands_under_its_group():
    found = headings("compare")
    for name, setting in SETTINGS.items():
        assert flag_of(name) in found[setting.stage.group]


@pytest.mark.parametrize("command", ["compare", "check"])
def test_every_option_stands_under_a_heading_once(command: str):
    by_heading = headings(command)
    assert by_heading["Other"] == ["--help"]
    shown = [flag for flags in by_heading.values() for flag in flags]
    known = [one.opts[0] for one in main.commands[command].params if isinstance(one, click.Option)]
    assert sorted(shown) == sorted([*known, "--help"])
