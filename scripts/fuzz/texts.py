"""Targets for text: tables, rules, TOML, names and answers, each with small valid seeds.

Seeds of several files, such as trials with their features, have `PARTS` between the files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from io import BytesIO
from pathlib import Path, PurePosixPath
from types import SimpleNamespace
from typing import Any, Final
from unittest.mock import patch

import cv2
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv
import scipy

from nvcore.common.arguments.groups import GroupArguments
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import provenance_json, read_provenance
from nvcore.evidence.groups.comparison import compare_groups
from nvcore.inputs.codes import codes_beyond, with_codes
from nvcore.inputs.evaluated_frames import parse_frames
from nvcore.inputs.facts import is_frame_range
from nvcore.inputs.load import load
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.meaning.frame_names import listed_frames
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.inputs.session.recordings_file import read_recordings_file
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.inputs.speed import FASTEST_KMH, with_speeds
from nvcore.pictures.index import map_frames
from nvcore.pictures.open import open_pictures
from nvcore.report.gate.measures import measure_names
from nvcore.report.gate.outcomes import judge
from nvcore.report.gate.rules import read_rules
from nvcore.report.terminal import render_findings
from nvcore.settings.params import Params
from nvcore.subjects.alerts.inputs import with_alerts
from nvcore.subjects.alerts.policy import read_policy
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.subjects.driver.features import FEATURE_KEYS
from nvcore.subjects.driver.illumination.meter import read_light
from nvcore.subjects.driver.inputs.fixation import read_gaze
from nvcore.subjects.driver.inputs.joining import read_detectability
from nvcore.subjects.driver.inputs.study_tables import TRIAL_COLUMNS
from nvcore.subjects.driver.study.pictures import read_pictures
from nvcore.subjects.driver.trials.table import training_table
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.query import worst
from nvcore.subjects.ratings.agreement import measure_agreement, rank_ratings
from nvcore.subjects.ratings.clip_task import RatingStore
from nvcore.subjects.ratings.reading import parse_ratings
from nvcore.subjects.ratings.worth import read_alerts
from scripts.fuzz.target import DATA, PARTS, SAMPLE, mutated_text, read_toml, target, written
from ui.access.login import read_login, section_of
from ui.subjects.driver.study.on_screen import answer_of, sent_by_browser
from ui.widgets.text import plain

PICTURE: Final = bytes(cv2.imencode(".png", np.zeros((4, 6), np.uint8))[1])
_MOST_NAMES: Final = 40
_TIMES_S: Final = np.array([-1e9, -0.5, 0.0, 0.05, 1.0, 2.5, 1e9])
_QUICK_RANGE: Final = SimpleNamespace(
    sf=lambda q, k, df: scipy.stats.t.sf(q / 2**0.5, df) * k * (k - 1),
    ppf=lambda p, k, df: 2**0.5 * scipy.stats.t.isf((1 - p) / (k * (k - 1)), df),
)
"""Bonferroni's bounds replace the studentised range, whose quantiles take 0.1 s."""
_text: Final = partial(target, mutate=mutated_text)
_NAMES: Final = (
    b"000001.png\n000002.png\n000003.jpg\n",
    b"set06/V000/I00019.jpg\nset06/V000/I00020.jpg\n",
    b"img_0120.png\nframe-7.png\nseq/im 8.png\n",
    b"drive_1_frame12.jpg\ndrive_1_frame13.jpg\n",
    b"7_jpg.rf.0a1b2c.jpg\n8_jpg.rf.0a1b2d.jpg\n9_jpg.rf.0a1b2e.jpg\n",
    b"1691234567890123_lwir.png\n1691234567990123_lwir.png\n1691234568090123_lwir.png\n",
    b"img_0120.png\nimg_0120 (1).png\nimg_0121.png\ncalib.png\n",
)

