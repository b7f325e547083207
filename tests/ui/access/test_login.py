"""The section [auth]: what it means, and what ends the start of a server."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
import streamlit as st
from people import AUTH, log_in_by

from nvcore.common.errors import InputError, MissingExtraError
from ui.access import login as module
from ui.access.login import login, read_login


def read(base: str = "", **more: Any):
    return read_login({**AUTH, **more}, file="auth.toml", base=base)


def test_without_a_list_everybody_whom_the_provider_knows_may_enter():
    by = read()
    assert (by.origin, by.is_secure, by.hours) == ("https://tools.example", True, 12)
    assert by.providers == ("default",)
    assert by.admits("")


@pytest.mark.parametrize(
    ("email", "enters"),
    [
        *(("Anna@Lab.Example", True), ("carl@partner.example", True)),
        *(("bert@partner.example", False), ("anna@sub.lab.example", False)),
        *(("anna@evil.example@lab.example", False), ("@lab.example", False), ("", False)),
        *(("lab.example", False), ("car\N{KELVIN SIGN}@lab.example", False)),
    ],
)
def test_a_list_names_domains_and_addresses(email: str, enters: bool):
    assert read(allow=["@lab.example", "carl@partner.example"]).admits(email) == enters


def test_several_providers_are_known_by_name():
    keys = ("client_id", "client_secret", "server_metadata_url")
    section = {key: value for key, value in AUTH.items() if key not in keys}
    named = {key: AUTH[key] for key in keys}
    by = read_login({**section, "one": named, "two": named}, file="")
    assert by.providers == ("one", "two")


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"redirect_uri": "tools.example"}, "expected https://HOST/oauth2callback"),
        ({"redirect_uri": "https://[::1/oauth2callback"}, "expected https://HOST/oauth2callback"),
        ({"redirect_uri": "https://tools.example/callback"}, "expected a path /oauth2callback"),
        ({"redirect_uri": "http://tools.example/oauth2callback"}, "expected https"),
        ({"cookie_secret": "short"}, "expected 32 random characters"),
        ({"client_id": ""}, "client_id is missing"),
        ({"client_secret": 3}, "client_secret: expected a text, got 3"),
        ({"hours": 0}, "hours: expected a number above 0"),
        ({"hours": 1000}, "720 at most, got 1000"),
        ({"allow": []}, "allow: expected a list"),
        ({"allow": "lab.example"}, "allow: expected a list"),
        ({"allow": ["*"]}, "expected an e-mail address or a domain"),
        ({"allow": ["@"]}, "expected an e-mail address or a domain"),
        ({"a_b": {"client_id": "x"}}, "without underscores"),
    ],
)
def test_what_cannot_work_is_refused(wrong: dict[str, Any], words: str):
    with pytest.raises(InputError, match=words):
        read(**wrong)


def test_the_way_back_leads_below_the_app_s_path():
    assert read(base="/night", redirect_uri="https://tools.example/night/oauth2callback")
    with pytest.raises(InputError, match="expected a path /night/oauth2callback"):
        read(base="/night")


def test_a_file_that_is_named_has_to_be_there_and_to_have_the_section(tmp_path: Path):
    with log_in_by(tmp_path):
        assert login() is not None
        file = tmp_path / "auth.toml"
        for content, words in (
            ("[auth", "is not TOML"),
            ("a = " + "[" * 5000, "is not TOML"),
            ("", r"has no section \[auth\]"),
        ):
            module.login.cache_clear()
            file.write_text(content)
            with pytest.raises(InputError, match=words):
                login()
        file.unlink()
        with pytest.raises(InputError, match="cannot be read"):
            login()


def test_secrets_that_streamlit_cannot_read_are_not_taken_for_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    file = tmp_path / "secrets.toml"
    file.write_text("[auth")
    monkeypatch.setattr(st, "get_option", lambda _: [str(file)])
    module.login.cache_clear()
    with pytest.raises(InputError, match="is not TOML"):
        login()
    module.login.cache_clear()


def test_a_server_does_not_open_without_the_packages_for_its_log_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(sys.modules, "authlib", None)
    with log_in_by(tmp_path), pytest.raises(MissingExtraError, match=r"nvcore\[login\]"):
        login()


def test_that_everybody_may_enter_is_said_at_the_start(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
):
    with log_in_by(tmp_path, allow=["lab.example"]):
        login()
        assert caplog.text == ""
    with log_in_by(tmp_path):
        login()
        assert "everybody with an account at the provider may enter" in caplog.text


def test_nobody_has_to_log_in_unless_it_is_set_up():
    module.login.cache_clear()
    assert login() is None
