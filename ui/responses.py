"""HTTP responses of the server itself, in place of the app's pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from starlette.responses import PlainTextResponse, Response

PRIVATE: Final = {"Cache-Control": "no-store"}
"""Headers of an answer that caches must not store."""


def text_answer(status: int, text: str, headers: Mapping[str, str] = PRIVATE) -> Response:
    """Return a plain-text answer. By default its headers forbid caching."""
    return PlainTextResponse(text, status, headers)