_RESULTS: Final = {
    "encounters": pa.csv.read_csv(
        BytesIO(
            b"recording,track,shown_frame,shown_s,severity_s_x,severity_s_y,detected_x,category\n"
            b"a,1,2,0.2,1.0,0.0,true,both\na,,5,0.5,,3.0,,it's\nb,7,9,0.9,2.0,,false,\n"
        )
    ),
    "recordings": pa.table(
        [
            ["a", "b"],
            [10.0, 20.0],
            ["u1", ""],
            [["night", "road=rural"], ["road=it's", "speed=60"]],
        ],
        ["recording", "fps", "unit", "tags"],
    ),
}
"""Files of a scan that `worst` finds below its folder."""


def _trials_seeds() -> Iterator[bytes]:
    """Yield two subjects and two pictures, separated by commas and by semicolons."""
    rows = [
        f"{subject},1,{i},{i},{image}.png,p,{period},{period},{touch},0.7,{not_seen},{device}"
        for subject, device in (("s1", "touch"), ("s2", "simulated"))
        for i, (image, period, touch, not_seen) in enumerate(
            (("a", 0.5, "12,22", 0), ("b", 0.5, ",", 1), ("a", 1.5, "90,90", 0)), 1
        )
    ]
    asked = "\n".join([",".join(TRIAL_COLUMNS), *rows]).encode()
    values = ",".join(f"{i}.5" for i in range(len(FEATURE_KEYS)))
    images = ("a.png,p", "b.png,p")
    head = f"image,pedestrian,{','.join(FEATURE_KEYS)}"
    features = "\n".join([head, *(f"{image},{values}" for image in images)]).encode()
    boxes = [f"{image},10,20,5,9" for image in images]
    apart = "\n".join(["image,pedestrian,x,y,w,h", *boxes]).encode()
    yield PARTS.join((asked, features, apart))
    yield PARTS.join((asked.replace(b",", b";"), features, apart))


@_text(b"time_s,lux\n-1.0,1000\n0.0,900.5\n0.1,10\n", b"lux;time_s;note\n1000,5;0,0;day\n10;0,1;\n")
def light(content: bytes, folder: Path) -> None:
    """Read a light meter, and look up readings and stretches at some times."""
    readings = read_light(written(folder, "lux.csv", content))
    levels, since_s = readings.at(_TIMES_S), readings.since_s(_TIMES_S)
    assert (np.isnan(levels) == np.isnan(since_s)).all(), "a level without a reading"
    assert not (levels < 0).any(), "less than no light"
    assert not (since_s > _TIMES_S).any(), "a reading of the future"
    assert readings.gaps_s.shape[1] == 2, "a gap without an end"


@_text(b"frame,x,y\n212,960.5,540\n3,-5,2000\n", b"y;x;frame\n540,5;960;-7\n", share=0.25)
def gaze(content: bytes, folder: Path) -> None:
    """Read a gaze file, and look up fixations in frames with and without one."""
    fixations = read_gaze(written(folder, "gaze.csv", content))
    assert (np.diff(fixations.frame) > 0).all(), "frames that are not sorted"
    frames = np.append(fixations.frame, [-(2**62), 0, 2**62])
    points = fixations.at(frames)[: len(fixations.frame)]
    assert np.array_equal(points, fixations.point), "another point"


@_text(
    b"recording,frame,x,y,w,h,track,detectability,sd,is_outside,period_s\n"
    b"drive,1,300,200,30,80,4,0.5,0.1,0,1.5\ndrive,2,301,200,30,80,4,,,1,\n"
)
def estimates(content: bytes, folder: Path) -> None:
    """Read a file of detectability estimates."""
    path = written(folder, "detectability.csv", content)
    table = read_detectability(SourceFile(path, path.name))
    known = table["detectability"].dropna()
    assert known.between(0, 1).all(), "no share"


@_text(_trials_seeds, share=1.0)
def trials(content: bytes, folder: Path) -> None:
    """Read, judge and join trials and features, with or without boxes."""
    names = ("trials.csv", "features.csv", "boxes.csv")
    parts = zip(names, content.split(PARTS), strict=False)
    paths = [written(folder, name, part) for name, part in parts]
    if len(paths) < 2:
        return
    table = training_table(*paths[:2], boxes=paths[2] if len(paths) > 2 else None)
    rows = table.rows
    assert rows["detectability"].between(0, 1).all(), "no share"
    assert (rows["n_right"] <= rows["n_subjects"]).all(), "more than all"
    assert rows["n_subjects"].sum() == table.n_trials, "trials that are lost"


