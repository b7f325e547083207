"""Names are shown as they are: no markup, and no links where they look like addresses."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from ui.widgets.text import plain, short_names

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


@pytest.mark.parametrize(
    ("x", "y", "short"),
    [
        ("FIR", "NIR", ["FIR", "NIR"]),
        ("a\nb", "*b*", ["a\\nb", "*b*"]),
        ("thermal camera 2", "NIR", ["thermal c…", "NIR"]),
        *((x, y, ["X", "Y"]) for x, y in [("thermal camera 2", "thermal camera 3"), ("Y", "NIR")]),
        ("", "NIR", ["X", "Y"]),
    ],
)
def test_short_names_of_systems_are_never_alike(x: str, y: str, short: list[str]):
    result = SimpleNamespace(sides=[("x", SimpleNamespace(name=x)), ("y", SimpleNamespace(name=y))])
    assert list(short_names(result).values()) == short
