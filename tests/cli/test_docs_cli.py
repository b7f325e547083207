"""docs/cli.md shows the program's own help, and its examples work.

Groups of options that several commands share stand once, in the section "Shared options", to which
these commands link. ``make docs`` writes the help texts of the page anew.
"""

from __future__ import annotations

import re
import shlex
import shutil
import textwrap
from collections import Counter
from functools import cache
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
SHARED = re.compile(r"^## Shared options$.*\Z", re.DOTALL | re.MULTILINE)
GROUP = re.compile(r"^### (.+?)\n\n```text\n(.*?)\n```$", re.DOTALL | re.MULTILINE)
TAKEN = re.compile(
    r"\n^Options \[shared\]\(#shared-options\) with other commands:\n(.*?)\.\n",
    re.DOTALL | re.MULTILINE,
)
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


@cache
def help_of(name: str) -> str:
    """What the command prints on a terminal of 100 columns, of which click leaves 2 free."""
    arguments = [*name.split()[1:], "--help"]
    result = CliRunner().invoke(main, arguments, prog_name="nvcore", terminal_width=98)
    assert result.exit_code == 0, result.output
    return result.stdout


def blocks_of(text: str) -> list[str]:
    """The usage, and each group of options under its heading."""
    return re.split(r"\n\n(?=\S)", text.rstrip("\n"))


def title_of(block: str) -> str:
    return block.partition(":\n")[0]


@cache
def shared_groups() -> dict[str, str]:
    """Text by title of the groups that stand once on the page, in the order of the help.

    Of groups of one title, the one that most commands have; short ones are not worth a link.
    """
    n_commands = Counter(chain(*(blocks_of(help_of(name)) for name in NAMES)))
    groups: dict[str, str] = {}
    for block, n in n_commands.most_common():
        if n > 1 and block.count("\n") >= 4:
            groups.setdefault(title_of(block), block)
    in_order = [title_of(block) for block in blocks_of(help_of("nvcore compare"))]
    rank = {title: i for i, title in enumerate(in_order)}
    return dict(sorted(groups.items(), key=lambda group: rank.get(group[0], len(rank))))


def groups_on_the_page() -> dict[str, str]:
    """Text by title below "Shared options"."""
    (section,) = SHARED.findall(PAGE.read_text(encoding="utf-8"))
    return dict(GROUP.findall(section))


def groups_taken(section: str) -> list[str]:
    """Titles of the shared groups to which a command's section links."""
    links = "".join(TAKEN.findall(section)).replace("\n", " ")
    return [title for title, _ in re.findall(r"\[(.+?)\]\(#(.+?)\)", links)]


def examples() -> list[str]:
    text = PAGE.read_text(encoding="utf-8")
    return [line for block in EXAMPLES.findall(text) for line in block.splitlines()]


def test_every_command_has_its_section_in_the_order_of_the_help():
    assert list(sections()) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_help_and_shared_groups_of_a_section_are_the_command_s_help(name: str):
    (text,) = HELP.findall(sections()[name])
    own = blocks_of(text)
    taken = [groups_on_the_page()[title] for title in groups_taken(sections()[name])]
    blocks = blocks_of(help_of(name))
    assert sorted(own + taken) == sorted(blocks)
    assert own == [block for block in blocks if block in own]
    assert taken == [block for block in blocks if block in taken]


@pytest.mark.parametrize("name", NAMES)
def test_every_option_of_a_command_is_in_its_section_or_its_shared_groups(name: str):
    command: click.Command = main
    for key in name.split()[1:]:
        assert isinstance(command, click.Group)
        command = command.commands[key]
    taken = (groups_on_the_page()[title] for title in groups_taken(sections()[name]))
    text = "\n".join([*HELP.findall(sections()[name]), *taken])
    options = chain(*(param.opts for param in command.params if isinstance(param, click.Option)))
    assert [flag for flag in options if not re.search(rf"^  .*{flag}\b", text, re.MULTILINE)] == []


def test_no_group_of_options_that_is_shared_stands_twice_on_the_page():
    page = PAGE.read_text(encoding="utf-8")
    assert {
        title: page.count(text) for title, text in groups_on_the_page().items()
    } == dict.fromkeys(shared_groups(), 1)


@pytest.mark.parametrize("name", NAMES)
def test_the_help_fits_a_terminal_of_100_columns(name: str):
    assert max(len(line) for line in help_of(name).splitlines()) <= 100


def test_the_examples_work_in_their_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    shutil.copytree(SAMPLE.parent, tmp_path / "sample_data")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NVCORE_PROJECTS", str(tmp_path / "projects.sqlite"))
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
    shared = shared_groups()

    def section(match: re.Match[str]) -> str:
        blocks = blocks_of(help_of(match[1]))
        own = "\n\n".join(block for block in blocks if block not in shared.values())
        titles = [title for title in map(title_of, blocks) if shared.get(title) in blocks]
        body = HELP.sub(lambda _: f"```text\n{own}\n```", TAKEN.sub("", match[2]))
        if titles:
            links = ", ".join(f"[{title}](#{title.lower().replace(' ', '-')})" for title in titles)
            lines = textwrap.fill(f"{links}.", 100, break_on_hyphens=False, break_long_words=False)
            taken = f"\n\nOptions [shared](#shared-options) with other commands:\n{lines}\n"
            body = re.sub(
                r"(^```text\n.*?^```$)\n", lambda m: m[1] + taken, body, flags=re.DOTALL | re.M
            )
        return f"## {match[1]}{body}"

    page = SECTION.sub(section, PAGE.read_text(encoding="utf-8"))
    (old,) = SHARED.findall(page)
    words = old.partition("\n### ")[0].rstrip("\n")
    groups = (f"### {title}\n\n```text\n{text}\n```\n" for title, text in shared.items())
    return page.replace(old, "\n".join([f"{words}\n", *groups]))


if __name__ == "__main__":
    PAGE.write_text(written_anew(), encoding="utf-8")
