"""Buttons whose clicks are not lost."""

from __future__ import annotations

from typing import Any

from streamlit.testing.v1 import AppTest


def page() -> None:
    import streamlit as st

    from ui.session import store
    from ui.widgets.buttons import button, submit_button

    state = st.session_state
    if state.pop("is_ended", False):
        st.rerun()  # as by another widget, before the buttons are drawn
    if not state.pop("is_hidden", False):
        for number in (1, 2):
            label = f"Go {number}{state['more']}"
            state[f"n_go{number}"] += button(label, key=f"go{number}", disabled=state["is_busy"])
        with st.form("form"):
            state["n_send"] += submit_button("Send", key="send")
    store.CLICKED.pop()


def new_page() -> AppTest:
    app = AppTest.from_function(page)
    for name in ("n_go1", "n_go2", "n_send", "is_busy"):
        app.session_state[name] = 0
    app.session_state["more"] = ""
    return app.run()


def click(app: AppTest, key: str, **state: Any) -> None:
    """Click, and let the page be in this state when it hears of it."""
    for name, value in state.items():
        app.session_state[name] = value
    app.button(key=key).click().run()
    app.run()


def test_a_click_counts_once_also_if_the_run_that_it_begins_is_ended_by_another():
    app = new_page()
    for n, is_ended in enumerate((False, True, True), start=1):
        for key in ("go1", "go2", "send"):
            click(app, key, is_ended=is_ended)
            assert app.session_state[f"n_{key}"] == n


def test_a_click_is_forgotten_where_the_page_no_longer_has_the_button_or_it_says_another_thing():
    app = new_page()
    click(app, "go1", is_hidden=True)
    click(app, "go1", more=" there")
    assert app.session_state["n_go1"] == 0
    click(app, "go1")
    assert app.session_state["n_go1"] == 1


def test_a_button_that_is_disabled_by_now_does_nothing_and_nothing_later():
    app = new_page()
    click(app, "go1", is_busy=True)
    app.session_state["is_busy"] = False
    assert app.run().session_state["n_go1"] == 0


def test_of_two_clicks_the_last_counts():
    app = new_page()
    app.session_state["clicked"] = "go1", "Go 1"  # its run was ended by the next click
    click(app, "go2")
    assert (app.session_state["n_go1"], app.session_state["n_go2"]) == (0, 1)
