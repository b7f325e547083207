"""Access to Streamlit's sessions: the running one, its browser, its uploads, and its end."""

from __future__ import annotations

import asyncio

from streamlit import runtime
from streamlit.runtime.scriptrunner import get_script_run_ctx


def running_session() -> str | None:
    """Return the id of the session whose script runs in this thread, or None."""
    context = get_script_run_ctx(suppress_warning=True)
    return context.session_id if context is not None and runtime.exists() else None


def was_led_by_history() -> bool:
    """Whether the browser's Back or Forward led to the address of this run."""
    context = get_script_run_ctx(suppress_warning=True)
    return context is not None and context.is_history_navigation


def is_connected(session_id: str) -> bool:
    """Whether the session's browser is connected."""
    return runtime.exists() and runtime.get_instance().is_active_session(session_id)


def close_session(session_id: str, loop: asyncio.AbstractEventLoop) -> None:
    """Close the session and drop its uploaded files. May be called from any thread."""
    if runtime.exists() and not loop.is_closed():
        loop.call_soon_threadsafe(runtime.get_instance().close_session, session_id)


def run_again(session_id: str) -> None:
    """Rerun the session's script if its browser is connected. Call on Streamlit's own loop."""
    manager = runtime.get_instance()._session_mgr
    if (active := manager.get_active_session_info(session_id)) is not None:
        active.session.request_rerun(active.session._client_state)


def held_bytes(session_id: str | None = None) -> int:
    """Return the bytes that ``st.file_uploader`` holds in memory, for one session or all."""
    if not runtime.exists():
        return 0
    held = runtime.get_instance().uploaded_file_mgr.file_storage  # type: ignore[attr-defined]
    sessions = list(held.values()) if session_id is None else [held.get(session_id, {})]
    return sum(len(file.data) for files in sessions for file in list(files.values()))
