"""The car's speed over time: read, put to frames, and what it changes in time left, by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from approach import PLACE, approach, only
from builders import NAN, make_dataset, result_of
from inputs import drive, session_of, write

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.inputs.speed import with_speeds
from nvcore.notes import Note, say
from nvcore.subjects.time_left.notes import last_chance, speed_of_all
from nvcore.subjects.time_left.steps import time_left_in, time_left_of
from nvcore.tables.result import recordings_table

HEAD = "time_s,speed_kmh"


def urban(folder: Path, *lines: str, **facts: float) -> Session:
    """Two recordings of 20 frames at 20 a second, and the speed of one of them."""
    write(folder / "speed.csv", *lines)
    return session_of(
        drive(folder), recordings=(RecordingEntry("urban", speed="speed.csv", **facts),)
    )


def met(folder: Path, *readings: str) -> Result:
    """A pedestrian whom the car reaches after 5 s, matched by X from frame 23 on, never by Y."""
    boxes = approach(range(40), 5)
    dataset = make_dataset(boxes, only(boxes, range(23, 40)), [], places=[PLACE])
    if readings:
        write(folder / "speed.csv", HEAD, *readings)
        entry = RecordingEntry(dataset.recordings["name"][0], speed="speed.csv")
        dataset = with_speeds(dataset, replace(session_of(folder), recordings=(entry,)))
    return result_of(dataset)


def test_between_two_readings_speed_is_on_their_line_outside_that_of_the_recording(tmp_path):
    session = urban(tmp_path, HEAD, "0.1,40", "0.5,80", speed_kmh=50.0)
    dataset = load(session)
    speed = dataset.frame_columns.speed_kmh
    assert speed[[1, 2, 4, 6, 10, 11, 19]].tolist() == pytest.approx([50, 40, 50, 60, 80, 50, 50])
    assert np.isnan(speed[20:]).all()  # of the other recording nothing is known
    (row,) = dataset.inputs[dataset.inputs["subject"] == "speed"].to_dict("records")
    assert row["file"] == "speed.csv"
    assert row["conversion"].startswith("speed of the car in 9 of 20 frames of 1 recording; in the")
    assert dataset.fingerprint != load(replace(session, recordings=())).fingerprint


def test_between_readings_more_than_five_seconds_apart_nothing_is_known(tmp_path):
    def speeds(*readings: str) -> list[float]:
        return met(tmp_path, *readings).dataset.frame_columns.speed_kmh[[0, 10, 20]].tolist()

    assert speeds("-4,10", "1,60") == pytest.approx([50, 60, NAN], nan_ok=True)
    assert speeds("-4.1,10", "1,60") == pytest.approx([NAN, 60, NAN], nan_ok=True)
    assert speeds("-9,10", "0,40", "1,60", "7,90") == pytest.approx([40, 60, NAN], nan_ok=True)


def test_a_written_session_names_the_series_and_tells_when_it_has_changed(tmp_path):
    session = urban(tmp_path, HEAD, "0,40", "1,80")
    text = write_session(replace(session, hashes={"speed": "0123"}), version="", fingerprint="")
    again = read_session(write(tmp_path / "session.toml", text))
    assert again.recordings[0].speed == (tmp_path / "speed.csv").as_posix()
    (finding,) = [known for known in load(again).findings if known.code == "input-changed"]
    assert finding.subject == "speed"


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([HEAD, "0,50", "0.5,60", "0.5,70"], r"speed.csv, line 4: time_s: expected a time after"),
        ([HEAD, "0,50", "0.5,-1"], r"speed.csv, line 3: speed_kmh: expected 0 to 400, found -1"),
        ([HEAD, "0,50", "0.5,401"], r"speed.csv, line 3: speed_kmh: expected 0 to 400, found 401"),
        ([HEAD, "0,fast"], r"speed.csv, line 2: speed_kmh: expected a number, found 'fast'"),
        ([HEAD, "2e8,50"], r"speed.csv, line 2: time_s: .*subtract the time of the first"),
        (["time_s,speed", "0,50"], r"speed.csv, line 1: .*speed_kmh is missing"),
        ([HEAD], r"speed.csv: expected speeds of the car, found none"),
        ([HEAD, "1,50", "9,50"], r"speed.csv: .*from 1 to 9 s, are of none .*from 0 to 0.95 s"),
    ],
)
def test_what_is_no_speed_of_the_recording_is_refused_with_its_line(tmp_path, lines, words):
    with pytest.raises(InputError, match=words):
        load(urban(tmp_path, *lines))


def test_each_frame_has_its_own_last_chance_and_the_impact_is_at_the_speed_there(tmp_path):
    # 5 s - t < 1.2 s + (50 + 10 t) / 3.6 / 14 from t = 2.343 s on: frame 24, at 74 km/h. X confirms
    # in frame 25, 2.5 s before contact: sqrt(20.556^2 - 14 * 20.556 * 1.3) m/s = 25.05 km/h.
    same, faster = met(tmp_path), met(tmp_path, "0,50", "4,90")
    for result, row, kmh, of_x in ((same, 29, 50.0, "in_time"), (faster, 24, 74.0, "late")):
        urgency = time_left_in(result).urgency
        assert urgency["urgent_row"].tolist() == [row]
        assert urgency["speed_kmh"].tolist() == pytest.approx([kmh])
        assert time_left_of(result.x)["time_left"].tolist() == [of_x]
        assert time_left_of(result.y)["impact_kmh"].tolist() == pytest.approx([kmh])
    assert time_left_of(faster.x)["impact_kmh"].tolist() == pytest.approx([25.05], abs=0.01)
    assert recordings_table(faster)["speed_kmh"].tolist() == pytest.approx([50 + 10 * 1.95])


def test_it_is_said_whether_speed_is_that_of_each_frame_or_assumed_in_some(tmp_path):
    assert speed_of_all(met(tmp_path)) == Note("time_left.speed", kmh=50.0)
    for readings, n_assumed in ((("0,50", "4,90"), None), (("0,50", "2,90"), 1)):
        result = met(tmp_path, *readings)
        speed = Note("time_left.speed", by="frame", kmh=50.0, n_assumed=n_assumed)
        assert speed_of_all(result) == speed
        assert time_left_in(result).assumed_speed_kmh is None
    own = last_chance(met(tmp_path, "0,50", "4,90"), 0)["speed"]
    kmh = [pytest.approx(74), pytest.approx(74)]
    assert own == Note("time_left.speed_of_one", kmh=kmh, is_stated=True)
    assert say(own, result.objects) == "74.0 km/h"
