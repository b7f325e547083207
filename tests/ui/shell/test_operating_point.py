"""Unequal operating points: each page has one message about them."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from pages import begin_with, checked, opened, part, texts, to_page, unequal_session

DIFFERENT = "compared at different operating points"
PAGES = ("timeline", "encounters", "saliency", "time_left", "detection", "stability", "alerts")


@pytest.fixture
def app(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AppTest:
    begin_with(unequal_session(tmp_path), monkeypatch)
    return checked(opened())


def captions(app: AppTest) -> list[str]:
    return [caption.value for caption in app.sidebar.caption]


def in_use(app: AppTest) -> str:
    """The caption about the threshold in use of X, whose threshold is moved."""
    threshold = app.session_state["workspace"].result.x.threshold
    return f"In use at equal false alarms: **{threshold:g}**."


def test_at_equal_false_alarms_no_page_warns_of_what_the_switch_has_settled(app: AppTest) -> None:
    assert app.session_state["workspace"].result.as_set is not None
    assert DIFFERENT not in texts(app)
    for name in PAGES:
        said = texts(checked(to_page(app, name)))
        assert DIFFERENT not in said
        count = said.count("At equal false alarms, not as set (X at a confidence threshold of ")
        assert count == (name != "detection")


def test_as_set_each_page_says_it_once_beside_the_switch(app: AppTest) -> None:
    checked(app.button_group(key="operating_point").set_value("as-set").run())
    for name in ("encounters", "stability"):
        said = texts(checked(to_page(app, name)))
        assert said.count("As set, at unequal operating points") == 1
        assert DIFFERENT not in said


def test_a_page_without_the_switch_warns_as_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begin_with(unequal_session(tmp_path), monkeypatch)
    page = part("ui.shell.messages.draw_warnings(RESULT)", point="as-set").run()
    (warning,) = checked(page).warning
    assert DIFFERENT in warning.value


def test_the_sidebar_names_the_threshold_in_use(app: AppTest) -> None:
    assert in_use(app) in captions(app)
    assert "Every detection of X counts." not in captions(app)
    assert "Every detection of Y counts." in captions(app)
    checked(app.button_group(key="operating_point").set_value("as-set").run())
    assert not [caption for caption in captions(app) if caption.startswith("In use")]
    assert "Every detection of X counts." in captions(app)


@pytest.mark.parametrize("name", ["overview", *PAGES, "driver", "data"])
def test_no_page_has_a_banner_twice(app: AppTest, name: str) -> None:
    page = app if name == "overview" else checked(to_page(app, name))
    for kind in (page.warning, page.info, page.error):
        banners = [banner.value for banner in kind]
        assert len(banners) == len({*banners})
