"""A run of a study in a real browser, without the app: what it shows, tells the page and sends."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Locator, Page, Route, expect

from nvcore.subjects.driver.study.settings import Timing
from ui.subjects.driver.study.screen import FOLDER
from ui.widgets.script import read_script

ADDRESS = "http://localhost:9/"  # nobody listens there: all is answered here
# Pictures are grey; what is sent is listed, and kept at once, or when the test says so.
HTML = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Study</title>
<link rel="stylesheet" href="screen.css"><body><div id="study"></div><script type="module">
import draw from "./study.js";
const grey = new OffscreenCanvas(32, 18);
grey.getContext("2d").fillRect(0, 0, 32, 18);
const picture = await grey.convertToBlob();
window.told = [];
window.sent = [];
window.waiting = [];
window.isHeld = window.isRefused = window.isLost = window.isGone = window.isFull = false;
window.locks = [];
Object.defineProperty(navigator, "wakeLock", { value: { request: async (kind) => {
  locks.push(kind);
  return { release: async () => { locks.push("released"); } };
} } });
window.fetch = async (address, options = {}) => {
  if (options.method !== "PUT") return new Response(picture);
  sent.push(address);
  if (isGone && address.startsWith("study/")) return new Response("ended", { status: 404 });
  if (isLost) throw new TypeError("Failed to fetch");
  if (isFull) return new Response("disk is full", { status: 503 });
  if (isRefused) return new Response("no such trial", { status: 400 });
  if (isHeld) await new Promise((done) => waiting.push(done));
  return new Response(null, { status: 204 });
};
window.following = () => ({
  ...begun, run: "run 2", title: "Begin run 2",
  trials: begun.trials.map((trial) => ({ ...trial, place: trial.place + 2 })),
});
window.begin = (data) => draw({
  data: window.begun = data, parentElement: document.getElementById("study"),
  setTriggerValue: (name, value) => told.push([name, value]),
});
</script></body></html>"""
SHORT = {
    "adaptation_s": (0.1, 0.2), "bright_s": 0.0, "preview_s": 0.0, "cross_s": 0.0, "show_s": 0.1,
    "answer_s": 0.0, "again_s": 0.0,
}  # fmt: skip
# Times with which a run stays in a phase, or in its answers.
STAYS = {
    "bright": {"bright_s": 600},
    "preview": {"preview_s": 600},
    "cross": {"cross_s": 600},
    "dark": {"adaptation_s": (500, 600)},
    "picture": {"show_s": 600},
    "answer": {},
    "again": {"adaptation_s": (0, 600)},
}
IN_THE_DARK = ("dark", "picture", "again")


def answer_request(route: Route) -> None:
    path = route.request.url.removeprefix(ADDRESS)
    if path == "study.js":
        route.fulfill(body=read_script(FOLDER / "run.js"), content_type="text/javascript")
    elif path == "screen.css":
        route.fulfill(path=FOLDER / "screen.css")
    else:
        route.fulfill(body="" if path else HTML, content_type="text/html")


@pytest.fixture
def run(person: BrowserContext) -> Iterator[Callable[..., Page]]:
    """Opens a run of two pictures with these times in a window of this size, and begins it.

    What happens to what is sent is one of the flags of `HTML`.
    """
    errors: list[str] = []
    pages: list[Page] = []

    def begin(fault: str = "", *, size: tuple[int, int] = (1280, 800), **times: Any) -> Page:
        page = person.new_page()
        pages.append(page)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.route(f"{ADDRESS}**", answer_request)
        page.set_viewport_size({"width": size[0], "height": size[1]})
        page.goto(ADDRESS)
        page.wait_for_function("'begin' in window")
        if fault:
            page.evaluate(f"window.{fault} = true")
        timing = Timing(**{**SHORT, **times})
        trials = [
            {"place": place, "picture": str(place), "width": 32, "height": 18, "adaptation_s": time}
            for place, time in enumerate(timing.adaptation_s, start=1)
        ]
        study = {"run": "run 1", "title": "Begin run 1", "url": "study", "whose": "anna"}
        study |= {"trials": trials}
        page.evaluate(f"begin({json.dumps({**study, 'timing': asdict(timing)})})")
        page.get_by_role("button", name="Begin run 1").click()
        return page

    yield begin
    for page in pages:
        page.close()
    assert errors == []


