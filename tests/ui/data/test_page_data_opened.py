"""The Data page: what is said once something was opened."""

from __future__ import annotations

from pathlib import Path

from data_page import opened_drive, press

from pages import checked, opened, texts, to_page


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
    page = press(checked(opened("data")), "open_sample")
    assert "Opened: Sample recordings" in texts(page)
    checked(to_page(page, "metrics"))
    checked(to_page(page, "data"))
    assert "Open now: Sample recordings" in texts(page)
    assert "Opened: Sample recordings" not in texts(page)
