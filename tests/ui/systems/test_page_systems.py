"""The Systems page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

import pages
from pages import FRAMES, begin_with, checked, press, rows, texts, to_page, write
from ui.views.systems import matrix


def detections(n_frames: int, *, score: float = 0.9) -> str:
    return "".join(
        f"night,{frame},{300 + frame},200,40,120,{score}\n" for frame in FRAMES[:n_frames]
    )


SYSTEMS = {"all": detections(30), "few": detections(3), "two thirds": detections(20, score=0.6)}


@pytest.fixture
def three(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A session of three systems, of which two detect the only pedestrian."""
    path = write(tmp_path, SYSTEMS, truth=rows(300))
    begin_with(path, monkeypatch)
    return path


def opened() -> AppTest:
    return checked(pages.opened("systems"))


def systems(page: AppTest) -> tuple[str, str]:
    x, y = page.session_state["workspace"].opened.dataset.compared()
    return x, y


def test_every_pair_stands_in_words_and_in_both_tables(three: Path):
    page = opened()
    names = ["all – few", "all – two thirds", "few – two thirds"]
    assert [page.button(key=f"pair_{number}").label for number in range(3)] == names
    assert texts(page).count("Nothing is claimed: 6 recordings are needed for a p.") == 3
    detected = pages.measures(page, "pairs-detected")
    assert [label.partition("[")[0] for label in detected] == names
    first = next(iter(detected.values()))
    assert first[:3] == ("100.0 %", "0.0 %", "+100.0 pp")
    assert first[4:] == ("–", "–")  # all at like operating points: no column says so
    similarity = pages.measures(page, "pairs-similarity")
    assert next(iter(similarity.values()))[0] == "1.0000"
    by_system = pages.measures(page, "systems")
    assert by_system["all"][1:3] == ("0", "100.0 %")
    assert list(by_system) == list(SYSTEMS)


def test_a_pair_opens_as_x_and_y_on_the_overview_and_the_numbers_stay(
    three: Path, monkeypatch: pytest.MonkeyPatch
):
    page = opened()
    before = pages.measures(page, "pairs-similarity")
    page = press(page, "pair_2")
    assert page.title[0].value == "Overview"
    assert systems(page) == ("few", "two thirds")
    assert ("".join(page.query_params["x"]), "".join(page.query_params["y"])) == (
        "few",
        "two thirds",
    )

    def compute(*_: object) -> None:
        raise AssertionError("the pairs were computed already")

    monkeypatch.setattr(matrix, "_compute", compute)
    page = checked(to_page(page, "systems"))
    assert pages.measures(page, "pairs-similarity") == before
    assert "few – two thirds" in page.button(key="pair_2").label
    assert sum("now X and Y" in item.value for item in page.markdown) == 1


def test_the_pair_that_is_open_keeps_its_order(three: Path):
    page = opened()
    page = press(page, "sidebar_swap")
    assert systems(page) == ("few", "all")
    page = press(page, "pair_0")
    assert page.title[0].value == "Overview"
    assert systems(page) == ("few", "all")


def test_a_threshold_of_the_sidebar_is_that_of_its_system(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    mixed = detections(10) + "".join(
        line.replace(",0.9", ",0.4") for line in detections(30).splitlines(keepends=True)[10:]
    )
    begin_with(write(tmp_path, {**SYSTEMS, "all": mixed}, truth=rows(300)), monkeypatch)
    page = opened()
    assert pages.measures(page, "systems")["all"][0] == "all scores"
    assert pages.measures(page, "systems")["all"][2] == "100.0 %"
    page = checked(page.slider(key="threshold_x").set_value(0.5).run())
    assert pages.measures(page, "systems")["all"][0] == "0.5"
    assert pages.measures(page, "systems")["all"][2] == "0.0 %"


def test_what_takes_long_is_computed_when_asked_for(three: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(matrix, "AT_ONCE", 0)
    page = opened()
    assert page.button(key="matrix_start").label == "Compare all 3 pairs"
    assert "Who is better in what" not in texts(page)
    page = press(page, "matrix_start")
    page.session_state["workspace"].job("matrix").join()
    page = checked(page.run())
    assert "Who is better in what" in texts(page)


def test_two_systems_are_one_pair_which_the_overview_compares(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    two = {name: SYSTEMS[name] for name in ("all", "few")}
    begin_with(write(tmp_path, two, truth=rows(300)), monkeypatch)
    page = opened()
    assert "There is one pair, all and few: the Overview compares it." in texts(page)
    assert "Needs a third system." in texts(page)  # in the navigation, too
    assert press(page, "add_system").title[0].value == "Data"
