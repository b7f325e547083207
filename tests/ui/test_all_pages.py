"""Every page in every situation: nothing breaks, and what is missing is said."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from places import ROOT
from streamlit.testing.v1 import AppTest

from pages import FRAMES, begin_with, checked, opened, rows, to_page, write
from ui.shell.pages import PAGE_OF

PAGES = list(PAGE_OF)


def detections(x: int) -> str:
    return "".join(f"night,{frame},{x + frame},200,40,120,0.{frame % 9}\n" for frame in FRAMES)


def situation(name: str, folder: Path) -> Path:
    truth = rows(300)
    if name == "one system":
        return write(folder, {"only": detections(300)}, truth=truth)
    if name == "nobody detected":
        return write(folder, {"one": "", "two": detections(300)}, truth=truth)
    if name == "frames pass for encounters":
        # apart, as ids that occur once each are linked by overlap
        single = "".join(
            rows(100 + 120 * (frame % 4), track=frame).splitlines(keepends=True)[frame]
            for frame in FRAMES
        )
        return write(folder, {"one": detections(300), "two": detections(310)}, truth=single)
    # five frames off, and boxes of no area
    late = detections(300).replace("night,", "night,1", 5) + "night,3,1,1,0,0,0.5\n"
    return write(folder, {"one": late, "two": detections(300)}, truth=truth)


SITUATIONS = [
    *("sample", "one system", "nobody detected", "audit errors", "frames pass for encounters")
]
"""All but the sample have no pictures."""


@pytest.fixture(scope="module", params=SITUATIONS)
def app(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[str, AppTest]]:
    """One visit in each situation, which goes from page to page."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param != "sample":
            folder = tmp_path_factory.mktemp("situation")
            begin_with(situation(request.param, folder), patch)
        yield request.param, opened()


@pytest.mark.parametrize("script", ["ui/main.py", *(f"pages/{page}.py" for page in PAGES)])
def test_a_script_prints_no_string_by_the_way(script: str):
    """Streamlit shows the value of every statement of its scripts but their docstring."""
    _, *statements = ast.parse((ROOT / script).read_text()).body
    values = [line.value for line in statements if isinstance(line, ast.Expr)]
    assert [value.lineno for value in values if not isinstance(value, ast.Call)] == []


@pytest.mark.parametrize("page", PAGES)
def test_a_page_shows_what_there_is(page: str, app: tuple[str, AppTest]):
    name, visit = app
    checked(to_page(visit, page))
    assert visit.title
    shown = " ".join(item.value for item in [*visit.info, *visit.error, *visit.warning])
    assert "fault of the program" not in shown
    if name == "one system" and page in ("overview", "timeline"):
        assert "A comparison needs two" in shown
    if name == "one system" and page in ("encounters", "saliency"):
        assert "Only one system is open" in shown
    if name in ("nobody detected", "audit errors") and page == "overview":
        assert any("depends on what the audit found" in item.value for item in visit.markdown)
        captions = [item.value for item in visit.caption]
        assert any(words.startswith("X is ") for words in captions)  # what the tiles are of, too
        assert not any("Bars: " in words for words in captions)
    if name == "sample" and page == "export":
        assert visit.header[0].value == "Link"
    if name == "frames pass for encounters" and page in ("encounters", "saliency"):
        assert "one frame long" in shown
