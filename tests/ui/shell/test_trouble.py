"""Errors reach a visitor as a sentence: as text, without the folders of the machine."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from nvcore.errors import InputError
from pages import scripted
from ui.session.state import ROOT
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error


def banner(error: str) -> str:
    """What the banner says of this error, which is Python."""
    script = "from nvcore.errors import InputError\nfrom ui.shell.messages import error_banner\n"
    (shown,) = scripted(f"{script}assert error_banner({error})").run().error
    return shown.value


def test_an_error_in_the_data_is_told_as_text():
    assert banner('InputError("the file is *odd*")') == "the file is \\*odd\\*"


def test_a_fault_of_the_program_is_told_without_its_details(caplog: pytest.LogCaptureFixture):
    with caplog.at_level(logging.ERROR, logger="nvcore.ui"):
        text = banner('KeyError("secret")')
    assert "a fault of the program" in text
    assert "secret" not in text
    assert "secret" in caplog.text


def test_an_error_loses_the_local_root_and_its_markup(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    error = InputError("**no** number", file=f"{tmp_path.resolve()}/night/t.csv")
    assert shown_error(error) == r"night/t\.csv\: \*\*no\*\* number"
    # also where nothing is open
    assert shown_error(InputError("gone", file=ROOT / "sample_data")) == r"sample\_data\: gone"


def test_an_error_loses_the_folder_of_uploads():
    page = AppTest.from_string(
        "import streamlit as st\n"
        "from ui.shell.messages import shown_error\n"
        "st.text(shown_error(OSError(str(st.session_state['workspace'].folder / 'a'))))"
    )
    page.session_state["workspace"] = Workspace()
    assert page.run().text[0].value == "a"
