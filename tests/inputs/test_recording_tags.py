"""Tags of recordings: from the session file to the dataset, and what they change."""

from __future__ import annotations

from pathlib import Path

import pytest
from builders import make_dataset
from inputs import drive, facts_of, session_of, write

from nvcore.dataset import dataset_from_tables
from nvcore.errors import SessionError
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session, write_session

INPUTS = '[truth]\npath = "truth.csv"\n[[system]]\npath = "fir.csv"'


def test_tags_of_the_session_reach_the_dataset(tmp_path: Path):
    session = session_of(drive(tmp_path), recordings=(facts_of("rural", tags=("night", "rain")),))
    recordings = load(session).recordings.set_index("name")
    assert recordings["tags"].to_dict() == {"rural": ("night", "rain"), "urban": ()}


def test_tags_survive_a_session_file(tmp_path: Path):
    facts = (facts_of("rural", tags=("night",)), facts_of("urban", fps=20.0))
    session = session_of(drive(tmp_path), recordings=facts)
    text = write_session(session, version="1", fingerprint="2")
    assert text.count("tags = ") == 1
    again = read_session(write(tmp_path / "session.toml", text))
    assert [one.tags for one in again.recordings] == [("night",), ()]


def test_the_fingerprint_knows_tags_and_is_as_before_without(tmp_path: Path):
    folder = drive(tmp_path)
    plain = load(session_of(folder)).fingerprint
    empty, night, day = (
        load(session_of(folder, recordings=(facts_of("rural", tags=tags),))).fingerprint
        for tags in ((), ("night",), ("day",))
    )
    assert empty == plain
    assert len({plain, night, day}) == 3


def test_tables_without_tags_have_none_and_keep_their_fingerprint():
    dataset = make_dataset(n_frames=2)
    assert dataset.recordings["tags"].tolist() == [()]
    frames = [dataset.frames["frame"].to_numpy()]
    again = dataset_from_tables(dataset.recordings, frames, dataset.boxes, dataset.systems)
    assert again.fingerprint == dataset.fingerprint


@pytest.mark.parametrize(
    ("tags", "words"),
    [
        ('"night"', "tags: expected a list of texts"),
        ("[1]", "tags: expected a list of texts"),
        ('["night", "night"]', "tags: expected different words"),
        ('["night", " "]', "tags: expected different words"),
    ],
)
def test_tags_that_are_no_words_are_told(tmp_path: Path, tags: str, words: str):
    path = write(tmp_path / "session.toml", f'[[recording]]\nname = "a"\ntags = {tags}', INPUTS)
    with pytest.raises(SessionError, match=words):
        read_session(path)
