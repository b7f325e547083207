"""Errors reach a visitor as a sentence: as text, without the folders of the machine."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import pytest
from data_page import PNG
from streamlit.testing.v1 import AppTest

from nvcore.common.errors import InputError
from nvcore.inputs.load import load
from nvcore.pictures.recordings import session_pictures
from pages import checked, opened, press, scripted, session
from ui.session import state
from ui.session.state import ROOT
from ui.session.uploads import receive
from ui.session.workspace import Opened, Workspace
from ui.shell.messages import shown_error


def banner(error: str) -> str:
    """What the banner says of this error, which is Python."""
    script = (
        "from nvcore.common.errors import InputError\nfrom ui.shell.messages import error_banner\n"
    )
    (shown,) = scripted(f"{script}assert error_banner({error})").run().error
    return shown.value


def failing_page(
    monkeypatch: pytest.MonkeyPatch, error: Exception, *, is_sent: bool = False
) -> AppTest:
    """The Overview, while this goes wrong in it."""

    def fail() -> None:
        raise error

    page = checked(opened())
    if is_sent:
        space = page.session_state["workspace"]
        asyncio.run(receive(space, "a.png", chunks(PNG)))
    monkeypatch.setattr(state, "result", fail)
    return checked(page.run())


async def chunks(content: bytes) -> AsyncIterator[bytes]:
    yield content


def offered(page: AppTest) -> set[str]:
    return {str(button.key) for button in page.button if "way_out" in str(button.key)}


def test_a_page_that_fails_by_a_fault_lets_one_start_over(monkeypatch: pytest.MonkeyPatch):
    page = failing_page(monkeypatch, KeyError("secret"))
    assert (offered(page), len(page.error)) == ({"way_out_anew"}, 1)  # the sidebar fails as well
    before = page.session_state["workspace"]
    monkeypatch.undo()
    page.session_state["settings"] = {"alpha": 0.2}
    press(page, "way_out_anew")
    assert page.session_state["workspace"] is not before
    assert (offered(page), before.opened, before.folder.exists()) == (set(), None, False)
    assert page.session_state["alpha"] == 0.9


def test_files_that_were_sent_can_be_taken_away(monkeypatch: pytest.MonkeyPatch):
    page = failing_page(monkeypatch, KeyError("secret"), is_sent=True)
    assert offered(page) == {"way_out_remove", "way_out_back", "way_out_anew"}
    press(page, "way_out_remove")
    assert page.session_state["workspace"].stored == {}
    assert offered(page) == {"way_out_anew"}


def test_what_was_opened_can_be_left_for_what_the_app_started_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    page = checked(opened())
    space = page.session_state["workspace"]
    night = session(tmp_path, "fir.csv")
    dataset = load(night)
    space.show(Opened.of(night, dataset, "night"), session_pictures(night, dataset))
    with monkeypatch.context() as patch:
        patch.setattr(state, "write_address", fail_on("night", space))
        checked(page.run())
        assert offered(page) == {"way_out_back", "way_out_anew"}
        press(page, "way_out_back")
    assert space.opened.label == state.SAMPLE_LABEL
    assert offered(page) == set()


def fail_on(label: str, space: Workspace) -> Callable[[], None]:
    """What cannot go on while this is open, as the data are at fault."""

    def fail() -> None:
        if space.opened is not None and space.opened.label == label:
            raise InputError("it cannot be drawn")

    return fail


def test_an_error_in_the_data_is_told_as_text():
    assert banner('InputError("the file is *odd*")') == "the file is \\*odd\\*"


def test_a_fault_of_the_program_is_told_without_its_details(caplog: pytest.LogCaptureFixture):
    with caplog.at_level(logging.ERROR, logger="nvcore.ui"):
        text = banner('KeyError("secret")')
    assert "a fault of the program" in text
    assert "secret" not in text
    assert "secret" in caplog.text


def test_an_error_loses_the_local_root_and_its_markup(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    error = InputError("**no** number", file=f"{tmp_path.resolve()}/night/t.csv")
    assert shown_error(error) == r"night/t\.csv\: \*\*no\*\* number"
    # also where nothing is open
    assert shown_error(InputError("gone", file=ROOT / "sample_data")) == r"sample\_data\: gone"


def test_an_error_loses_the_folder_of_uploads():
    page = AppTest.from_string(
        "import streamlit as st\n"
        "from ui.shell.messages import shown_error\n"
        "st.text(shown_error(OSError(str(st.session_state['workspace'].folder / 'a'))))"
    )
    page.session_state["workspace"] = Workspace()
    assert page.run().text[0].value == "a"
