"""The help of compare and check: every option under a heading."""

from __future__ import annotations

import re

import click
import pytest
from inputs import nvcore

from nvcore.cli import main
from nvcore.cli.options import flag_of
from nvcore.params import SETTINGS


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
