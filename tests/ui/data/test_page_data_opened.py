"""The Data page: what is said once something was opened."""

from __future__ import annotations

from pathlib import Path

from data_page import ROOT, checked, opened_drive, press, texts
from streamlit.testing.v1 import AppTest


def test_what_was_opened_and_the_next_step_stand_first(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    banner, button = (page.main.children[1].children[at] for at in range(2))
    assert (banner.type, button.type) == ("success", "button")
    assert banner.value.startswith("**Opened: Uploaded files.**")
    assert button.label == "Next: see the comparison"


def test_the_next_step_stays_while_one_works_on_the_page_and_leads_to_the_overview(tmp_path: Path):
    page = opened_drive(tmp_path, "fir.csv", "nir.csv")
    checked(page.number_input(key="data_threshold_x").set_value(0.8).run())
    assert "Opened: Uploaded files" in texts(page)
    press(page, "see_opened")
    assert page.session_state["wanted_page"] == "overview"


def test_the_next_step_is_gone_when_one_comes_back_to_the_page():
    page = AppTest.from_file(str(ROOT / "app.py"), default_timeout=60)
    page.switch_page(str(ROOT / "pages" / "data.py"))
    press(checked(page.run()), "open_sample")
    assert "Opened: Sample recordings" in texts(page)
    page.switch_page(str(ROOT / "pages" / "metrics.py"))
    checked(page.run())
    page.switch_page(str(ROOT / "pages" / "data.py"))
    checked(page.run())
    assert "Open now: Sample recordings" in texts(page)
    assert "Opened: Sample recordings" not in texts(page)
