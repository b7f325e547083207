"""Coded intervals: read, written again, and the classes that encounters have by them."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from figure_parts import words
from inputs import drive, flags, nvcore, session_of, write

from nvcore.common.errors import InputError, SessionError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.comparison.compare import Result, compare
from nvcore.evidence.subgroups import find_subgroups
from nvcore.figures.lanes import lanes_figure
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.report.files import export_files
from nvcore.report.terminal import render_scorecard
from nvcore.settings.codes import CodedInterval
from nvcore.tables.encounters.miss_classes import class_counts
from nvcore.tables.result import codes_table, encounters_table

HEAD = "recording,start_s,end_s,code"


def coded(folder: Path, *lines: str, **facts: object) -> Session:
    """The drive with these lines in the file of its codes."""
    write(folder / "codes.csv", *lines)
    return session_of(drive(folder), codes_file="codes.csv", **facts)


@cache
def four() -> Result:
    """Four pedestrians of a second each, one after another: X detects the first three, Y the outer.

    Glare until the second one comes, distraction from its end (1.9 s) to the third's first frame.
    """
    truth = [at(frame, 50, track=1 + frame // 10) for frame in range(40)]
    dataset = make_dataset(truth, truth[:30], truth[:10] + truth[30:])
    name = dataset.recordings["name"][0]
    codes = (
        CodedInterval(name, 0.5, 1.2, "glare"),
        CodedInterval(name, 0.0, 0.1, "glare"),
        CodedInterval(name, 1.9, 2.0, "distraction"),
        CodedInterval("another", 0.0, 9.0, "violation"),
    )
    return result_of(dataset.with_settings(replace(dataset.settings, codes=codes)))


def test_an_encounter_counts_in_each_code_that_it_overlaps_else_in_none_of_them():
    counts = class_counts(four())[["both", "x_only", "y_only", "neither"]]
    assert counts.loc["glare"].tolist() == [1, 1, 0, 0]
    assert counts.loc["distraction"].tolist() == [0, 2, 0, 0]
    assert counts.loc["no_code"].tolist() == [0, 0, 1, 0]
    assert "violation" not in counts.index  # nobody of another recording is in this one
    texts = [set(text.split(";")) for text in encounters_table(four())["classes"]]
    assert texts[1] >= {"glare", "distraction"}
    assert "no_code" in texts[3]
    groups = {of.group: np.flatnonzero(of.is_member).tolist() for of in find_subgroups(four())}
    assert groups["glare"] == [0, 1]
    assert groups["distraction"] == [1, 2]
    assert groups["no_code"] == [3]


def test_stretches_are_shaded_in_the_lanes_of_their_recording():
    figure = lanes_figure(four(), 0, theme="light")
    shaded = [shape for shape in figure.layout.shapes if shape.name == "code"]
    assert [(of.x0, of.x1, of.label.text) for of in shaded] == [
        (0.5, 1.2, "glare"),
        (0.0, 0.1, "glare"),
        (1.9, 2.0, "distraction"),
    ]
    assert "shaded: stretches with a code" in words(figure)


def test_intervals_are_read_by_name_or_title_and_written_as_they_were_read(tmp_path):
    lines = [HEAD, "urban,0.25,0.5,glare", "Country,0,2,rain; no"]
    titled = (RecordingEntry("rural", title="Country"), RecordingEntry("urban", title="Town"))
    with pytest.raises(InputError, match=r"codes.csv, line 3: code: expected"):
        load(coded(tmp_path, *lines))
    session = coded(tmp_path, *lines[:2], "Country,0,2,rain", recordings=titled)
    dataset = load(session)
    assert dataset.settings.codes == (
        CodedInterval("Town", 0.25, 0.5, "glare"),
        CodedInterval("Country", 0.0, 2.0, "rain"),
    )
    assert dataset.fingerprint == load(replace(session, codes_file=None)).fingerprint
    files = export_files(compare(dataset), dataset.settings)
    write(tmp_path / "again.csv", files["codes.csv"]().decode().rstrip("\n"))
    again = load(replace(session, codes_file="again.csv"))
    assert sorted(again.settings.codes) == sorted(dataset.settings.codes)
    text = write_session(dataset.settings, version="", fingerprint="")
    written = read_session(write(tmp_path / "session.toml", text))
    assert written.codes == dataset.settings.codes
    assert written.codes_file is None
    assert load(written).settings.codes == written.codes


@pytest.mark.parametrize(
    ("row", "fault"),
    [
        ("village,0,1,glare", "there is no recording 'village'; the recordings are"),
        ("urban,1,0.5,glare", "end_s: expected 1, the start, or more; got 0.5"),
        ("urban,0,soon,glare", "end_s: expected a number, found 'soon'"),
        ("urban,0,1,", "code is empty"),
        ("urban,0,1,no_code", "code: expected"),
    ],
)
def test_what_is_no_stretch_of_a_recording_is_refused_with_its_line(tmp_path, row, fault):
    with pytest.raises(InputError, match=f"codes.csv, line 3: {fault}"):
        load(coded(tmp_path, HEAD, "rural,0,1,rain", row))


def test_a_code_outside_of_the_evaluated_frames_is_warned_of(tmp_path):
    lines = "urban,0,1,rain", "urban,9,12,glare", "rural,-2,-1,glare"
    (found,) = [of for of in load(coded(tmp_path, HEAD, *lines)).findings if "code" in of.code]
    assert (found.code, found.count) == ("code-beyond-recording", 2)
    assert found.message == "2 coded intervals of 3 lie outside of the evaluated frames."
    assert found.example == "urban, 9 to 12 s, glare"
    assert not load(coded(tmp_path, HEAD, lines[0])).findings


def test_nobody_is_without_a_code_in_recordings_that_nobody_coded():
    truth = [
        at(frame, 50, track=1, recording=recording) for recording in (0, 1) for frame in range(9)
    ]
    truth += [at(frame, 20, track=2, recording=0) for frame in range(20, 29)]
    dataset = make_dataset(truth, places=[Place(range(40))] * 2)
    codes = (CodedInterval(dataset.recordings["name"][0], 0.0, 0.1, "glare"),)
    result = result_of(dataset.with_settings(replace(dataset.settings, codes=codes)))
    assert encounters_table(result)["recording"].tolist() == ["r0", "r0", "r1"]
    classes = [set(text.split(";")) for text in encounters_table(result)["classes"]]
    assert [of & {"glare", "no_code"} for of in classes] == [{"glare"}, {"no_code"}, set()]


def test_the_terminal_says_who_detects_the_encounters_of_each_code():
    text = render_scorecard(four())
    assert re.search(r"^    glare( \(\w\))? +1 +1 +0 +0 ", text, re.MULTILINE)
    assert re.search(r"^    no code( \(\w\))? +0 +0 +1 +0 ", text, re.MULTILINE)


def test_a_session_file_names_the_file_or_holds_the_intervals(tmp_path):
    session = coded(tmp_path, HEAD, "urban,0,1,glare")
    text = write_session(session, version="", fingerprint="")
    assert read_session(write(tmp_path / "a.toml", text)).codes_file == str(tmp_path / "codes.csv")
    own = '[[code]]\nrecording = "{}"\nstart_s = 1\nend_s = {}\ncode = "glare"\n'
    text = write_session(replace(session, codes_file=None), version="", fingerprint="")
    with pytest.raises(SessionError, match=r"\[\[code\]\]: end_s: expected 1"):
        read_session(write(tmp_path / "b.toml", text, own.format("urban", 0)))
    with pytest.raises(InputError, match=r"\[\[code\]\]: there is no recording 'village'"):
        load(read_session(write(tmp_path / "b.toml", text, own.format("village", 2))))


def test_the_flag_takes_the_place_of_the_sessions_codes_and_the_report_has_them(tmp_path):
    write(tmp_path / "codes.csv", HEAD, "urban,0,1,glare")
    done = nvcore("compare", *flags(drive(tmp_path), "--codes", tmp_path / "codes.csv"),
                  "--out", tmp_path / "out")  # fmt: skip
    assert done.exit_code == 0, done.output
    table = codes_table([CodedInterval("urban", 0.0, 1.0, "glare")])
    assert (tmp_path / "out" / "codes.csv").read_bytes() == to_csv_bytes(table)
