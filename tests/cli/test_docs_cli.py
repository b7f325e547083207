"""docs/cli.md shows the program's own help, and its examples work.

``make docs`` writes the help texts of the page anew.
"""

from __future__ import annotations

import re
import shlex
import shutil
from itertools import chain
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from places import ROOT, SAMPLE

from nvcore.cli import main

PAGE = ROOT / "docs" / "cli.md"
SECTION = re.compile(r"^## (nvcore.*?)$(.*?)(?=^## |\Z)", re.DOTALL | re.MULTILINE)
HELP = re.compile(r"^```text\n(.*?)^```$", re.DOTALL | re.MULTILINE)
EXAMPLES = re.compile(r"^```console\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def names_of(group: click.Group, name: str) -> list[str]:
    """The group and all commands below it, in the order of the help."""
    below = [
        names_of(command, f"{name} {key}")
        if isinstance(command, click.Group)
        else [f"{name} {key}"]
        for key, command in group.commands.items()
    ]
    return [name, *chain(*below)]


NAMES = names_of(main, "nvcore")


def sections() -> dict[str, str]:
    """Text of each command's section by its name."""
    return dict(SECTION.findall(PAGE.read_text(encoding="utf-8")))


def help_of(name: str) -> str:
    """What the command prints on a terminal of 100 columns, of which click leaves 2 free."""
    arguments = [*name.split()[1:], "--help"]
    result = CliRunner().invoke(main, arguments, prog_name="nvcore", terminal_width=98)
    assert result.exit_code == 0, result.output
    return result.stdout


def examples() -> list[str]:
    text = PAGE.read_text(encoding="utf-8")
    return [line for block in EXAMPLES.findall(text) for line in block.splitlines()]


def test_every_command_has_its_section_in_the_order_of_the_help():
    assert list(sections()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_the_page_shows_the_command_s_help(name: str):
    assert HELP.findall(sections()[name]) == [help_of(name)]


@pytest.mark.parametrize("name", NAMES)
def test_the_help_fits_a_terminal_of_100_columns(name: str):
    assert max(len(line) for line in help_of(name).splitlines()) <= 100


def test_the_examples_work_in_their_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    shutil.copytree(SAMPLE.parent, tmp_path / "sample_data")
    monkeypatch.chdir(tmp_path)
    failed = {}
    for line in examples():
        result = CliRunner().invoke(main, shlex.split(line)[1:])
        if result.exit_code:
            failed[line] = result.output[-500:]
    assert not failed
    assert Path("again/frames.csv").read_bytes() == Path("report/frames.csv").read_bytes()
    report = Path("night.html").read_text(encoding="utf-8")
    assert len(report) < 5_000_000
    assert "encounters detected, of 38</td>" in report
    assert 10 <= report.count("data:image/jpeg") <= 14  # two of them on the first page


def written_anew() -> str:
    """The page with the help of today."""

    def section(found: re.Match[str]) -> str:
        help_text = help_of(found[1])
        body = HELP.sub(lambda _: f"```text\n{help_text}```", found[2])
        return f"## {found[1]}{body}"

    return SECTION.sub(section, PAGE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    PAGE.write_text(written_anew(), encoding="utf-8")
