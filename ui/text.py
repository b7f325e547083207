"""Names from files as plain text, and the few phrases that several pages share."""

from __future__ import annotations

import re
from typing import Final

from nvcore.errors import one_line

UNDEFINED: Final = "–"

_MARKUP = re.compile(r"([\\`*_{}\[\]<>()#+\-.!|$~:&^=])")


def plain(name: object) -> str:
    """The name as text for Markdown: no markup, no HTML, no directives, one line.

    Parameters
    ----------
    name
        A name that came from a file or a user.
    """
    return _MARKUP.sub(r"\\\1", one_line(str(name)))


def number(value: float | None, form: str) -> str:
    """The number in this format, a dash where it is undefined."""
    return UNDEFINED if value is None or value != value else format(value, form)
