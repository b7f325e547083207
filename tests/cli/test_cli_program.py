"""The program as a whole: how it starts, its help, and that nothing it prints can be forged."""

from __future__ import annotations

import errno
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import pytest
from inputs import FACTS, drive, flags, nvcore
from places import ROOT

from nvcore import __version__
from nvcore.cli import main
from nvcore.cli.options import flag_of
from nvcore.common.errors import InputError
from nvcore.settings.params import SETTINGS


def test_help_starts_without_what_only_a_command_needs():
    code = (
        "from nvcore.cli import main; import sys; "
        "print({'numpy', 'pandas', 'jinja2', 'cv2'} & {*sys.modules})"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert run.stdout == "set()\n", run.stderr


@pytest.mark.parametrize("commands", ["alerts.calls", "detectors.calls", "driver.calls", "fleet"])
def test_the_commands_of_a_subject_can_be_imported_first(commands: str):
    code = f"import nvcore.subjects.{commands}.commands"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert run.returncode == 0, run.stderr


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


def process(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """The program in a process of its own."""
    command = [sys.executable, "-m", "nvcore", *arguments]
    return subprocess.run(command, stderr=subprocess.PIPE, text=True, cwd=ROOT, **options)


def test_a_reader_that_went_away_gives_exit_code_141_and_no_word():
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as output:
        run = process("--help", stdout=output)
    assert (run.returncode, run.stderr) == (141, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux only")
def test_a_full_disk_is_no_fault_of_the_program():
    with Path("/dev/full").open("w") as output:
        run = process("--help", stdout=output)
    assert run.returncode == 2
    assert run.stderr == "Error: the output cannot be written: no space is left\n"


@pytest.mark.skipif(sys.platform == "win32", reason="needs a POSIX system")
def test_a_closed_output_is_said():
    run = process("--help", preexec_fn=lambda: os.close(1))
    assert run.returncode == 2
    assert run.stderr == "Error: there is no standard output to write to\n"


@pytest.mark.parametrize(
    ("error", "exit_code", "words"),
    [
        (KeyError("k"), 3, "this is a fault of the program, not of your data"),
        (MemoryError(), 3, "too little memory"),
        (KeyboardInterrupt(), 130, "Stopped."),
    ],
)
def test_a_gate_that_ends_early_never_says_that_a_rule_is_broken(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    exit_code: int,
    words: str,
):
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("nvcore.inputs.load.load", fail)
    junit = tmp_path / "gate.xml"
    result = nvcore("gate", *flags(drive(tmp_path)), "--rule", "lamr_y <= 1", "--junit", junit)
    assert result.exit_code == exit_code
    assert words in result.stderr
    assert "<failure" not in junit.read_text()


WORK = {
    "compare": "nvcore.comparison.compare.compare",
    "check": "nvcore.auditing.audit",
    "gate": "nvcore.report.gate.run_gate",
    "plan": "nvcore.evidence.planning.plan_recordings",
    "report": "nvcore.report.html.write_html_report",
    "convert": "nvcore.inputs.conversion.convert",
    "sample": "pathlib.Path.rglob",
    "app": "streamlit.web.cli.main",
}
"""What each command does its work by."""


@pytest.mark.parametrize("command", WORK)
@pytest.mark.parametrize(
    ("error", "exit_code", "words"),
    [
        (InputError("too wide"), 2, "Error: too wide\n"),
        (ZeroDivisionError("1/0"), 3, "this is a fault of the program, not of your data"),
        (MemoryError(), 3, "too little memory"),
        (KeyboardInterrupt(), 130, "Stopped."),
        (BrokenPipeError(errno.EPIPE, "gone"), 141, ""),
    ],
)
def test_every_command_ends_with_the_code_for_what_ended_it(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    error: BaseException,
    exit_code: int,
    words: str,
):
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(WORK[command], fail)
    monkeypatch.setattr("nvcore.cli.program._forget_output", lambda: None)
    given = {
        "gate": [*flags(folder), "--rule", "frames == 40"],
        "report": [*flags(folder), "--out", folder.parent / "r.html"],
        "convert": [folder / "truth.csv", "--to", "coco", "--out", folder.parent / "a.json"],
        "sample": [folder.parent / "sample"],
        "app": [],
    }
    if command == "app" and isinstance(error, KeyboardInterrupt):
        exit_code, words = 0, ""  # the way to end it
    result = nvcore(command, *given.get(command, flags(folder)))
    assert result.exit_code == exit_code
    assert words in result.stderr
    assert ("Traceback" in result.stderr) == isinstance(error, ZeroDivisionError)


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
    by_heading: dict[str, list[str]] = {}
    heading = ""
    for line in nvcore(command, "--help").stdout.splitlines():
        if re.fullmatch(r"[A-Z][\w ]+:", line):
            heading = line.rstrip(":")
        flag = re.match(r"  (?:-h, )?(--[a-z-]+)", line)
        if flag:
            by_heading.setdefault(heading, []).append(flag[1])
    return by_heading


def test_every_parameter_stands_under_its_group():
    by_heading = headings("compare")
    for name, setting in SETTINGS.items():
        assert flag_of(name) in by_heading[setting.group]


@pytest.mark.parametrize("command", ["compare", "check"])
def test_every_option_stands_under_a_heading_once(command: str):
    by_heading = headings(command)
    assert by_heading["Other"] == ["--help"]
    shown = [flag for flags in by_heading.values() for flag in flags]
    known = [
        option.opts[0]
        for option in main.commands[command].params
        if isinstance(option, click.Option)
    ]
    assert sorted(shown) == sorted([*known, "--help"])
