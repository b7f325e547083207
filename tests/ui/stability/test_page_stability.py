"""The Stability page, driven without a browser."""

from __future__ import annotations

import pytest
from inputs import write
from streamlit.testing.v1 import AppTest

from pages import begin_with, part, session, tables
from ui.jobs.background import JobState
from ui.session import sample
from ui.views.stability import survey, verdict_map


@pytest.fixture(autouse=True)
def no_survey(monkeypatch: pytest.MonkeyPatch) -> None:
    """The table of all maps is not made where it is not asked for, nor known from other tests."""
    monkeypatch.setattr(survey, "AT_ONCE", 0)
    for shared in sample._samples.values():
        for kind in [kind for kind in shared._caches if kind.startswith(survey.RUN.name)]:
            del shared._caches[kind]


MAP = "ui.views.stability.verdict_map.draw(RESULT)"


def opened(*calls: str) -> AppTest:
    return checked(part(*(calls or [MAP])).run())


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    assert not page.error
    return page


def words(page: AppTest) -> str:
    return " ".join(text.value for text in page.markdown).replace("\\", "")


def choose(page: AppTest, plane: str, criterion: str) -> AppTest:
    page.button_group(key="stability_plane").set_value(plane)
    return checked(page.button_group(key="stability_criterion").set_value(criterion).run())


def test_the_map_of_the_sample_is_told_for_each_choice_and_setting():
    page = opened()
    assert "As analysed, X has the higher mean similarity, by 0.0189." in words(page)
    assert "range: misses against false alarms (alpha) 0.5 to 1" in words(page)
    p = "p = 0.47; 0.77 after correction for all measures"
    assert f"not shown to be more than chance (10 recordings, {p})" in words(page)
    for plane, criterion, who in (
        ("thresholds", "encounters", "X detects 3 encounters more"),
        ("matching", "encounters", "X detects 3 encounters more"),
        ("edge-weight-alpha", "saliency", "X has the lower saliency"),
        ("pairing-alpha", "similarity", "X has the higher mean similarity"),
        ("saliency-rule", "saliency", "X has the lower saliency"),
    ):
        assert f"As analysed, {who}" in words(choose(page, plane, criterion))
    choose(page, "alpha-midpoint", "similarity")
    page.session_state["new_params"] = {"midpoint": 120.0}
    checked(page.run())
    assert "As analysed, Y has the higher mean similarity" in words(page)


def test_that_the_difference_may_be_chance_is_said_without_unfolding_anything():
    page = opened()
    (more,) = page.main.expander
    folded = " ".join(text.value for text in more.markdown)
    assert "more than chance" in words(page)
    assert "more than chance" not in folded


def test_unequal_operating_points_are_told_as_on_the_other_pages():
    page = opened("ui.shell.messages.draw_operating_point(RESULT)", MAP)
    assert "equal false alarms (" not in words(page)
    page.session_state["new_params"] = {"threshold_y": 0.2}
    checked(page.run())
    assert "At equal false alarms, not as set (Y at a confidence threshold of" in words(page)
    checked(page.button_group(key="operating_point").set_value("as-set").run())
    assert "As set, at unequal operating points" in words(page)
    assert "Nothing is claimed from these" in words(page)


def test_single_frames_are_not_tested_as_if_they_were_persons(tmp_path, monkeypatch):
    frames = session(tmp_path, "fir.csv", "nir.csv")
    # apart, as ids that occur once each are linked by overlap
    rows = [f"urban,{f},{100 * (f % 4)},200,40,100" for f in range(20)]
    numbered = (f"{row},{track}" for track, row in enumerate(rows))
    write(tmp_path / "truth.csv", "recording,frame,x,y,w,h,track", *numbered)
    for name, detected in (("fir", rows), ("nir", rows[:1])):
        scored = (f"{row},0.9" for row in detected)
        write(tmp_path / f"{name}.csv", "recording,frame,x,y,w,h,score", *scored)
    begin_with(frames, monkeypatch)
    page = opened()
    checked(page.button_group(key="stability_criterion").set_value("encounters").run())
    assert "As analysed, X detects 19 encounters more." in words(page)
    assert "It cannot be tested here whether this difference is more than chance" in words(page)


def test_the_table_of_many_frames_is_made_on_a_wish():
    page = opened("ui.views.stability.survey.draw(RESULT)")
    assert not tables(page)
    checked(page.button(key="stability_survey_start").click().run())
    job = page.session_state["workspace"].job(survey.RUN.name)
    job.join()
    assert job.state is JobState.DONE
    table = tables(checked(page.run()))[0].set_index("What is varied")
    expected = [f"X better in {share} % of the range" for share in (64, 70, 61)]
    assert table.loc["Both thresholds"].tolist() == expected


def test_a_large_map_is_made_on_a_wish_and_then_known(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(verdict_map, "AT_ONCE", 0)
    monkeypatch.setattr(sample, "_samples", type(sample._samples)())  # nobody has made one before
    page = opened()
    assert "As analysed" not in words(page)
    checked(page.button(key="stability_start").click().run())
    job = page.session_state["workspace"].job(verdict_map.RUN.name)
    job.join()
    assert job.state is JobState.DONE
    assert "As analysed, X has the higher" in words(checked(page.run()))
    for criterion in ("encounters", "similarity"):
        checked(page.button_group(key="stability_criterion").set_value(criterion).run())
    assert "As analysed, X has the higher" in words(page)
