"""Page before the log-in, with the product's name and a button but no content of the app."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Final
from urllib.parse import urlencode

from ui.access.login import DEFAULT
from ui.streamlit_inside.login import LOG_OUT

LOG_IN: Final = "/log-in"
NEXT: Final = "next"
PROVIDER: Final = "provider"
MAX_ADDRESS: Final = 2000
_LOGO: Final = Path(__file__).parents[1] / "assets" / "logo.svg"
_PAGE: Final = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="robots" content="noindex">
<title>nvcore – log in</title>
<link rel="icon" href="data:,">
<style>
:root { color-scheme: light dark; font: 15px/1.5 "Source Sans", Arial, sans-serif; }
body { margin: 0; min-height: 100vh; display: grid; place-items: center;
  color: light-dark(#10161C, #E6EAF0); background: light-dark(#F2F4F6, #11161B); }
main { box-sizing: border-box; width: min(26rem, 100vw - 2rem); padding: 2rem; border-radius: 6px;
  border: 1px solid light-dark(#D5DBE1, #323C46); background: light-dark(#FFFFFF, #1B2229); }
h1 { margin: 0 0 1rem; font-size: 0; }
h1 svg { height: 40px; width: auto; }
p { margin: 0 0 1.2rem; overflow-wrap: anywhere; }
a { display: block; margin-top: 0.6rem; padding: 0.6rem; border-radius: 6px; text-align: center;
  text-decoration: none; font-weight: 600; color: light-dark(#FFFFFF, #11161B);
  background: light-dark(#1F5F6B, #57B8C7); }
a:focus-visible { outline: 3px solid light-dark(#10161C, #E6EAF0); outline-offset: 2px; }
</style>
</head>
<body><main><h1 aria-label="nvcore">$logo</h1><p>$text</p>$links</main></body>
</html>
""")


def log_in_page(providers: Sequence[str], *, base: str, wanted: str) -> str:
    """Return the HTML page that asks to log in.

    Parameters
    ----------
    providers
        Names of the providers to choose from.
    base
        Path below which the app is served, with a leading slash.
    wanted
        Requested address, to open after the log-in.
    """
    links = {}
    for name in providers:
        query = urlencode({PROVIDER: name, NEXT: wanted})
        text = "Log in" if name == DEFAULT else f"Log in with {name}"
        links[text] = f"{base}{LOG_IN}?{query}"
    return _page("This server asks who you are.", links)


def refusal_page(email: str, *, base: str) -> str:
    """Return the HTML page that refuses a person and offers to log in as somebody else."""
    text = (
        f"{email} is not on the list of those who may open this server. Ask whoever runs it."
        if email
        else "This server admits people by their e-mail address, and the log-in came without one "
        "that is verified. Ask whoever runs it."
    )
    return _page(text, {"Log in as somebody else": f"{base}{LOG_OUT}"})


def _page(text: str, links: dict[str, str]) -> str:
    buttons = (f'<a href="{escape(to)}">{escape(label)}</a>' for label, to in links.items())
    logo = _LOGO.read_text(encoding="utf-8")
    return _PAGE.substitute(logo=logo, text=escape(text), links="".join(buttons))


def is_own_address(address: str, base: str) -> bool:
    r"""Whether a redirect to this address without a host stays within the app.

    Examples
    --------
    >>> is_own_address("/nvcore/timeline?frame=3", "/nvcore"), is_own_address("/data", "")
    (True, True)
    >>> [is_own_address(text, "") for text in ("//evil.example", "/\\evil.example", "data", "")]
    [False, False, False, False]
    """
    return (
        address.startswith(f"{base}/")
        and not address.startswith("//")
        and len(address) <= MAX_ADDRESS
        and address.isascii()
        and address.isprintable()
        and not set(address) & set("\\ ")
        and "/.." not in address
    )
