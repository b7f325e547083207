"""Addresses of studies."""

from __future__ import annotations

import pytest

import ui.subjects.people.studies
from ui.subjects.people.studies import Studies, is_local


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


def test_answers_are_in_the_file_of_the_variable_else_in_the_users_folder(monkeypatch, tmp_path):
    class Toy(Studies):
        variable, file_name = "TOY_ANSWERS", "toy.sqlite"

    monkeypatch.setattr(ui.subjects.people.studies.click, "get_app_dir", lambda _: str(tmp_path))
    monkeypatch.delenv("TOY_ANSWERS", raising=False)
    assert Toy().file() == tmp_path / "toy.sqlite"
    monkeypatch.setenv("TOY_ANSWERS", str(tmp_path / "other.sqlite"))
    assert Toy().file() == tmp_path / "other.sqlite"
