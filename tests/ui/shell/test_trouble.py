"""Errors reach a visitor as a sentence."""

from __future__ import annotations

import logging

import pytest
from streamlit.testing.v1 import AppTest

from pages import TIMEOUT_S


def page(kind: str) -> None:
    from nvcore.errors import InputError
    from ui.shell.messages import error_banner

    errors = {"data": InputError("the file is *odd*"), "bug": KeyError("secret")}
    assert error_banner(errors[kind])


def shown(kind: str) -> str:
    (error,) = AppTest.from_function(page, args=(kind,), default_timeout=TIMEOUT_S).run().error
    return error.value


def test_an_error_in_the_data_is_told_as_text():
    assert shown("data") == "the file is \\*odd\\*"


def test_a_fault_of_the_program_is_told_without_its_details(caplog: pytest.LogCaptureFixture):
    with caplog.at_level(logging.ERROR, logger="nvcore.ui"):
        text = shown("bug")
    assert "a fault of the program" in text
    assert "secret" not in text
    assert "secret" in caplog.text
