"""The HTML report on the Export page, driven without a browser."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from export_page import downloads, job_of, opened, uploaded_drive
from streamlit.testing.v1 import AppTest

from nvcore.common.errors import InputError
from nvcore.settings.protocols import PROTOCOLS
from pages import checked, press
from ui.jobs.background import JobState
from ui.views.export.html import NAME


@pytest.fixture
def page(tmp_path: Path) -> AppTest:
    return opened("html", space=uploaded_drive(tmp_path))


def made(page: AppTest) -> AppTest:
    """The page once the report is finished."""
    press(page, "make_html")
    job_of(page, "html").join()
    return checked(page.run())


def file_of(page: AppTest) -> Path:
    return job_of(page, "html").folder / NAME


def is_of_other_settings(page: AppTest) -> bool:
    return any("made with other settings" in text.value for text in page.warning)


def test_the_report_is_made_and_offered_and_names_no_folder_of_the_machine(
    page, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        "ui.views.export.html.AT_ONCE", 10
    )  # without the maps, which take their time
    assert NAME not in downloads(page)
    page.text_input(key="html_title").set_value("Night drive")
    page.text_input(key="html_question").set_value("Which is safer?")
    made(checked(page.run()))
    assert job_of(page, "html").state is JobState.DONE
    assert NAME in downloads(page)
    content = file_of(page).read_text(encoding="utf-8")
    assert "<h1>Night drive</h1>" in content
    assert "Which is safer?" in content
    assert f'<p class="muted">{page.text_input(key="html_date").value}</p>' in content
    assert "fir (X) and nir (Y) compared" in content
    assert "<td>only X</td><td" in content
    assert str(tmp_path) not in content
    assert f"{tmp_path.name}/" not in content
    assert "truth.csv</td>" in content
    assert not is_of_other_settings(page)
    page.text_input(key="html_title").set_value("Day drive")
    assert is_of_other_settings(checked(page.run()))


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Protocol and stability of each report, of which only the files are made."""
    reports: list[dict[str, Any]] = []

    def write(_result, session, _findings, path: Path, *, stability, **_: object) -> None:
        path.write_text("report")
        reports.append({"protocol": session.protocol.name, "stability": stability})

    monkeypatch.setattr("ui.views.export.html.write_html_report", write)
    return reports


def test_a_report_made_with_other_settings_says_so_and_goes_when_there_is_a_new_one(page, written):
    assert not is_of_other_settings(made(page))
    before = file_of(page)
    space = page.session_state["workspace"]
    session = replace(space.opened.session, protocol=PROTOCOLS["reasonable"])
    space.opened = replace(space.opened, session=session)
    assert is_of_other_settings(checked(page.run()))
    assert not is_of_other_settings(made(page))
    assert [report["protocol"] for report in written] == ["all", "reasonable"]
    assert file_of(page).exists()
    assert not before.exists()


def test_with_many_frames_the_stability_map_is_made_when_asked_for(page, written, monkeypatch):
    assert not [toggle for toggle in page.toggle if toggle.key == "html_stability"]
    monkeypatch.setattr("ui.views.export.html.AT_ONCE", 10)
    checked(page.run())
    assert page.toggle(key="html_stability").value is False
    made(page)
    made(checked(page.toggle(key="html_stability").set_value(True).run()))
    assert [report["stability"] for report in written] == [False, True]


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (InputError("no *room* on the disk"), r"no \*room\* on the disk"),
        (CancelledError(), "Cancelled. No report was made."),
    ],
)
def test_a_report_that_fails_or_is_cancelled_is_told(page, monkeypatch, error, message):
    def fail(*_arguments: object, **_options: object) -> None:
        raise error

    monkeypatch.setattr("ui.views.export.html.write_html_report", fail)
    made(page)
    assert [text.value for text in (*page.error, *page.info)] == [message]
    assert NAME not in downloads(page)
    assert not file_of(page).exists()