def reach(page: Page, phase: str) -> None:
    """Wait until the run is in this phase; the second cross comes after the first answer."""
    if phase == "again":
        answer(page, 1)
    expect(page.locator(f'.nv-study[data-phase="{phase}"]')).to_have_count(1)


def answer(page: Page, picture: int) -> None:
    """Wait until the run asks for this picture, and say that nobody was seen."""
    asked = f'.nv-study[data-phase="answer"][data-picture="{picture}"]'
    expect(page.locator(asked)).to_have_count(1)
    page.keyboard.press("n")


def stop_of(page: Page) -> Locator:
    return page.get_by_role("button", name="Stop")


def tap(page: Page, button: Locator) -> None:
    """Touch the middle of a button, whether it is drawn or not, as a finger does."""
    box = button.bounding_box()
    assert box is not None
    place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    browser = page.context.new_cdp_session(page)
    browser.send("Emulation.setTouchEmulationEnabled", {"enabled": True})
    browser.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [place]})
    browser.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_in_every_phase_stop_is_at_the_lower_edge_and_a_touch_of_it_ends_the_run(
    run: Callable[..., Page],
):
    for phase, times in STAYS.items():
        page = run(**times)
        reach(page, phase)
        page.wait_for_function("locks.join() === 'screen'")  # which stays awake

        # no light in the dark, and beside all that is to be looked at
        expect(stop_of(page), phase).to_have_css("opacity", "0" if phase in IN_THE_DARK else "1")
        window, stop, canvas = (
            place.bounding_box()
            for place in (page.locator("dialog"), stop_of(page), page.locator("canvas"))
        )
        assert window is not None
        assert stop is not None
        assert canvas is not None
        assert stop["y"] >= canvas["y"] + canvas["height"], phase
        assert window["width"] - stop["x"] - stop["width"] == pytest.approx(24, abs=1), phase

        tap(page, stop_of(page))
        expect(page.locator("dialog"), phase).not_to_be_visible()
        page.wait_for_function("told.length > 0")
        assert page.evaluate("told") == [["stopped", "run 1"]], phase
        page.wait_for_function("locks.join() === 'screen,released'")


def test_a_narrow_screen_has_room_for_text_and_buttons(run: Callable[..., Page]):
    page = run(size=(390, 844))
    reach(page, "answer")
    bar = page.locator(".nv-bar").bounding_box()
    parts = page.locator(".nv-bar > :visible")
    expect(parts).to_have_count(3)
    boxes = [part.bounding_box() for part in parts.all()]
    assert bar is not None
    edges = [edge for box in boxes if box for edge in (box["x"], box["x"] + box["width"])]
    assert edges == sorted(edges)
    assert (edges[0] >= 0, edges[-1] <= 390) == (True, True)
    assert all(box and bar["y"] <= box["y"] for box in boxes)
    assert all(box and box["y"] + box["height"] <= 844 for box in boxes)


def test_a_run_that_is_seen_to_its_end_has_ended_and_is_said_to_be_kept(run: Callable[..., Page]):
    page = run()
    expect(page.locator(".nv-bar span")).not_to_have_text(re.compile("kept"))
    for picture in (1, 2):
        answer(page, picture)
    page.wait_for_function("told.length > 0")
    assert page.evaluate("told") == [["ended", "run 1"]]
    assert page.evaluate("sent") == [
        "study/1/shown", "study/1/answer", "study/2/shown", "study/2/answer",
    ]  # fmt: skip
    page.evaluate("begin(following())")
    expect(page.locator(".nv-bar span")).to_have_text("The run is kept. Rest as long as you like.")


