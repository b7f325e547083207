"""Names from files as plain text, and the few phrases that several pages share."""

from __future__ import annotations

import re
from typing import Final

from nvcore.comparison import Result
from nvcore.wording import UNDEFINED, markdown_text, number, one_line, shortened

__all__ = ["UNDEFINED", "docs_link", "number", "plain", "short_names"]

MAX_NAME: Final = 10
"""Characters of a system's name where there is little room."""

_ADDRESS: Final = re.compile(r"(?:https?(?=\\:)|www(?=\\\.)|(?=\\@))", re.IGNORECASE)
"""Where Streamlit would see the start of a web or e-mail address, in text without markup."""
_NOTHING: Final = ":small[]"
"""Streamlit's Markdown for small text, of no characters: nothing to see and nothing to copy."""


def plain(text: object) -> str:
    r"""The text as Streamlit's Markdown that shows it as it is, addresses too: no links.

    Streamlit makes links of what looks like an address even where its signs are escaped; it looks
    at one stretch of text at a time, so an empty piece of another kind within it is enough.

    Examples
    --------
    >>> plain("*a*_1")
    '\\*a\\*\\_1'
    >>> plain("www.example.com")
    'www:small[]\\.example\\.com'
    """
    return _ADDRESS.sub(lambda start: start[0] + _NOTHING, markdown_text(text))


def short_names(result: Result) -> dict[str, str]:
    """Names of both systems by letter, shortened; not escaped.

    They are X and Y if the short names are alike, or could be taken for these letters.
    """
    names = {letter: shortened(one_line(system.name), MAX_NAME) for letter, system in result.sides}
    short = {name.casefold() for name in names.values()}
    is_clear = len(short) == 2 and short.isdisjoint({"", "x", "y"})
    return names if is_clear else {"x": "X", "y": "Y"}


def docs_link(text: str, anchor: str, *, doc: str = "metrics") -> str:
    """Markdown of a link to a section of the documentation inside the app, from any page.

    It is relative, so that it also works where the app is served below a path: all pages lie
    beside each other.

    Examples
    --------
    >>> docs_link("Saliency", "saliency")
    '[Saliency](metrics#saliency)'
    """
    page = "" if doc == "metrics" else f"?doc={doc}"
    return f"[{text}](metrics{page}#{anchor})"
