"""Names are shown as they are: no markup, and no links where they look like addresses."""

from __future__ import annotations

import pytest

from ui.widgets.text import plain

NOTHING = ":small[]"


@pytest.mark.parametrize(
    ("name", "starts"),
    [
        *(("http://a.example", 1), ("HTTPS://a.example/?q=1 (http://b.example)", 2)),
        *(("www.a.example", 1), ("a@b.example", 1), ("mailto:a@b.example", 1)),
        *((r"\www.a.example", 1), ("wwww", 0), ("https", 0), ("night_01", 0)),
    ],
)
def test_an_address_is_broken_by_nothing_that_one_sees(name: str, starts: int):
    shown = plain(name)
    assert shown.count(NOTHING) == starts
    assert shown.replace(NOTHING, "").replace("\\\\", "\0").replace("\\", "") == name.replace(
        "\\", "\0"
    )
    for start in ("http\\:", "https\\:", "www\\.", "a\\@"):
        assert start not in shown.lower()
