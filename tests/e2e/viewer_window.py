"""What a test does to the viewer in its window, and what it reads from it."""

from __future__ import annotations

import re
from contextlib import suppress

from playwright import sync_api
from viewer_reading import READER


def viewer_of(page: sync_api.Page) -> sync_api.Locator:
    return page.locator(".viewer")


def painted(page: sync_api.Page, row: int) -> int:
    """The row on the canvas, once it is this one or has had the time to be."""
    with suppress(sync_api.TimeoutError):
        page.wait_for_selector(f'.viewer[data-shown-row="{row}"]')
    return int(viewer_of(page).get_attribute("data-shown-row") or -1)


def settled(page: sync_api.Page, row: int | str) -> str:
    """The row that Python has heard of, once it is this one or has had the time to be."""
    text = page.get_by_text(re.compile("^settled "))
    with suppress(sync_api.TimeoutError):
        text.filter(has_text=re.compile(f"^settled {row} ")).wait_for()
    return text.inner_text().split()[1]


def press(page: sync_api.Page, *keys: str) -> None:
    viewer_of(page).focus()
    for key in keys:
        page.keyboard.press(key)


def choose(page: sync_api.Page, recording: str) -> None:
    page.get_by_role("combobox", name="recording").click()
    page.get_by_role("option", name=recording, exact=True).click()


def read(page: sync_api.Page) -> dict[str, float]:
    return viewer_of(page).evaluate(READER)
