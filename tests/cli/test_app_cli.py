"""``nvcore app``: what it hands to the server, and what it refuses before there is one."""

from __future__ import annotations

import errno
import socket
from importlib import import_module
from pathlib import Path
from typing import Any

import click
import pytest
from inputs import drive, nvcore, write
from places import ROOT, SAMPLE
from streamlit.web import cli


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """The arguments with which Streamlit was started."""
    calls: list[list[str]] = []

    def main(arguments: list[str], **_: Any) -> None:
        calls.append(arguments)
        raise click.Abort  # as after Ctrl+C

    monkeypatch.setattr(cli, "main", main)
    return calls


def test_in_a_checkout_it_starts_the_checkout(started: list[list[str]]):
    assert nvcore("app").exit_code == 0
    (arguments,) = started
    assert arguments[:2] == ["run", str(ROOT / "app.py")]
    assert arguments[-1] == "--"


def test_session_and_folder_are_for_the_app_the_rest_for_the_server(
    started: list[list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(SAMPLE.parent)
    login = tmp_path / "auth.toml"
    login.write_text("[auth]")
    result = nvcore("app", "session.toml", "--local-root", tmp_path, "--port", "8600",
                    "--address", "0.0.0.0", "--login", login, "--no-browser")  # fmt: skip
    assert result.exit_code == 0
    (arguments,) = started
    cut = arguments.index("--")
    assert arguments[cut + 1 :] == [
        f"--session={SAMPLE}",
        f"--local-root={tmp_path}",
        f"--login={login}",
    ]
    assert {"--server.port=8600", "--server.address=0.0.0.0", "--server.headless=true"} <= set(
        arguments[:cut]
    )


def test_what_is_not_given_is_left_to_streamlit_and_its_environment(started: list[list[str]]):
    nvcore("app")
    assert not any("port" in text or "address" in text for text in started[0])


def test_a_session_with_a_missing_file_is_refused(started: list[list[str]], tmp_path: Path):
    drive(tmp_path)
    session = write(tmp_path / "s.toml", '[truth]\npath = "truth.csv"',
                    '[[system]]\npath = "fir.csv"', '[[system]]\npath = "gone.csv"')  # fmt: skip
    result = nvcore("app", session)
    assert (result.exit_code, started) == (2, [])
    assert "gone.csv" in result.stderr


def test_a_folder_that_is_not_there_is_refused(started: list[list[str]], tmp_path: Path):
    result = nvcore("app", "--local-root", tmp_path / "gone")
    assert (result.exit_code, started) == (2, [])


def test_without_the_dashboard_s_files_it_says_what_to_install(
    started: list[list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(import_module("nvcore.cli.app"), "PACKAGE", tmp_path / "nvcore")
    result = nvcore("app")
    assert (result.exit_code, started) == (2, [])
    assert "is not in this installation; install the wheel" in result.stderr


@pytest.mark.parametrize(
    ("ends", "code", "words"),
    [
        (SystemExit(1), 2, ""),  # the port is taken, which Streamlit says
        (SystemExit(3), 3, ""),
        (OSError(errno.EADDRNOTAVAIL, "Cannot assign"), 2, "cannot listen on 203.0.113.5"),
        (socket.gaierror(-2, "Name or service not known"), 2, "cannot listen on 203.0.113.5"),
        (OSError(errno.EIO, "Input/output error"), 3, "a fault of the program"),
    ],
)
def test_a_server_that_cannot_listen_is_told_as_bad_input(
    ends: BaseException, code: int, words: str, monkeypatch: pytest.MonkeyPatch
):
    def main(*_: Any, **__: Any) -> None:
        raise ends

    monkeypatch.setattr(cli, "main", main)
    result = nvcore("app", "--address", "203.0.113.5")
    assert result.exit_code == code
    assert words in result.stderr