@_text(
    b"image,pedestrian,x,y,w,h\na.png,1,1,1,2,2\nb.png,2,0.5,0,1,3\n",
    b"image;pedestrian;x;y;w;h;note\nb.png;p;-1;1,5;4;2;dark\n",
)
def boxes(content: bytes, folder: Path) -> None:
    """Read a study's table of boxes in a folder with two pictures."""
    for name in ("a.png", "b.png"):
        written(folder, name, PICTURE)
    pictures = read_pictures(written(folder, "boxes.csv", content).parent)
    assert {picture.image for picture in pictures} <= {"a.png", "b.png"}, "a picture of elsewhere"
    for picture in pictures:
        assert (picture.width, picture.height) == (6, 4), "another size"
        assert min(picture.w, picture.h) > 0, "a box without size"


@_text(
    b"participant,clip,rating\nann,a,1\nann,b,2\nben,a,2\nben,b,3\ncy,a,\ncy,b,4\n",
    b"participant;clip;system;rating;delay_s\nann;a;x;1,5;2\nann;a;y;3;2\nben;a;x;2;-\n",
)
def ratings(content: bytes, _folder: Path) -> None:
    """Read ratings of clips, rank them and compare them with each other."""
    table = parse_ratings(content, name="ratings.csv")
    agreement = measure_agreement(rank_ratings(table))
    assert math.isnan(agreement.w) or -1e-9 <= agreement.w <= 1 + 1e-9, "no share"


@_text(
    b'{"measured_s": 1.52, "shown_s": 0.2, "touch": [12.5, 40], "response_s": 0.71, '
    b'"is_answered": true, "pointer": "touch", "shown_px": 640, "screen_px": 1280}',
    b'{"measured_s": 3, "shown_s": 0.2, "touch": null, "is_answered": false}',
    share=0.25,
    most_bytes=2000,
)
def answers(content: bytes, _folder: Path) -> None:
    """Parse a participant's answer as sent by the browser."""
    answer = answer_of(sent_by_browser(content), "a screen")
    assert math.isfinite(answer.measured_s + answer.shown_s), "no number"
    assert math.isnan(answer.touch_x) == math.isnan(answer.touch_y), "half a touch"
    assert "a screen" in answer.device, "another screen"
    assert len(answer.device) <= 200, "more text than is stored"


@_text(*_NAMES, most_bytes=2048)
def names(content: bytes, folder: Path) -> None:
    """Parse file names, one per line, into recording and frame."""
    names = content.decode("utf-8", "replace").splitlines()[:_MOST_NAMES]
    table = listed_frames([SourceFile(folder, name) for name in names], ReadOptions()).table
    frames = table[table["frame"] >= 0]
    assert len(table) == len(names), "names that are lost"
    assert not frames.duplicated(["recording", "frame"]).any(), "a frame twice"


@_text(*_NAMES, most_bytes=2048)
def folders(content: bytes, folder: Path) -> None:
    """Place pictures in a folder by file names, one per line."""
    for name in content.decode("utf-8", "replace").splitlines()[:_MOST_NAMES]:
        path = PurePosixPath(name.replace("\0", ""))
        if path.name not in ("", "..") and len(path.name.encode()) < 200:
            written(folder, path.name, PICTURE)
    pictures = open_pictures(folder)
    try:
        if (numbers := pictures.numbers) is not None:
            assert len({*numbers.tolist()}) == pictures.n, "a number each"
        frames = np.arange(pictures.n)
        shown = map_frames(frames, pictures).index
        assert len({*shown[shown >= 0].tolist()}) == np.count_nonzero(shown >= 0), "shown twice"
        assert pictures.read(pictures.n - 1).shape == (4, 6), "another picture"
    finally:
        pictures.close()


