"""The Detection page, driven without a browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

import pages
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.metrics.detection.curve_summary import summarise_curve
from nvcore.metrics.detection.curves import detection_curve
from nvcore.settings.protocols import PROTOCOLS
from nvcore.tables.scorecard import curve_rows
from pages import part
from ui.session.state import SAMPLE
from ui.widgets.html import score_row

OWN = "own filters"
OF_SESSION = "filters of the session"
WHOLE_SAMPLE = "8,172 pedestrians in 3,000 images"


CURVES = (
    "ui.views.detection.curves.draw(RESULT, ui.views.detection.protocol.choose(RESULT.dataset))"
)


def opened() -> AppTest:
    return checked(part(CURVES).run())


def checked(page: AppTest) -> AppTest:
    assert not page.exception
    assert not page.error
    return page


def to_page(app: AppTest, name: str) -> AppTest:
    return checked(pages.to_page(app, name))


def figures(page: AppTest) -> pd.Series:
    return pd.Series({name: x for name, (x, *_) in pages.measures(page, "curve_figures").items()})


def told(page: AppTest) -> str:
    return " ".join(text.value for text in page.caption).replace("\\", "")


def filters_told(page: AppTest) -> str:
    return told(page).partition("Filters: ")[2]


def choose(page: AppTest, protocol: str) -> AppTest:
    return checked(page.selectbox(key="protocol").set_value(protocol).run())


def put(page: AppTest, **numbers: float | None) -> AppTest:
    for key, value in numbers.items():
        page.number_input(key=key).set_value(value)
    return page.run()


def test_the_table_holds_the_librarys_figures_and_a_threshold_moves_those_at_it_only():
    dataset = load(read_session(SAMPLE))
    params = dataset.params_of()
    curve = detection_curve(dataset, "FIR", params, PROTOCOLS["all"])
    summary = summarise_curve(curve, params.threshold_x)
    page = opened()
    before = figures(page)
    assert before.tolist() == [score_row(row).cells[0] for row in curve_rows(summary, summary)]
    differences = [cells[2] for cells in pages.measures(page, "curve_figures").values()]
    assert any(text.startswith("−") for text in differences)  # as wide as a plus
    assert not any("-" in text for text in differences)
    assert not page.warning
    ends = "Log-average miss rate of X: the curve ends at 0.477 false positives per image"
    assert ends in told(page)  # and does not reach the references
    assert "geometric mean" in pages.texts(page)
    page.session_state["new_params"] = {"threshold_x": 0.7}
    checked(page.run())
    after = figures(page)
    changed = before.index[before != after]
    assert len(changed) == 4
    assert all("at the threshold" in name for name in changed)


def test_a_protocol_says_what_it_leaves_out_and_own_filters_start_as_it():
    page = opened()
    before = figures(page).tolist()
    assert WHOLE_SAMPLE in told(page)
    choose(page, "reasonable")
    assert "height 50 or more px" in told(page)
    assert "ignored: 136 flagged in the ground truth, " in told(page)
    assert figures(page).tolist() != before
    filters = filters_told(choose(page, "medium"))
    assert filters_told(choose(page, OWN)) == filters
    assert page.number_input(key="own_expand").value == 1.25
    checked(put(page, own_expand=None))
    assert "detections" not in filters_told(page).partition(".")[0]


def test_lowest_above_highest_is_an_error_and_the_filters_stay():
    page = choose(opened(), OWN)
    checked(put(page, own_high=60.0))
    put(page, own_low=100.0)
    assert [error.value for error in page.error] == [
        "The lowest is above the highest: the filters stay as they were."
    ]
    assert "height 60 or less px" in told(page)
    checked(put(page, own_low=50.0))
    assert "height 50 to 60 px" in told(page)


def test_few_pedestrians_are_a_warning():
    page = checked(put(choose(opened(), OWN), own_low=250.0))
    (warning,) = page.warning
    assert "Few pedestrians: 16, a single miss changes the miss rate by" in warning.value
    assert told(page).count("nothing is missed") == 2  # of X and of Y, not again with the evidence
    assert "have pedestrians that count" in told(page)
    words = " ".join(text.value for text in page.markdown).replace("\\", "")
    assert "no interval (see below), p = 1" in words


@pytest.fixture
def sample_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], AppTest]:
    """A function: the page with the sample opened from a session file that says more."""

    def open_it(text: str) -> AppTest:
        own = SAMPLE.read_text().replace('pictures = "', f'pictures = "{SAMPLE.parent}/')
        file = tmp_path / "session.toml"
        file.write_text(own.replace('path = "', f'path = "{SAMPLE.parent}/') + text)
        pages.begin_with(file, monkeypatch)
        return part(CURVES).run()

    return open_it


@pytest.mark.parametrize(
    "filters", ["border_px = [0, 0, 0, 0]", "height_px = [50, 20000]\nexpand = 25"]
)
def test_own_filters_start_as_those_of_the_session(filters, sample_with):
    page = checked(sample_with(f"[protocol]\n{filters}\n"))
    space = page.session_state["workspace"]
    before = space.opened.session.protocol.filters
    assert before
    choose(page, OWN)
    assert page.selectbox(key="protocol").value == OWN
    assert space.opened.session.protocol.filters == before


def test_a_sessions_own_filters_can_be_changed_left_and_taken_again(sample_with):
    page = checked(sample_with('[protocol]\nname = "near"\nborder_px = [5, 10, 15, 40]\n'))
    assert page.selectbox(key="protocol").value == OF_SESSION
    border = "whole box at least 5, 10, 15, 40 px (left, top, right, bottom) inside the picture"
    assert border in told(page)
    checked(put(choose(page, OWN), own_border_top=None, own_border_right=20.0))
    assert "whole box at least 5, 0, 20, 40 px" in told(page)
    checked(put(page, own_border_left=None, own_border_right=None, own_border_bottom=None))
    assert "whole box" not in told(page)
    assert "No filter." in told(choose(page, "all"))
    page.session_state["workspace"].forget()  # as when other systems are compared
    checked(page.run())
    assert border in told(choose(page, OF_SESSION))


def test_a_tag_that_no_recording_has_is_told_and_can_be_taken_out(sample_with):
    sample_with('[protocol]\ntags = ["fog"]\n')
    page = pages.opened("detection")
    assert "no recording with frames has the tags fog" in page.error[0].value
    checked(page.multiselect(key="protocol_tags").set_value([]).run())
    assert WHOLE_SAMPLE in told(page)


def test_the_overview_uses_the_protocol():
    page = opened()
    names = page.multiselect(key="protocol_recordings").options[:2]
    checked(page.multiselect(key="protocol_recordings").set_value(names).run())
    assert "in 600 images count" in told(page)
    assert f"only recordings {names[0]}, {names[1]}" in told(page)
    evidence = (
        "ui.views.overview.evidence.draw(RESULT, ui.session.results.measure_evidence(RESULT))"
    )
    overview = checked(part(evidence, space=pages.space_of(page)).run())
    labels = [label.partition("[")[0] for label in pages.measures(overview, "evidence")]
    assert "log-average miss rate, all, 2 recordings ↓" in labels


def test_the_protocol_is_there_when_one_comes_back():
    page = checked(put(choose(checked(pages.opened("detection")), OWN), own_low=100.0))
    to_page(page, "metrics")
    assert to_page(page, "detection").selectbox(key="protocol").value == OWN
    assert "height 100 or more px" in told(page)


@pytest.mark.parametrize(("clicked", "threshold"), [(0.7, 0.7), (None, 0.5)])
def test_a_click_sets_the_threshold_where_there_is_a_score(clicked, threshold, monkeypatch):
    page = opened()
    clicks = [["x", clicked]]
    monkeypatch.setattr(
        "ui.views.detection.curves.clicked_chart", lambda *_, **__: clicks.pop() if clicks else None
    )
    checked(page.run())
    assert not clicks
    assert page.session_state["params"].threshold_x == threshold


def test_windows_are_counted_or_given():
    page = opened()
    checked(page.button_group(key="curve_kind").set_value("roc_windows").run())
    # 640 x 480, scale 1: ((640 - 32) / 4 + 1) * ((480 - 64) / 4 + 1) windows
    for scales, why in (
        ("1, 1, 1", ""),
        ("many", "three numbers"),
        ("2, 1, 0.1", "the first scale must be above 0, the last at least as large"),
        ("1, 2, 0.001", "more than 200 scales"),
    ):
        checked(page.text_input(key="window_scales").set_value(scales).run())
        assert why in " ".join(text.value for text in page.warning).replace("\\", "")
        assert (f"{153 * 105:,} windows per image" in told(page)) is (not why)
    checked(page.text_input(key="window_scales").set_value("1, 1, 1").run())
    checked(page.number_input(key="window_Width (px)").set_value(700).run())
    assert "No window of 700 x 64 px has a place to slide in" in page.warning[0].value
    assert "0 windows" not in told(page)
    checked(page.number_input(key="windows_given").set_value(1000).run())
    assert not page.warning
