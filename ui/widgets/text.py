"""Names from files as plain text, and the few phrases that several pages share."""

from __future__ import annotations

from nvcore.wording import UNDEFINED, number
from nvcore.wording import markdown_text as plain

__all__ = ["UNDEFINED", "docs_link", "number", "plain"]


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
