"""What was open in a tab is given back to it, and to nobody who does not know its name."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import ModuleType
from typing import Any

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from nvcore.pictures.recordings import RecordingPictures
from pages import TIMEOUT_S, checked, press, scripted, texts
from ui.jobs.background import JobState
from ui.session import sample, state
from ui.session.address import changed_parameters
from ui.session.workspace import Workspace
from ui.shell import tab
from ui.subjects.ratings import fit
from ui.views.export import html
from ui.views.stability import survey, verdict_map

SCRIPT = """
import streamlit as st
from ui.session import settings, state
from ui.shell import live_params
from ui.shell import tab
if token := st.session_state.pop("claims", None):
    tab.claim(token)
settings.begin_run()
live_params.read()
"""
PARTS = {
    "": "",
    "map": "import ui.views.stability.verdict_map as map\nmap.draw(state.result())",
    "ratings": "import ui.subjects.ratings.results as ratings\nratings.draw(state.result())",
    "report": "import ui.views.export.html as report\nreport.draw(state.result())",
    "protocol": "from ui.views.detection import protocol\nprotocol.choose(state.opened().dataset)",
}


@pytest.fixture(autouse=True)
def no_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    # without a browser every session passes for one whose page is there
    monkeypatch.setattr(state, "is_in_use", lambda _: False)
    monkeypatch.setattr(survey, "AT_ONCE", 0)  # no table of all maps: it takes its time


def page(name: str = "", **query: str) -> AppTest:
    """What every page begins with, and this part of one."""
    return checked(scripted(SCRIPT + PARTS[name], **query).run())


def claiming(app: AppTest, token: str) -> Workspace:
    app.session_state["claims"] = token
    checked(app.run())
    return app.session_state["workspace"]


def test_a_new_session_goes_on_with_the_workspace_and_its_address():
    before = page().session_state["workspace"]
    after = page(recording="winter_frost", frame="12", alpha="0.25")
    assert claiming(after, before.token) is before
    assert after.session_state["place"] == (9, 12)
    assert after.session_state["params"].alpha == 0.25


def test_what_the_page_still_shows_is_served_until_it_is_drawn_anew():
    before, after = page().session_state["workspace"], page("ratings")
    left = after.session_state["workspace"]
    assert claiming(after, before.token) is before
    assert after.session_state["left_workspace"] is left  # else it would be gone at once
    assert left.compared is not None
    assert len(left.pictures.sources) > 0


def test_an_unknown_name_or_a_closed_workspace_gives_nothing():
    app = page()
    own = app.session_state["workspace"]
    assert claiming(app, "x" * 32) is own
    other = Workspace()
    assert claiming(app, other.token) is own  # nothing is open in it


@pytest.fixture
def used(monkeypatch: pytest.MonkeyPatch) -> Workspace:
    """The workspace of another page."""
    space: Workspace = page().session_state["workspace"]
    monkeypatch.setattr(state, "is_in_use", lambda other: other is space)
    return space


def test_a_workspace_is_not_shared_and_had_once_its_page_has_gone(
    used: Workspace, monkeypatch: pytest.MonkeyPatch
):
    app = page()
    assert claiming(app, used.token) is not used
    assert not app.session_state["tab_is_settled"]
    monkeypatch.setattr(state, "is_in_use", lambda _: False)
    assert claiming(app, used.token) is used
    assert app.session_state["tab_is_settled"]


def test_a_workspace_that_stays_in_use_is_given_up(used: Workspace):
    app = page()
    for n_claims in range(1, tab.MOST_CLAIMS + 1):
        assert claiming(app, used.token) is not used
        assert app.session_state["tab_is_settled"] is (n_claims == tab.MOST_CLAIMS)


def test_who_has_opened_something_meanwhile_keeps_it(used: Workspace):
    app = page()
    own = app.session_state["workspace"]
    own.n_opened += 1
    assert claiming(app, used.token) is own
    assert app.session_state["tab_is_settled"]


class Gate:
    """Lets a function wait, in the background, until the test says that it may go on."""

    def __init__(self, real: Callable[..., Any]) -> None:
        self.real = real
        self.is_reached, self.is_open = threading.Event(), threading.Event()

    def __call__(self, *given: Any, **more: Any) -> Any:
        self.is_reached.set()
        assert self.is_open.wait(TIMEOUT_S)
        return self.real(*given, **more)


@pytest.fixture
def gated(monkeypatch: pytest.MonkeyPatch) -> Callable[..., Gate]:
    """Makes a module do its work in the background, where this function of it waits."""

    monkeypatch.setattr(sample, "_samples", type(sample._samples)())  # nobody has done it before

    def gate(module: ModuleType, function: str, instead: Callable[..., Any] | None = None) -> Gate:
        monkeypatch.setattr(module, "AT_ONCE", 0)
        made = Gate(instead or getattr(module, function))
        monkeypatch.setattr(module, function, made)
        return made

    return gate


def reloaded(before: AppTest, name: str) -> AppTest:
    """The page in a new session, which has claimed what was open."""
    after = page(name)
    claiming(after, before.session_state["workspace"].token)
    return after


def keys(app: AppTest) -> list[str | None]:
    return [button.key for button in app.button]


def ended(app: AppTest, kind: str) -> AppTest:
    """The page once its job has ended."""
    app.session_state["workspace"].job(kind).join()
    checked(app.run())
    return app


def test_a_map_goes_on_after_a_reload_of_its_page(gated):
    gate = gated(verdict_map, "map_stability")
    before = page("map")
    before.button_group(key="stability_criterion").set_value("encounters").run()
    press(before, "stability_start")
    assert gate.is_reached.wait(TIMEOUT_S)
    job = before.session_state["workspace"].job(verdict_map.RUN.name)
    after = reloaded(before, "map")
    assert after.session_state["workspace"].job(verdict_map.RUN.name) is job
    assert after.button_group(key="stability_criterion").value == "encounters"
    assert "stability_cancel" in keys(after)
    gate.is_open.set()
    assert "As analysed, X detects 3 encounters more" in texts(ended(after, verdict_map.RUN.name))


def test_after_a_reload_a_map_can_be_cancelled(gated):
    gate = gated(verdict_map, "map_stability")
    before = press(page("map"), "stability_start")
    assert gate.is_reached.wait(TIMEOUT_S)
    after = press(reloaded(before, "map"), "stability_cancel")
    gate.is_open.set()
    ended(after, verdict_map.RUN.name)
    assert [text.value for text in after.info] == ["Cancelled. No map was made."]
    assert "stability_start" in keys(after)


def test_a_fit_goes_on_after_a_reload_and_fitted_settings_are_still_marked(gated, monkeypatch):
    monkeypatch.setattr("nvcore.subjects.ratings.fit.HEIGHT_SHARES", (0.075,))  # few are tried
    gate = gated(fit, "fit_saliency")
    before = press(page("ratings"), "rating_fit")
    assert gate.is_reached.wait(TIMEOUT_S)
    fitting = reloaded(before, "ratings")
    assert "rating_fit_cancel" in keys(fitting)
    gate.is_open.set()
    press(ended(fitting, fit.RUN.name), "rating_fit_take")
    space = fitting.session_state["workspace"]
    start = space.opened.dataset.params_of()
    query = changed_parameters(fitting.session_state["params"], start)
    after = page("ratings", **query)
    assert not fitted(after)  # a fresh tab by the same address has no fit
    claiming(after, space.token)
    assert fitted(after)
    press(after, "rating_fit_back")
    assert not fitted(after.run())
    assert after.session_state["params"] == start


def fitted(app: AppTest) -> bool:
    return any("**fitted to these ratings**" in text.value for text in app.warning)


def test_a_report_goes_on_after_a_reload_of_its_page(gated):
    gate = gated(html, "write_html_report", lambda *given, **_: given[3].write_text("report"))
    before = page("report")
    before.toggle(key="html_stability").set_value(True).run()
    press(before, "make_html")
    assert gate.is_reached.wait(TIMEOUT_S)
    after = reloaded(before, "report")
    assert after.toggle(key="html_stability").value is True
    assert after.button(key="make_html").disabled
    assert "html_cancel" in keys(after)
    gate.is_open.set()
    ended(after, html.RUN.name)
    assert html.NAME in [button.proto.label for button in after.get("download_button")]
    assert not any("other settings" in text.value for text in after.warning)


def test_opening_ends_the_jobs_before_it_closes_their_pictures():
    order: list[str] = []

    class Noted:
        def discard(self) -> None:
            order.append("job")

        def close(self) -> None:
            order.append("pictures")

    app = page()
    space = app.session_state["workspace"]
    space.show(space.opened, RecordingPictures({0: Noted()}))
    space.put_job("noted", Noted())
    space.opened = None  # the next run opens the sample again
    assert not app.run().exception
    assert order == ["job", "pictures"]


def test_the_protocol_is_still_chosen_after_a_reload():
    before = page("protocol")
    names = before.multiselect(key="protocol_recordings").options[:2]
    before.multiselect(key="protocol_recordings").set_value(names).run()
    before.selectbox(key="protocol").set_value("own filters").run()
    before.number_input(key="own_low").set_value(100.0).run()
    after = reloaded(before, "protocol")
    assert after.selectbox(key="protocol").value == "own filters"
    assert after.number_input(key="own_low").value == 100.0
    assert after.multiselect(key="protocol_recordings").value == names
    live = after.session_state["workspace"].opened.session.protocol
    assert (live.height_px[0], live.recordings) == (100.0, tuple(names))


def test_typed_ratings_are_still_there_after_a_reload():
    before = typing(page("ratings"))
    before.text_input(key="ratings_typed_name").set_value("Anna")
    next(button for button in before.button if "Add a row" in button.label).click().run()
    after = typing(page("ratings"))
    assert shown(after).empty
    claiming(after, before.session_state["workspace"].token)
    assert shown(after)["participant"].unique().tolist() == ["Anna"]
    assert len(shown(after)) == 20


def typing(app: AppTest) -> AppTest:
    return app.button_group(key="ratings_source_4").set_value("Typed in").run()


def shown(app: AppTest) -> pd.DataFrame:
    return next(item.value for item in app.dataframe if "participant" in item.value)


def test_a_workspace_that_nobody_comes_back_to_ends_its_jobs(gated):
    gate = gated(verdict_map, "map_stability")
    space = press(page("map"), "stability_start").session_state["workspace"]
    assert gate.is_reached.wait(TIMEOUT_S)
    job = space.job(verdict_map.RUN.name)
    space.close()  # as `ui.session.lifetime` does it
    gate.is_open.set()
    job.join()
    assert job.state is JobState.CANCELLED
