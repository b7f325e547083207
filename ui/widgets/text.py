"""Escape names from files as plain text, and build phrases that several pages share."""

from __future__ import annotations

import re
from typing import Final

from nvcore.common.wording import UNDEFINED, markdown_text, number, one_line, shortened
from nvcore.comparison.compare import Result

__all__ = ["UNDEFINED", "docs_link", "number", "plain", "short_names"]

MAX_NAME: Final = 10
"""Maximum length of a system's name in little space, in characters."""

_ADDRESS: Final = re.compile(r"(?:https?(?=\\:)|www(?=\\\.)|(?=\\@))", re.IGNORECASE)
"""Starts of web and e-mail addresses that Streamlit would detect in text without markup."""
_NOTHING: Final = ":small[]"
"""Empty small text in Streamlit's Markdown: nothing to see and nothing to copy."""


def plain(text: object) -> str:
    r"""Return Markdown that Streamlit shows as the literal text, without turning it into links.

    Streamlit links apparent addresses even if their characters are escaped. It looks at one
    stretch of text at a time, so an empty piece of another kind within it prevents the link.

    Examples
    --------
    >>> plain("*a*_1")
    '\\*a\\*\\_1'
    >>> plain("www.example.com")
    'www:small[]\\.example\\.com'
    """
    return _ADDRESS.sub(lambda start: start[0] + _NOTHING, markdown_text(text))


def short_names(result: Result) -> dict[str, str]:
    """Return shortened names of both systems by letter, not escaped.

    They are X and Y if the short names are alike or could be taken for these letters.
    """
    names = {letter: shortened(one_line(system.name), MAX_NAME) for letter, system in result.sides}
    short = {name.casefold() for name in names.values()}
    is_clear = len(short) == 2 and short.isdisjoint({"", "x", "y"})
    return names if is_clear else {"x": "X", "y": "Y"}


def docs_link(text: str, anchor: str, *, doc: str = "metrics") -> str:
    """Return a Markdown link to a section of the documentation in the app.

    The link is relative, so it also works if the app is served below a path: all pages are
    siblings.

    Examples
    --------
    >>> docs_link("Saliency", "saliency")
    '[Saliency](metrics#saliency)'
    """
    page = "" if doc == "metrics" else f"?doc={doc}"
    return f"[{text}](metrics{page}#{anchor})"
