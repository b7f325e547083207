"""The file of answers: who may read it."""

import os
import stat

import pytest

from nvcore.errors import InputError, StoreError
from nvcore.people.store import AnswerFile

TABLES = "CREATE TABLE IF NOT EXISTS answer (text TEXT);"


@pytest.fixture
def open_umask():
    """Permissions are those that the program asks for."""
    before = os.umask(0)
    yield
    os.umask(before)


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.usefixtures("open_umask")
def test_a_new_file_and_its_journal_are_readable_by_this_user_alone(tmp_path):
    tmp_path.chmod(0o755)
    file = AnswerFile(tmp_path / "answers.sqlite", TABLES, what="answers")
    with file.connect() as base:
        base.execute("INSERT INTO answer VALUES ('x')")
        modes = {path.name: mode(path) for path in tmp_path.iterdir()}
    assert modes == {"answers.sqlite": 0o600, "answers.sqlite-journal": 0o600}


def test_a_file_that_is_there_keeps_its_permissions_and_answers(tmp_path):
    path = tmp_path / "answers.sqlite"
    with AnswerFile(path, TABLES, what="answers").connect() as base:
        base.execute("INSERT INTO answer VALUES ('x')")
    path.chmod(0o640)
    with AnswerFile(path, TABLES, what="answers").connect() as base:
        assert base.execute("SELECT * FROM answer").fetchall() == [("x",)]
    assert mode(path) == 0o640


def test_a_file_that_cannot_be_created_is_told(tmp_path):
    (tmp_path / "link.sqlite").symlink_to(tmp_path / "gone" / "answers.sqlite")
    with pytest.raises(InputError, match=r"file of the answers cannot be used \(No such file"):
        AnswerFile(tmp_path / "link.sqlite", TABLES, what="answers")


def test_a_full_disk_is_no_fault_of_the_answer(tmp_path):
    file = AnswerFile(tmp_path / "answers.sqlite", TABLES, what="answers")
    fill = "PRAGMA max_page_count = 1; INSERT INTO answer VALUES (zeroblob(1000000))"
    with pytest.raises(StoreError, match="disk is full"), file.connect() as base:
        base.executescript(fill)
