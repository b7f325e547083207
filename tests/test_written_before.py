"""What nvcore 0.1.0 wrote of a comparison, and links to it, still open: no name has changed."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from nvcore.cli import main
from nvcore.inputs.session.toml import read_session, write_session
from ui.session.address import read_parameters
from ui.shell.pages import PAGES

WRITTEN = Path(__file__).parent / "data" / "written" / "session.toml"
"""Every key that a session file can have, every parameter at another value than its default."""


def content() -> dict[str, Any]:
    return tomllib.loads(WRITTEN.read_text(encoding="utf-8"))


def test_every_key_of_a_session_file_is_read_and_written_again():
    before = content()
    again = write_session(read_session(WRITTEN), version="0.1.0", fingerprint="0123")
    assert tomllib.loads(again) == before


def test_an_address_with_every_parameter_is_followed():
    parameters = content()["parameters"]
    address = {name: str(value) for name, value in parameters.items()}
    assert read_parameters(address) == (parameters, [])


def test_every_parameter_is_a_flag_of_the_commands_that_compare():
    for name in ("compare", "report", "gate", "plan", "matrix"):
        command = main.get_command(None, name)
        flags = {flag for option in command.params for flag in option.opts}
        assert {f"--{key.replace('_', '-')}" for key in content()["parameters"]} <= flags


def test_every_page_has_its_address():
    names = {path.stem for path in PAGES.glob("*.py")}
    assert names >= {
        *("data", "overview", "timeline", "encounters", "saliency", "detection", "stability"),
        *("systems", "metrics", "export", "time_left", "driver", "detectors", "ratings", "study"),
    }
