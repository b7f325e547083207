"""Pages are for whoever has logged in, and a session for whoever began it."""

from __future__ import annotations

from pathlib import Path

import pytest
import streamlit as st
from people import cookies, log_in_by

from pages import checked, opened, press, scripted, texts
from ui.access.people import key_of
from ui.session.workspace import Workspace
from ui.shell import account


class Context:
    """What Streamlit says of a browser with these cookies."""

    def __init__(self, name: str = "") -> None:
        self.cookies = cookies(name) if name else {}


def test_without_a_log_in_there_is_nothing_of_it():
    page = checked(scripted("from ui.shell import account\naccount.draw()").run())
    assert (len(page.button), len(page.caption), account.is_welcome()) == (0, 0, True)


def test_a_page_without_a_log_in_opens_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(st, "context", Context())
    with log_in_by(tmp_path):
        page = checked(opened())
    assert page.title[0].value == "Logged out"
    assert "workspace" not in page.session_state
    assert len(page.sidebar.children) == 0


def test_a_session_is_not_gone_on_with_by_somebody_else(
    space: Workspace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    with log_in_by(tmp_path):
        space.owner = key_of(cookies("anna")) or ""
        st.session_state["workspace"] = space
        for name, is_welcome in (("anna", True), ("bert", False), ("", False)):
            monkeypatch.setattr(st, "context", Context(name))
            assert account.is_welcome() == is_welcome


def test_a_tab_gets_nothing_back_that_is_somebody_else_s(
    space: Workspace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    script = "import streamlit as st\nfrom ui.session import state\nspace = state.workspace()\n"
    script += "st.session_state['first_query'] = {}\n"
    script += f"state.restore({space.token!r})\nst.text(state.workspace().token)"
    monkeypatch.setattr("ui.session.state.is_in_use", lambda _: False)
    monkeypatch.setattr(st, "context", Context("bert"))
    with log_in_by(tmp_path):
        space.opened = object()  # type: ignore[assignment]
        for owner, is_given in (("anna", False), ("bert", True)):
            space.owner = key_of(cookies(owner)) or ""
            shown = checked(scripted(script).run()).text[0].value
            assert (shown == space.token) == is_given
        space.opened = None


def test_to_log_out_closes_what_is_open_and_ends_the_log_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(st, "context", Context("anna"))
    with log_in_by(tmp_path):
        script = "from ui.session import state\nfrom ui.shell import account\n"
        script += "if account.is_welcome():\n    state.workspace()\n    account.draw()"
        page = checked(scripted(script).run())
        assert "Logged in as anna@lab.example" in texts(page)
        folder = page.session_state["workspace"].folder
        assert len(press(page, "log_out").button) == 0
        assert not folder.exists()
        assert key_of(cookies("anna")) is None
