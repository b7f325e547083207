"""Addresses of studies."""

from __future__ import annotations

import pytest

from ui.people.studies import is_local


@pytest.mark.parametrize(
    ("address", "expected"),
    [
        ("http://localhost:8501/ratings", True),
        ("http://127.0.0.1/ratings", True),
        ("http://[::1]:8501/ratings", True),
        ("http://lab-3:8501/ratings", False),
    ],
)
def test_an_address_of_this_computer_is_told_from_others(address: str, expected: bool):
    assert is_local(address) is expected
