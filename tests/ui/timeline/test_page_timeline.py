"""Timeline page, run without a browser (the viewer itself is tested in one)."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from pages import checked, opened


@pytest.fixture
def app() -> AppTest:
    """The app on the sample recordings, at frame 57 of rural_child."""
    return checked(opened("timeline", recording="rural_child", frame="57"))


def test_the_page_opens_at_the_frame_of_the_address(app: AppTest):
    assert not app.exception
    assert any("**Frame 57**, 2.85 s" in one.value for one in app.markdown)
    assert app.query_params["frame"] == "57"


def test_another_recording_starts_at_its_first_frame(app: AppTest):
    (choice,) = [one for one in app.selectbox if one.label == "Recording"]
    choice.set_value(0).run()
    assert not app.exception
    assert app.query_params["recording"] == "urban_crossing"
    assert any("**Frame 0**" in one.value for one in app.markdown)


def test_the_plot_can_stand_upright(app: AppTest):
    app.toggle(key="upright").set_value(True).run()
    assert not app.exception


def test_the_frame_stays_when_a_parameter_changes(app: AppTest):
    app.slider(key="alpha").set_value(0.2).run()
    assert app.query_params["frame"] == "57"


def test_the_missed_pedestrians_are_listed_with_who_misses_them(app: AppTest):
    (choice,) = [one for one in app.selectbox if one.label == "Recording"]
    choice.set_value(0).run()
    table = app.dataframe[0].value
    assert table["ped."].tolist() == [1, 2, 5]
    assert set(table["by"]) == {"X and Y"}
