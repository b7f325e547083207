"""Errors as they are shown: as text, without the folders of the machine."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from nvcore.errors import InputError
from ui.session.state import ROOT
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error


def test_an_error_loses_the_local_root_and_its_markup(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    error = InputError("**no** number", file=f"{tmp_path.resolve()}/night/t.csv")
    assert shown_error(error) == r"night/t\.csv\: \*\*no\*\* number"


def test_an_error_is_shown_though_nothing_is_open():
    assert shown_error(InputError("gone", file=ROOT / "sample_data")) == r"sample\_data\: gone"


def test_an_error_loses_the_folder_of_uploads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path))
    page = AppTest.from_string(
        "import streamlit as st\n"
        "from ui.shell.messages import shown_error\n"
        "st.text(shown_error(OSError(str(st.session_state['workspace'].folder / 'a'))))"
    )
    page.session_state["workspace"] = Workspace()
    assert page.run().text[0].value == "a"
