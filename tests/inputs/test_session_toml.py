"""Session files: what they say, what they may not say, and that writing them loses nothing."""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inputs import write

from nvcore.common.errors import SessionError
from nvcore.inputs.session import RecordingEntry, RecordingsFile, Session, Source, SystemSource
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN, Objects, objects_from
from nvcore.settings.params import Params
from nvcore.settings.primary import Primary
from nvcore.settings.protocols import OWN, PROTOCOLS, Protocol
from nvcore.settings.published import PublishedPoint

MINIMAL = ('[truth]\npath = "gt.csv"', '[[system]]\npath = "fir.csv"')
FULL = Session(
    folder=Path("/drives"),
    truth=Source(("gt/a.csv", "gt/b*.csv"), "csv", ("person", "child"), 0, 1),
    systems=(
        SystemSource(
            ("fir.csv",), "csv", ("7",), 1, 0, name="FIR", threshold=0.25, offset_frames=-3,
            offset_px=(1.5, -2.0), scale=(2.0, 0.5),
        ),
        SystemSource(("nir.csv",), name="NIR", scale=(1.25, 1.25)),
    ),
    recordings=(
        RecordingEntry(
            "urban", 640.0, 480.0, 20.0, "frames.txt", 236.5, "urban.mp4", 3, ("night", "wet road"),
            0.25,
        ),
        RecordingEntry("rural", frames="0:299:20", context=1.0, speed_kmh=80.0),
    ),
    size=(1280, 960),
    fps=12.5,
    frames="lists/all.txt",
    x="NIR",
    y="FIR",
    params=Params(alpha=0.7, midpoint=30.0, proximity="horizon", threshold_y=-0.5),
    protocol=Protocol(
        OWN, height_px=(40.0, math.inf), occlusion=(0, 1), border_px=(1.0, 2.0, 3.0, 4.5),
        aspect=(0.5, 4.0), tags=("night",), expand=1.5,
    ),
    primary=Primary("saliency", "2026-11-26T17:40:12+00:00", "ab", is_changed=True),
    published=(
        PublishedPoint(name="report", recall=0.939, precision=0.215),
        PublishedPoint(name="\"paper\"", miss_rate=0.1, fppi=1.5, fppw=1e-5),
    ),
    hashes={"truth": "ab", "FIR": "cd", "odd \"name\"\n": "ef"},
)  # fmt: skip


def read(folder: Path, *parts: str) -> Session:
    return read_session(write(folder / "session.toml", *parts))


def written(session: Session, folder: Path) -> Session:
    text = write_session(session, version="1", fingerprint="2")
    return read_session(write(folder / "session.toml", text))


def test_a_minimal_session_takes_everything_else_from_the_data(tmp_path: Path):
    session = read(tmp_path, *MINIMAL)
    assert session == Session(tmp_path, Source(("gt.csv",)), (SystemSource(("fir.csv",)),))


def test_every_key_is_read(tmp_path: Path):
    session = read(
        tmp_path,
        '[defaults]\nsize = "640x480"\nfps = 20\nframes = "0:9"',
        '[[recording]]\nname = "urban"\nwidth = 320\nheight = 240\nfps = 12.5\nframes = "0:4"\n'
        'horizon = 120\npictures = "urban.mp4"\nfirst_picture = 2330\ntags = ["night"]',
        '[truth]\npath = ["a.csv", "b.csv"]\nformat = "csv"\nclasses = ["person"]\n'
        "frame_base = 0\nbox_base = 1",
        '[[system]]\nname = "FIR"\npath = "fir.csv"\nthreshold = 0.5\noffset_frames = 2\n'
        "offset_px = [1, -2.5]\nscale = 2",
        '[[system]]\npath = "nir.csv"\nscale = [2, 0.5]',
        '[compare]\nx = "FIR"\ny = "NIR"',
        '[parameters]\nalpha = 0.5\nmatch = "lateral"',
        '[protocol]\nname = "near"\ntags = ["night"]',
        '[written]\nversion = "0"\nsha256 = {truth = "ab"}',
    )
    first, second = session.systems
    assert (session.size, session.fps, session.frames) == ((640, 480), 20.0, "0:9")
    assert session.protocol == replace(PROTOCOLS["near"], tags=("night",))
    assert session.recordings == (
        RecordingEntry("urban", 320.0, 240.0, 12.5, "0:4", 120.0, "urban.mp4", 2330, ("night",)),
    )
    assert session.truth == Source(("a.csv", "b.csv"), "csv", ("person",), 0, 1)
    assert (first.name, first.threshold, first.offset_frames) == ("FIR", 0.5, 2)
    assert (first.offset_px, first.scale, second.scale) == ((1.0, -2.5), (2.0, 2.0), (2.0, 0.5))
    assert (session.x, session.y, session.hashes) == ("FIR", "NIR", {"truth": "ab"})
    assert session.params == Params(alpha=0.5, match="lateral")


