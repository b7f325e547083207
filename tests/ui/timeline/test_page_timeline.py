"""Timeline page, run without a browser (the viewer itself is tested in one)."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from streamlit.testing.v1 import AppTest

from nvcore.common.findings import Cases, Finding, Severity
from nvcore.metrics.encounter_classes import classes_of
from nvcore.pictures.recordings import RecordingPictures
from nvcore.settings.codes import CodedInterval
from pages import checked, figures, opened, part, press, space_of, tables, texts, to_page
from ui.session.store import ENCOUNTER
from ui.shell.review import Review
from ui.views.timeline import plots


def parts(**address: str) -> AppTest:
    """The choice of a recording, and what shows its frames."""
    draw = "ui.views.timeline.plots.draw_all(RESULT, state.recording())"
    return checked(part("ui.widgets.recording.recording_choice()", draw, **address).run())


def choose(app, name):
    app.session_state[ENCOUNTER.key] = (app.session_state["workspace"].n_opened, name)
    return checked(app.run())


def test_the_page_opens_at_the_frame_of_the_address_which_stays_while_parameters_change():
    app = parts(alpha="0.4", recording="rural_child", frame="57")
    assert any("**Frame 57**, 2.85 s" in text.value for text in app.markdown)
    app.session_state["new_params"] = {"alpha": 0.2}
    checked(app.run())
    for kind in ("losses", "upright", "side_by_side"):
        checked(app.segmented_control(key="plot_over_time").set_value(kind).run())
    assert app.query_params["recording"] == "rural_child"
    assert app.query_params["frame"] == "57"


def test_how_frames_are_numbered_is_said_only_where_it_is_unusual(monkeypatch):
    app = parts()
    assert "counted from 0" not in texts(app)
    space = app.session_state["workspace"]
    note = "Picture i, counted from 0, shows frame i + 1: the frames count from 1."
    monkeypatch.setattr(space, "pictures", replace(space.pictures, notes={0: note}))
    assert note in texts(checked(app.run()))
    monkeypatch.setattr(space, "pictures", RecordingPictures())
    assert "has no pictures" in texts(checked(app.run()))


def test_another_recording_starts_at_its_first_frame_with_those_missed_in_it():
    app = parts(recording="rural_child", frame="57")
    pedestrians, detections = tables(app)
    pedestrians, detections = (table.set_index("") for table in (pedestrians, detections))
    for terms in (pedestrians.loc[["term X", "term Y"]], detections.loc[["term"]]):
        assert terms.astype(float).max().is_monotonic_decreasing
    assert set(pedestrians.loc["border (px)"]) == {"320"}  # on a rural road
    (choice,) = [box for box in app.selectbox if box.label == "Recording"]
    checked(choice.set_value(0).run())
    assert app.query_params["recording"] == "urban_crossing"
    assert any("**Frame 0**" in text.value for text in app.markdown)
    (table,) = tables(app)  # nothing is detected
    assert table.attrs["labels"] == ["ped", "1", "2", "5"]
    assert set(table.set_index("").loc["missed by"]) == {"X, Y"}


def test_a_high_similarity_with_nobody_matched_is_explained_beside_it():
    words = texts(parts())
    assert "Misses take 0.077: pedestrian 1, 28 px tall, weight 0.11, is not detected" in words
    assert "All 3 not detected are too far to count" in words


def test_the_chosen_pedestrian_is_told_of_marked_in_the_lanes_and_open_in_encounters():
    app = choose(checked(opened("timeline", recording="rural_child", frame="225")), "rural_child:3")
    assert "Pedestrian 3: missed by Y" in texts(app)
    assert "Takes 0.715 of Y's similarity" in texts(app)
    assert any(shape.get("name") == "chosen" for shape in lanes_layout(app)["shapes"])
    # filters of an earlier visit leave the pedestrian out: they are cleared
    key = f"encounters_recording_{app.session_state['workspace'].n_opened}"
    app.session_state[key] = ["urban_crossing"]
    checked(app.button(key="open_chosen").click().run())
    assert app.title[0].value == "Encounters"
    assert "Pedestrian 3 in rural_child" in texts(app)


def test_lanes_come_so_many_at_a_time_and_the_page_of_the_chosen_one(monkeypatch):
    monkeypatch.setattr(plots, "LANES", 2)
    app = parts()
    pages = app.selectbox(key="lanes_first")
    assert pages.options[0] == "1 to 2"
    lanes = [lane_names(app, first) for first in pages.options]
    assert all(len(names) <= 2 for names in lanes)
    app = choose(app, f"{app.session_state['workspace'].opened.dataset.recordings['name'][0]}:1")
    assert any("▶ ped 1" in name for name in lane_names(app))
    app.toggle(key="lanes_missed").set_value(True).run()
    assert "with misses" in str(lanes_layout(app))


def lanes_layout(app):
    layouts = [figure["layout"] for figure in figures(app)]
    (layout,) = [layout for layout in layouts if "Who is missed when" in str(layout)]
    return layout


def lane_names(app, page=None):
    if page is not None:
        checked(app.selectbox(key="lanes_first").select(page).run())
    return lanes_layout(app)["yaxis"]["ticktext"]


def walked(app: AppTest, cases: Cases, at: int = 0) -> AppTest:
    """The page on which the list of a finding with these cases is walked through."""
    finding = Finding(
        Severity.NOTE, "odd", "truth", len(cases), "3 odd boxes.", "Look.", cases=cases
    )
    key = (app.session_state["workspace"].opened.dataset.fingerprint, "odd", "truth", "1")
    app.session_state["review"] = Review(finding, at, key)
    return checked(app.run())


@pytest.fixture
def of_two_recordings() -> tuple[AppTest, Cases, list[tuple[int, int]]]:
    """The page, cases in two recordings, and the place of each."""
    app = parts()
    dataset = app.session_state["workspace"].opened.dataset
    frames = dataset.frame_columns
    rows = [
        int(dataset.truth.offsets[frames.first[recording] + row])
        for recording, row in ((0, 30), (0, 40), (1, 20))
    ]
    in_all = dataset.boxes["frame_index"].to_numpy()[rows]
    places = [
        (int(frames.recording[i]), int(i - frames.first[frames.recording[i]])) for i in in_all
    ]
    return app, Cases("boxes", np.array(rows)), places


def test_a_list_is_walked_through_across_recordings(of_two_recordings):
    app, cases, places = of_two_recordings
    app = walked(app, cases)
    assert "**1** of 3" in texts(app)
    assert app.button(key="listed_previous").disabled
    for at in (1, 2):
        app = press(app, "listed_next")
        assert app.session_state["place"] == places[at]
        assert f"**{at + 1}** of 3" in texts(app)
    names = app.session_state["workspace"].opened.dataset.recordings["name"]
    (choice,) = [box for box in app.selectbox if box.label == "Recording"]
    assert choice.value == 1
    assert app.query_params["recording"] == names[1]
    assert app.button(key="listed_next").disabled
    app = press(app, "listed_previous")
    assert app.session_state["place"] == places[1]
    (seen,) = app.session_state["entries_seen"].values()
    assert seen == {1, 2}


def test_the_box_of_the_entry_is_said_and_marked(of_two_recordings):
    app, cases, places = of_two_recordings
    app = press(walked(app, cases), "listed_next")
    box = app.session_state["workspace"].opened.dataset.boxes.iloc[cases.rows[1]]
    assert f"box of {box['w']:.0f} × {box['h']:.0f} px at {box['x']:.0f}, {box['y']:.0f}" in (
        texts(app)
    )
    (sent,) = [
        json.loads(item.proto.json)
        for item in app.get("bidi_component")
        if "listed" in item.proto.json
    ]
    assert sent["listed"] == {"row": places[1][1], "box": box[["x", "y", "w", "h"]].tolist()}


def test_who_has_left_the_entrys_frame_is_led_back_to_it(of_two_recordings):
    app, cases, places = of_two_recordings
    app = press(walked(app, cases), "listed_next")
    assert "listed_again" not in [button.key for button in app.button]
    app.session_state["place"] = (0, 3)
    app = press(checked(app.run()), "listed_again")
    assert app.session_state["place"] == places[1]


def test_a_list_is_closed_and_leads_back_to_where_it_stands(of_two_recordings):
    _, cases, _ = of_two_recordings
    app = press(walked(checked(opened("timeline")), cases), "listed_back")
    assert app.title[0].value == "Data"
    app = press(to_page(app, "timeline"), "listed_close")
    assert "listed_next" not in [button.key for button in app.button]


def test_an_entry_without_an_evaluated_frame_says_so_and_stays(of_two_recordings):
    app, _, _ = of_two_recordings
    dataset = app.session_state["workspace"].opened.dataset
    one = {"subject": "x", "recording": "urban_crossing", "frame": 9999, "file": 0, "line": 3}
    left_out = dataset.left_out.reindex([0]).assign(**one)
    object.__setattr__(dataset, "left_out", left_out)
    try:
        app = walked(app, Cases("left_out", np.array([0])))
        assert "which is not evaluated: there is nothing to show" in texts(app)
    finally:
        object.__setattr__(dataset, "left_out", left_out.iloc[:0])


def test_a_stretch_is_marked_at_the_frame_shown_becomes_a_class_and_is_changed_and_removed():
    page = part(
        "ui.views.timeline.codes.draw(state.recording())", recording="rural_child", frame="57"
    )
    checked(page.run())
    fields = {field.label: field for field in page.number_input}
    assert fields["Start (s)"].value == pytest.approx(2.85)
    fields["End (s)"].set_value(1.0)
    page.text_input[0].set_value("glare")
    assert "the start, or more; got 1" in press(page, "code_use").error[0].value
    page.number_input[1].set_value(4.0)
    press(page, "code_use")
    marked = CodedInterval("rural_child", 2.85, 4.0, "glare")
    assert space_of(page).opened.session.codes == (marked,)
    classes = classes_of(space_of(page).opened.dataset)
    assert classes.coded == ("glare", "no_code")
    assert not classes.members["glare"].all()
    # the fields are for a new one again, until a stretch is chosen
    assert page.text_input[0].value == ""
    checked(page.selectbox[0].set_value(marked).run())
    checked(page.text_input[0].set_value("low sun").run())
    press(page, "code_use")
    assert space_of(page).opened.session.codes == (replace(marked, code="low sun"),)
    checked(page.selectbox[0].set_value(replace(marked, code="low sun")).run())
    press(page, "code_remove")
    assert space_of(page).opened.session.codes == ()


def test_stretches_of_a_file_are_added_unless_it_has_a_wrong_line():
    page = checked(part("ui.views.timeline.codes.draw(state.recording())").run())
    lines = ["recording,start_s,end_s,code", "rural_child,1,2,glare", "rural_child,3,2,glare"]
    for n_lines, n_codes in ((3, 0), (2, 1)):
        content = "\n".join(lines[:n_lines]).encode()
        checked(page.file_uploader[0].set_value(("codes.csv", content, "text/csv")).run())
        assert len(space_of(page).opened.session.codes) == n_codes
        if not n_codes:
            assert "line 3" in page.error[0].value
    assert not page.error
