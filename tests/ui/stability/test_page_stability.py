"""The Stability page, driven without a browser."""

from __future__ import annotations

import threading

import pytest
from inputs import write
from streamlit.testing.v1 import AppTest

import pages
from pages import TIMEOUT_S, begin_with, session
from ui.jobs.background import JobState
from ui.stability import survey, verdict_map


def opened() -> AppTest:
    return checked(pages.opened("stability"))


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    assert not page.error
    return page


def words(page: AppTest) -> str:
    return " ".join(one.value for one in page.markdown).replace("\\", "")


def test_the_map_says_how_far_the_verdict_holds():
    shown = words(opened())
    assert "As analysed, X has the higher mean similarity, by 0.0059." in shown
    assert "range: misses against false alarms (alpha) 0.5 to 1 (a miss counts at least" in shown
    assert (
        "and counts half at (midpoint) 28.8 to 72 px (6 to 15 % of the picture's height, from the"
        in shown
    )


def test_a_difference_that_may_be_chance_is_told_to():
    shown = words(opened())
    assert "This difference is not shown to be more than chance (p = 1, corrected for" in shown
    assert "is no evidence against chance" in shown


def test_single_frames_are_not_tested_as_if_they_were_persons(tmp_path, monkeypatch):
    frames = session(tmp_path, "fir.csv", "nir.csv")
    rows = [f"urban,{f},100,200,40,100" for f in range(20)]
    numbered = (f"{row},{track}" for track, row in enumerate(rows))
    write(tmp_path / "truth.csv", "recording,frame,x,y,w,h,track", *numbered)
    for name, found in (("fir", rows), ("nir", rows[:1])):
        scored = (f"{row},0.9" for row in found)
        write(tmp_path / f"{name}.csv", "recording,frame,x,y,w,h,score", *scored)
    begin_with(frames, monkeypatch)
    page = opened()
    checked(page.button_group(key="stability_criterion").set_value("encounters").run())
    assert "As analysed, X detects more encounters, by 19 encounters." in words(page)
    chance = page.markdown[1].value
    assert "corrected for all figures tested; by 10 blocks of time" in chance.replace("\\", "")


def test_all_maps_stand_in_one_table():
    table = opened().dataframe[0].value.set_index("What is varied")
    assert table.loc["Both thresholds"].tolist() == [
        "X better, in 51 %", "X better, in 70 %", "Y better, in 89 %",
    ]  # fmt: skip
    assert table.loc["Traffic context and alpha", "by encounters detected"] == (
        "X better, does not depend on them"
    )


def test_the_table_of_many_frames_is_made_on_a_wish(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(survey, "AT_ONCE", 0)
    page = opened()
    assert not page.dataframe
    checked(page.button(key="stability_survey_start").click().run())
    job = page.session_state["workspace"].job(survey.JOB)
    job.join()
    assert job.state is JobState.DONE
    table = checked(page.run()).dataframe[0].value
    assert "X better, in 51 %" in table["by mean similarity"].tolist()


def test_what_the_audit_warns_of_stands_above_the_map(tmp_path, monkeypatch: pytest.MonkeyPatch):
    assert not opened().warning
    two_floors = session(tmp_path, "fir.csv", "nir.csv")
    rows = [f"urban,{f},{10 * x},0,10,50" for f in range(20) for x in range(3)]
    for name, floor in (("fir", 0.01), ("nir", 0.5)):
        scores = (f"{row},{min(0.99, floor + i / 200):.3f}" for i, row in enumerate(rows))
        write(tmp_path / f"{name}.csv", "recording,frame,x,y,w,h,score", *scores)
    begin_with(two_floors, monkeypatch)
    told = [one.value.replace("\\", "") for one in opened().warning]
    assert any("X and Y are compared at different operating points" in one for one in told)


def test_another_setting_gives_another_map():
    page = opened()
    checked(page.slider(key="midpoint").set_value(100.0).run())
    assert "As analysed, Y has the higher mean similarity" in words(page)


@pytest.mark.parametrize(
    ("plane", "criterion", "told"),
    [
        ("thresholds", "encounters", "X detects more encounters"),
        ("matching", "encounters", "X detects more encounters"),
        ("edge-weight-alpha", "saliency", "Y has the lower saliency"),
    ],
)
def test_each_map_and_criterion_is_told(plane: str, criterion: str, told: str):
    page = opened()
    page.button_group(key="stability_plane").set_value(plane)
    checked(page.button_group(key="stability_criterion").set_value(criterion).run())
    assert f"As analysed, {told}" in words(page)


def test_a_large_map_is_made_on_a_wish_and_then_known(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(verdict_map, "AT_ONCE", 0)
    page = opened()
    assert "As analysed" not in words(page)
    checked(page.button(key="stability_start").click().run())
    job = page.session_state["workspace"].job(verdict_map.JOB)
    job.join()
    assert job.state is JobState.DONE
    assert "As analysed, X has the higher" in words(checked(page.run()))
    checked(page.button_group(key="stability_criterion").set_value("encounters").run())
    checked(page.button_group(key="stability_criterion").set_value("similarity").run())
    assert "As analysed, X has the higher" in words(page)


def test_a_map_can_be_cancelled(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(verdict_map, "AT_ONCE", 0)
    is_started, may_go_on = threading.Event(), threading.Event()
    real = verdict_map.map_stability

    def waits(*of, **more):
        is_started.set()
        assert may_go_on.wait(TIMEOUT_S)
        return real(*of, **more)

    monkeypatch.setattr(verdict_map, "map_stability", waits)
    page = opened()
    checked(page.button(key="stability_start").click().run())
    assert is_started.wait(TIMEOUT_S)
    checked(page.button(key="stability_cancel").click().run())
    may_go_on.set()
    job = page.session_state["workspace"].job(verdict_map.JOB)
    job.join()
    assert job.state is JobState.CANCELLED
    assert [one.value for one in checked(page.run()).info] == ["Cancelled. No map was made."]
