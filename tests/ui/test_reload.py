"""What was open in a tab is given back to it, and to nobody who does not know its name."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from ui import state
from ui.workspace import Workspace

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
import streamlit as st
from ui import live_params, state
if token := st.session_state.pop("claims", None):
    state.take_back(token)
state.begin_run()
live_params.read()
"""


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    # without a browser every session passes for one whose page is there
    monkeypatch.setattr(state, "is_in_use", lambda _: False)


def page(**query: str) -> AppTest:
    app = AppTest.from_string(SCRIPT, default_timeout=60)
    for name, value in query.items():
        app.query_params[name] = value
    app.run()
    assert not app.exception
    return app


def claiming(app: AppTest, token: str) -> Workspace:
    app.session_state["claims"] = token
    app.run()
    assert not app.exception
    return app.session_state["workspace"]


def test_a_new_session_goes_on_with_the_workspace_and_its_address():
    before = page().session_state["workspace"]
    after = page(recording="winter_frost", frame="12", alpha="0.25")
    assert claiming(after, before.token) is before
    assert after.session_state["place"] == (9, 12)
    assert after.session_state["params"].alpha == 0.25


def test_an_unknown_name_or_a_closed_workspace_gives_nothing():
    app = page()
    own = app.session_state["workspace"]
    assert claiming(app, "x" * 32) is own
    other = Workspace()
    assert claiming(app, other.token) is own  # nothing is open in it


def test_a_workspace_that_another_page_uses_is_not_shared(monkeypatch: pytest.MonkeyPatch):
    before = page().session_state["workspace"]
    monkeypatch.setattr(state, "is_in_use", lambda one: one is before)
    app = page()
    own = app.session_state["workspace"]
    assert claiming(app, before.token) is own
