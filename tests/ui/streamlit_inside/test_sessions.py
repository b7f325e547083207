"""What Streamlit's runtime tells of its sessions."""

from __future__ import annotations

import asyncio
import inspect
from types import SimpleNamespace

import pytest
from streamlit.runtime import Runtime
from streamlit.runtime.app_session import AppSession
from streamlit.runtime.memory_uploaded_file_manager import MemoryUploadedFileManager
from streamlit.runtime.scriptrunner import ScriptRunContext
from streamlit.runtime.uploaded_file_manager import UploadedFileRec
from streamlit.testing.v1 import AppTest

from ui.streamlit_inside import sessions


@pytest.fixture
def runtime(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A server with two sessions, of which one is connected; each has sent a file."""
    files = MemoryUploadedFileManager("/_stcore/upload_file")
    for session, content in (("here", b"123"), ("away", b"12345")):
        files.add_file(session, UploadedFileRec("id", "gt.txt", "text/plain", content))
    closed: list[str] = []
    server = SimpleNamespace(
        uploaded_file_mgr=files,
        is_active_session=lambda session: session == "here",
        close_session=closed.append,
        closed=closed,
    )
    monkeypatch.setattr(sessions.runtime, "exists", lambda: True)
    monkeypatch.setattr(sessions.runtime, "get_instance", lambda: server)
    return server


def test_the_runtime_has_what_is_asked_of_it():
    assert [*inspect.signature(Runtime.is_active_session).parameters] == ["self", "session_id"]
    assert [*inspect.signature(Runtime.close_session).parameters] == ["self", "session_id"]
    assert isinstance(Runtime.uploaded_file_mgr, property)
    assert [*inspect.signature(AppSession.request_rerun).parameters] == ["self", "client_state"]
    assert {"session_id", "is_history_navigation"} <= {*ScriptRunContext.__dataclass_fields__}


def test_outside_of_a_run_there_is_no_session():
    assert sessions.running_session() is None
    assert not sessions.was_led_by_history()
    assert not sessions.is_connected("here")
    assert sessions.held_bytes() == 0


def test_a_run_knows_its_session_and_that_no_history_led_to_it():
    page = AppTest.from_string("""
import streamlit as st
from ui.streamlit_inside import sessions
st.text(f"{sessions.get_script_run_ctx().session_id} {sessions.was_led_by_history()}")
""").run()
    (text,) = page.text
    session, _, is_led = text.value.rpartition(" ")
    assert session
    assert is_led == "False"


def test_the_session_that_runs_is_that_of_the_context(
    runtime: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
):
    context = SimpleNamespace(session_id="here", is_history_navigation=True)
    monkeypatch.setattr(sessions, "get_script_run_ctx", lambda **_: context)
    assert sessions.running_session() == "here"
    assert sessions.was_led_by_history()


def test_who_is_connected_and_what_is_held_is_known(runtime: SimpleNamespace):
    assert [sessions.is_connected(session) for session in ("here", "away")] == [True, False]
    held = [sessions.held_bytes(session) for session in (None, "here", "away", "gone")]
    assert held == [8, 3, 5, 0]


def test_a_session_is_closed_on_the_loop_while_that_is_open(runtime: SimpleNamespace):
    loop = asyncio.new_event_loop()
    sessions.close_session("away", loop)
    assert runtime.closed == []
    loop.run_until_complete(asyncio.sleep(0))
    loop.close()
    sessions.close_session("here", loop)
    assert runtime.closed == ["away"]