@_text(*((place / "session.toml").read_bytes() for place in (SAMPLE, DATA / "written")), share=1.0)
def sessions(content: bytes, folder: Path) -> None:
    """Read a session file, and check its round trip."""
    path = written(folder, "session.toml", content)
    session = read_toml(read_session, path)
    text = write_session(session, version="0", fingerprint="0")
    path.write_bytes(text.encode())
    again = read_session(path)
    assert write_session(again, version="0", fingerprint="0") == text, "the text has changed"
    assert str(again.params) == str(session.params), "settings have changed"
    assert str(again.protocol) == str(session.protocol), "the protocol has changed"


@_text(
    b"recording,width,height,fps,context,tags,pictures\na,640,480,20,rural,night;rain,a.mp4\n",
    b'recording;tags;fps;context\n"a b";"x y";20,5;0,5\nb;;;\n',
)
def recordings(content: bytes, folder: Path) -> None:
    """Read a table of recordings."""
    path = written(folder, "recordings.csv", content)
    for name, (line, entry) in read_recordings_file(path, "recordings.csv").items():
        assert name == entry.name, "another name"
        assert line > 1, "no line"


@_text(
    b'{"detector": {"trained_on": [{"recording": "a", "first_frame": 0}]}}',
    b'{"written_by": "nvcore", "detector": {"kind": "hog", "name": "HOG", "labels": ["sign"], '
    b'"fingerprint": "5f", "settings": {"a": 1, "b": true, "c": null, "d": 0.5, "e": "f"}, '
    b'"trained_on": [{"fingerprint": "ab", "last_frame": -3}]}, "files": {"a.csv": "cd"}, '
    b'"recordings": [{"name": "a", "frames": ["0:9", "11:11"]}]}',
    share=0.25,
)
def provenance(content: bytes, folder: Path) -> None:
    """Read a provenance record of detections."""
    path = written(folder, "provenance.json", content)
    text = provenance_json(read_provenance(path, "provenance.json"))
    path.write_bytes(text)
    assert provenance_json(read_provenance(path, "again")) == text, "another record"


@_text(b"0:299", b"-5:10:2", b"1\n2\n5\n", b"\xef\xbb\xbf3\r\n4\r\n", share=0.25)
def frames(content: bytes, folder: Path) -> None:
    """Read evaluated frames: a range, or a file of numbers."""
    written(folder, "frames.txt", content)
    text = content.decode("utf-8", "replace")
    own = np.arange(10, 15)
    frames = parse_frames(text if is_frame_range(text) else "frames.txt", folder, own)
    assert (np.diff(frames) > 0).all(), "frames that are not sorted"


@_text(
    b"mean_similarity_y >= 0.9\nlog_average_miss_rate_y <= 10% or undefined # why\n",
    b"newly_missed == 0\nsaliency_x <= 1e-3\nsaliency_difference => -5\naudit_errors < 1\n",
    share=0.25,
)
def rules(content: bytes, _folder: Path) -> None:
    """Read gate rules, and apply them to measures with and without a value."""
    names = measure_names()
    lines = [("--rule", text) for text in content.decode("utf-8", "replace").splitlines()]
    read, problems = read_rules(lines, names)
    assert problems or len(read) <= len(lines), "more rules than lines"
    judge(read, dict.fromkeys(names, 0.5))
    judge(read, dict.fromkeys(names, float("nan")))


@_text(
    b'base = "cautious"\nalert_k = 0.4\nalert_pause_s = 5\nalert_corridor = 0.5\n',
    b"alert_on_s = 0.5\nalert_off_s = 0.2\nalert_distance_m = 40.0\nalert_score = -1e3\n",
)
def policies(content: bytes, folder: Path) -> None:
    """Read an alert policy, whose values are settings."""
    path = written(folder, "policy.toml", content)
    Params(**read_toml(lambda path: read_policy(SourceFile(path, path.name)), path))


