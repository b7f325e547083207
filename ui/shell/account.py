"""Who has logged in, and the way out; nothing where there is no log-in."""

from __future__ import annotations

import streamlit as st

from ui.access.login import login
from ui.access.people import end_log_in, is_same, key_of, person_of
from ui.session import store
from ui.widgets.text import plain


def is_welcome() -> bool:
    """Whether this browser's user may go on: is logged in, as whoever began the session."""
    if login() is None:
        return True
    key = key_of(st.context.cookies)
    space = store.WORKSPACE.get()
    return key is not None and (space is None or is_same(space.owner, key))


def draw_farewell() -> None:
    """In place of every page, where the log-in has ended: the gate then asks for another."""
    st.title("Logged out")
    st.write("Load the page again to log in.")


def draw() -> None:
    """Who has logged in, and the button to log out."""
    by = login()
    person = None if by is None else person_of(st.context.cookies, by)
    if person is None:
        return
    with st.container(key="account"):
        st.caption(f"Logged in as {plain(person.email)}" if person.email else "Logged in")
        st.button("Log out", key="log_out", width="stretch", on_click=_log_out)


def _log_out() -> None:
    """End the log-in and close what is open; the browser then goes to the provider."""
    space = store.WORKSPACE.get()
    end_log_in(st.context.cookies)
    if space is not None:
        space.close()  # not forgotten: the session ends with it
    st.logout()
