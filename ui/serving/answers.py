"""What the server itself answers, instead of the app."""

from __future__ import annotations

from typing import Final

from starlette.responses import PlainTextResponse, Response

PRIVATE: Final = {"Cache-Control": "no-store"}


def text_answer(status: int, text: str) -> Response:
    """A sentence that nobody keeps."""
    return PlainTextResponse(text, status, PRIVATE)
