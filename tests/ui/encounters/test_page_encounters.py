"""The Encounters page, driven without a browser."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import small_estimator
from streamlit.testing.v1 import AppTest

import pages
from pages import alone, begin_with, checked, part, press, session, shown, space_of, tables, texts
from ui.session.chosen import encounter_of, name_of
from ui.session.store import ENCOUNTER
from ui.subjects.time_left import encounter
from ui.views.encounters import details, figures, table
from ui.views.encounters.address import Choice, from_address, to_address
from ui.views.encounters.filters import Filters
from ui.views.encounters.order import Order
from ui.widgets import table_columns

ALL = "nvcore.tables.result.encounters_table(RESULT)"
FILTERS = f"st.session_state['matching'] = ui.views.encounters.filters.draw(RESULT, {ALL})[1]"
RECORDINGS = ["rural_road", "urban_crossing"]


def opened(section: str | None = None, **link: str) -> AppTest:
    """The page with one of its sections unfolded."""
    page = alone("encounters", **link)
    page.session_state["encounters_more"] = section
    return checked(page.run())


def one(row: int = 0) -> AppTest:
    """The part of one encounter, beside the list."""
    return checked(part(f"ui.views.encounters.details.draw(RESULT, {ALL}, {row})").run())


@pytest.fixture(scope="module")
def page() -> AppTest:
    """The whole page on the sample, to look at."""
    return opened()


def only(page: AppTest, name: str) -> str:
    return "".join(page.query_params[name])


def listed(page: AppTest) -> pd.DataFrame:
    return tables(page)[0]


def widget(page: AppTest, kind: str, label: str):
    (labelled,) = [item for item in getattr(page, kind) if item.label == label]
    return labelled


def choose(page: AppTest, row: int) -> AppTest:
    space = space_of(page)
    page.session_state[ENCOUNTER.key] = (space.n_opened, name_of(space.result, row))
    return checked(page.run())


def test_all_encounters_of_the_sample_are_listed_the_heaviest_failures_first(page: AppTest):
    assert "**46** of 46 encounters" in texts(page)
    rows = listed(page)
    assert len(rows) == 46
    heavier_s = rows[["severity_s_x", "severity_s_y"]].max(axis=1)
    assert heavier_s.head(38).is_monotonic_decreasing
    assert set(rows["category"].tail(8)) == {"distant"}
    assert page.selectbox(key="encounters_order").value == "severity"
    assert "encounters_clear" not in [button.key for button in page.button]
    assert "X misses 8 and Y misses 11" not in texts(page)  # folded
    assert list(rows) == list(table.FIRST_COLUMNS)  # until all are asked for
    more = part(f"ui.views.encounters.table.draw({ALL}, 0)")
    more.session_state["encounters_columns"] = True
    columns = {*listed(checked(more.run()))}
    assert {"lag_s_y", "gap_s_x", "tail_s_x", "peak_k", "aspect_z", "occluded_share"} <= columns


def test_what_the_measures_of_one_encounter_mean_stands_behind_a_question_mark(page: AppTest):
    (facts,) = [text for text in page.caption if "position −0.48" in text.value.replace("\\", "")]
    for term in ("Peak cost: ", "Lag: ", "Longest gap: ", "Tail: ", "standard deviations"):
        assert term in facts.proto.help


def test_a_fusion_detects_more():
    assert "“X or Y” detects 35 of 38 encounters, 5 more than X alone" in texts(opened("fusion"))


def test_the_keys_n_and_p_step(page: AppTest):
    assert page.button(key="encounters_next").proto.shortcut == "n"
    assert page.button(key="encounters_previous").proto.shortcut == "p"


def test_an_encounter_is_named_by_its_recording_and_track(page: AppTest):
    result = space_of(page).result
    assert [encounter_of(result, name_of(result, row)) for row in (3, 45)] == [3, 45]
    name = name_of(result, 3).rpartition(":")[0]
    for other in (
        "",
        "7",
        "::",
        f"{name}:",
        f"{name}:99",
        f"{name}:1.0",
        f"{name}:٣",
        f"{name}:{'1' * 40}",
        "other:1",
    ):
        assert encounter_of(result, other) is None


def test_a_pair_of_miss_classes_is_listed_by_a_click(monkeypatch: pytest.MonkeyPatch):
    page = opened("misses")
    assert "X misses 8 and Y misses 11" in texts(page)
    assert "Miss class of FIR (X, rows) against that of NIR (Y, columns)" in texts(page)
    chosen: list[tuple[str | None, str | None]] = []
    monkeypatch.setattr(figures, "set_classes", lambda x, y: chosen.append((x, y)))
    (pairs,) = [pairs for pairs in tables(page) if "never" in pairs]
    assert pairs["x"].tolist()[0] == "X never"
    for row, column in ((5, "lost_early"), (6, "late"), (0, "all")):
        figures._choose_pair([*pairs][1:], row, column)
    assert chosen == [("none", "lost_early"), (None, "late"), ("never", None)]


def test_without_detectability_nothing_is_said_or_asked_of_the_driver(page: AppTest):
    assert "Driver:" not in texts(page)
    assert "By the driver" not in [group.label for group in page.button_group]


def test_a_click_in_the_venn_diagram_presets_the_category_which_can_be_changed():
    page = opened(category="x_only,<b>", driver="sees")
    assert "category cannot be <b>" in texts(page)
    assert "driver cannot be sees" in page.warning[0].value
    assert set(listed(page)["category"]) == {"only X"}
    page.session_state["page_link"] = {"category": "y_only"}  # as the Overview leaves it
    checked(page.run())
    assert set(listed(page)["category"]) == {"only Y"}
    assert page.query_params["category"] == "y_only"
    page.button_group[0].set_value(["x_only"])
    assert set(listed(checked(page.run()))["category"]) == {"only X"}
    assert "**8** of 46" in texts(page)
    assert page.query_params["category"] == "x_only"


def test_encounters_can_be_chosen_by_miss_class_recording_and_least_severity():
    page = checked(part(FILTERS).run())
    widget(page, "multiselect", "Miss class of Y").set_value(["late"])
    widget(page, "multiselect", "Recording").set_value(["urban_crossing"])
    rows = checked(page.run()).session_state["matching"]
    assert set(rows["miss_class_y"]) == {"late"}
    assert set(rows["recording"]) == {"urban_crossing"}
    for label in ("Miss class of Y", "Recording"):
        widget(page, "multiselect", label).set_value([])
    widget(page, "slider", "Least severity (s)").set_value(0.5)
    rows = checked(page.run()).session_state["matching"]
    assert 0 < len(rows) < 38
    assert (rows[["severity_s_x", "severity_s_y"]].max(axis=1) >= 0.5).all()


def test_tags_set_no_filter_and_take_back_none():
    page = checked(part("ui.shell.recordings_filter.draw()", FILTERS).run())

    def with_tags(*tags: str) -> pd.DataFrame:
        checked(shown(page, "multiselect", "tags_chosen").set_value(list(tags)).run())
        return page.session_state["matching"]

    assert len(with_tags("rural")) == 12
    assert len(with_tags()) == 46
    height = widget(page, "slider", "Largest height (px)")
    checked(height.set_value((60.0, height.max)).run())
    widget(page, "multiselect", "Recording").set_value(RECORDINGS)
    before = checked(page.run()).session_state["matching"]
    rural = with_tags("rural")
    assert set(rural["recording"]) == {"rural_road"}
    assert rural["peak_height"].min() >= 60
    assert with_tags().equals(before)


def test_filters_that_leave_nothing_say_what_to_do_and_are_cleared_at_once():
    page = opened(category="distant", miss_x="late", height="10:338", order="-peak_height")
    assert texts(page).count("No encounter") == 1
    assert "Click a bar" not in texts(page)  # nor a figure of nothing
    press(page, "encounters_clear")
    assert len(listed(page)) == 46
    assert "category" not in page.query_params
    assert only(page, "order") == "-peak_height"


def test_a_chosen_encounter_opens_where_the_heavier_failure_costs_most(
    monkeypatch: pytest.MonkeyPatch,
):
    shown: list[int] = []
    monkeypatch.setattr(details, "open_row", shown.append)
    page = one(2)
    result = space_of(page).result
    assert "Pedestrian 3 in urban_crossing" in texts(page)
    assert "Only FIR detected the pedestrian" in texts(page)
    assert "Where Y's failure, the heavier, costs most" in texts(page)
    assert "**FIR**: never missed in 2.55 s" in texts(page)
    assert "**NIR**: missed for 2.15 of 2.55 s, severity **0.64 s**" in texts(page)
    values = page.table[0].value
    assert values.index.name == "Measure"  # no table has an empty heading
    assert values.loc["Matched"].tolist() == ["51 of 51 frames (100 %)", "8 of 51 frames (16 %)"]
    assert values.loc["Severity"].tolist() == ["0.00 s", "0.64 s"]
    press(page, "encounters_show")
    press(page, "encounters_show_y")  # first missed by Y
    assert shown == [result.y.failures["peak_row"][2], 40]


def test_an_encounter_that_nobody_misses_opens_where_it_begins_to_count(page: AppTest):
    result = space_of(page).result
    is_whole = (result.x.failures["peak_row"] < 0) & (result.y.failures["peak_row"] < 0)
    whole = int(np.flatnonzero(is_whole & (result.category == "both"))[0])
    assert "Where the encounter begins to count" in texts(one(whole))


def test_encounters_are_gone_through_one_by_one_in_the_order_of_the_list_across_recordings():
    page = opened(category="y_only")
    names = listed(page)[["recording", "track"]].itertuples(index=False)
    in_order = [f"Pedestrian {track} in {recording}" for recording, track in names]
    assert len({name.split(" in ")[1] for name in in_order}) > 1
    assert page.button(key="encounters_previous").disabled
    assert "encounter" not in page.query_params  # nothing is selected yet, the first is shown
    for at, name in enumerate(in_order):
        assert name in texts(page)
        assert f"**{at + 1}** of {len(in_order)}" in texts(page)
        if at + 1 < len(in_order):
            press(page, "encounters_next")
            recording, track = name.split(" in ")[1], name.split()[1]
            assert only(page, "encounter") != f"{recording}:{track}"
    assert page.button(key="encounters_next").disabled
    press(page, "encounters_previous")
    recording, track = in_order[-2].split(" in ")[1], in_order[-2].split()[1]
    assert only(page, "encounter") == f"{recording}:{track}"


def test_time_left_and_classes_are_said_of_the_encounter_and_its_last_chance_opens(
    page: AppTest, monkeypatch: pytest.MonkeyPatch
):
    shown: list[int] = []
    monkeypatch.setattr(encounter, "open_row", shown.append)
    result = space_of(page).result
    page = one(encounter_of(result, "rural_road:4"))
    assert (
        "Urgent at 50 km/h (assumed): the last chance to stop is frame 194 (9.70 s). X confirms "
        "the pedestrian in time, 0.45 s before the last chance. Y confirms the pedestrian late, "
        "1.55 s after the last chance: impact at 50 km/h."
    ) in texts(page)
    assert "(metrics#classes-of-encounters): in road." in texts(page)
    button = page.button(key="encounters_show_chance")
    assert (button.label, button.help) == ("Last chance to stop", "Frame 194")
    press(page, "encounters_show_chance")
    assert result.dataset.frames.iloc[shown]["frame"].tolist() == [194]
    distant = one(encounter_of(result, "urban_crossing:1"))
    assert "Not urgent at 50 km/h (assumed): never less than" in texts(distant)
    assert "encounters_show_chance" not in [button.key for button in distant.button]


def test_everything_that_is_chosen_is_in_the_address_and_a_link_chooses_it_again():
    link = {
        "category": "x_only,both", "miss_y": "late", "only": "rural_road,urban_crossing",
        "position": "-0.9:0.95", "height": "20:300", "pose": "-4:0.7", "severity": "0.05",
        "order": "-peak_height", "columns": "all", "encounter": "urban_crossing:3",
    }  # fmt: skip
    page = opened(**link)
    assert [warning.value for warning in page.warning] == []
    rows = listed(page)
    assert rows["peak_height"].is_monotonic_decreasing
    assert set(rows["miss_class_y"]) == {"late"}
    assert "Pedestrian 3 in urban_crossing" in texts(page)
    asked = {name: set(text.split(",")) for name, text in link.items()}
    given = {name: set(only(page, name).split(",")) for name in link}
    assert given == asked


def test_a_hostile_or_stale_address_is_told_and_lists_what_there_is():
    page = opened(height="<script>", encounter="::", only="no such,%2C")
    (warning,) = page.warning
    assert "could not be followed in all" in warning.value
    assert "there is no such encounter" in warning.value
    assert len(listed(page)) == 46


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("position", "1e999:0"),
        ("height", "<script>"),
        ("height", "9:1"),
        ("pose", "nan:1"),
        ("severity", "-1"),
        ("severity", "1" * 400),
        ("order", "-__class__"),
        ("only", "no such,%2C"),
        ("miss_x", "late,../../etc"),
        ("class", "child,<b>"),
    ],
)
def test_what_cannot_be_in_an_address_is_told_shortly_and_chooses_nothing(name: str, text: str):
    choice, wrong = from_address({name: text}, RECORDINGS, ["child"])
    assert (choice.order, choice.encounter) == (Order(), None)
    assert replace(choice.filters, classes=(), classes_x=()) == Filters()
    assert 0 < len("; ".join(wrong)) < 200


def test_names_with_commas_come_back_from_the_address():
    recordings = ["a,b", "50%2C", "c"]
    filters = Filters(recordings=("a,b", "50%2C"), classes=("1,2",), height_px=(1.5, 20))
    choice = Choice(filters, Order("lag_s_x", is_descending=False), encounter="a:b:7")
    assert from_address(to_address(choice), recordings, ["1,2", "3"]) == (choice, ())
    assert to_address(Choice()) == {}


def test_a_class_is_listed_counted_and_kept_in_the_address():
    page = opened("classes", **{"class": "child"})
    assert not page.warning
    rows = listed(page)
    assert sorted(rows[["recording", "track"]].to_numpy().tolist()) == [
        ["odd_pose", 1],
        ["rural_child", 2],
        ["rural_child", 3],
    ]
    assert only(page, "class") == "child"
    assert "class child" in texts(page)
    counts = pages.measures(page, "by-class")
    assert list(counts) == ["crossing[a]", "in road[b]", "group[a]", "child[c]"]
    assert counts["child[c]"][:7] == ("2", "0", "0", "1", "0", "0.0 pp", "–")
    assert "c: Too few recordings for an interval: 2, at least 8 are needed." in texts(page)


def test_filters_and_the_selection_hold_when_recordings_are_chosen_by_tag():
    page = opened(only="rural_road,urban_crossing", encounter="rural_road:4")
    space = space_of(page)
    session = replace(space.opened.session, only=("rural_road",))
    whole = space.opened.whole.with_settings(session)
    space.look_at(space.opened.of(session, whole, space.opened.label))
    checked(page.run())
    assert "recording" not in listed(page)  # it is one only
    assert only(page, "only") == "rural_road"
    assert "Pedestrian 4 in rural_road" in texts(page)


def test_a_heading_sorts_and_turns_the_order_round(monkeypatch):
    monkeypatch.setattr(table.st, "session_state", {})
    table._sort("peak_height")
    assert table.order() == Order("peak_height")
    table._sort("peak_height")
    assert table.order() == Order("peak_height", is_descending=False)


def test_a_distant_encounter_has_no_severity_and_else_dashes():
    page = one(4)
    assert "never came near enough" in texts(page)
    severity, peak, *others = page.table[0].value["FIR"].tolist()
    assert (severity, peak) == ("0.00 s", "0.00")
    assert others == ["–"] * 5


def test_an_encounter_that_was_chosen_in_other_data_is_forgotten():
    page = part(f"st.text(ui.views.encounters.selection.shown(RESULT, {ALL}))")
    page.session_state[ENCOUNTER.key] = (0, "winter_frost:1")
    assert checked(page.run()).text[0].value == "0"


def test_without_pedestrians_there_is_nobody_to_miss(tmp_path, monkeypatch):
    begin_with(session(tmp_path, "fir.csv", "nir.csv"), monkeypatch)
    ignored = "recording,frame,x,y,w,h,track,ignore\nurban,0,100,200,40,100,1,1\n"
    (tmp_path / "truth.csv").write_text(ignored, encoding="utf-8")
    assert "nobody to miss" in texts(opened())


def test_without_pictures_the_boxes_are_drawn_and_distances_are_dashes(tmp_path, monkeypatch):
    begin_with(session(tmp_path, "fir.csv", "nir.csv"), monkeypatch)
    page = one()
    assert "Pedestrian 1 in urban" in texts(page)
    weighed = weighings(unfolded(page))
    assert set(weighed["Horizon"]) | set(weighed["Distance"]) == {"–"}
    assert "The row of the horizon is not known: the page Data estimates it" in texts(page)
    assert "No distance of this pedestrian is known: give" in texts(page)


def test_the_column_of_recordings_is_left_out_where_there_is_one(tmp_path, monkeypatch):
    begin_with(replace(session(tmp_path, "fir.csv", "nir.csv"), only=("urban",)), monkeypatch)
    page = checked(part(f"ui.views.encounters.table.draw({ALL}, 0)").run())
    assert list(tables(page)[0]) == list(table.FIRST_COLUMNS[1:])
    page.session_state["encounters_columns"] = True
    assert "recording" not in tables(checked(page.run()))[0]


def test_of_very_many_encounters_the_first_are_listed_and_a_fusion_waits_to_be_asked_for(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(table, "MOST_ROWS", 20)
    monkeypatch.setattr(table_columns, "MOST_ROWS", 20)
    monkeypatch.setattr(figures, "MANY_BOXES", 1000)
    calls = (
        f"ui.views.encounters.table.draw({ALL}, 0)",
        "ui.views.encounters.figures.draw_fusion(RESULT)",
    )
    page = checked(part(*calls).run())
    assert len(listed(page)) == 20
    assert "The first 20 of 46 are listed" in texts(page)
    assert "X or Y” detects" not in texts(page)
    checked(page.toggle(key="encounters_fuse").set_value(True).run())
    assert "X or Y” detects" in texts(page)


SIX = pd.DataFrame(
    {
        "category": ["both", "both", "x_only", "y_only", "neither", "distant"],
        "miss_class_x": ["none", "late", "none", "late", "never", None],
        "miss_class_y": ["none", "none", "never", "none", "never", None],
        "recording": ["a", "a", "a", "b", "b", "b"],
        "classes": ["child;group", "", "group", "grouped", "child", ""],
        "lateral_position": [-0.5, 0, 0.5, 0, 0, 0],
        "peak_height": [50.0, 60, 70, 80, 90, 10],
        "aspect_z": [0, 1, 2, -3, 0, np.nan],
        "severity_s_x": [0.0, 0.2, 0, 0.5, 1.0, np.nan],
        "severity_s_y": [0.0, 0.0, 0.7, 0, 1.0, np.nan],
    }
)


def test_the_heavier_failure_comes_first_then_the_taller_and_distant_ones_last():
    tall = pd.concat([SIX, SIX.iloc[[0]].assign(peak_height=95.0)], ignore_index=True)
    assert Order().sort(tall).index.tolist() == [4, 2, 3, 1, 6, 0, 5]
    assert Order("severity", is_descending=False).sort(SIX).index.tolist() == [0, 1, 3, 2, 4, 5]
    # of equals the heavier failure; what has no value is last, either way
    assert Order("severity_s_y").sort(SIX).index.tolist() == [4, 2, 3, 1, 0, 5]
    assert Order("aspect_z", is_descending=False).sort(SIX).index.tolist() == [3, 4, 0, 1, 2, 5]


@pytest.mark.parametrize(
    ("filters", "rows"),
    [
        (Filters(), [0, 1, 2, 3, 4, 5]),
        (Filters(categories=["both", "neither"]), [0, 1, 4]),
        (Filters(classes_x=["late"]), [1, 3]),
        (Filters(classes_x=["late"], classes_y=["none"], recordings=["b"]), [3]),
        (Filters(classes=["group"]), [0, 2]),
        (Filters(classes=["group", "child"], recordings=["b"]), [4]),
        (Filters(position=(0, 1)), [1, 2, 3, 4, 5]),
        (Filters(height_px=(60, 80)), [1, 2, 3]),
        (Filters(pose_z=(-3, 0)), [0, 3, 4]),
        (Filters(least_severity_s=0.5), [2, 3, 4]),
        (Filters(of_subjects={"driver": ["open", "unseen"]}), [1, 3]),
        (Filters(of_subjects={"driver": ["sees"]}, categories=["both"]), [0]),
    ],
)
def test_filters_are_joined_and_keep_the_index(filters: Filters, rows: list[int]):
    sights = np.array(["sees", "open", "sees", "unseen", "unknown", "distant"], object)
    assert filters.keep(SIX, {"driver": sights}).index.tolist() == rows


def unfolded(page: AppTest) -> AppTest:
    page.session_state["encounters_weightings"] = True
    return checked(page.run())


def weighings(page: AppTest) -> pd.DataFrame:
    (weighed,) = [table.value for table in page.table if "Height (in use)" in table.value]
    return weighed


def test_the_encounter_is_weighed_by_height_horizon_and_distance_when_unfolded(page: AppTest):
    assert not [table for table in page.table if "Height (in use)" in table.value]
    weighed = weighings(unfolded(one(encounter_of(space_of(page).result, "rural_child:3"))))
    assert weighed.loc["From – to"].tolist() == ["215 – 255", "214 – 255", "204 – 255"]
    assert weighed.loc["Y misses"].tolist() == ["13, late", "14, late", "24, late"]
    assert weighed.loc["Severity of Y"].tolist() == ["0.44 s", "0.48 s", "0.87 s"]


def test_the_pedestrian_is_cut_out_of_visible_light_as_chosen(tmp_path, monkeypatch):
    begin_with(small_estimator.write_session(tmp_path), monkeypatch)
    page = one()
    assert not page.toggle(key="encounters_visible").value
    page = checked(page.toggle(key="encounters_visible").set_value(True).run())
    assert page.toggle(key="encounters_visible").value
    assert only(page, "picture") == "visible"


@pytest.fixture
def seen_and_not(tmp_path, monkeypatch: pytest.MonkeyPatch) -> AppTest:
    """The page of one pedestrian whom the driver sees, and one of whom it is not known."""
    of_x, of_y = (pages.rows(x).replace(",1,0.9", ",0.9") for x in (300, 100))
    folder = pages.write(tmp_path, {"one": of_x, "two": of_y}, truth="")
    head = "recording,frame,x,y,w,h,track,detectability\n"
    lines = [
        f"night,{frame},{x + frame},200,40,120,{x},{share}\n"
        for frame in pages.FRAMES
        for x, share in ((300, 0.8), (100, ""))
    ]
    (tmp_path / "truth.csv").write_text(head + "".join(lines))
    begin_with(folder, monkeypatch)
    return opened(driver="unknown")


def test_encounters_are_listed_by_what_the_driver_sees(seen_and_not: AppTest):
    page = seen_and_not
    assert listed(page)["track"].tolist() == [100]  # as the address asks for
    assert page.button_group(key="encounters_driver_1").options == [
        "sees, clearly", "does not see, clearly", "open, seen or not", "not known",
    ]  # fmt: skip
    page.button_group(key="encounters_driver_1").set_value(["sees"]).run()
    assert "Driver: sees. Detectability reaches 0.80 by the first frame that counts." in texts(page)
    assert only(page, "driver") == "sees"
    press(page, "encounters_clear")
    assert len(listed(page)) == 2
    order = [*listed(page)]  # beside who detects whether the driver sees
    assert order[order.index("category") :][:3] == ["category", "driver_sees", "within_sd"]
    assert listed(page)["driver_sees"].dropna().tolist() == ["yes"]
