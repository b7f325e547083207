"""A study in a browser, as its conductor begins it and as a participant goes through it."""

from __future__ import annotations

import re
from collections.abc import Sequence

from app_visit import Visit
from playwright.sync_api import Locator, expect

SHORT = {
    "Bright screen, s": "0.1",
    "Coarse picture, s": "0.1",
    "Cross before dark, s": "0.1",
    "Picture, s": "0.2",
    "Answer (0: no limit), s": "0",
    "Cross before the second picture, s": "0.1",
}


def choose_folder(one: Visit, name: str) -> None:
    """These pictures, also where the sample has some."""
    field = one.page.get_by_role("combobox", name="Pictures")
    field.fill(name)
    field.press("Enter")
    one.wait_until_drawn()


def shorten(one: Visit, times_s: Sequence[float]) -> None:
    """Let a run take moments, with pictures at these times after the change of light."""
    one.page.get_by_text("Times", exact=True).click()
    times = ", ".join(map(str, times_s))
    for label, value in {**SHORT, "Seconds from dark to each picture": times}.items():
        field = one.page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Enter")
        one.wait_until_drawn()


def start(one: Visit) -> tuple[str, str]:
    """Start the study; pages of the participants and of the conductor."""
    one.keyed("study_start").get_by_role("button").click()
    expect(one.heading("The study")).to_be_visible()
    codes = one.page.get_by_test_id("stCode").locator("code").filter(has_text="http")
    expect(codes).to_have_count(2)
    study, conduct = (code.inner_text().strip().rpartition("/")[2] for code in codes.all())
    return study, conduct


def join(one: Visit) -> str:
    """Agree and take part; the participant's code."""
    one.page.get_by_role("spinbutton", name="Age in years").fill("31")
    one.page.get_by_text("I have read this and agree").click()
    one.page.get_by_role("button", name="Take part", exact=True).click()
    expect(one.heading("Practice")).to_be_visible()
    return re.search("participant=(.+)", one.page.url)[1]


def begins(one: Visit, name: str) -> None:
    """Begin the run of that name when its pictures are there, wherever its button is."""
    expect(phase(one, "ready")).to_have_count(1)
    one.page.get_by_role("button", name=name, exact=True).last.click()


def practise(one: Visit) -> None:
    begins(one, "Begin the practice")
    answer_both(one)


def answer_both(one: Visit) -> None:
    """Answer that nobody was seen, by keyboard."""
    for picture in (1, 2):
        expect(phase(one, "answer").and_(asked_for(one, picture))).to_have_count(1)
        one.page.keyboard.press("n")


def phase(one: Visit, name: str) -> Locator:
    return one.page.locator(f'.nv-study[data-phase="{name}"]')


def asked_for(one: Visit, picture: int) -> Locator:
    """The study while it shows this picture of a run, or waits for its answer."""
    return one.page.locator(f'.nv-study[data-picture="{picture}"]')


def pixel_on_screen(one: Visit, x: float, y: float, size: tuple[int, int]) -> tuple[float, float]:
    """Where a pixel of a picture of this size is in the window."""
    box = one.page.locator(".nv-study canvas").bounding_box()
    scale = min(box["width"] / size[0], box["height"] / size[1])
    left = box["x"] + (box["width"] - scale * size[0]) / 2
    top = box["y"] + (box["height"] - scale * size[1]) / 2
    return left + scale * x, top + scale * y
