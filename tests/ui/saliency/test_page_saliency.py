"""The Saliency page, driven without a browser."""

from __future__ import annotations

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from pages import begin_with, checked, part, session, shown, tables, texts
from ui.views.saliency import events, figures

NUMBERS = (
    "st.caption(ui.views.saliency.figures.what_it_is(state.params()))",
    "ui.views.saliency.figures.draw_numbers(RESULT)",
)
EVENTS = (
    "ui.views.saliency.events.open_asked()",
    "ui.views.saliency.figures.draw_recordings(RESULT)",
    "ui.views.saliency.events.draw_table(RESULT, ui.views.saliency.events.choose_recording())",
)


def opened() -> AppTest:
    return checked(part(*NUMBERS, *EVENTS).run())


def listed(page: AppTest) -> pd.DataFrame:
    return tables(page)[0]


def test_the_number_of_each_system_is_taken_apart_and_its_events_are_listed():
    page = opened()
    assert [metric.value for metric in page.metric] == ["1.43 s", "1.91 s"]
    assert "5.00 s × 0.76 = 3.81 s" in texts(page)
    assert "pedestrian 2 in winter_frost, missed 5.0 s, late in the recording" in texts(page)
    table = listed(page)
    result = page.session_state["workspace"].result
    n_x, n_y = (len(system.events) for system in (result.x, result.y))
    assert len(table) == n_x + n_y
    assert set(table["system"]) == {"X", "Y"}
    assert table["saliency_s"].is_monotonic_decreasing
    page.button_group[0].set_value("Y")
    assert len(listed(checked(page.run()))) == n_y


def test_the_page_says_what_saliency_is_with_the_settings_at_hand():
    page = opened()
    assert "missing both can have a lower saliency than missing one" in texts(page)
    assert "share that has passed of the recording" in texts(page)
    assert "tau" in tables(page)[0]
    page.session_state["new_params"] = {
        "recency_unit": "seconds", "saliency_weight": "risk", "saliency_of": "each",
    }  # fmt: skip
    checked(page.run())
    assert "missing both can come out" not in texts(page)
    assert "one pedestrian is missed by more than the tolerance" in texts(page)
    assert "by its weighted distance, summed over time, times its" in texts(page)
    assert "seconds left of the recording" in texts(page)
    order = tables(page)[0]
    assert {"weight_s", "rest_s"} <= set(order)
    assert "tau" not in order


def test_a_click_on_a_recording_leaves_its_events_only():
    page = opened()
    page.session_state["saliency_wanted"] = 0
    table = listed(checked(page.run()))
    assert set(table["recording"]) == {"urban_crossing"}
    (chosen,) = [box for box in page.selectbox if box.label == "Recording"]
    assert chosen.value == "urban_crossing"


def test_a_chosen_recording_stays_where_tags_leave_it_and_goes_where_they_do_not():
    page = checked(part("ui.shell.recordings_filter.draw()", *EVENTS).run())
    (choice,) = [item for item in page.selectbox if item.label == "Recording"]
    page = checked(choice.set_value("rural_child").run())
    for tag, left in (("rural", {"rural_child"}), ("winter", {"winter_frost"})):
        checked(shown(page, "multiselect", "tags_chosen").set_value([tag]).run())
        assert left <= set(listed(page)["recording"])
    (choice,) = [item for item in page.selectbox if item.label == "Recording"]
    assert choice.value is None


def test_the_first_row_of_every_listed_event_is_known():
    page = opened()
    result = page.session_state["workspace"].result
    shown_events, first_row = events._events(result, 3, "y")
    frames = result.dataset.frames.iloc[first_row]
    assert frames["frame"].tolist() == shown_events["first_frame"].tolist()
    assert set(frames["recording"]) == {3}


def test_an_event_opens_by_a_click_and_the_most_salient_one_by_a_button(
    monkeypatch: pytest.MonkeyPatch,
):
    rows: list[int] = []
    for module in (events, figures):
        monkeypatch.setattr(module, "open_row", rows.append)
    page = opened()
    page.session_state["saliency_open"] = 123
    checked(page.run())
    checked(page.run())
    assert rows == [123]
    checked(page.button(key="saliency_show_x").click().run())
    worst = page.session_state["workspace"].result.x.events
    assert rows[1:] == [worst["first_row"][worst["saliency_s"].idxmax()]]


def test_without_a_miss_there_is_no_event(tmp_path, monkeypatch):
    alike = session(tmp_path, "fir.csv", "fir2.csv")
    (tmp_path / "fir2.csv").write_bytes((tmp_path / "fir.csv").read_bytes())
    begin_with(alike, monkeypatch)
    page = opened()
    assert [metric.value for metric in page.metric] == ["0.00 s", "0.00 s"]
    assert "No event here" in texts(page)
