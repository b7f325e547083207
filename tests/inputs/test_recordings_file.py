"""A table of recordings: what it may say, what is refused, and what goes before it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from inputs import drive, flags, nvcore, session_of, write

from nvcore.api.inputs import load as load_inputs
from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, RecordingsFile, Session
from nvcore.inputs.session.recordings_file import read_recordings_file, with_recordings_file
from nvcore.inputs.session.toml import read_session
from nvcore.report.protect_inputs import files_read

HEADER = "recording,width,height,fps,context,tags,pictures,speed_kmh,horizon"


def rows_of(folder: Path, *lines: str) -> dict[str, RecordingEntry]:
    path = write(folder / "recordings.csv", *lines)
    rows = read_recordings_file(path, "recordings.csv")
    return {name: entry for name, (_, entry) in rows.items()}


def listed(folder: Path, *lines: str, **facts: object) -> Session:
    """The session of `drive` with this table of recordings, without size and rate of its own."""
    write(drive(folder) / "recordings.csv", *lines)
    table = RecordingsFile("recordings.csv")
    return session_of(folder, **{"size": None, "fps": None, "recordings_file": table, **facts})


def facts_of(dataset: Dataset) -> dict[str, tuple[object, ...]]:
    columns = ["name", "width", "height", "fps", "context", "tags"]
    return {name: tuple(facts) for name, *facts in dataset.recordings[columns].to_numpy()}


def test_every_column_is_read(tmp_path: Path):
    rows = rows_of(
        tmp_path,
        HEADER,
        "urban,640,480,20,urban,night; wet road,urban.mp4,30,236.5",
        '"rural, 2",1280,720,12.5,0.75,,,,',
    )
    assert rows == {
        "urban": RecordingEntry(
            "urban",
            640,
            480,
            20,
            pictures="urban.mp4",
            tags=("night", "wet road"),
            context=0.0,
            speed_kmh=30,
            horizon=236.5,
        ),
        "rural, 2": RecordingEntry("rural, 2", 1280, 720, 12.5, context=0.75),
    }


def test_columns_but_the_name_may_be_missing_in_any_order_and_rows_be_empty(tmp_path: Path):
    rows = rows_of(tmp_path, "\ufeffContext,Recording", "rural,a", "", ",b", " , ")
    assert rows == {"a": RecordingEntry("a", context=1.0), "b": RecordingEntry("b")}


def test_semicolons_between_columns_bring_decimal_commas_and_quoted_tags(tmp_path: Path):
    rows = rows_of(tmp_path, "recording;fps;context;tags", 'a;12,5;0,25;"night;rain"')
    assert rows["a"] == RecordingEntry("a", fps=12.5, context=0.25, tags=("night", "rain"))


def test_the_frame_of_the_first_picture_is_a_whole_number(tmp_path: Path):
    rows = rows_of(tmp_path, "recording,first_picture", "a,-2", "b,7.0", "c,")
    assert [row.first_picture for row in rows.values()] == [-2, 7, None]
    with pytest.raises(
        InputError, match=r"line 2: first_picture: expected a whole number, found 1\.5"
    ):
        rows_of(tmp_path, "recording,first_picture", "a,1.5")


def test_a_cell_made_harmless_for_spreadsheets_is_read_as_it_was(tmp_path: Path):
    assert list(rows_of(tmp_path, "recording,title", "'=a,'-b")) == ["=a"]


def test_pictures_start_from_the_folder_of_the_table(tmp_path: Path):
    lines = ("recording,pictures", "a,a.mp4", "b,/v/b.mp4")
    path = write(tmp_path / "meta" / "recordings.csv", *lines)
    rows = read_recordings_file(path, "meta/recordings.csv")
    assert [entry.pictures for _, entry in rows.values()] == ["meta/a.mp4", "/v/b.mp4"]


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], r"recordings.csv: this is no CSV table of recordings \(it is empty\)"),
        (["name,fps"], "line 1: a table of recordings .*; recording is missing"),
        (["recording,widht"], "line 1: there is no column 'widht'; did you mean 'width'"),
        (["recording,fps,fps"], "line 1: there are several columns fps"),
        (["recording,fps", "a"], "line 2: expected 2 fields, as in the first line; found 1"),
        (["recording,fps", "a,1,2"], "line 2: expected 2 fields, .* found 3"),
        (
            ["recording,fps", "a,20", "", "a,21"],
            r"line 4: the recording 'a' .* twice.* \(first in line 2\)",
        ),
        (["recording,fps", "a,twenty"], "line 2: fps: expected a number, found 'twenty'"),
        (["recording,fps", "a,2_0"], "line 2: fps: expected a number, found '2_0'"),
        (["recording,fps", "a,0"], "line 2: fps: expected a number from 0.001 to 1"),
        (["recording,width", "a,-640"], "line 2: width: expected a positive number, found -640"),
        (["recording,height", "a,inf"], "line 2: height: expected a number, found 'inf'"),
        (["recording,context", "a,suburb"], "line 2: context: expected urban, rural or a number"),
        (["recording,speed_kmh", "a,0"], "line 2: speed_kmh: expected a positive number, found 0"),
        (["recording,context", "a,2"], "line 2: context: .* from 0 to 1, found '2'"),
        (["recording,tags", "a,night;night"], "line 2: tags: expected different words"),
        (["recording,fps", ",20"], "line 2: recording is empty"),
        (["recording,fps", 'a,"20'], "line 2: this is no CSV"),
        (["recording,pictures", "a,b\0.mp4"], "line 2: .*NUL"),
    ],
)
def test_what_cannot_be_is_refused_with_file_and_line(tmp_path: Path, lines: list[str], words: str):
    path = write(tmp_path / "recordings.csv", *lines)
    with pytest.raises(InputError, match=words):
        read_recordings_file(path, "recordings.csv")


def test_a_file_that_is_none_or_no_text_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match=r"recordings.csv: cannot be opened"):
        read_recordings_file(tmp_path / "recordings.csv", "recordings.csv")
    (tmp_path / "recordings.csv").write_bytes(b"recording\n\xff")
    with pytest.raises(InputError, match="line 2: expected UTF-8 text"):
        read_recordings_file(tmp_path / "recordings.csv", "recordings.csv")


def test_a_session_takes_what_its_data_do_not_say_from_the_table(tmp_path: Path):
    lines = (HEADER, "rural,1280,960,10,rural,night;dry,r.mp4,,", "urban,640,480,20,0.2,,,80,")
    dataset = load(listed(tmp_path, *lines))
    assert facts_of(dataset) == {
        "urban": (640, 480, 20, 0.2, ()),
        "rural": (1280, 960, 10, 1.0, ("night", "dry")),
    }
    entries = {entry.name: entry.pictures for entry in dataset.settings.recordings}
    assert entries == {"urban": None, "rural": "r.mp4"}


def test_a_table_named_by_a_session_file_starts_from_its_folder(tmp_path: Path):
    write(drive(tmp_path) / "recordings.csv", "recording,context,width,height,fps",
          "urban,0.1,640,480,20", "rural,0.9,640,480,20")  # fmt: skip
    text = '[recordings]\npath = "recordings.csv"\n[truth]\npath = "truth.csv"\n'
    systems = (f'[[system]]\npath = "{name}.csv"' for name in ("fir", "nir"))
    dataset = load(read_session(write(tmp_path / "session.toml", text, *systems)))
    assert dataset.recordings["context"].tolist() == [0.1, 0.9]


def test_what_the_session_says_of_a_recording_goes_before_the_table_and_defaults_after(
    tmp_path: Path,
):
    session = listed(
        tmp_path,
        *("recording,fps,context,tags", "urban,10,0.2,night", "rural,,0.9,"),
        recordings=(RecordingEntry("urban", fps=25.0, tags=("day",)),),
        size=(640, 480),
        fps=12.0,
    )
    assert facts_of(load(session)) == {
        "urban": (640, 480, 25, 0.2, ("day",)),
        "rural": (640, 480, 12, 0.9, ()),
    }


def test_a_recording_that_the_truth_does_not_have_is_refused_with_its_line(tmp_path: Path):
    session = listed(tmp_path, "recording,context", "urban,0", "rurl,1", size=(640, 480), fps=20.0)
    words = r"recordings.csv, line 3: there is no recording 'rurl'.*did you mean 'rural'\? Its"
    with pytest.raises(InputError, match=words):
        load(session)


def test_a_recording_without_pedestrians_may_stand_in_the_table_if_its_frames_are_known(
    tmp_path: Path,
):
    lines = ("recording,context", "urban,0", "empty,1")
    session = listed(tmp_path, *lines, size=(640, 480), fps=20.0)
    own = replace(session, recordings=(RecordingEntry("empty", frames="0:9"),))
    assert load(own).recordings["name"].tolist() == ["urban", "rural", "empty"]
    assert load(replace(session, frames="0:9")).recordings["context"].tolist()[-1] == 1.0


def test_a_single_row_is_about_the_only_recording(tmp_path: Path):
    write(tmp_path / "truth.csv", "frame,x,y,w,h", "0,10,20,30,60")
    write(tmp_path / "fir.csv", "frame,x,y,w,h,score", "0,10,20,30,60,1")
    write(tmp_path / "recordings.csv", "recording,width,height,fps,context", "night,64,48,5,1")
    table = RecordingsFile("recordings.csv")
    facts = {"size": None, "fps": None, "recordings_file": table}
    dataset = load(session_of(tmp_path, "truth.csv", "fir.csv", **facts))
    assert facts_of(dataset) == {"night": (64, 48, 5, 1.0, ())}


def test_the_table_is_read_once(tmp_path: Path):
    session = with_recordings_file(listed(tmp_path, "recording,context", "urban,1"))
    (tmp_path / "recordings.csv").unlink()
    assert with_recordings_file(session) is session
    assert session.recordings_file == RecordingsFile("recordings.csv", {"urban": 2})
    assert "recordings.csv" not in set(session.paths())


def test_the_command_line_takes_a_table_that_goes_before_the_session_and_after_flags(
    tmp_path: Path,
):
    write(drive(tmp_path) / "r.csv", "recording,fps,context", "urban,10,0.5", "rural,10,rural")
    write(
        tmp_path / "session.toml",
        '[recordings]\npath = "gone.csv"\n[defaults]\nsize = "640x480"',
        '[[recording]]\nname = "urban"\ncontext = 0.1\ntags = ["night"]',
        '[truth]\npath = "truth.csv"',
        *(f'[[system]]\npath = "{name}.csv"' for name in ("fir", "nir")),
    )
    out = tmp_path / "out"
    given = ("--recordings", tmp_path / "r.csv", "--fps", "20", "--out", out)
    outcome = nvcore("compare", tmp_path / "session.toml", *given)
    assert outcome.exit_code in (0, 1), outcome.output
    table = np.genfromtxt(out / "recordings.csv", delimiter=",", names=True, dtype=None)
    assert table["fps"].tolist() == [20, 20]
    again = read_session(out / "session.toml")
    assert again.recordings_file is None
    told = {entry.name: (entry.context, entry.tags) for entry in again.recordings}
    assert told == {"urban": (0.5, ("night",)), "rural": (1.0, ())}


def test_from_python_a_table_is_a_keyword(tmp_path: Path):
    write(drive(tmp_path) / "r.csv", "recording,width,height,fps,context",
          "urban,640,480,20,0.5", "rural,640,480,20,rural")  # fmt: skip
    files = {name: tmp_path / f"{name}.csv" for name in ("truth", "fir", "nir")}
    dataset = load_inputs(
        truth=files["truth"], x=files["fir"], y=files["nir"], recordings=tmp_path / "r.csv", fps=10
    )
    assert dataset.recordings["context"].tolist() == [0.5, 1.0]
    assert dataset.recordings["fps"].tolist() == [10, 10]


def test_the_report_does_not_replace_the_table(tmp_path: Path):
    write(drive(tmp_path) / "recordings.csv", "recording,context", "urban,0.5")
    arguments = flags(tmp_path, "--recordings", tmp_path / "recordings.csv", "--out", tmp_path)
    outcome = nvcore("compare", *arguments)
    assert outcome.exit_code == 2
    assert "recordings.csv" in outcome.output
    session = with_recordings_file(listed(tmp_path, "recording,context", "urban,1"))
    assert tmp_path / "recordings.csv" in set(files_read(session))
