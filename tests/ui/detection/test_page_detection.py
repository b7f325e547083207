"""The Detection page, driven without a browser."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

import pages
from nvcore.detection.curve_summary import summarise_curve
from nvcore.detection.curves import detection_curve
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.protocols import PROTOCOLS
from nvcore.tables.scorecard import curve_rows
from ui.session.state import SAMPLE


def opened() -> AppTest:
    return checked(pages.opened("detection"))


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    assert not page.error
    return page


def figures(page: AppTest) -> pd.DataFrame:
    return page.dataframe[0].value


def captions(page: AppTest) -> str:
    return " ".join(one.value for one in page.caption)


def test_the_table_holds_the_librarys_figures():
    dataset = load(read_session(SAMPLE))
    params = dataset.params_of()
    curve = detection_curve(dataset, "FIR", params, PROTOCOLS["all"])
    summary = summarise_curve(curve, params.threshold_x)
    expected = [format(row.x, row.form) for row in curve_rows(summary, summary)]
    assert figures(opened())["X"].tolist() == expected


def test_a_protocol_says_what_it_leaves_out_and_changes_the_figures():
    page = opened()
    before = figures(page)["X"].tolist()
    assert "8,172 pedestrians in 3,000 images" in captions(page)
    checked(page.selectbox(key="protocol").set_value("reasonable").run())
    assert "height 50 or more px" in captions(page).replace("\\", "")
    assert "ignored: flagged in the ground truth 136, height" in captions(page)
    assert figures(page)["X"].tolist() != before


def test_own_filters_are_taken():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    assert "8,172 pedestrians" in captions(page)
    checked(page.number_input(key="own_low").set_value(100.0).run())
    assert "height 100 or more px" in captions(page).replace("\\", "")
    assert "8,172 pedestrians" not in captions(page)


def test_lowest_above_highest_is_an_error_and_the_filters_stay():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    checked(page.number_input(key="own_high").set_value(60.0).run())
    page.number_input(key="own_low").set_value(100.0).run()
    assert [one.value for one in page.error] == [
        "The lowest is above the highest: the filters stay as they were."
    ]
    assert "height 60 or less px" in told(page)
    checked(page.number_input(key="own_low").set_value(50.0).run())
    assert "height 50 to 60 px" in told(page)


def test_own_filters_start_as_the_protocol_chosen_before():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("medium").run())
    before = told(page).partition("Filters: ")[2]
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    assert told(page).partition("Filters: ")[2] == before
    assert page.number_input(key="own_expand").value == 1.25
    checked(page.number_input(key="own_expand").set_value(None).run())
    assert "detections" not in told(page).partition("Filters: ")[2].partition(".")[0]


@pytest.mark.parametrize(
    "filters",
    [
        "border_px = [5, 10, 15, 40]",
        "border_px = [0, 0, 0, 0]",
        "height_px = [50, 20000]\nexpand = 25",
        "aspect = [0.5, 30]",
    ],
)
def test_own_filters_start_as_those_of_the_session(filters, sample_with):
    page = checked(sample_with(f"[protocol]\n{filters}\n"))
    space = page.session_state["workspace"]
    before = space.opened.session.protocol.filters
    assert before
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    assert page.selectbox(key="protocol").value == "own filters"
    assert space.opened.session.protocol.filters == before


def test_the_sessions_filters_can_be_taken_again_after_other_systems_are_compared(sample_with):
    page = checked(sample_with("[protocol]\nheight_px = [77, 200]\n"))
    checked(page.selectbox(key="protocol").set_value("all").run())
    page.session_state["workspace"].forget()
    checked(page.run())
    checked(page.selectbox(key="protocol").set_value("filters of the session").run())
    assert "height 77 to 200 px" in told(page)


def test_each_of_four_margins_can_be_changed(sample_with):
    page = checked(sample_with("[protocol]\nborder_px = [5, 10, 15, 40]\n"))
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    checked(page.number_input(key="own_border_top").set_value(None).run())
    checked(page.number_input(key="own_border_right").set_value(20.0).run())
    assert "whole box at least 5, 0, 20, 40 px (left, top, right, bottom)" in told(page)
    for side in ("left", "right", "bottom"):
        checked(page.number_input(key=f"own_border_{side}").set_value(None).run())
    assert "whole box" not in told(page)


def test_own_filters_stay_when_one_comes_back():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    checked(page.number_input(key="own_low").set_value(100.0).run())
    to_page(page, "overview")
    assert "height 100 or more px" in told(to_page(page, "detection"))


def test_recordings_are_chosen_by_name():
    page = opened()
    names = page.multiselect(key="protocol_recordings").options
    checked(page.multiselect(key="protocol_recordings").set_value(names[:2]).run())
    assert "in 600 images count" in captions(page)
    assert f"only recordings {names[0]}, {names[1]}" in told(page)
    assert "log-average miss rate, all, 2 recordings ↓" in evidence_labels(
        to_page(page, "overview")
    )


def test_what_does_not_reach_the_references_is_told():
    told_of = told(opened())
    assert "Log-average miss rate of X: the curve ends at 0.477 false positives per image" in (
        told_of
    )
    assert "geometric mean" in told_of


@pytest.mark.parametrize(("clicked", "threshold"), [(0.7, 0.7), (None, 0.5)])
def test_a_click_sets_the_threshold_where_there_is_a_score(clicked, threshold, monkeypatch):
    page = opened()
    points = {"selection": {"points": [{"curve_number": 4, "customdata": ["x", clicked]}]}}
    monkeypatch.setattr("ui.detection.curves.st.plotly_chart", lambda *_, **__: points)
    monkeypatch.setattr("ui.widgets.charts.is_new_click", once := Once())
    checked(page.run())
    assert once.is_asked
    assert page.slider(key="threshold_x").value == threshold


class Once:
    """The first click is new, the same one on the next run is not."""

    is_asked = False

    def __call__(self, *_: object) -> bool:
        is_new, self.is_asked = not self.is_asked, True
        return is_new


def test_few_pedestrians_are_a_warning():
    page = opened()
    assert not page.warning
    checked(page.selectbox(key="protocol").set_value("own filters").run())
    checked(page.number_input(key="own_low").set_value(250.0).run())
    assert page.warning[0].value == (
        "Few pedestrians: 16, a single miss changes the miss rate by 6.2 percentage points."
    )
    said = told(page)
    assert "Log-average miss rate of X: nobody is missed at any of the 9 references." in said
    assert said.count("nobody is missed") == 2  # of X and of Y, not again with the evidence
    assert "have pedestrians that count" in said
    assert "no interval (see below), p = 1" in page.markdown[-1].value.replace("\\", "")


def told(page: AppTest) -> str:
    return captions(page).replace("\\", "")


def test_windows_are_counted_or_given():
    page = opened()
    checked(page.button_group(key="curve_kind").set_value("roc_windows").run())
    # 640 x 480, scale 1: ((640 - 32) / 4 + 1) * ((480 - 64) / 4 + 1) windows
    checked(page.text_input(key="window_scales").set_value("1, 1, 1").run())
    assert f"{153 * 105:,} windows per image" in captions(page)
    checked(page.text_input(key="window_scales").set_value("many").run())
    assert "three numbers" in page.warning[0].value
    checked(page.text_input(key="window_scales").set_value("2, 1, 0.1").run())
    assert "the first scale must be above 0, the last at least as large" in (
        page.warning[0].value.replace("\\", "")
    )
    checked(page.text_input(key="window_scales").set_value("1, 2, 0.001").run())
    assert "more than 200 scales" in page.warning[0].value
    checked(page.number_input(key="windows_given").set_value(1000).run())
    assert not page.warning


def test_a_window_larger_than_the_picture_is_told():
    page = opened()
    checked(page.button_group(key="curve_kind").set_value("roc_windows").run())
    checked(page.number_input(key="window_Width (px)").set_value(700).run())
    assert page.warning[0].value == (
        "No window of 700 x 64 px has a place to slide in: the largest picture is 640 x 480 px."
    )
    assert "0 windows" not in captions(page)


def test_the_threshold_moves_the_figures_at_it_and_not_the_curve():
    page = opened()
    before = figures(page).set_index("figure")["X"]
    checked(page.slider(key="threshold_x").set_value(0.7).run())
    after = figures(page).set_index("figure")["X"]
    changed = before.index[before != after]
    assert len(changed) == 4
    assert all("at the threshold" in name for name in changed)


def to_page(app: AppTest, name: str) -> AppTest:
    return checked(pages.to_page(app, name))


def evidence_labels(page: AppTest) -> list[str]:
    table = next(one.value for one in page.dataframe if "p (Holm)" in one.value.columns)
    return table["figure"].tolist()


def test_the_overview_uses_the_protocol_that_was_chosen_here():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("near").run())
    assert "log-average miss rate, near ↓" in evidence_labels(to_page(page, "overview"))


def test_the_protocol_stays_chosen_when_one_comes_back():
    page = opened()
    checked(page.selectbox(key="protocol").set_value("far").run())
    to_page(page, "overview")
    assert to_page(page, "detection").selectbox(key="protocol").value == "far"


@pytest.fixture
def sample_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A function: the page with the sample opened from a session file that says more."""

    def open_it(text: str) -> AppTest:
        own = SAMPLE.read_text().replace('pictures = "', f'pictures = "{SAMPLE.parent}/')
        file = tmp_path / "session.toml"
        file.write_text(own.replace('path = "', f'path = "{SAMPLE.parent}/') + text)
        pages.begin_with(file, monkeypatch)
        return pages.opened("detection")

    return open_it


def test_a_sessions_own_filters_can_be_left_and_taken_again(sample_with):
    page = checked(sample_with('[protocol]\nname = "near"\nborder_px = [1, 2, 3, 4]\n'))
    assert page.selectbox(key="protocol").value == "filters of the session"
    told = "whole box at least 1, 2, 3, 4 px (left, top, right, bottom) inside the picture"
    assert told in captions(page).replace("\\", "")
    checked(page.selectbox(key="protocol").set_value("all").run())
    assert "No filter." in captions(page).replace("\\", "")
    checked(page.selectbox(key="protocol").set_value("filters of the session").run())
    assert told in captions(page).replace("\\", "")


def test_a_tag_that_no_recording_has_is_told_and_can_be_taken_out(sample_with):
    page = sample_with('[protocol]\ntags = ["fog"]\n')
    assert "no recording with frames has the tags fog" in page.error[0].value
    checked(page.multiselect(key="protocol_tags").set_value([]).run())
    assert "8,172 pedestrians in 3,000 images" in captions(page)
