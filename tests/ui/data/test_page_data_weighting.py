"""The Data page: pedestrians without distances beside systems that report them."""

from __future__ import annotations

from data_page import open_files, press, sent
from streamlit.testing.v1 import AppTest

from pages import checked, texts


def opened_by_distance() -> AppTest:
    """Two systems with distances, a truth without, and nearness by distance."""
    truth, seen = ["frame,x,y,w,h,track"], ["frame,x,y,w,h,score,distance_m"]
    for frame in range(40):
        truth.append(f"{frame},{100 + frame},100,40,120,1")
        seen.append(f"{frame},{100 + frame},100,40,120,0.{50 + frame},{40 - 0.5 * frame}")
    system = "\n".join(seen).encode()
    page = open_files(sent("\n".join(truth).encode(), ("a.csv", system), ("b.csv", system)))
    page.session_state["settings"] = {"proximity": "distance"}
    return checked(page.run())


def test_a_truth_without_distances_may_borrow_them_on_a_click() -> None:
    page = opened_by_distance()
    assert "have no distance and weigh by height" in texts(page)
    (borrow,) = [button.key for button in page.button if (button.key or "").startswith("borrow_")]
    page = press(page, borrow)
    assert page.session_state["params"].missing_distance == "borrow"
    assert "40 truth boxes borrowed a distance: 40 as a (40) and b (40) report" in texts(page)
    assert "have no distance and are weighted" not in texts(page)


def test_or_all_weigh_by_height() -> None:
    page = opened_by_distance()
    (button,) = [button for button in page.button if button.label == "Weigh by height"]
    page = checked(button.click().run())
    assert page.session_state["params"].proximity == "height"