@pytest.mark.parametrize("objects", [PEDESTRIAN, SPEED_SIGN, objects_from(["child", "children"])])
def test_what_the_boxes_are_of_is_written_and_read_back(tmp_path: Path, objects: Objects):
    text = write_session(replace(FULL, objects=objects), version="1", fingerprint="2")
    assert ("objects = " in text) == (objects is not PEDESTRIAN)
    assert read_session(write(tmp_path / "again.toml", text)).objects == objects


def test_objects_may_be_named_by_a_singular_alone(tmp_path: Path):
    assert read(tmp_path, *MINIMAL, '[compare]\nobjects = "cyclist"').objects.plural == "cyclists"


def test_what_is_written_reads_back_as_the_same_session(tmp_path: Path):
    again = written(FULL, tmp_path)
    paths = [source.path for source in (again.truth, *again.systems)]
    assert paths == [
        tuple(f"/drives/{path}" for path in source.path) for source in (FULL.truth, *FULL.systems)
    ]
    assert again.frames == "/drives/lists/all.txt"
    assert again.recordings[0].frames == "/drives/frames.txt"
    assert again.recordings[0].pictures == "/drives/urban.mp4"
    relative = replace(
        again,
        folder=FULL.folder,
        truth=replace(again.truth, path=FULL.truth.path),
        systems=tuple(
            replace(a, path=b.path) for a, b in zip(again.systems, FULL.systems, strict=True)
        ),
        frames=FULL.frames,
        recordings=FULL.recordings,
    )
    assert relative == FULL


def test_writing_again_what_was_read_gives_the_same_text(tmp_path: Path):
    first = write_session(FULL, version="1", fingerprint="2")
    again = write_session(written(FULL, tmp_path / "far" / "away"), version="1", fingerprint="2")
    assert again == first


def test_a_glob_below_a_folder_with_brackets_still_means_the_same(tmp_path: Path):
    folder = tmp_path / "drive[1]"
    write(folder / "a.csv", "x")
    session = Session(folder, Source(("*.csv",)), (SystemSource(("a.csv",)),))
    path = written(session, tmp_path).truth.path[0]
    assert path == f"{tmp_path.as_posix()}/drive[[]1]/*.csv"


@settings(max_examples=30)
@given(st.floats(0, 1), st.text(st.characters(codec="utf-8"), min_size=1))
def test_any_threshold_and_any_name_survive(threshold: float, name: str):
    system = SystemSource(("a.csv",), name=name, threshold=threshold)
    text = write_session(
        Session(Path("/d"), Source(("t.csv",)), (system,)), version="1", fingerprint="2"
    )
    table = tomllib.loads(text)["system"][0]
    assert (table["name"], table["threshold"]) == (name, threshold)


def test_filters_in_whole_numbers_are_written_the_same_again(tmp_path: Path):
    lines = (*MINIMAL, '[protocol]\nname = "reasonable"\naspect = [1, inf]')
    first = write_session(
        read_session(write(tmp_path / "a.toml", *lines)), version="", fingerprint=""
    )
    (tmp_path / "b.toml").write_text(first, "utf-8")
    assert write_session(read_session(tmp_path / "b.toml"), version="", fingerprint="") == first


def test_the_written_session_holds_version_and_fingerprint():
    table = tomllib.loads(write_session(FULL, version="1.2.3", fingerprint="f00"))
    assert ["tags" in recording for recording in table["recording"]] == [True, False]
    told = {"version": "1.2.3", "fingerprint": "f00", "sha256": dict(FULL.hashes)}
    assert table["written"] == told


