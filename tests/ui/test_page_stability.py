"""The Stability page, driven without a browser."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from ui import stability_map
from ui.background_job import JobState

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 20


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))


def opened() -> AppTest:
    app = AppTest.from_file(str(ROOT / "ui" / "main.py"), default_timeout=60).run()
    return checked(app.switch_page(str(ROOT / "pages" / "stability.py")).run())


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    assert not page.error
    return page


def words(page: AppTest) -> str:
    return " ".join(one.value for one in page.markdown).replace("\\", "")


def test_the_map_says_how_far_the_verdict_holds():
    shown = words(opened())
    assert "As analysed, X has the higher mean similarity, by 0.0059." in shown
    assert "of the plausible range (alpha 0.5 to 1 and midpoint 28.8 to 72 px)" in shown


def test_another_setting_gives_another_map():
    page = opened()
    checked(page.slider(key="midpoint").set_value(100.0).run())
    assert "As analysed, Y has the higher mean similarity" in words(page)


@pytest.mark.parametrize(
    ("plane", "criterion", "told"),
    [
        ("thresholds", "encounters", "X detects more encounters"),
        ("matching", "encounters", "X detects more encounters"),
        ("edge-weight-alpha", "saliency", "Y has the lower saliency"),
    ],
)
def test_each_map_and_criterion_is_told(plane: str, criterion: str, told: str):
    page = opened()
    page.button_group(key="stability_plane").set_value(plane)
    checked(page.button_group(key="stability_criterion").set_value(criterion).run())
    assert f"As analysed, {told}" in words(page)


def test_a_large_map_is_made_on_a_wish_and_then_known(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(stability_map, "AT_ONCE", 0)
    page = opened()
    assert "As analysed" not in words(page)
    checked(page.button(key="stability_start").click().run())
    job = page.session_state[stability_map.JOB]
    job.join()
    assert job.state is JobState.DONE
    assert "As analysed, X has the higher" in words(checked(page.run()))
    checked(page.button_group(key="stability_criterion").set_value("encounters").run())
    checked(page.button_group(key="stability_criterion").set_value("similarity").run())
    assert "As analysed, X has the higher" in words(page)


def test_a_map_can_be_cancelled(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(stability_map, "AT_ONCE", 0)
    is_started, may_go_on = threading.Event(), threading.Event()
    real = stability_map.map_stability

    def waits(*of, **more):
        is_started.set()
        assert may_go_on.wait(PATIENCE_S)
        return real(*of, **more)

    monkeypatch.setattr(stability_map, "map_stability", waits)
    page = opened()
    checked(page.button(key="stability_start").click().run())
    assert is_started.wait(PATIENCE_S)
    checked(page.button(key="stability_cancel").click().run())
    may_go_on.set()
    job = page.session_state[stability_map.JOB]
    job.join()
    assert job.state is JobState.CANCELLED
    assert "was cancelled" in checked(page.run()).info[0].value
