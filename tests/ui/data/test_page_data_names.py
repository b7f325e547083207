"""The Data page: names, tags and facts of what is open are changed in one table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import Place, make_dataset, tagged
from data_page import Edit, opened, press_labelled, recordings_of, sizes_of, space_of

from nvcore.common.errors import InputError
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.inputs.session.recordings_file import read_recordings_file
from pages import begin_with, checked, part, session, shown, texts
from ui.session import state
from ui.session.store import ENCOUNTER
from ui.views.data.recordings import changes_in, saved

TABLES = ("ui.views.data.opening.draw_outcome()", "ui.views.data.inputs.draw()")
FILTER = ("ui.shell.recordings_filter.draw()", "ui.session.state.write_address()")

BEFORE = pd.DataFrame(
    {
        "name": ["a", "b"],
        "width": [640.0, 640.0],
        "height": [480.0, 480.0],
        "fps": [20.0, 20.0],
        "context": ["", "rural"],
        "speed_kmh": [50.0, np.nan],
        "horizon": [np.nan, 240.0],
        "tags": ["night", ""],
        "pictures": ["a.mp4", "no pictures"],
        "first_picture": [np.nan, np.nan],
    }
)


def edited(row: int, **values: object) -> pd.DataFrame:
    after = BEFORE.copy().astype(object)
    for column, value in values.items():
        after.loc[row, column] = value
    return after


def test_only_what_differs_is_a_change():
    assert changes_in(BEFORE, BEFORE.copy(), {}) == {}
    after = edited(1, name="town", tags="day, wet;day", context="0.3", width=1224)
    change = {"title": "town", "tags": ("day", "wet"), "context": 0.3, "width": 1224.0}
    assert changes_in(BEFORE, after, {}) == {"b": change}


def test_speed_and_horizon_are_given_and_taken_back():
    after = edited(0, speed_kmh=None, horizon=-12.5)
    assert changes_in(BEFORE, after, {}) == {"a": {"speed_kmh": None, "horizon": -12.5}}
    assert changes_in(after, BEFORE, {}) == {"a": {"speed_kmh": 50.0, "horizon": None}}


def test_pictures_are_chosen_by_their_label_and_taken_away():
    paths = {"a.mp4": "up/a.mp4", "b.mp4": "up/b.mp4"}
    assert changes_in(BEFORE, edited(1, pictures="b.mp4"), paths) == {"b": {"pictures": "up/b.mp4"}}
    assert changes_in(BEFORE, edited(0, pictures="no pictures"), paths) == {"a": {"pictures": None}}


def test_the_frame_of_the_first_picture_is_given_and_taken_back():
    given = edited(0, first_picture=7.0)
    assert changes_in(BEFORE, given, {}) == {"a": {"first_picture": 7}}
    assert changes_in(given, BEFORE, {}) == {"a": {"first_picture": None}}


def test_the_table_is_saved_as_a_csv_that_fills_it_again(tmp_path: Path):
    places = [Place(range(3), horizon=41.5), Place(range(3), context=1.0)]
    made = tagged(make_dataset(places=places), ("a", "b"), ())
    made = replace(made, recordings=made.recordings.assign(speed_kmh=[80.0, np.nan]))
    entries = (RecordingEntry("r0", pictures="../x/p.mp4", first_picture=-2),)
    systems = (SystemSource("x", name="x"), SystemSource("y", name="y"))
    session = Session(folder=tmp_path, truth=Source("t"), systems=systems, recordings=entries)
    made = made.with_settings(session)
    named = made.renamed({}, {"r0": "=1"})
    file = tmp_path / "recordings.csv"
    file.write_bytes(saved(named, named.settings))
    rows = {name: row for name, (_, row) in read_recordings_file(file, "recordings.csv").items()}
    facts = {"width": 100, "height": 100, "fps": 10}
    own = {"speed_kmh": 80, "horizon": 41.5, "tags": ("a", "b"), "title": "=1", "unit": "r0"}
    assert rows == {
        "r0": RecordingEntry("r0", **facts, **own, pictures="p.mp4", first_picture=-2),
        "r1": RecordingEntry("r1", **facts, context=1.0, unit="r1"),
    }


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"width": None}, "recording 'a': width: expected a positive number, found nothing"),
        ({"fps": -3}, "recording 'a': fps: expected a number from 0.001 to 10000, found -3"),
        ({"name": " "}, "recording 'a': name: expected a name"),
        ({"context": "city"}, "recording 'a': context"),
        ({"speed_kmh": 0}, "recording 'a': speed_kmh: expected a positive number, found 0"),
        ({"horizon": np.inf}, "recording 'a': horizon: expected a finite number, found inf"),
        (
            {"first_picture": 1.5},
            "recording 'a': first_picture: expected a frame number, found 1.5",
        ),
    ],
)
def test_a_value_that_cannot_be_is_refused_with_its_recording(values, words: str):
    with pytest.raises(InputError, match=words):
        changes_in(BEFORE, edited(0, **values), {})


def test_a_recording_is_called_otherwise_without_reading_it_again(
    monkeypatch: pytest.MonkeyPatch, edit: Edit
):
    monkeypatch.setattr(state, "load_for", None)  # whoever reads again fails
    page = edit.apply(opened(*TABLES), name="Crossing", tags="wet")
    assert "are used from now on" in texts(page)
    space = space_of(page)
    assert space.opened.dataset.recordings["name"][0] == "Crossing"
    assert recordings_of(page).loc[0, ["name", "tags"]].tolist() == ["Crossing", "wet"]
    entry = space.opened.session.recordings[0]
    assert (entry.name, entry.title, entry.tags) == ("urban_crossing", "Crossing", ("wet",))
    assert space.pictures.sources[0].name == "urban_crossing.mp4"  # they stay open


def test_a_rename_keeps_who_is_chosen_and_which_preset(edit: Edit):
    page = opened(
        "ui.views.data.inputs.draw()", "ui.shell.sidebar.draw(wrong, pages.PAGE_OF['data'])"
    )
    page.session_state[ENCOUNTER.key] = (1, "urban_crossing:2")
    page.session_state["encounters_recording_1"] = ["urban_crossing", "rural_child"]
    page.session_state["saliency_recording_1"] = "urban_crossing"
    page.session_state["protocol_recordings"] = ["urban_crossing"]
    page = checked(page.button_group(key="preset").set_value("Rural").run())
    page = edit.apply(page, name="Crossing")
    assert space_of(page).opened.dataset.recordings["name"][0] == "Crossing"
    assert page.session_state[ENCOUNTER.key] == (1, "Crossing:2")
    assert page.session_state["encounters_recording_1"] == ["Crossing", "rural_child"]
    assert page.session_state["saliency_recording_1"] == "Crossing"
    assert page.session_state["protocol_recordings"] == ["Crossing"]
    assert not [button for button in page.button if (button.key or "").startswith("reset_")]


def test_a_size_is_used_by_reading_again(edit: Edit):
    page = edit.apply(opened(*TABLES), width=720.0)
    assert sizes_of(page)[0] == (720, 480)
    assert "Changed, and opened again" in texts(page)


def test_an_impossible_change_is_said_and_changes_nothing(edit: Edit):
    page = edit.apply(opened(*TABLES), name="urban_sidewalk")
    assert "two recordings would be called 'urban_sidewalk'" in texts(page)
    assert space_of(page).opened.dataset.recordings["name"][0] == "urban_crossing"


def test_the_systems_are_called_otherwise_and_keep_their_result():
    page = opened("ui.views.data.inputs.draw()", "ui.session.state.result()")
    before = space_of(page).result
    page.text_input(key="system_name_1_0_0").set_value("Thermal")
    page = press_labelled(page, "Use these names")
    space = space_of(page)
    assert space.opened.dataset.systems == ("Thermal", "NIR", "NIR 2")
    assert space.result.x.name == "Thermal"
    assert space.result.x.matches is before.x.matches  # nothing was matched again
    assert [system.name for system in space.opened.session.systems] == ["Thermal", "NIR", "NIR 2"]


def test_two_systems_of_one_name_are_refused():
    page = opened(*TABLES)
    page.text_input(key="system_name_1_0_0").set_value("NIR")
    page = press_labelled(page, "Use these names")
    assert "two systems would be called 'NIR'" in texts(page)


def test_a_tag_chosen_in_the_sidebar_holds_for_what_is_compared():
    page = opened(*FILTER)
    page = checked(page.multiselect(key="tags_chosen").set_value(["rural"]).run())
    assert "3 of 10 recordings: rural" in texts(page)
    assert space_of(page).opened.dataset.recordings["name"].tolist() == [
        *("rural_road", "rural_child", "rural_cyclist")
    ]
    assert space_of(page).pictures.sources[0].name == "rural_road.mp4"
    assert page.query_params["tags"] == "rural"
    assert page.query_params["recording"] == "rural_road"
    page = checked(page.multiselect(key="tags_chosen").set_value([]).run())
    assert len(space_of(page).opened.dataset.recordings) == 10
    assert "tags" not in page.query_params
    assert space_of(page).opened is state.shared_start().opened


def test_the_frame_stays_with_its_recording_alone():
    page = opened(*FILTER)
    names = space_of(page).opened.dataset.recordings["name"].tolist()
    page.session_state["place"] = (names.index("rural_child"), 7)
    page = checked(page.multiselect(key="tags_chosen").set_value(["rural"]).run())
    assert page.session_state["place"] == (1, 7)
    page.session_state["place"] = (1, 7)
    page = checked(page.multiselect(key="tags_chosen").set_value(["winter"]).run())
    assert "rural_child" not in space_of(page).opened.dataset.recordings["name"].tolist()
    assert page.session_state["place"] == (0, 0)


def test_tags_taken_from_the_recordings_that_are_compared_choose_no_longer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, edit: Edit
):
    """Another recording, which is not compared, still has the tag."""
    of_both = session(tmp_path, "fir.csv", "nir.csv")
    entries = (RecordingEntry("urban", tags=("night",)), RecordingEntry("rural", tags=("night",)))
    begin_with(
        replace(of_both, recordings=entries, only=("urban",), only_tags=("night",)), monkeypatch
    )
    page = edit.apply(opened(*TABLES), tags="day")
    space = space_of(page)
    assert space.opened.session.only_tags == ()
    assert space.opened.dataset.recordings["name"].tolist() == ["urban"]


def test_tags_are_chosen_where_the_recording_has_no_evaluated_frame(
    monkeypatch: pytest.MonkeyPatch,
):
    page = opened(*FILTER)
    monkeypatch.setattr(state, "frame_numbers", lambda _: np.empty(0, dtype=int))
    page = checked(page.multiselect(key="tags_chosen").set_value(["rural"]).run())
    assert len(space_of(page).opened.dataset.recordings) == 3
    assert page.session_state["place"] == (0, 0)


def test_tags_that_no_recording_has_together_are_refused():
    page = opened(*FILTER)
    page = checked(page.multiselect(key="tags_chosen").set_value(["rural", "summer"]).run())
    assert "No recording has the tags rural and summer" in texts(page)
    assert shown(page, "multiselect", "tags_chosen").value == []


def test_an_address_with_tags_shows_these_recordings():
    page = checked(part(tags="rural;winter", recording="rural_cyclist").run())
    space = space_of(page)
    assert space.opened.dataset.recordings["name"].tolist() == ["rural_road", "rural_cyclist"]
    assert page.session_state["place"] == (1, 0)


def test_an_address_with_tags_of_a_recording_that_is_not_compared_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    of_both = session(tmp_path, "fir.csv", "nir.csv")
    entries = (RecordingEntry("urban", tags=("day",)), RecordingEntry("rural", tags=("night",)))
    begin_with(replace(of_both, recordings=entries, only=("urban",)), monkeypatch)
    page = checked(part(tags="night").run())
    assert "no recording has its tags" in page.session_state["bad_link"]
    assert space_of(page).opened.dataset.recordings["name"].tolist() == ["urban"]


def test_an_exported_session_holds_names_and_choice(tmp_path: Path):
    from nvcore.inputs.load import load
    from nvcore.inputs.session.toml import read_session, write_session

    page = opened(*FILTER, "ui.views.data.inputs.draw()")
    page.text_input(key="system_name_1_0_0").set_value("Thermal")
    page = press_labelled(page, "Use these names")
    page = checked(page.multiselect(key="tags_chosen").set_value(["rural"]).run())
    path = tmp_path / "session.toml"
    path.write_text(write_session(space_of(page).opened.session, version="1", fingerprint="2"))
    again = load(read_session(path))
    assert again.systems == ("Thermal", "NIR", "NIR 2")
    assert len(again.recordings) == 3
