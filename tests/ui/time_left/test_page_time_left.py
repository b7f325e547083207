"""The Time left page, driven without a browser."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from approach import approach, only
from builders import Box
from streamlit.testing.v1 import AppTest

import pages
from nvcore.common.wording.footnotes import Footnotes
from nvcore.evidence.measures import Evidence
from nvcore.evidence.units import BLOCKS
from nvcore.subjects.time_left.steps import time_left_in
from pages import HEAD, alone, begin_with, checked, figures, sidebar, tables, texts
from ui.session.chosen import encounter_of
from ui.subjects.time_left.numbers import with_interval
from ui.widgets.html import MeasureRow

ASSUMED = "Assumed speed (km/h)"


def alone_on(section: str | None = None) -> AppTest:
    """The page with one of its sections unfolded."""
    page = alone("time_left")
    page.session_state["time_left_more"] = section
    return checked(page.run())


@pytest.fixture(scope="module")
def page() -> AppTest:
    """The page on the sample, to look at."""
    return alone_on()


def headings(page: AppTest) -> list[str]:
    """Titles of the figures, in their order."""
    return [figure["layout"]["meta"][0] for figure in figures(page)]


def table(page: AppTest) -> pd.DataFrame:
    return tables(page)[0]


def csv(boxes: list[Box], *, has_tracks: bool) -> str:
    return "".join(
        f"night,{box.frame},{box.x},{box.y},{box.w},{box.h}"
        f"{f',{box.track}' if has_tracks else ',0.9'}\n"
        for box in boxes
    )


def session(folder: Path, truth: list[Box], *systems: list[Box]) -> Path:
    """One recording of 100 x 100 px, 40 frames at ten a second, and systems named by number."""
    head = HEAD.replace(",track,score", "")[:-1]
    (folder / "truth.csv").write_text(f"{head},track\n{csv(truth, has_tracks=True)}")
    text = '[defaults]\nsize = "100x100"\nfps = 10\nframes = "0:39"\n'
    text += '[truth]\npath = "truth.csv"\n'
    for number, boxes in enumerate(systems):
        (folder / f"{number}.csv").write_text(f"{head},score\n{csv(boxes, has_tracks=False)}")
        text += f'[[system]]\nname = "s{number}"\npath = "{number}.csv"\n'
    path = folder / "session.toml"
    path.write_text(text)
    return path


def test_the_sample_has_the_numbers_of_an_independent_reading(page: AppTest):
    headline = page.header[0].value
    assert headline.replace("\\", "").startswith(
        "Of 20 urgent encounters at 50 km/h (assumed), X confirms 19 in time and Y 15. The mean "
        "impact speed is 1.3 km/h with X and 9.0 km/h with Y"
    )
    measures = pages.measures(page, "time-left")
    assert measures["urgent encounters in time, of 20 ↑"] == ("19", "15", "+4", "")
    assert measures["as a share[a]"][2] == "+20.0 pp"
    assert measures["as a share[a]"][3] == "–"  # only two recordings differ
    assert measures["confirmed too late ↓"][:2] == ("1", "5")
    assert "X and Y differ in too few recordings for a test: 2" in texts(page)
    assert "In time means that a warning could have come early enough, not that" in texts(page)
    assert headings(page) == ["From the first sight to contact"]
    assert not tables(page)


def test_the_order_turns_at_a_speed():
    page = alone_on("speeds")
    assert headings(page)[1:] == ["Share in time over speed", "Mean impact speed over speed"]
    assert "Below 75 km/h, X confirms the larger share in time; from there on, Y does" in texts(
        page
    )


def test_children_only_stand_in_the_table_by_class():
    page = alone_on("classes")
    rows = pages.measures(page, "time-left-by-class")
    assert rows["child, 2 urgent[c]"] == (
        *("1", "0", "+50.0 pp", "–", "13.0", "30.5", "−17.6", "–"),
    )
    assert "c: Too few recordings for an interval: 1, at least 8 are needed." in texts(page)


def test_the_list_has_the_fastest_impact_first_and_opens_the_last_chance(
    monkeypatch: pytest.MonkeyPatch,
):
    shown: list[int] = []
    monkeypatch.setattr("ui.subjects.time_left.listed.open_row", shown.append)
    page = alone_on("encounters")
    assert headings(page)[1:] == ["Margin of X against Y"]
    assert len(table(page)) == 20
    worst = table(page)[["impact_kmh_x", "impact_kmh_y"]].max(axis=1)
    assert worst.is_monotonic_decreasing
    assert table(page)["time_left_y"].iloc[0] == "late"
    result = page.session_state["workspace"].result
    first = table(page).iloc[0]
    encounter = encounter_of(result, f"{first['recording']}:{first['track']}")
    row = int(time_left_in(result).urgency["urgent_row"].iloc[encounter])
    page = alone("time_left")
    page.session_state["time_left_open"] = encounter, row
    checked(checked(page.run()).run())
    assert shown == [row]
    chosen = page.session_state["encounters_chosen"][1]
    assert chosen == f"rural_road:{first['track']}"


def test_the_speed_stands_first_in_the_sidebar_and_moves_all():
    page = sidebar(page="time_left")
    first = page.slider[0]
    assert (first.label, first.value) == (ASSUMED, 50)
    assert not first.disabled
    assert [slider.label for slider in page.slider].count(ASSUMED) == 1
    page = checked(first.set_value(100.0).run())
    assert "".join(page.query_params["speed_kmh"]) == "100"
    assert ASSUMED not in [slider.label for slider in sidebar(page="saliency").slider]
    page = checked(alone("time_left", speed_kmh="100").run())
    headline = page.header[0].value
    assert "Of 30 urgent encounters at 100 km/h" in headline.replace("\\", "")
    # more than a screen full: in parts
    choice = page.selectbox(key="time_left_first")
    assert len(choice.options) == 2
    checked(choice.set_value(20).run())


def test_a_few_encounters_are_called_few_and_a_system_that_is_never_sure_hits_at_full_speed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    boxes = approach(range(40), 5)
    begin_with(session(tmp_path, boxes, boxes, only(boxes, range(3))), monkeypatch)
    page = alone_on("encounters")
    assert "There is only 1 urgent encounter. It shows what happened in these recordings" in texts(
        page
    )
    assert pages.measures(page, "time-left")["median margin, where both confirm (s)"][0] != "–"
    assert "recording" not in tables(page)[0]


def test_where_the_recordings_state_their_speed_the_assumed_one_moves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    boxes = approach(range(40), 5)
    path = session(tmp_path, boxes, boxes, boxes)
    path.write_text(f'[[recording]]\nname = "night"\nspeed_kmh = 90\n{path.read_text()}')
    begin_with(path, monkeypatch)
    page = alone_on()
    assert "The recordings state the speed of the car: the assumed one moves nothing." in texts(
        page
    )
    assert "The only urgent encounter at the speed of each recording" in texts(page)


def test_where_nobody_is_urgent_the_page_says_why_and_what_the_speed_would_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    still = [box._replace(frame=frame) for frame in range(40) for box in approach([0], 5)]
    begin_with(session(tmp_path, still, still, still), monkeypatch)
    page = alone_on()
    assert "Nobody is urgent at 50 km/h (assumed)." in texts(page)
    assert "neither system is better in that" in texts(page)
    assert not tables(page)
    assert not page.header
    assert not headings(page)
    assert page.button_group(key="time_left_more").options == ["If the car were slower or faster"]
    page.button_group(key="time_left_more").set_value("speeds")
    assert "No encounter is urgent at any speed" in texts(checked(page.run()))


def test_where_time_left_is_unknown_the_page_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    boxes = [box._replace(track=number) for number, box in enumerate(approach(range(40), 5))]
    begin_with(session(tmp_path, boxes, boxes, boxes), monkeypatch)
    page = alone_on()
    assert "Time left to stop is unknown for all encounters" in texts(page)
    assert "Nothing can be said of any of them" in texts(page)
    assert not page.header


def test_notes_are_lettered_from_a_on_beside_the_star_of_blocks() -> None:
    notes = Footnotes()
    unknown = Evidence.undefined("mean_impact_kmh", "", "lower", unit=BLOCKS, note="")
    in_blocks = replace(unknown, low=-2.0, high=-1.0)
    noted = replace(unknown, note="too few; all the same")
    row = MeasureRow("", ("1", "2", "−1"))
    assert with_interval(row, in_blocks, notes).cells[-1] == "−2.0 to −1.0 *"
    assert with_interval(row, noted, notes).marks == "a b"
    assert notes.marks == {
        "within these recordings alone": "*",
        "too few": "a",
        "all the same": "b",
    }
