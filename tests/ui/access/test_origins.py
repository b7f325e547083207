"""Which names a server answers to, and whose pages may send to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import streamlit as st
from people import log_in_by
from streamlit import config

from ui.access import origins
from ui.access.origins import is_own_host, is_own_origin


@pytest.fixture(autouse=True)
def names(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Options of the server; a machine called lab-3.corp.example."""
    options: dict[str, Any] = {}
    own = st.get_option
    monkeypatch.setattr(config, "get_option", lambda name: options.get(name, own(name)))
    monkeypatch.setattr(st, "get_option", lambda name: options.get(name, own(name)))
    monkeypatch.setattr("socket.getfqdn", lambda: "lab-3.corp.example")
    origins.own_names.cache_clear()
    return options


@pytest.mark.parametrize(
    ("host", "is_own"),
    [
        *(("localhost:8501", True), ("127.0.0.1:8501", True), ("[::1]:8501", True)),
        *(("192.168.3.4", True), ("lab-3:8501", True), ("Lab-3.Corp.Example:8501", True)),
        *(("night.localhost", True), ("evil.example", False), ("evil.example:8501", False)),
        *(("localhost.evil.example", False), ("127.0.0.1.evil.example", False)),
        *(("", False), (None, False), ("[::1", False)),
    ],
)
def test_a_name_of_the_internet_is_not_the_server_s_own(host: str | None, is_own: bool):
    assert is_own_host(host) == is_own


def test_names_that_are_allowed_are_the_only_ones(names: dict[str, Any]):
    names["server.allowedHosts"] = ["tools.example"]
    assert is_own_host("tools.example")
    assert not is_own_host("localhost")


def test_the_address_of_the_log_in_is_a_name_of_the_server(tmp_path: Path):
    assert not is_own_host("tools.example")
    with log_in_by(tmp_path):
        assert is_own_host("tools.example")


def test_a_page_of_another_port_is_not_the_server_s_own():
    host = "localhost:8501"
    assert is_own_origin("http://localhost:8501", host)
    assert is_own_origin(None, host)
    assert not is_own_origin("http://localhost:3000", host)
    assert not is_own_origin("null", host)
    assert not is_own_origin("http://[", host)
    assert not is_own_origin("http://evil.example", "evil.example")


def test_a_proxy_that_gives_another_host_on_is_named_by_its_origin(names: dict[str, Any]):
    assert not is_own_origin("https://tools.example", "127.0.0.1:8501")
    names["server.corsAllowedOrigins"] = ["https://tools.example"]
    assert is_own_origin("https://tools.example", "127.0.0.1:8501")
    assert not is_own_origin("http://tools.example", "127.0.0.1:8501")
