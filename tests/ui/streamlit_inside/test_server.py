"""What Streamlit's server answers where, whom it answers, and what its page is like."""

from __future__ import annotations

from typing import Any
from unittest.mock import MagicMock

import pytest
from starlette.datastructures import Headers
from streamlit import config
from streamlit.web.server.starlette.starlette_app import create_streamlit_routes

from ui.streamlit_inside import login, server


@pytest.fixture(scope="module")
def paths() -> set[str]:
    """Of all routes of Streamlit's."""
    return {getattr(route, "path", "") for route in create_streamlit_routes(MagicMock())}


@pytest.mark.parametrize(
    "address",
    [
        *(server.HEALTH, server.HOST_CONFIG, server.STREAM, server.METRICS),
        *(login.LOG_IN, login.LOG_OUT, login.CALLBACK),
    ],
)
def test_an_address_is_one_of_streamlits(address: str, paths: set[str]):
    assert address in paths


def test_files_are_uploaded_to_the_address_that_names_their_session(paths: set[str]):
    (path,) = [path for path in paths if "upload_file" in path]
    match = server.UPLOAD.search(path.format(session_id="one", file_id="two"))
    assert match is not None
    assert match["session"] == "one"


def test_every_address_that_is_no_page_begins_as_known(paths: set[str]):
    starts = {path.split("/")[1] for path in paths if path.count("/") > 1}
    assert starts <= {*server.FILES}


def test_hosts_and_origins_are_those_of_the_options(monkeypatch: pytest.MonkeyPatch):
    options: dict[str, Any] = {
        "server.allowedHosts": ["tools.example"],
        "server.corsAllowedOrigins": ["https://proxy.example"],
    }
    monkeypatch.setattr(config, "get_option", options.__getitem__)
    assert server.is_allowed_host("tools.example:8501")
    assert not server.is_allowed_host("evil.example")
    assert server.allowed_origins() == {"https://proxy.example"}


def test_a_websocket_names_its_session():
    headers = Headers({"sec-websocket-protocol": "streamlit, xsrf, session-1"})
    assert server.parse_subprotocols(headers) == ("streamlit", "xsrf", "session-1")
    assert server.parse_subprotocols(Headers()) == (None, None, None)


def test_the_page_has_scripts_within_and_one_end():
    page = server.page_with("<style></style>")
    assert page.count("<script>") == len(server.inline_scripts()) > 0
    assert page.count("<style></style></body>") == page.count(server.PAGE_END) == 1
