"""Lists of the core with what subjects add to them."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from nvcore.subjects import in_place


class Entry(NamedTuple):
    key: str
    after: str = ""


OWN = (Entry("a"), Entry("b"))


@pytest.mark.parametrize(
    ("added", "order"),
    [
        ([Entry("c", "a"), Entry("d", "a")], "acdb"),
        ([Entry("c", "a"), Entry("d", "c")], "acdb"),
        ([Entry("d", "c"), Entry("c", "a")], "acdb"),  # what it follows is added later
        ([Entry("c"), Entry("d", "gone")], "abcd"),
    ],
)
def test_what_is_added_stands_after_what_it_follows(added: list[Entry], order: str):
    assert "".join(entry.key for entry in in_place(OWN, added)) == order