SYSTEM = '[[system]]\npath = "fir.csv"\n'
RECORDING = '[[recording]]\nname = "a"\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello = ", "is not TOML"),
        ("a = " + "[" * 5000, "is not TOML"),
        (f"a = {'9' * 5000}", "is not TOML"),
        (SYSTEM + f"offset_frames = 0x{'f' * 5000}", "is not TOML: an integer of more than 64"),
        (SYSTEM + f"scale = [1, {10**400}]", "is not TOML: an integer of more than 64 bits"),
        (
            "[truths]",
            "the session has no key 'truths'; did you mean 'truth'? Its keys are code, codes",
        ),
        ("truth = 1  # [truth]", "expected [truth] to be a table"),
        ("system = 1  # [[syste", "expected [[system]] to be a list of tables"),
        ("[defaults]\nsize = '640'", "[defaults]: expected a size such as 640x480, got '640'"),
        ("[defaults]\nsize = 640", "[defaults]: size: expected a text, found 640"),
        ("[defaults]\nfps = '20'", "[defaults]: fps: expected a number, found '20'"),
        ("[defaults]\nfps = inf", "fps: expected a number from 0.001 to 10000, found inf"),
        ("[defaults]\nfps = 0", "fps: expected a number from 0.001 to 10000, found 0"),
        (RECORDING + "fps = 1e300", "fps: expected a number from 0.001 to 10000, found 1e+300"),
        ("[defaults]\nheight = 1", "[defaults] has no key 'height'; its keys are fps, frames"),
        ("[compare]\nx = 1", "[compare]: x: expected a text, found 1"),
        ("[compare]\nobjects = 1", "[compare]: objects: expected a list of texts, found 1"),
        ('[compare]\nobjects = "<b>"', "[compare]: objects: expected a name of letters"),
        ('[compare]\nobjects = ["a", "b", "c"]', "[compare]: objects: expected a singular"),
        ("[parameters]\nalfa = 1", "[parameters]: there is no parameter 'alfa'"),
        ("[protocol]\nname = 'best'", "[protocol]: there is no protocol 'best'; there are: all"),
        ("protocol = 1  # [protocol]", "expected [protocol] to be a table"),
        ("[primary]\nkey = 'saliency'", "[primary] has no key 'key'; its keys are changed"),
        ("[primary]\nchanged = 1", "[primary]: changed: expected true or false, found 1"),
        ("[written]\nsha256 = {a = 1}", "[written]: sha256: a: expected a text, found 1"),
        ("[[recording]]\nwidth = 1", "[[recording]]: expected a name"),
        (RECORDING + "wide = 1", "[[recording]] has no key 'wide'; did you mean 'width'?"),
        (RECORDING + "fps = true", "[[recording]]: fps: expected a number, found True"),
        (RECORDING + "horizon = nan", "[[recording]]: horizon: expected a finite number"),
        (RECORDING + "first_picture = 1.5", "first_picture: expected a whole number, found 1.5"),
        (RECORDING + f"first_picture = {10**16}", "first_picture: expected a frame number"),
        (RECORDING + "tags = 'night'", "tags: expected a list of texts"),
        (RECORDING + "tags = ['night', 'night']", "tags: expected different words"),
        (RECORDING + "tags = ['night', ' ']", "tags: expected different words"),
        (RECORDING * 2, "the session: expected one [[recording]] named 'a', found several"),
        (SYSTEM + "scores = 1", "[[system]] has no key 'scores'"),
        (SYSTEM + "scale = 0", "[[system]]: scale: expected a positive number, found 0"),
        (SYSTEM + "scale = [1, 2, 3]", "[[system]]: scale: expected two numbers, found [1, 2, 3]"),
        (SYSTEM + "offset_px = [1, inf]", "offset_px: expected a finite number, found inf"),
        (SYSTEM + "offset_frames = 1.5", "offset_frames: expected a whole number, found 1.5"),
        (SYSTEM + "offset_frames = 99999999", "offset_frames: expected at most 1000000, found"),
        (SYSTEM + "threshold = nan", "[[system]]: threshold: expected a number, found nan"),
        (SYSTEM + "frame_base = true", "frame_base: expected a whole number, found True"),
        (SYSTEM + "frame_base = 2", "[[system]]: frame_base: expected 0 or 1, found 2"),
        (SYSTEM + "classes = []", "[[system]]: classes: expected names or numbers of classes"),
        ("[[system]]\npath = []", "[[system]]: path: expected a file, folder or glob"),
        ("[[system]]\nname = 'a'", "[[system]]: expected a path"),
        ("[[system]]\npath = ''", "[[system]]: path: expected a file, folder or glob"),
    ],
)
def test_what_cannot_be_done_is_told_with_its_table_and_key(tmp_path: Path, text: str, words: str):
    with pytest.raises(SessionError, match=re.escape(words)) as caught:
        read(tmp_path, text, *(part for part in MINIMAL if part[:7] not in text))
    assert caught.value.file == str(tmp_path / "session.toml")
    assert str(caught.value).count("session.toml") == 1


