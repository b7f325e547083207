"""The HTML report on the Export page, driven without a browser."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import replace
from pathlib import Path

import pytest
from export_page import downloads, job_of, opened_drive
from streamlit.testing.v1 import AppTest

from nvcore.protocols import PROTOCOLS
from pages import checked
from ui.export.html import JOB, NAME
from ui.jobs.background import JobState


@pytest.fixture
def page(tmp_path: Path) -> AppTest:
    return opened_drive(tmp_path)


def made(page: AppTest) -> AppTest:
    """The page once the report is finished."""
    checked(page.button(key="make_html").click().run())
    job_of(page, JOB).join()
    return checked(page.run())


def test_the_button_makes_the_report_and_offers_it(page):
    assert NAME not in downloads(page)
    made(page)
    assert job_of(page, JOB).state is JobState.DONE
    assert NAME in downloads(page)
    content = job_of(page, JOB).path.read_text(encoding="utf-8")
    assert "fir (X) and nir (Y) compared" in content
    assert "<td>only X</td><td" in content


def test_the_report_names_no_folder_of_the_machine(page, tmp_path):
    content = job_of(made(page), JOB).path.read_text(encoding="utf-8")
    assert str(tmp_path) not in content
    assert f"{tmp_path.name}/" not in content
    assert "truth.csv</td>" in content


def test_a_report_made_with_other_settings_says_so(page):
    made(page)
    shown = [one.value for one in page.warning]
    assert not any("other settings" in one for one in shown)
    space = page.session_state["workspace"]
    session = replace(space.opened.session, protocol=PROTOCOLS["reasonable"])
    space.opened = replace(space.opened, session=session)
    checked(page.run())
    assert any("made with other settings" in one.value for one in page.warning)
    content = job_of(made(page), JOB).path.read_text(encoding="utf-8")
    assert "Protocol reasonable:" in content
    assert not any("other settings" in one.value for one in page.warning)


def test_a_new_report_takes_the_place_of_the_one_before(page):
    before = job_of(made(page), JOB).path
    after = job_of(made(page), JOB).path
    assert after.exists()
    assert not before.exists()


def test_a_failure_is_told(page, monkeypatch):
    def fail(*_arguments: object, **_options: object) -> None:
        from nvcore.errors import InputError

        raise InputError("no room on the disk")

    monkeypatch.setattr("ui.export.html.write_html_report", fail)
    made(page)
    assert [one.value for one in page.error] == ["no room on the disk"]
    assert NAME not in downloads(page)


def test_a_cancelled_report_leaves_nothing(page, monkeypatch):
    def stop(*_arguments: object, **_options: object) -> None:
        raise CancelledError

    monkeypatch.setattr("ui.export.html.write_html_report", stop)
    made(page)
    assert [one.value for one in page.info] == ["Cancelled. No report was made."]
    assert not job_of(page, JOB).path.exists()


def test_with_many_frames_the_stability_map_is_made_when_asked_for(page, monkeypatch):
    assert not [one for one in page.toggle if one.key == "html_stability"]
    monkeypatch.setattr("ui.export.html.AT_ONCE", 10)
    checked(page.run())
    assert page.toggle(key="html_stability").value is False
    assert "Not computed for these 40 frames" in job_of(made(page), JOB).path.read_text("utf-8")
    checked(page.toggle(key="html_stability").set_value(True).run())
    assert "Not computed" not in job_of(made(page), JOB).path.read_text("utf-8")