@_text(
    b"start_s,end_s,kind,track,recording\n0.1,0.45,red,1,urban\n0.5,0.5,,,rural\n",
    b"kind;end_s;start_s;recording\nsign;0,2;0,1;urban\ntone;0,2;0,1;urban\n;0,9;0,8;rural\n",
    b"recording,frame,x,y,w,h,track,score,alerted\nurban,1,103,200,40,101,1,0.8,1\n"
    b"urban,2,106,200,40,102,1,0.7,0\nrural,3,109,200,40,103,1,0.6,true\n",
    share=1.0,
)
def logs(content: bytes, folder: Path) -> None:
    """Read a log of alerts, or detections with an alert column, for one and for two recordings."""
    session, result = _compared(folder)
    header = content.partition(b"\n")[0].lower()
    name = "x.csv" if b"alerted" in header else "log.csv"
    for file, text in {**_drives(), name: content}.items():
        written(folder, file, text)
    x, y = session.systems
    session = replace(session, systems=(replace(x, alerts=name), y))
    if b"recording" not in header:
        with_alerts(_urban(folder), session)
    known = {key: made for key, made in result.stages.items() if key[0] != "alerts"}
    dataset = with_alerts(result.dataset, session)
    table = alerts_in(compare(dataset, Params(alerts="log"), stages=known)).table
    _check_finite(table.drop(columns="lead_s"))
    assert (table["duration_s"] >= 0).all(), "an alert that ends before it begins"


@_text(
    b"recording,start_s,end_s,code\nurban,0.1,0.4,glare\nrural,2.5,18,eyes off road\n",
    b"code;end_s;start_s;recording;note\nglare;0,4;-1;rural;x\nglare;0,4;-1;rural;\n",
)
def codes(content: bytes, folder: Path) -> None:
    """Read coded intervals, and find those beyond the recordings."""
    written(folder, "codes.csv", content)
    session, result = _compared(folder)
    names = [*result.dataset.recordings["name"]]
    coded = with_codes(replace(session, codes_file="codes.csv"), names)
    render_findings(codes_beyond(result.dataset, coded.codes))


@_text(b"time_s,speed_kmh\n0.00,48.2\n0.10,48.0\n9,0\n", b"speed_kmh;time_s\n30,5;-1\n400;0,5\n")
def speeds(content: bytes, folder: Path) -> None:
    """Read speeds of the car over a recording."""
    written(folder, "speed.csv", content)
    session, result = _compared(folder)
    entry = RecordingEntry("urban", speed="speed.csv")
    dataset = with_speeds(result.dataset, replace(session, recordings=(entry,)))
    known = dataset.frames["speed_kmh"].dropna()
    assert known.between(0, FASTEST_KMH).all(), "no speed of a car"


@_text(
    b"condition,n,mean,sd\na,11,1678,755.1\nb,11,2171,766.2\nc,1,1245,\n",
    b"participant,condition,value\np1,a,1\np1,b,2.5\np2,a,3\np2,b,3\np3,a,1\np3,b,7\n",
    b"condition;time_s\na;0,5\na;1,5\na;2\nb;1\nb;2\nb;9\n",
    b"participant,condition,kind,run,n\na,x,near,1,2\na,x,far,1,0\na,y,near,1,3\nb,y,far,1,4\n",
    share=1.0,
    most_bytes=1024,
)
def groups(content: bytes, folder: Path) -> None:
    """Read a table of groups, and run every test that it allows."""
    path = written(folder, "groups.csv", content)
    with patch("scipy.stats.studentized_range", _QUICK_RANGE):
        comparison = compare_groups(GroupArguments(path))
    str(comparison)
    _check_finite(comparison.groups[["n", "mean"]])
    for table in (comparison.groups, comparison.tests, comparison.pairs, comparison.assumptions):
        _check_finite(table.select_dtypes("number").fillna(0))
        for column in {"p", "p_corrected"} & {*table}:
            assert table[column].dropna().between(0, 1).all(), "no probability"


@_text(
    b"recording,system,start_s,end_s,kind\nurban,x,0.1,0.5,wanted\nrural,Y,0.2,0.2,false\n",
    b"kind;duration_s;start_s;system;recording\nignored;1;0;y;urban\nneeded;0,5;0,2;X;rural\n",
)
def judged(content: bytes, folder: Path) -> None:
    """Read alerts that raters judge."""
    for alert in read_alerts(content, _compared(folder)[1], name="alerts.csv"):
        assert 0 <= alert.start_s <= alert.end_s < math.inf, "no times"


