"""The HTML report on the Export page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import DATA, drive
from streamlit.testing.v1 import AppTest

from ui.background_job import JobState
from ui.export_html import JOB, NAME, HtmlJob

ROOT = DATA.parents[1]
PAGE = f"""
import runpy
from ui import state
state.begin_run()
runpy.run_path({str(ROOT / "pages" / "export.py")!r})
"""
OPENING = """
import streamlit as st
from pathlib import Path
from nvcore.session import Session, Source, SystemSource
from ui import state
if "is_open" not in st.session_state:
    st.session_state["is_open"] = True
    folder = Path({folder!r})
    systems = tuple(SystemSource((path,), name=name) for name, path in {systems!r})
    state.open_session(Session(folder, Source(("truth.csv",)), systems, size=(640, 480), fps=20),
                       label="Uploaded files")
"""
SYSTEMS = (("fir", "fir.csv"), ("nir", "nir.csv"))


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AppTest:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    monkeypatch.delenv("NVCORE_LOCAL_ROOT", raising=False)
    drive(tmp_path)
    script = OPENING.format(folder=str(tmp_path), systems=SYSTEMS) + PAGE
    return checked(AppTest.from_string(script, default_timeout=60).run())


def checked(page: AppTest) -> AppTest:
    assert [error.message for error in page.exception] == []
    return page


def job_of(page: AppTest) -> HtmlJob:
    job: HtmlJob = page.session_state[JOB]
    return job


def made(page: AppTest) -> AppTest:
    """The page once the report is finished."""
    checked(page.button(key="make_html").click().run())
    job_of(page).join()
    return checked(page.run())


def labels(page: AppTest) -> list[str]:
    return [one.proto.label for one in page.get("download_button")]


def test_the_button_makes_the_report_and_offers_it(page):
    assert NAME not in labels(page)
    made(page)
    assert job_of(page).state is JobState.DONE
    assert NAME in labels(page)
    content = job_of(page).path.read_text(encoding="utf-8")
    assert "fir (X) and nir (Y) compared" in content
    assert "<td>only X</td><td" in content


def test_the_report_names_no_folder_of_the_machine(page, tmp_path):
    content = job_of(made(page)).path.read_text(encoding="utf-8")
    assert str(tmp_path) not in content
    assert f"{tmp_path.name}/" not in content
    assert "truth.csv</td>" in content


def test_a_report_made_with_other_settings_says_so(page):
    made(page)
    shown = [one.value for one in page.warning]
    assert not any("other settings" in one for one in shown)
    checked(page.selectbox(key="html_protocol").set_value("reasonable").run())
    assert any("made with other settings" in one.value for one in page.warning)
    content = job_of(made(page)).path.read_text(encoding="utf-8")
    assert "Protocol reasonable:" in content
    assert not any("other settings" in one.value for one in page.warning)


def test_a_new_report_takes_the_place_of_the_one_before(page):
    before = job_of(made(page)).path
    after = job_of(made(page)).path
    assert after.exists()
    assert not before.exists()


def test_a_failure_is_told(page, monkeypatch):
    def fail(*_arguments: object, **_options: object) -> bool:
        from nvcore.errors import InputError

        raise InputError("no room on the disk")

    monkeypatch.setattr("ui.export_html.write_html_report", fail)
    made(page)
    assert [one.value for one in page.error] == ["no room on the disk"]
    assert NAME not in labels(page)


def test_a_cancelled_report_leaves_nothing(page, monkeypatch):
    def stop(*_arguments: object, **_options: object) -> bool:
        return False

    monkeypatch.setattr("ui.export_html.write_html_report", stop)
    made(page)
    assert any("cancelled" in one.value for one in page.info)
    assert not job_of(page).path.exists()


def test_with_many_frames_the_stability_map_is_made_when_asked_for(page, monkeypatch):
    assert not [one for one in page.toggle if one.key == "html_stability"]
    monkeypatch.setattr("ui.export_html.AT_ONCE", 10)
    checked(page.run())
    assert page.toggle(key="html_stability").value is False
    assert "Not computed for these 40 frames" in job_of(made(page)).path.read_text("utf-8")
    checked(page.toggle(key="html_stability").set_value(True).run())
    assert "Not computed" not in job_of(made(page)).path.read_text("utf-8")
