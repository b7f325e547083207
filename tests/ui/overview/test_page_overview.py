"""Overview page, sidebar and navigation, run without a browser."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from pages import checked, opened, texts


@pytest.fixture
def app() -> AppTest:
    """The app on the sample recordings, at the Overview."""
    return checked(opened())


def scorecard(app: AppTest) -> dict[str, tuple[str, str, str]]:
    table = app.dataframe[0].value
    return {row["figure"].strip(): tuple(row[["X", "Y", "X - Y"]]) for _, row in table.iterrows()}


def test_the_app_opens_on_the_verdict_of_the_sample_recordings(app: AppTest):
    assert not app.exception
    assert app.title[0].value == "Overview"
    assert "These data do not show which system detects more encounters" in texts(app)


def test_the_scorecard_has_the_figures_of_the_command_line(app: AppTest):
    rows = scorecard(app)
    assert rows["mean similarity ↑"] == ("0.9220", "0.9161", "+0.0059")
    assert rows["encounters detected, of 38 ↑"] == ("30", "27", "+3")


def test_alpha_changes_similarity_but_not_who_is_detected(app: AppTest):
    before = scorecard(app)
    app.slider(key="alpha").set_value(0.5).run()
    after = scorecard(app)
    assert not app.exception
    assert after["mean similarity ↑"] != before["mean similarity ↑"]
    assert after["encounters detected, of 38 ↑"] == before["encounters detected, of 38 ↑"]


def test_a_changed_parameter_stands_in_the_address(app: AppTest):
    app.slider(key="alpha").set_value(0.5).run()
    assert app.query_params["alpha"] == "0.5"


def test_the_address_sets_parameters_and_place():
    app = opened(alpha="0.4", recording="rural_child", frame="57")
    assert app.slider(key="alpha").value == 0.4
    assert app.query_params["recording"] == "rural_child"
    assert app.query_params["frame"] == "57"
    assert not app.warning


def test_a_bad_address_is_told_and_the_app_lives_on():
    app = checked(opened(alpha="seven", recording="<script>"))
    assert app.slider(key="alpha").value == 0.9
    assert "could not be followed" in app.warning[0].value
    assert "alpha" in app.warning[0].value


def test_a_preset_sets_its_parameters_and_reset_takes_them_back(app: AppTest):
    app.button(key="preset_Rural").click().run()
    assert app.slider(key="edge_weight").value == 1.0
    assert app.slider(key="midpoint").value == pytest.approx(28.8)
    (reset,) = [one for one in app.button if one.label == "Reset all parameters"]
    reset.click().run()
    assert app.slider(key="edge_weight").value == 0.0
    assert app.slider(key="midpoint").value == 48.0
    assert not {"edge_weight", "midpoint"} & set(app.query_params)


def test_the_lowest_threshold_counts_every_detection(app: AppTest):
    slider = app.slider(key="threshold_x")
    slider.set_value(slider.min).run()
    assert app.session_state["params"].threshold_x is None


def test_the_untouched_sigmoid_is_that_of_each_recording(app: AppTest):
    assert app.session_state["params"].midpoint is None
    app.slider(key="midpoint").set_value(60.0).run()
    assert app.session_state["params"].midpoint == 60.0


def test_proximity_by_distance_asks_for_metres(app: AppTest):
    app.selectbox(key="proximity").set_value("distance").run()
    assert not app.exception
    assert app.slider(key="midpoint_m").value == 35.0
    assert app.session_state["params"].proximity == "distance"


@pytest.mark.parametrize("kind", ["x", "y", "x_better", "y_better"])
def test_every_kind_of_moment_can_be_looked_at(app: AppTest, kind: str):
    app.session_state["moments"] = kind
    app.run()
    assert not app.exception
    assert [one for one in app.button if one.label == "Open frame"]


def test_a_page_that_was_asked_for_is_opened(app: AppTest):
    app.session_state["wanted_page"] = "timeline"
    app.run()
    assert not app.exception
    assert app.title[0].value == "Timeline"


def forest(app: AppTest) -> str:
    """The forest plot of subgroups, as sent to the browser."""
    plots = [one.proto.spec for one in app.get("plotly_chart")]
    (found,) = [spec for spec in plots if "X less Y, by group" in spec]
    return found


def test_the_figure_that_groups_are_compared_in_can_be_chosen(app: AppTest):
    box = app.selectbox(key="subgroup_figure")
    assert box.value == "encounters_detected"
    assert "Share of encounters detected: X less Y, by group" in forest(app)
    box.set_value("saliency").run()
    assert not app.exception
    assert "Saliency of a recording" in forest(app)
    assert "place: edge" in forest(app)
    assert "a false alert belongs to no pedestrian" not in texts(app)


def test_a_figure_that_groups_of_pedestrians_lack_says_why(app: AppTest):
    app.selectbox(key="subgroup_figure").set_value("false_alert_episodes_per_hour").run()
    assert not app.exception
    assert "a false alert belongs to no pedestrian" in texts(app)
    assert "place: edge" not in forest(app)


def test_groups_have_the_miss_rate_of_the_table_of_evidence(app: AppTest):
    labels = app.selectbox(key="subgroup_figure").options
    assert "log-average miss rate" in labels
    app.selectbox(key="subgroup_figure").set_value("log_average_miss_rate").run()
    assert not app.exception
    assert "Log-average miss rate: X less Y, by group" in forest(app)
    assert "distance: near" in forest(app)
