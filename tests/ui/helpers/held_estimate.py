"""An estimate of whom the driver sees that is under way for as long as a test wants."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest
import small_estimator

from nvcore.errors import InputError
from pages import TIMEOUT_S, checked, opened, to_page
from ui.driver import run


class Held:
    """An estimate that is under way until it `ends`, started on its page in the app."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, *, fails: str = ""):
        self._may_end, self._fails, self._run = threading.Event(), fails, run.run_confined
        monkeypatch.setattr(run, "run_confined", self._wait)
        page = checked(opened("driver"))
        content = small_estimator.write_model(folder / "small.npz").read_bytes()
        page.file_uploader(key="estimator_file").set_value([("small.npz", content, "")])
        page = checked(page.run())
        self.page = checked(page.button(key="driver_estimate").click().run())
        self.space = self.page.session_state["workspace"]
        self.job = self.space.job("driver_run")

    def _wait(self, *given, **more):
        self._may_end.wait(TIMEOUT_S)
        if self._fails:
            raise InputError(self._fails)
        return self._run(*given, **more)

    def look_at(self, name: str):
        self.page = checked(to_page(self.page, name))
        return self.page

    def ends(self) -> None:
        self._may_end.set()
        self.job.join()

    @property
    def is_taken_over(self) -> bool:
        return self.space.opened.session.driver.detectability is not None
