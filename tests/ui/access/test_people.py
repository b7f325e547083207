"""Whom a cookie lets in: signed, young, for this address, on the list, and not logged out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from people import USER, cookies, log_in_by

from ui.access import people as module
from ui.access.people import NOBODY, end_log_in, is_same, key_of, owner_of_session


@pytest.fixture
def asked(tmp_path: Path) -> Iterator[None]:
    with log_in_by(tmp_path, allow=["lab.example"], hours=2):
        yield


def test_without_a_log_in_everybody_is_nobody():
    assert key_of({}) == owner_of_session() == NOBODY
    assert is_same(NOBODY, key_of({}))


def test_a_person_has_one_key_in_all_log_ins_and_nobody_else_has_it(asked: None):
    anna = key_of(cookies("anna"))
    assert anna is not None
    assert is_same(anna, key_of(cookies("anna", nonce="of another log-in")))
    assert not is_same(anna, key_of(cookies("bert", email="anna@lab.example")))
    assert not is_same(anna, key_of(cookies("anna", iss="https://other.example")))
    assert not is_same(anna, None)


@pytest.mark.parametrize(
    "more",
    [
        {"secret": "t" * 32},
        {"origin": "https://other.example"},
        {"is_logged_in": False},
        {"sub": None},
        {"email": "anna@elsewhere.example"},
        {"email_verified": False},
        {"email_verified": "true"},
    ],
)
def test_who_is_not_let_in(asked: None, more: dict[str, Any]):
    assert key_of(cookies("anna", **more)) is None


def test_a_cookie_that_was_tampered_with_is_worth_nothing(asked: None):
    (value,) = cookies("anna").values()
    for wrong in ("", "x", value[1:], value + "x", "é☃", "chunks-2"):
        assert key_of({USER: wrong}) is None
    assert key_of({"_streamlit_user_tokens": value}) is None


def test_a_log_in_lasts_as_long_as_it_is_set_up(asked: None, monkeypatch: pytest.MonkeyPatch):
    anna = cookies("anna")
    now = module.time.time()
    monkeypatch.setattr("itsdangerous.timed.time.time", lambda: now + 3600)
    assert key_of(anna) is not None
    monkeypatch.setattr("itsdangerous.timed.time.time", lambda: now + 7300)
    assert key_of(anna) is None


def test_after_the_log_out_a_copy_of_the_cookie_is_worth_nothing(asked: None):
    anna, again = cookies("anna"), cookies("anna", nonce="another")
    end_log_in(anna)
    assert key_of(anna) is None
    assert key_of(again) is not None
    end_log_in({})
    assert len(module._ended) == 1
