"""The page What changed, driven without a browser."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from inputs import drive, session_of
from streamlit.testing.v1 import AppTest

import pages
from nvcore.inputs.session import SystemSource
from pages import begin_with, checked, figures, press, tables, texts


def begin(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    *,
    version_of: str | None = "NIR",
    n_systems: int = 3,
) -> None:
    """FIR, NIR, and FIR's detections once more as NIR 2, which fix one and mend a false alarm."""
    drive(folder)
    systems = [
        SystemSource((f"{file}.csv",), name=name, version_of=of)
        for name, file, of in (
            ("FIR", "fir", None),
            ("NIR", "nir", None),
            ("NIR 2", "fir", version_of),
        )
    ]
    rules = ("newly_missed == 0", "encounters_detected_y >= 2")
    begin_with(session_of(folder, "truth.csv", *systems[:n_systems], rules=rules), monkeypatch)


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AppTest:
    """The page with NIR as the old and NIR 2 as the new version."""
    begin(tmp_path, monkeypatch)
    return press(checked(pages.opened("releases")), "releases_pair_0")


def tiles(page: AppTest) -> list[str]:
    (html,) = [item.proto.body for item in page.get("html") if "nv-counts" in item.proto.body]
    return re.findall("<span>(.*?)</span>", html)


def kinds(page: AppTest) -> list[str]:
    return tables(page)[0]["kind"].tolist()


def systems(page: AppTest) -> tuple[str | None, str | None]:
    return page.session_state["workspace"].opened.dataset.compared()


def test_the_latest_versions_are_a_click_away_and_become_x_and_y(page: AppTest):
    assert systems(page) == ("NIR", "NIR 2")
    assert [page.selectbox(key=f"releases_{which}").value for which in ("old", "new")] == [
        "NIR",
        "NIR 2",
    ]
    assert "releases_pair_0" not in [button.key for button in page.button]


def test_tiles_count_every_kind_and_the_list_has_what_changed(page: AppTest):
    assert tiles(page) == ["0", "0", "1", "1", "1"]
    assert kinds(page) == ["fixed", "gone"]
    page = checked(page.button_group(key="releases_kinds").set_value(["unchanged"]).run())
    assert kinds(page) == ["unchanged"]
    page = checked(page.button_group(key="releases_kinds").set_value(["newly false"]).run())
    assert "There is no case of this kind." in texts(page)


def test_the_first_case_is_shown_with_both_versions_and_leads_to_its_encounter(page: AppTest):
    assert "Fixed: pedestrian 1 in rural" in [header.value for header in page.header]
    old, new = (image.proto.imgs[0].url for image in page.get("image"))
    assert old != new  # NIR alone misses the pedestrian
    page = press(page, "releases_encounter")
    assert page.title[0].value == "Encounters"
    assert page.header[0].value == "Pedestrian 1 in rural"


def test_tests_of_both_versions_and_a_chart_for_each_rule_follow(page: AppTest):
    measured = pages.measures(page, "releases-tests")
    assert measured["share of encounters detected, within these recordings ↑"][:3] == (
        "50.0 %",
        "100.0 %",
        "−50.0 pp",
    )
    first, second = (of for of in figures(page) if of["layout"]["meta"][1])
    assert first["layout"]["meta"][:2] == ["Newly missed", "newly_missed == 0"]
    assert second["layout"]["meta"][0] == "Encounters detected, of 2"
    assert second["data"][0]["marker"]["symbol"] == ["x", "circle"]
    assert [shape["y0"] for of in (first, second) for shape in of["layout"]["shapes"]] == [0, 2]


def test_any_two_systems_can_be_chosen_and_the_same_name_swaps_them(page: AppTest):
    page = checked(page.selectbox(key="releases_old").set_value("FIR").run())
    assert systems(page) == ("FIR", "NIR 2")
    page = checked(page.selectbox(key="releases_new").set_value("FIR").run())
    assert systems(page) == ("NIR 2", "FIR")


def test_without_versions_the_page_is_named_among_those_that_lack_data(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    begin(tmp_path, monkeypatch, n_systems=2)
    page = checked(pages.opened("releases"))
    assert "Needs two versions of a system." in texts(page)
    assert kinds(page) == ["newly missed", "newly false"]  # of X and Y, as they are open
