"""A log-in set up for one test, and the cookies of people who have logged in."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import pytest
from streamlit.web.server.starlette.starlette_app_utils import create_signed_value

from ui.access import login as login_module
from ui.access import origins, people

USER: Final = "_streamlit_user"
SECRET: Final = "s" * 32
AUTH: Final[dict[str, Any]] = {
    "redirect_uri": "https://tools.example/oauth2callback",
    "cookie_secret": SECRET,
    "client_id": "nvcore",
    "client_secret": "of the tests",
    "server_metadata_url": "https://id.example/.well-known/openid-configuration",
}


@contextmanager
def log_in_by(folder: Path, **more: Any) -> Iterator[None]:
    """While it lasts, visitors have to log in, as `AUTH` and these keys say."""
    file = folder / "auth.toml"
    file.write_text(
        "[auth]\n"
        + "\n".join(f"{key} = {json.dumps(value)}" for key, value in {**AUTH, **more}.items())
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(login_module.VARIABLE, str(file))
        _forget()
        yield
    _forget()


def _forget() -> None:
    login_module.login.cache_clear()
    origins.own_names.cache_clear()
    people._ended.clear()


def claims(name: str, **more: Any) -> dict[str, Any]:
    return {
        "iss": "https://id.example",
        "sub": name,
        "email": f"{name}@lab.example",
        "email_verified": True,
        "nonce": f"of {name}",
        "provider": "default",
        "origin": "https://tools.example",
        "is_logged_in": True,
        **more,
    }


def cookies(name: str, *, secret: str = SECRET, **more: Any) -> dict[str, str]:
    """Cookies of somebody who has logged in."""
    return {USER: create_signed_value(secret, USER, json.dumps(claims(name, **more))).decode()}


def header(of: dict[str, str]) -> dict[str, str]:
    return {"cookie": "; ".join(f"{name}={value}" for name, value in of.items())}
