"""The Driver page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pytest

from nvcore.schema import DriverRegion
from pages import FRAMES, alone, begin_with, checked, texts, write


def rows(x: int, detectability: float) -> str:
    return "".join(
        f"night,{frame},{x + frame},200,40,120,{x},{detectability}\n" for frame in FRAMES
    )


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """X detects one of two pedestrians, whom the driver sees; Y both."""
    path = write(
        tmp_path,
        {
            "one": "".join(f"night,{frame},{300 + frame},200,40,120,0.9\n" for frame in FRAMES),
            "two": "".join(
                f"night,{frame},{x + frame},200,40,120,0.9\n"
                for frame in FRAMES
                for x in (300, 100)
            ),
        },
        truth="",
    )
    head = "recording,frame,x,y,w,h,track,detectability\n"
    (tmp_path / "truth.csv").write_text(head + rows(300, 0.8) + rows(100, 0.2))
    begin_with(path, monkeypatch)
    return checked(alone("driver").run())


def test_regions_and_encounters_say_who_sees_whom(page):
    regions, encounters = (table.value for table in page.dataframe)
    counts = dict(zip(regions["who"], regions["encounters"], strict=True))
    assert {who: n for who, n in counts.items() if n} == {"driver, X and Y": 1, "Y alone": 1}
    assert encounters["detectability"].tolist() == [0.2, 0.8]
    assert "Pedestrian 100 of night" in [item.value for item in page.subheader]


def test_a_region_is_chosen_and_its_encounters_are_listed(page):
    checked(page.selectbox(key="driver_region").set_value(DriverRegion.DRIVER_X_Y).run())
    assert page.dataframe[1].value["detectability"].tolist() == [0.8]
    checked(page.selectbox(key="driver_region").set_value(DriverRegion.NOBODY).run())
    assert "No pedestrian is seen so." in texts(page)


def test_without_detectability_the_page_says_how_to_get_it():
    page = checked(alone("driver").run())
    assert "is not known here" in texts(page)
    assert "nvcore driver estimate" in page.code[0].value
    assert not page.dataframe
