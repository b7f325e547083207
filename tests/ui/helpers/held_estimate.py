"""An estimate of whom the driver sees that is under way for as long as a test wants."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
import small_estimator
import streamlit as st
from streamlit.testing.v1 import AppTest

from nvcore.common.errors import InputError
from pages import TIMEOUT_S, checked, part, press, space_of
from ui.subjects.driver import run

TAKE_OVER = "ui.subjects.driver.run.take_over()"
"""What the app does once any page is drawn."""
FORM = ("ui.subjects.driver.run.draw(is_known=False)", TAKE_OVER)


def sent(folder: Path, *calls: str, **kind: float) -> AppTest:
    """The form, or these parts of the page, to which an estimator was sent."""
    page = checked(part(*(calls or FORM)).run())
    return send(page, small_estimator.write_model(folder / "small.npz", **kind))


def send(page: AppTest, file: Path) -> AppTest:
    page.file_uploader(key="estimator_file").set_value([(file.name, file.read_bytes(), "")])
    return checked(page.run())


class Held:
    """An estimate that is under way until it `ends`, started on its page."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, *, fails: str = ""):
        self._may_end, self._fails, self._run = threading.Event(), fails, run.run_confined
        monkeypatch.setattr(run, "run_confined", self._wait)
        # a link has to lead to a page of the app, which a part of a page does not know
        monkeypatch.setattr(st, "page_link", lambda *_, **link: st.caption(link.get("label", "")))
        page = sent(folder)
        self.space = space_of(page)
        self.used_before = self.space.used_bytes
        press(page, "driver_estimate")
        self.job = self.space.job("driver_run")

    def _wait(self, *given, **more):
        self._may_end.wait(TIMEOUT_S)
        if self._fails:
            raise InputError(self._fails)
        return self._run(*given, **more)

    def beside(self, page: str) -> AppTest:
        """What is said of the estimate beside this page."""
        aside = f"ui.subjects.driver.run.draw_aside({page!r})"
        return checked(part(aside, TAKE_OVER, space=self.space).run())

    def ends(self) -> None:
        self._may_end.set()
        self.job.join()

    @property
    def is_taken_over(self) -> bool:
        return self.space.opened.session.driver.detectability is not None
