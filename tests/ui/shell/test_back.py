"""Back and Forward lead to the frame and the encounter of their address; settings stay."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from streamlit.testing.v1 import AppTest

from pages import checked, opened, press, texts
from ui.streamlit_inside import sessions


@pytest.fixture
def go_back(monkeypatch: pytest.MonkeyPatch):
    """Runs the page as a browser does that went to an address of its history."""

    def go(page: AppTest, **address: str) -> AppTest:
        for name in list(page.query_params):
            del page.query_params[name]
        for name, text in address.items():
            page.query_params[name] = text
        with monkeypatch.context() as patch:
            context = SimpleNamespace(is_history_navigation=True)
            patch.setattr(sessions, "get_script_run_ctx", lambda **_: context)
            return checked(page.run())

    return go


def only(page: AppTest, name: str) -> str:
    return "".join(page.query_params[name])


def test_back_leads_to_the_recording_before_and_leaves_the_settings(go_back):
    page = checked(opened("export", recording="winter_frost", frame="12"))
    page.session_state["new_params"] = {"alpha": 0.5}
    checked(page.run())
    go_back(page, recording="another", frame="<b>")  # no longer open
    assert page.session_state["place"] == (9, 12)
    assert only(page, "recording") == "winter_frost"
    go_back(page, recording="rural_child", frame="120")
    assert page.session_state["place"] == (4, 120)
    assert page.session_state["params"].alpha == 0.5
    assert only(page, "alpha") == "0.5"


def test_back_leads_to_the_encounter_and_the_filters_before(go_back):
    page = checked(opened("encounters", category="x_only"))
    press(page, "encounters_next")
    before, name = dict(page.query_params), page.header[0].value
    press(page, "encounters_next")
    assert page.header[0].value != name
    go_back(page, **{key: "".join(text) for key, text in before.items()})
    assert page.header[0].value == name
    assert "**2** of 8" in texts(page)
    # a change that is made afterwards holds
    press(page, "encounters_clear")
    assert "**46** of 46 encounters" in texts(page)
