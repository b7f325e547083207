"""Who takes part: numbers, names, leaving."""

import pytest

from nvcore.errors import InputError
from nvcore.people.participants import (
    CODE_LENGTH,
    PARTICIPANTS,
    fold_name,
    join,
    known_name,
    new_code,
    remove,
)
from nvcore.people.store import AnswerFile, new_names

TABLES = f"""
CREATE TABLE IF NOT EXISTS study (token TEXT PRIMARY KEY);
{PARTICIPANTS}
CREATE TABLE IF NOT EXISTS answer (study TEXT, participant TEXT, text TEXT);
"""


@pytest.fixture
def file(tmp_path):
    file = AnswerFile(tmp_path / "answers.sqlite", TABLES, what="answers")
    with file.connect() as base:
        base.execute("INSERT INTO study VALUES ('a'), ('b')")
    return file


def test_numbers_count_within_a_study_and_who_leaves_makes_room(file):
    with file.connect() as base:
        assert [join(base, "a", name) for name in ("Ann", "Bob", "Cem")] == [0, 1, 2]
        assert join(base, "b", "Dan") == 0
        assert remove(base, "a", " bob ", ["answer"])
        assert not remove(base, "a", "bob", ["answer"])
    with file.connect() as base:
        assert known_name(base, "a", "Bob") is None
        assert [join(base, "a", name) for name in ("Eve", "CEM", "Fay")] == [1, 2, 3]


def test_who_leaves_takes_the_answers_along_and_leaves_no_bytes(file, tmp_path):
    text = "my secret answer, of which nothing stays"
    with file.connect() as base:
        for name in ("Ann", "Bob"):
            join(base, "a", name)
        base.execute("INSERT INTO answer VALUES ('a', 'Ann', ?), ('a', 'Bob', 'x')", (text,))
    assert text.encode() in (tmp_path / "answers.sqlite").read_bytes()
    with file.connect() as base:
        remove(base, "a", "Ann", ["answer"])
        assert base.execute("SELECT participant FROM answer").fetchall() == [("Bob",)]
    assert text.encode() not in (tmp_path / "answers.sqlite").read_bytes()


def test_an_error_keeps_nothing_of_what_was_begun(file):
    def join_both():
        with file.connect() as base:
            join(base, "a", "Ann")
            join(base, "a", "x" * 65)

    with pytest.raises(InputError, match="1 to 64"):
        join_both()
    with file.connect() as base:
        assert known_name(base, "a", "Ann") is None


def test_names_and_codes_cannot_be_guessed():
    assert len({*new_names(), *new_names()}) == 4
    codes = {new_code() for _ in range(100)}
    assert len(codes) == 100
    assert {len(code) for code in codes} == {CODE_LENGTH}
    assert fold_name(" Anna  K") == fold_name("anna k")
