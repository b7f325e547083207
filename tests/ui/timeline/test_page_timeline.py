"""Timeline page, run without a browser (the viewer itself is tested in one)."""

from __future__ import annotations

import json

from pages import checked, opened, texts
from ui.session.chosen import CHOSEN
from ui.timeline import plots


def choose(app, name):
    app.session_state[CHOSEN] = (app.session_state["workspace"].n_opened, name)
    return checked(app.run())


def test_the_page_opens_at_the_frame_of_the_address_which_stays_while_parameters_change():
    app = checked(opened("timeline", alpha="0.4", recording="rural_child", frame="57"))
    assert any("**Frame 57**, 2.85 s" in text.value for text in app.markdown)
    assert app.slider(key="alpha").value == 0.4
    assert not app.warning
    checked(app.slider(key="alpha").set_value(0.2).run())
    for kind in ("losses", "upright", "side_by_side"):
        checked(app.segmented_control(key="plot_over_time").set_value(kind).run())
    assert app.query_params["recording"] == "rural_child"
    assert app.query_params["frame"] == "57"


def test_another_recording_starts_at_its_first_frame_with_those_missed_in_it():
    app = checked(opened("timeline", recording="rural_child", frame="57"))
    pedestrians, detections = (table.value for table in app.dataframe)
    for terms in (pedestrians.loc[["term X", "term Y"]], detections.loc[["term"]]):
        assert terms.astype(float).max().is_monotonic_decreasing
    assert set(pedestrians.loc["border (px)"]) == {"320"}  # on a rural road
    (choice,) = [box for box in app.selectbox if box.label == "Recording"]
    checked(choice.set_value(0).run())
    assert app.query_params["recording"] == "urban_crossing"
    assert any("**Frame 0**" in text.value for text in app.markdown)
    (table,) = app.dataframe  # nothing is detected
    headings = [column["label"] for column in json.loads(table.proto.columns).values()]
    assert sorted(headings) == ["1", "2", "5", "ped."]
    assert set(table.value.loc["missed by"]) == {"X, Y"}


def test_a_high_similarity_with_nobody_matched_is_explained_beside_it():
    app = checked(opened("timeline"))
    said = texts(app)
    assert "Misses take 0.077: pedestrian 1, 28 px tall, weight 0.11, is not detected" in said
    assert "All 3 not detected are too far to count" in said


def test_the_chosen_pedestrian_is_told_of_marked_in_the_lanes_and_open_in_encounters():
    app = choose(checked(opened("timeline", recording="rural_child", frame="225")), "rural_child:3")
    said = texts(app)
    assert "Pedestrian 3: missed by Y" in said
    assert "Takes 0.715 of Y's similarity" in said
    assert any(shape.get("name") == "chosen" for shape in lanes_layout(app)["shapes"])
    # filters of an earlier visit leave him out: they are cleared
    key = f"encounters_recording_{app.session_state['workspace'].n_opened}"
    app.session_state[key] = ["urban_crossing"]
    checked(app.button(key="open_chosen").click().run())
    assert app.title[0].value == "Encounters"
    assert "Pedestrian 3 in rural_child" in texts(app)


def test_lanes_come_so_many_at_a_time_and_the_page_of_the_chosen_one(monkeypatch):
    monkeypatch.setattr(plots, "LANES", 2)
    app = checked(opened("timeline"))
    pages = app.selectbox(key="lanes_first")
    assert pages.options[0] == "1 to 2"
    lanes = [lane_names(app, first) for first in pages.options]
    assert all(len(names) <= 2 for names in lanes)
    app = choose(app, f"{app.session_state['workspace'].opened.dataset.recordings['name'][0]}:1")
    assert any("▶ ped 1" in name for name in lane_names(app))
    app.toggle(key="lanes_missed").set_value(True).run()
    assert "with misses" in str(lanes_layout(app))


def lanes_layout(app):
    layouts = [json.loads(chart.proto.spec)["layout"] for chart in app.get("plotly_chart")]
    (layout,) = [layout for layout in layouts if "Who is missed when" in str(layout)]
    return layout


def lane_names(app, page=None):
    if page is not None:
        checked(app.selectbox(key="lanes_first").select(page).run())
    return lanes_layout(app)["yaxis"]["ticktext"]