@pytest.mark.parametrize("part", MINIMAL)
def test_a_session_needs_truth_and_a_system(tmp_path: Path, part: str):
    with pytest.raises(SessionError, match=r"expected a \[truth\] table and at least one \[\[sys"):
        read(tmp_path, part)


def test_a_missing_file_and_a_video_are_no_session(tmp_path: Path):
    with pytest.raises(SessionError, match=r"no\.toml: cannot be opened \(No such file"):
        read_session(tmp_path / "no.toml")
    (tmp_path / "a.mp4").write_bytes(b"\x00\x00\x00\x18ftyp\xff\xfe")
    with pytest.raises(SessionError, match=r"a\.mp4: is not TOML"):
        read_session(tmp_path / "a.mp4")


def test_a_session_file_of_hundreds_of_megabytes_is_refused(tmp_path: Path):
    with (tmp_path / "a.toml").open("wb") as file:
        file.truncate((16 << 20) + 1)
    with pytest.raises(SessionError, match=r"a\.toml: is larger than 16 MiB"):
        read_session(tmp_path / "a.toml")


def test_a_name_that_is_not_utf8_is_refused():
    with pytest.raises(SessionError, match=r"name: expected UTF-8 text, found '\\udcff'"):
        SystemSource(("a",), name="\udcff")


def test_a_glob_longer_than_a_file_name_is_written_as_it_is(tmp_path: Path):
    path = f"{'long' * 100}*.csv"
    session = Session(tmp_path, Source((path,)), (SystemSource(("s",)),))
    assert f"/{path}" in write_session(session, version="1", fingerprint="2")


@pytest.mark.parametrize(
    ("facts", "expected"),
    [
        ({"size": (640, 480)}, (640, 480)),
        ({"recordings": tuple(RecordingEntry(name, 320, 240) for name in "ab")}, (320, 240)),
        ({"recordings": (RecordingEntry("a", 320, 240), RecordingEntry("b"))}, None),
        ({"recordings": (RecordingEntry("a"),)}, None),
        ({}, None),
    ],
)
def test_the_common_size_is_that_of_all_recordings(facts: dict, expected: tuple | None):
    session = Session(Path(), Source(("t",)), (SystemSource(("s",)),), **facts)
    assert session.common_size == expected


@pytest.mark.parametrize(
    "lines",
    [
        ("[[recording]]", 'name = "a"', r'pictures = "night\u0000.mp4"', *MINIMAL),
        ("[[recording]]", 'name = "a"', r'frames = "night\u0000.txt"', *MINIMAL),
        ("[defaults]", r'frames = "night\u0000.txt"', *MINIMAL),
        ("[truth]", r'path = ["a.csv", "night\u0000.csv"]', MINIMAL[1]),
    ],
)
def test_a_path_that_no_file_can_have_is_refused(tmp_path: Path, lines: tuple[str, ...]):
    with pytest.raises(SessionError, match="expected a path, found one with a NUL") as caught:
        read_session(write(tmp_path / "s.toml", *lines))
    assert str(caught.value).isprintable()


