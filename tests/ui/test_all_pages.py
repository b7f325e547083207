"""Every page in every situation: nothing breaks, and what is missing is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import ROOT
from streamlit.testing.v1 import AppTest

from pages import FRAMES, rows, write
from ui.session import state

PAGES = [
    *("data", "overview", "timeline", "encounters", "saliency", "detection", "stability"),
    *("ratings", "export", "metrics"),
]


def detections(x: int) -> str:
    return "".join(f"night,{frame},{x + frame},200,40,120,0.{frame % 9}\n" for frame in FRAMES)


def situation(name: str, folder: Path) -> Path:
    truth = rows(300)
    if name == "sample":
        return state.SAMPLE
    if name == "one system":
        return write(folder, {"only": detections(300)}, truth=truth)
    if name == "no pictures":
        return write(folder, {"one": detections(300), "two": detections(310)}, truth=truth)
    if name == "nobody detected":
        return write(folder, {"one": "", "two": detections(300)}, truth=truth)
    # five frames off, and boxes of no area
    late = detections(300).replace("night,", "night,1", 5) + "night,3,1,1,0,0,0.5\n"
    return write(folder, {"one": late, "two": detections(300)}, truth=truth)


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize(
    "name", ["sample", "one system", "no pictures", "nobody detected", "audit errors"]
)
def test_a_page_shows_what_there_is(
    page: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(state, "SAMPLE", situation(name, tmp_path))
    app = AppTest.from_file(str(ROOT / "ui" / "main.py"), default_timeout=90).run()
    app.switch_page(str(ROOT / "pages" / f"{page}.py")).run()
    assert not app.exception
    assert app.title
    shown = " ".join(one.value for one in [*app.info, *app.error, *app.warning])
    assert "fault of the program" not in shown
    if name == "one system" and page in ("overview", "timeline"):
        assert "A comparison needs two" in shown
    if name in ("nobody detected", "audit errors") and page == "overview":
        assert "depends on what the audit found" in shown


@pytest.mark.parametrize("page", ["encounters", "saliency"])
def test_frames_that_pass_for_encounters_are_told_where_the_figures_are(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    single = "".join(rows(300, track=frame).splitlines(keepends=True)[frame] for frame in FRAMES)
    session = write(tmp_path, {"one": detections(300), "two": detections(310)}, truth=single)
    monkeypatch.setattr(state, "SAMPLE", session)
    app = AppTest.from_file(str(ROOT / "ui" / "main.py"), default_timeout=90).run()
    app.switch_page(str(ROOT / "pages" / f"{page}.py")).run()
    assert not app.exception
    assert any("one frame long" in one.value for one in app.warning)