@_text(
    b"tag.road = 'rural' and shown_frame > 3 or category <> 'it''s' and not track is null",
    b"not tag.night or tag.speed between 50 and 1e2 or tag.road like 'r%'",
    b"(recording.fps in (10, 20.5) and detected_x is not true) or severity_s_x is null",
    share=1.0,
    most_bytes=1024,
)
def filters(content: bytes, folder: Path) -> None:
    """Parse conditions for the worst rows of a scan's results."""
    with patch(
        "nvcore.subjects.fleet.query._dataset", lambda _results, table, _versions: _RESULTS[table]
    ):
        str(worst(Location(folder), where=content.decode("utf-8", "replace")))


@_text(b"Shoe size\nDo you *drive* at night?\n", b"A\n\nB\n1. A\n", most_bytes=4096)
def forms(content: bytes, folder: Path) -> None:
    """Parse a form's own questions, one per line, and ask, answer and list them."""
    lines = content.decode("utf-8", "replace").splitlines()
    questions = [line.strip() for line in lines if line.strip()]
    store = RatingStore(folder / "ratings.sqlite")
    begun = store.begin("0", [("a", "x")], questions=questions)
    study = store.study(begun.token)
    assert study is not None
    assert study.form == begun.form, "another form"
    assert len(study.form) - len(questions) == 4, "a question without a field"
    answers = {field: plain(label) for field, label in study.form.items()}
    store.join(study, answers, name="Ann")
    table = store.forms(study)
    assert table.iloc[0].to_dict() == {"participant": "Ann", **answers}, "another answer"
    to_csv_bytes(table)


@_text(
    b'[auth]\nredirect_uri = "https://tools.example.com/oauth2callback"\nclient_id = "n"\n'
    b'cookie_secret = "0123456789012345678901234567890123"\nclient_secret = "s"\nhours = 12\n'
    b'server_metadata_url = "https://id.example.com/.well-known/openid-configuration"\n'
    b'allow = ["example.com", "anna@partner.example"]\n',
    b'[auth]\nredirect_uri = "http://localhost:{port}/oauth2callback"\n'
    b'cookie_secret = "0123456789012345678901234567890123"\n[auth.two]\nclient_id = "n"\n'
    b'client_secret = "s"\nserver_metadata_url = "https://id.example.com/x"\n',
)
def logins(content: bytes, folder: Path) -> None:
    """Read login settings."""
    path = written(folder, "login.toml", content)
    settings = read_toml(lambda path: read_login(section_of(path), file=path.name), path)
    assert settings.allow is None or not settings.admits("anna@"), "nobody's address"
    assert settings.origin.startswith(("https://", "http://")), "no origin"
    assert 0 < settings.hours < math.inf, "no time"


def _check_finite(table: pd.DataFrame) -> None:
    numbers = table.select_dtypes("number").to_numpy(dtype=float, na_value=0.0)
    assert np.isfinite(numbers).all(), "numbers that are none"


@cache
def _drives() -> dict[str, bytes]:
    """Return two drives of a pedestrian whom the second system misses in the last frames."""
    rows = [
        f"{name},{frame},{100 + 3 * frame},200,40,{100 + frame},1,0.{9 - frame % 9}\n"
        for name in ("urban", "rural")
        for frame in range(20)
    ]
    files = {"truth.csv": rows, "x.csv": rows, "y.csv": rows[:30]}
    head = "recording,frame,x,y,w,h,track,score\n"
    return {name: "".join([head, *lines]).encode() for name, lines in files.items()}


@cache
def _compared(folder: Path) -> tuple[Session, Result]:
    """Return the session of `_drives` in this folder, and its comparison."""
    for name, content in _drives().items():
        written(folder, name, content)
    systems = tuple(SystemSource((f"{name}.csv",), name=name.upper()) for name in "xy")
    facts: dict[str, Any] = {"size": (640, 480), "fps": 20.0}
    session = Session(folder=folder, truth=Source(("truth.csv",)), systems=systems, **facts)
    result = compare(load(session), Params(alerts="log"))
    assert len(alerts_in(result).table), "no alerts of which anything could be wrong"
    return session, result


@cache
def _urban(folder: Path) -> Dataset:
    return _compared(folder)[1].dataset.only((), ("urban",))
