"""Timeline page, run without a browser (the viewer itself is tested in one)."""

from __future__ import annotations

import json

from pages import checked, opened


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
