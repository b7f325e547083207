"""The classes on the Detection page: shown where the truth and a system name some."""

from __future__ import annotations

from pathlib import Path

import pytest
from limits import write_limits
from signs import write_signs
from streamlit.testing.v1 import AppTest

from pages import begin_with, checked, part, texts


def classes(session: Path, patch: pytest.MonkeyPatch) -> AppTest:
    begin_with(session, patch)
    return checked(part("ui.views.detection.classes.draw(RESULT)").run())


def test_a_limit_that_was_read_wrong_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    page = classes(write_limits(tmp_path), monkeypatch)
    words = texts(page).replace("\\", "")
    assert "Classes" in [header.value for header in page.header]
    assert (
        "X: class correct in 66.7 % of 3 matches, 95 % confidence interval 20.8 % to 93.9 %"
        in words
    )
    assert "Y names no classes" in words


def test_signs_without_limits_to_compare_have_no_such_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    page = classes(write_signs(tmp_path), monkeypatch)
    assert "Classes" not in [header.value for header in page.header]
