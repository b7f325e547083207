"""Questions that engineers come with, each answered in few clicks on the sample."""

from __future__ import annotations

import re
from dataclasses import dataclass

from app_visit import SECTION_OF, Visit
from playwright.sync_api import Locator, expect

from ui.shell.pages import GROUPS


@dataclass
class Asker:
    """Somebody with a question; counts the clicks, keys on sliders aside."""

    visit: Visit
    clicks: int = 0

    def click(self, what: Locator) -> None:
        self.clicks += 1
        what.click()
        self.visit.wait_until_drawn()

    def open(self, title: str) -> None:
        self.clicks += SECTION_OF[title] in GROUPS  # unfolds it
        self.click(self.visit.find_entry(title))
        expect(self.visit.heading(title, level=1)).to_be_visible()

    def follow(self, question: str, title: str) -> None:
        """Go to the page that the Overview's link with this question opens."""
        self.click(self.visit.keyed("questions").get_by_role("link", name=question))
        expect(self.visit.heading(title, level=1)).to_be_visible()

    def reads(self, text: str | re.Pattern[str], *, within: str = "stMain") -> None:
        expect(self.visit.page.get_by_test_id(within)).to_contain_text(text)

    def starts_anew(self) -> None:
        """Return to where questions begin."""
        if not self.visit.heading("Overview", level=1).count():
            self.visit.switch_to("Overview")
        self.clicks = 0


def test_about_the_whole_comparison(visit):
    asker = Asker(visit(""))

    # does one recording decide?
    asker.reads("whichever recording is left out: by 0.005 or more (least without rural_road)")
    asker.reads("stays ahead in encounters detected, severity and false-alert episodes")
    assert asker.clicks == 0

    # a figure for a slide says who X and Y are
    menu = asker.visit.page.get_by_test_id("stMain").locator(".nv-take").first
    asker.click(menu.locator("summary"))
    with asker.visit.page.expect_download() as download:
        asker.click(menu.get_by_role("button", name="Drawing"))
    assert asker.clicks == 2
    drawing = download.value.path().read_text(encoding="utf-8")
    assert "X: FIR" in drawing
    assert "Y: NIR" in drawing

    # how many more drives would it take?
    asker.starts_anew()
    asker.click(asker.visit.keyed("overview_more").get_by_text("How much more would it take?"))
    asker.reads(re.compile(r"recordings like these|in 80 % of|too few recordings to plan from"))
    assert asker.clicks == 1

    # every pair of three systems in words
    asker.starts_anew()
    asker.follow("How do all systems compare?", "Systems")
    asker.reads("FIR – NIR 2")
    asker.reads("NIR – NIR 2")
    assert asker.clicks == 1

    # night only
    asker.starts_anew()
    asker.click(asker.visit.keyed("tags_chosen").get_by_role("combobox"))
    asker.click(asker.visit.page.get_by_role("option", name="night", exact=True))
    asker.visit.page.keyboard.press("Escape")
    asker.reads("7 recordings, 2,100 frames")
    assert asker.clicks == 2
    asker.visit.switch_to("Timeline")  # all pages follow
    expect(asker.visit.recording_field("urban_crossing")).to_have_count(1)


def test_about_who_was_missed_and_when(visit):
    asker = Asker(visit(""))

    # only Y, by severity, one after the other
    asker.click(asker.visit.keyed("open_y_only").get_by_role("button"))
    asker.reads("5 of 46 encounters")
    asker.visit.keyed("encounters_next").get_by_role("button").click()
    asker.reads(re.compile(r"2\s*of 5"))
    assert asker.clicks == 1

    # would the driver have seen them?
    asker.starts_anew()
    asker.follow("Would the driver have seen them?", "Driver")
    expect(asker.visit.page.get_by_role("button", name="Estimate")).to_be_visible()
    assert asker.clicks == 1

    # the truth's doubtful boxes, for the annotators
    asker.starts_anew()
    asker.open("Data")
    asker.click(asker.visit.page.get_by_role("button", name=re.compile("Show (all|the)")).first)
    asker.visit.page.locator("[class*='st-key-entries_table_']").wait_for()
    assert asker.clicks == 2

    # children only; from which speed on the order turns; would braking have helped at 80 km/h?
    asker.starts_anew()
    asker.open("Time left")
    sections = asker.visit.keyed("time_left_more")
    asker.click(sections.get_by_text("By class of pedestrian"))
    row = asker.visit.page.locator(".nv-time-left-by-class tr", has_text="child")
    expect(row).to_be_visible()
    assert asker.clicks == 2
    asker.click(sections.get_by_text("If the car were slower or faster"))
    asker.reads(re.compile(r"Below \d+ km/h, [XY] .* from there on, [XY]"))
    for speed in range(55, 85, 5):
        asker.visit.slider("Assumed speed").press("ArrowRight")
        expect(asker.visit.slider("Assumed speed")).to_have_value(str(speed))
    asker.reads(re.compile(r"Of \d+ urgent encounters at 80 km/h .* confirms \d+ in time"))
    assert asker.clicks == 3

    # who is hit hardest is shown with the settings kept
    asker.clicks = 0
    asker.click(sections.get_by_text("One by one"))
    asker.click(asker.visit.table("time_left_list").get_by_role("rowheader").first)
    expect(asker.visit.heading("Timeline", level=1)).to_be_visible()
    asker.visit.query("speed_kmh", "80")
    assert asker.clicks == 2


def test_of_a_link(visit):
    # who is better at as many false alarms?
    asker = Asker(visit("?threshold_x=0.3"))
    asker.reads("At equal false alarms, not as set (X at a confidence threshold of")
    assert asker.clicks == 0
    asker.click(asker.visit.page.get_by_role("button", name="X to Y", exact=True))
    asker.reads("Undo", within="stSidebar")
    assert asker.clicks == 1

    # what did the next version break and mend?
    asker = Asker(visit("?x=NIR&y=NIR 2"))
    expect(asker.visit.keyed("open_x_only")).to_contain_text("Only NIR 0")  # newly missed
    asker.click(asker.visit.keyed("open_y_only").get_by_role("button"))
    asker.reads("2 of 46 encounters")  # it mends these
    assert asker.clicks == 1
