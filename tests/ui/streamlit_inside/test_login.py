"""The cookie that Streamlit's log-in leaves, where it begins, and how a page is loaded anew."""

from __future__ import annotations

import json
from random import Random

import pytest
from people import SECRET, cookies
from streamlit.auth_util import set_cookie_with_chunks
from streamlit.proto.ForwardMsg_pb2 import ForwardMsg
from streamlit.runtime.secrets import AttrDict
from streamlit.web.server.starlette.starlette_app_utils import create_signed_value
from streamlit.web.server.starlette.starlette_server_config import USER_COOKIE_NAME

from ui.streamlit_inside import login


def test_the_cookie_says_who_has_logged_in():
    signed = login.signed_user(cookies("anna"), SECRET, hours=1)
    assert signed is not None
    assert json.loads(signed)["sub"] == "anna"


@pytest.mark.parametrize(("secret", "hours"), [("t" * 32, 1), (SECRET, -1)])
def test_a_cookie_of_another_server_or_too_old_says_nothing(secret: str, hours: float):
    assert login.signed_user(cookies("anna"), secret, hours=hours) is None


def test_without_a_cookie_nobody_has_logged_in():
    assert login.signed_user({}, SECRET, hours=1) is None
    assert login.signed_user({USER_COOKIE_NAME: "\u20ac"}, SECRET, hours=1) is None


def test_a_long_cookie_is_put_together_again():
    sent: dict[str, str] = {}
    claims = {"sub": "anna", "groups": Random(0).randbytes(6000).hex()}  # cannot be packed
    set_cookie_with_chunks(
        lambda name, value: sent.update({name: create_signed_value(SECRET, name, value).decode()}),
        lambda name, value: create_signed_value(SECRET, name, value),
        USER_COOKIE_NAME,
        claims,
        cookie_attr_size=100,
    )
    assert len(sent) > 1
    signed = login.signed_user(sent, SECRET, hours=1)
    assert signed is not None
    assert json.loads(signed) == claims


def test_the_log_in_begins_at_streamlits_address():
    start, _, query = login.address_of("corporate").partition("?")
    assert start.endswith(login.LOG_IN)
    assert query.startswith("provider=")


def test_the_section_of_the_secrets_is_a_plain_mapping(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(login, "get_secrets_auth_section", lambda: AttrDict({}))
    assert login.section_of_secrets() is None
    monkeypatch.setattr(login, "get_secrets_auth_section", lambda: AttrDict({"hours": 1}))
    assert login.section_of_secrets() == {"hours": 1}


def test_whether_authlib_is_there_is_known():
    assert login.has_authlib() in (True, False)


def test_a_page_is_loaded_anew_by_a_redirect_to_where_it_is():
    message = ForwardMsg.FromString(login.reload_message())
    assert message.WhichOneof("type") == "auth_redirect"
    assert message.auth_redirect.url == ""
