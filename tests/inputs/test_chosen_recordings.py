"""A session compares only some of its recordings, and calls them as it likes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from inputs import drive, flags, nvcore, session_of, write

from nvcore.common.errors import InputError, MissingFactError, SessionError
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.settings.protocols import PROTOCOLS

URBAN, RURAL = RecordingEntry("urban", tags=("day",)), RecordingEntry("rural", tags=("night",))


def tagged_drive(folder: Path, **facts: object) -> Session:
    return session_of(drive(folder), recordings=(URBAN, RURAL), **facts)


def test_only_the_recordings_with_the_sessions_tags_are_loaded(tmp_path: Path):
    dataset = load(tagged_drive(tmp_path, only_tags=("night",)))
    assert dataset.recordings["name"].tolist() == ["rural"]
    assert len(dataset.frames) == 20
    assert dataset.notes[-1] == "1 of 2 recordings: night"


def test_only_the_named_recordings_are_loaded(tmp_path: Path):
    dataset = load(tagged_drive(tmp_path, only=("urban",)))
    assert dataset.recordings["name"].tolist() == ["urban"]


def test_facts_of_recordings_that_are_left_out_may_be_unknown(tmp_path: Path):
    facts = (RecordingEntry("urban", fps=10, title="Town"), RecordingEntry("rural"))
    session = replace(session_of(drive(tmp_path), recordings=facts), fps=None)
    for name in ("urban", "Town"):
        dataset = load(replace(session, only=name))
        assert dataset.recordings["name"].tolist() == ["Town"]
    with pytest.raises(MissingFactError, match="the frame rate of recording 'rural' is not in"):
        load(session)


def test_frames_without_an_end_go_to_that_of_each_recording(tmp_path: Path):
    session = tagged_drive(tmp_path)
    n_frames = len(load(session).frames)
    assert len(load(replace(session, frames="2:")).frames) == n_frames - 4
    assert load(replace(session, frames=":")).fingerprint == load(session).fingerprint
    with pytest.raises(
        InputError, match="no frame is in '900:': urban and rural have frames 0 to 19"
    ):
        load(replace(session, frames="900:"))


def test_facts_of_one_recording_are_not_taken_for_the_only_one_left(tmp_path: Path):
    facts = (RecordingEntry("urban", tags=("day",), pictures="urban.mp4"),)
    session = session_of(drive(tmp_path), recordings=facts, only=("rural",))
    assert session.entries(["rural"]).get("rural") is None


def test_a_choice_from_loaded_data_is_in_their_session_file(tmp_path: Path):
    whole = load(tagged_drive(tmp_path))
    for part in (
        whole.only(["night"]),
        whole.only(names=["rural"]),
        whole.only(["night"], ["rural"]),
    ):
        settings = part.settings
        assert isinstance(settings, Session)
        path = tmp_path / "session.toml"
        path.write_text(write_session(settings, version="1", fingerprint="2"))
        assert load(read_session(path)).fingerprint == part.fingerprint


def test_a_session_file_keeps_the_choice(tmp_path: Path):
    session = tagged_drive(tmp_path, only_tags=("night",), only=("rural",))
    path = tmp_path / "session.toml"
    path.write_text(write_session(session, version="1", fingerprint="2"))
    again = read_session(path)
    assert (again.only_tags, again.only) == (("night",), ("rural",))


def test_the_command_line_chooses_by_tag_and_by_name(tmp_path: Path):
    drive(tmp_path)
    table = write(tmp_path / "rec.csv", "recording,tags", "urban,day", "rural,night;rain")
    of_table = flags(tmp_path, "--recordings", table)
    done = nvcore("compare", *of_table, "--tag", "night", "--tag", "rain", "--json")
    assert json.loads(done.stdout)["recordings"] == 1
    assert (
        "1 of 2 recordings: night, rain"
        in nvcore("check", *of_table, "--tag", "night", "--tag", "rain").stdout
    )
    done = nvcore("compare", *of_table, "--only", "urban", "--json")
    assert json.loads(done.stdout)["recordings"] == 1
    done = nvcore("compare", *of_table, "--tag", "snow")
    assert done.exit_code == 2
    assert "no recording has the tag snow; the tags are day, night and rain" in done.stderr


def test_a_title_is_what_a_recording_is_called_everywhere(tmp_path: Path):
    named = replace(RURAL, title="Country road", fps=10.0)
    dataset = load(session_of(drive(tmp_path), recordings=(URBAN, named)))
    assert dataset.recordings["name"].tolist() == ["urban", "Country road"]
    assert dataset.recordings["fps"].tolist() == [20, 10]
    assert dataset.left_out.empty
    assert len(dataset.system("fir")) == 40


def test_a_recording_is_chosen_by_its_title_or_as_in_the_data(tmp_path: Path):
    named = replace(RURAL, title="Country road")
    for name in ("Country road", "rural"):
        protocol = replace(PROTOCOLS["all"], recordings=(name,))
        session = session_of(
            drive(tmp_path), recordings=(URBAN, named), only=(name,), protocol=protocol
        )
        dataset = load(session)
        assert dataset.recordings["name"].tolist() == ["Country road"]
        assert dataset.settings.protocol.recordings == ("Country road",)
    # what is the title of one and the name of another in the data means the title
    swapped = (replace(URBAN, title="rural"), replace(RURAL, title="urban"))
    dataset = load(session_of(tmp_path, recordings=swapped, only=("rural",)))
    assert dataset.left_out.empty
    assert len(dataset.system("nir")) == 10  # those of the data's urban


def test_renamed_data_have_settings_that_name_them_so(tmp_path: Path):
    protocol = replace(PROTOCOLS["all"], recordings=("rural",))
    session = tagged_drive(tmp_path, x="nir", only=("rural",), protocol=protocol)
    renamed = load(session).renamed({"nir": "NIR"}, {"rural": "Road"})
    settings = renamed.settings
    assert isinstance(settings, Session)
    assert renamed.compared() == ("NIR", "fir")
    assert (settings.only, settings.protocol.recordings) == (("Road",), ("Road",))
    again = load(settings)
    assert again.systems == renamed.systems == ("fir", "NIR")
    assert again.recordings["name"].tolist() == ["Road"]


def test_a_title_survives_the_session_file(tmp_path: Path):
    named = replace(RURAL, title="Country road")
    session = session_of(drive(tmp_path), recordings=(URBAN, named))
    path = tmp_path / "session.toml"
    path.write_text(write_session(session, version="1", fingerprint="2"))
    again = load(read_session(path))
    assert again.fingerprint == load(session).fingerprint
    assert again.recordings["name"].tolist() == ["urban", "Country road"]


def test_a_table_of_recordings_gives_titles(tmp_path: Path):
    drive(tmp_path)
    table = write(tmp_path / "rec.csv", "recording,title", "urban,Town", "rural,Country")
    done = nvcore("check", *flags(tmp_path, "--recordings", table))
    assert "Town" in done.stdout


def test_two_recordings_of_one_title_are_refused(tmp_path: Path):
    named = replace(RURAL, title="urban")
    with pytest.raises(InputError, match="two recordings would be called 'urban'"):
        load(session_of(drive(tmp_path), recordings=(named,)))
    with (tmp_path / "nir.csv").open("a") as file:  # a recording that only a system has
        file.write("tunnel,0,1,2,3,4,0.5\n")
    with pytest.raises(InputError, match="two recordings would be called 'tunnel'"):
        load(session_of(tmp_path, recordings=(replace(RURAL, title="tunnel"),)))
    with pytest.raises(SessionError, match="title: expected a name"):
        RecordingEntry("a", title=" ")
