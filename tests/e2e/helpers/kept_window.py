"""A window that tests use one after the other, since opening one costs seconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Generic, Protocol, TypeVar

import pytest
from playwright.sync_api import Page

HAS_FAILED = pytest.StashKey[bool]()


class Window(Protocol):
    """Something in the browser that notes what goes wrong in it."""

    complaints: list[str]
    page: Page


AnyWindow = TypeVar("AnyWindow", bound=Window)


class Kept(Generic[AnyWindow]):
    """Opened when the first test wants it, and again after a test that went wrong."""

    def __init__(self, open_window: Callable[[], AnyWindow]) -> None:
        self._open = open_window
        self._window: AnyWindow | None = None

    @contextmanager
    def lend(self, request: pytest.FixtureRequest) -> Iterator[AnyWindow]:
        """The window for one test; afterwards nothing may have gone wrong in it."""
        if self._window is None:
            self._window = self._open()
        window = self._window
        is_sound = False
        try:
            yield window
            assert window.complaints == [], window.complaints
            is_sound = not request.node.stash.get(HAS_FAILED, False)
        finally:
            if not is_sound:
                self.close()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.page.close()
            self._window = None
