"""Questions that engineers come with, each answered in few clicks on the sample."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import pytest
from app_visit import Visit
from playwright.sync_api import Locator, expect

from ui.shell.pages import GROUPS, SECTIONS


@dataclass
class Asker:
    """Somebody with a question; counts the clicks, keys on sliders aside."""

    visit: Visit
    clicks: int = field(default=0)

    def click(self, what: Locator) -> None:
        self.clicks += 1
        what.click()
        self.visit.wait_until_drawn()

    def open(self, title: str) -> None:
        self.clicks += any(title in SECTIONS[group].values() for group in GROUPS)  # unfolds it
        self.click(self.visit.find_entry(title))
        expect(self.visit.heading(title, level=1)).to_be_visible()

    def reads(self, text: str | re.Pattern[str], *, within: str = "stMain") -> None:
        expect(self.visit.page.get_by_test_id(within)).to_contain_text(text)


@pytest.fixture
def asker(visit) -> Asker:
    return Asker(visit(""))


def test_would_braking_have_helped_at_80_km_an_hour(asker):
    asker.open("Time left")
    for speed in range(55, 85, 5):
        asker.visit.slider("Assumed speed").press("ArrowRight")
        expect(asker.visit.slider("Assumed speed")).to_have_value(str(speed))
    asker.reads(re.compile(r"Of \d+ urgent encounters at 80 km/h .* confirms \d+ in time"))
    assert asker.clicks == 1


def test_only_y_by_severity_one_after_the_other(asker):
    asker.click(asker.visit.keyed("open_y_only").get_by_role("button"))
    asker.reads("5 of 46 encounters")
    asker.visit.keyed("encounters_next").get_by_role("button").click()
    asker.reads(re.compile(r"2\s*of 5"))
    assert asker.clicks == 1


def test_does_one_recording_decide(asker):
    asker.reads("whichever recording is left out: by 0.005 or more (least without rural_road)")
    asker.reads("stays ahead in encounters detected, severity and false-alert episodes")
    assert asker.clicks == 0


def test_who_is_better_at_as_many_false_alarms(visit):
    asker = Asker(visit("?threshold_x=0.3"))
    asker.reads("At equal false alarms (X with scores of")
    assert asker.clicks == 0
    asker.click(asker.visit.page.get_by_role("button", name="X to Y", exact=True))
    asker.reads("Undo", within="stSidebar")
    assert asker.clicks == 1


def test_what_did_the_next_version_break_and_mend(visit):
    asker = Asker(visit("?x=NIR&y=NIR 2"))
    expect(asker.visit.keyed("open_x_only")).to_contain_text("Only X 0")  # newly missed
    asker.click(asker.visit.keyed("open_y_only").get_by_role("button"))
    asker.reads("2 of 46 encounters")  # it mends these
    assert asker.clicks == 1


def test_every_pair_of_three_systems_in_words(asker):
    asker.open("Systems")
    asker.reads("FIR – NIR 2")
    asker.reads("NIR – NIR 2")
    assert asker.clicks == 2


def test_a_figure_for_a_slide_says_who_x_and_y_are(asker):
    menu = asker.visit.page.get_by_test_id("stMain").locator(".nv-take").first
    asker.click(menu.locator("summary"))
    with asker.visit.page.expect_download() as download:
        asker.click(menu.get_by_role("button", name="Drawing"))
    assert asker.clicks == 2
    drawing = download.value.path().read_text(encoding="utf-8")
    assert "X: FIR" in drawing
    assert "Y: NIR" in drawing


def test_the_truth_s_doubtful_boxes_for_the_annotators(asker):
    asker.open("Data")
    asker.click(asker.visit.page.get_by_role("button", name=re.compile("Show (all|the)")).first)
    asker.visit.page.locator("[class*='st-key-entries_table_']").wait_for()
    assert asker.clicks == 2


def test_night_only(asker):
    field_of_tags = asker.visit.keyed("tags_chosen")
    asker.click(field_of_tags.get_by_role("combobox"))
    asker.click(asker.visit.page.get_by_role("option", name="night", exact=True))
    asker.visit.page.keyboard.press("Escape")
    asker.reads("7 recordings, 2,100 frames")
    assert asker.clicks == 2
    asker.visit.switch_to("Timeline")  # all pages follow
    expect(asker.visit.recording_field("urban_crossing")).to_have_count(1)


def test_who_is_hit_hardest_is_shown_with_the_settings_kept(visit):
    asker = Asker(visit("time_left?speed_kmh=70"))
    asker.click(asker.visit.table("time_left_list").get_by_role("rowheader").first)
    expect(asker.visit.heading("Timeline", level=1)).to_be_visible()
    asker.visit.query("speed_kmh", "70")
    assert asker.clicks == 1


def test_from_which_speed_on_the_order_turns(asker):
    asker.open("Time left")
    asker.reads(re.compile(r"Below \d+ km/h [XY] .* from there on [XY]"))
    assert asker.clicks == 1


def test_how_many_more_drives_it_would_take(asker):
    asker.click(asker.visit.keyed("overview_more").get_by_text("How much more would it take?"))
    asker.reads(re.compile(r"recordings like these|in 80 % of"))
    assert asker.clicks == 1


def test_children_only(asker):
    asker.open("Time left")
    row = asker.visit.page.locator(".nv-time-left-by-class tr", has_text="child")
    expect(row).to_be_visible()
    assert asker.clicks == 1


def test_would_the_driver_have_seen_him(asker):
    asker.open("Driver")
    expect(asker.visit.page.get_by_role("button", name="Estimate")).to_be_visible()
    assert asker.clicks == 2