def test_an_answer_that_is_refused_is_told_and_the_run_is_not_offered_again(
    run: Callable[..., Page],
):
    page = run("isRefused")
    for picture in (1, 2):
        answer(page, picture)
    reach(page, "failed")
    tap(page, stop_of(page))
    expect(page.locator("dialog")).not_to_be_visible()
    expect(page.locator(".nv-message")).to_have_text("This does not work: no such trial")
    expect(page.get_by_role("button", name="Begin run 1")).to_be_disabled()
    assert page.evaluate("told") == []


def test_answers_that_are_not_kept_are_told_and_sent_again(run: Callable[..., Page]):
    for fault in ("isLost", "isFull"):
        page = run(fault)
        for picture in (1, 2):
            answer(page, picture)
        again = re.compile("trying again. Leave this page")
        expect(page.locator(".nv-bar span"), fault).to_have_text(again)
        page.evaluate(f"window.{fault} = false")
        page.wait_for_function("told.length > 0")
        assert page.evaluate("told") == [["ended", "run 1"]], fault


def test_answers_go_to_the_new_address_when_the_app_has_started_anew(run: Callable[..., Page]):
    page = run("isGone")
    for picture in (1, 2):
        answer(page, picture)
    expect(page.locator(".nv-bar span")).to_have_text(re.compile("trying again"))
    assert page.evaluate("told") == [["kept", "run 1"]]  # so that the page is drawn again
    page.evaluate("begin({ ...begun, url: 'new' })")
    page.wait_for_function("told.length > 1")
    assert page.evaluate("told")[1:] == [["ended", "run 1"]]
    kept = page.evaluate("sent.filter((address) => address.startsWith('new'))")
    assert kept == ["new/1/shown", "new/1/answer", "new/2/shown", "new/2/answer"]


def test_a_page_that_is_drawn_again_leaves_the_run_that_is_on(run: Callable[..., Page]):
    page = run(adaptation_s=(0, 0.1))
    answer(page, 1)
    page.evaluate("begin({ ...following(), url: 'new' })")
    answer(page, 2)
    page.wait_for_function("told.length > 0")
    assert page.evaluate("told") == [["ended", "run 1"]]
    expect(page.locator('.nv-study[data-run="run 2"][data-phase="ready"]')).to_have_count(1)


def load_again(page: Page, whose: str) -> None:
    """Load the page anew in the middle of a run, as it is drawn for this participant."""
    data = page.evaluate("begun")
    page.reload()
    page.wait_for_function("'begin' in window")
    page.evaluate("data => begin(data)", {**data, "url": "new", "whose": whose})


def test_answers_outlive_the_page_for_who_gave_them_and_no_picture_is_shown_again(
    run: Callable[..., Page],
):
    page = run("isGone", adaptation_s=(0, 600))
    reach(page, "again")
    load_again(page, "anna")
    page.wait_for_function("told.length > 0")
    assert page.evaluate("told") == [["kept", "run 1"]]
    assert page.evaluate("sent") == ["new/1/shown", "new/1/answer"]
    expect(page.get_by_role("button", name="Begin run 1")).to_be_disabled()

    # another participant in the tab sends none of them
    page = run("isGone", adaptation_s=(0, 600))
    reach(page, "again")
    load_again(page, "bert")
    expect(page.locator('.nv-study[data-phase="ready"]')).to_have_count(1)
    assert page.evaluate("sent") == []


def test_an_answer_waits_for_the_report_that_its_picture_appears(run: Callable[..., Page]):
    page = run("isHeld", adaptation_s=(0, 600))
    reach(page, "again")
    assert page.evaluate("sent") == ["study/1/shown"]
    page.evaluate("waiting[0]()")
    page.wait_for_function("sent.length > 1")
    assert page.evaluate("sent") == ["study/1/shown", "study/1/answer"]
