"""The document's title says what is open: ten tabs have ten titles."""

from __future__ import annotations

import pytest
import streamlit as st
from places import ROOT

from pages import begin_with, checked, opened, rows, to_page, write


@pytest.fixture
def titles(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    given: list[str] = []
    real = st.set_page_config

    def note(**settings: str) -> None:
        given.append(settings["page_title"])
        real(**settings)

    monkeypatch.setattr(st, "set_page_config", note)
    return given


def test_the_title_names_the_page_or_the_frame_and_the_systems(titles: list[str]):
    page = opened("metrics", recording="winter_frost", frame="193")
    assert titles[-1] == "Documentation · FIR/NIR · nvcore"
    checked(to_page(page, "timeline"))
    assert titles[-1] == "winter_frost 9.65 s · FIR/NIR · nvcore"
    checked(page.run())
    assert set(titles[-3:]) == {"winter_frost 9.65 s · FIR/NIR · nvcore"}  # it does not flicker


def test_a_title_holds_no_signs_that_act_and_no_long_names(titles, tmp_path, monkeypatch):
    path = write(tmp_path, {"only": "night,3,1,1,20,40,0.5\n"}, truth=rows(300))
    path.write_text(
        path.read_text().replace('name = "only"', 'name = "a\\u001b\\u202e' + "b" * 60 + '"')
    )
    begin_with(path, monkeypatch)
    opened("metrics")
    assert titles[-1] == r"Documentation · a\x1b\u202ebbbbbbbbbbbb… · nvcore"


def test_the_logo_is_outlines_that_no_other_font_widens():
    logo = (ROOT / "ui" / "assets" / "logo.svg").read_text(encoding="utf-8")
    assert "<path" in logo
    assert "<text" not in logo