def test_the_paths_of_a_session_are_inputs_frame_lists_and_pictures():
    facts = RecordingEntry("a", frames="a.txt", pictures="a.mp4")
    session = Session(
        Path(), Source(("t.csv",)), (SystemSource(("x.csv", "y/*.csv")),), (facts,), frames="0:9"
    )
    assert list(session.paths()) == ["t.csv", "x.csv", "y/*.csv", "a.txt", "a.mp4"]


@pytest.mark.parametrize(
    ("text", "context"), [('"urban"', 0.0), ('"Rural"', 1.0), ("0.3", 0.3), ("1", 1.0)]
)
def test_the_traffic_context_of_a_recording_is_a_word_or_a_number(
    tmp_path: Path, text: str, context: float
):
    session = read(tmp_path, f'[[recording]]\nname = "a"\ncontext = {text}', *MINIMAL)
    assert session.recordings == (RecordingEntry("a", context=context),)
    assert written(session, tmp_path).recordings == session.recordings


@pytest.mark.parametrize("text", ['"suburban"', "1.1", "-0.1", "nan", "true", "[0.5]"])
def test_another_traffic_context_is_refused_with_file_and_key(tmp_path: Path, text: str):
    words = (
        r"session.toml: \[\[recording\]\]: context: expected urban, rural or a number from 0 to 1"
    )
    with pytest.raises(SessionError, match=words):
        read(tmp_path, f'[[recording]]\nname = "a"\ncontext = {text}', *MINIMAL)
    with pytest.raises(SessionError, match="context: expected urban"):
        RecordingEntry("a", context=1.5)


def test_the_ends_of_the_traffic_context_are_written_as_words():
    session = replace(FULL, recordings=(RecordingEntry("a", context=1.0),))
    assert 'context = "rural"' in write_session(session, version="1", fingerprint="2")


def test_a_table_of_recordings_is_named_until_it_has_been_read(tmp_path: Path):
    session = read(tmp_path, '[recordings]\npath = "meta/recordings.csv"', *MINIMAL)
    assert session.recordings_file == RecordingsFile("meta/recordings.csv")
    assert "meta/recordings.csv" in session.paths()
    again = written(session, tmp_path)
    assert again.recordings_file == RecordingsFile(str(tmp_path / "meta" / "recordings.csv"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[recordings]", "expected a path"),
        ("[recordings]\npath = 3", "path: expected a text, found 3"),
        ('[recordings]\npath = ""', "path: expected a file, found nothing"),
        ('[recordings]\nfile = "a.csv"', "has no key 'file'"),
        ('[[recordings]]\npath = "a.csv"', "to be a table"),
    ],
)
def test_a_table_of_recordings_that_is_not_named_is_refused(tmp_path: Path, text: str, words: str):
    with pytest.raises(SessionError, match=words):
        read(tmp_path, text, *MINIMAL)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ("precision = 0.5", "recall or miss_rate"),
        ("recall = 0.5\nmiss_rate = 0.5\nfppi = 1", "recall or miss_rate"),
        ("recall = 0.5", "precision, fppi or fppw"),
        ("recall = 93.9\nprecision = 0.2", "recall: expected 0 to 1, got 93.9"),
        ("recall = nan\nprecision = 0.2", "recall: expected 0 to 1"),
        ("recall = 0.5\naccuracy = 0.2", "no key 'accuracy'"),
    ],
)
def test_a_published_point_that_cannot_be_is_refused(tmp_path: Path, values: str, message: str):
    with pytest.raises(SessionError, match=re.escape(message)):
        read(tmp_path, *MINIMAL, f'[[published]]\nname = "report"\n{values}')


def test_a_session_of_thousands_of_systems_or_a_key_of_as_many_parts_is_refused(tmp_path: Path):
    path = tmp_path / "session.toml"
    system = '[[system]]\nname = "a"\npath = "a.csv"\n'
    path.write_text('[truth]\npath = "t.csv"\n' + system * 1001)
    with pytest.raises(SessionError, match="system: expected at most 1,000"):
        read_session(path)
    path.write_text(".".join("a" * 200_000) + " = 1\n")
    with pytest.raises(SessionError, match="a line with more than 20,000 dots"):
        read_session(path)
