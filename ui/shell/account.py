"""Name of the logged-in person and the button to log out, if log-in is set up."""

from __future__ import annotations

import streamlit as st

from ui.access.login import login
from ui.access.people import end_log_in, is_same, key_of, person_of
from ui.session import store
from ui.widgets.text import plain


def is_welcome() -> bool:
    """Whether this browser's user may go on, being logged in as the session's owner."""
    if login() is None:
        return True
    key = key_of(st.context.cookies)
    space = store.WORKSPACE.get()
    return key is not None and (space is None or is_same(space.owner, key))


def draw_farewell() -> None:
    """Draw a notice in place of the page once the log-in has ended. A reload asks to log in."""
    st.title("Logged out")
    st.write("Load the page again to log in.")


def draw() -> None:
    """Draw the name of the logged-in person and the button to log out."""
    by = login()
    person = None if by is None else person_of(st.context.cookies, by)
    if person is None:
        return
    with st.container(key="account"):
        st.caption(f"Logged in as {plain(person.email)}" if person.email else "Logged in")
        st.button("Log out", key="log_out", width="stretch", on_click=_log_out)


def _log_out() -> None:
    """End the log-in, close the workspace and send the browser to the provider."""
    space = store.WORKSPACE.get()
    end_log_in(st.context.cookies)
    if space is not None:
        space.close()  # stays in the store, because the session ends as well
    st.logout()
