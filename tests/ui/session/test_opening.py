"""Sessions made from what people chose: found by name, kept inside, corrected on top."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from builders import at, make_dataset
from inputs import write

from nvcore.common.errors import InputError, SessionError
from nvcore.common.findings import Finding, Severity
from nvcore.inputs.session import RecordingEntry, RecordingsFile, Session, Source, SystemSource
from ui.access.files import check_confined
from ui.confined import reading
from ui.confined.process import Allowance
from ui.session.opening import (
    checked_frames,
    corrected,
    guess_pictures,
    public_text,
    recording_entry,
    uploaded_session,
    with_recordings,
    with_uploaded_recordings,
)


def session(folder: Path = Path("/data"), **parts: object) -> Session:
    systems = (SystemSource(("a.csv",), name="x"), SystemSource(("b.csv",), name="y"))
    return Session(folder, Source(("t.csv",)), systems, **parts)


def finding(subject: str = "x", **suggestion: float) -> Finding:
    suggestions = tuple(suggestion.items())
    return Finding(Severity.WARNING, "offset", subject, 1, "moved", "move", suggestion=suggestions)


@pytest.fixture
def dataset():
    return make_dataset(truth=[at(0, 50)], n_frames=2)


def test_a_correction_takes_the_place_of_what_the_session_says(dataset):
    x, y = session().systems
    start = replace(session(), systems=(replace(x, offset_frames=-1, offset_px=(1, 2)), y))
    changed = corrected(start, dataset, finding(offset_frames=-3.0, frame_step=2, scale=1.5))
    assert changed.systems[0] == replace(
        x, offset_frames=-3, offset_px=(1, 2), frame_step=2, scale=(1.5, 1.5)
    )
    assert changed.systems[1] == y


def test_factors_of_width_and_height_may_differ(dataset):
    suggested = finding(scale_x=1.5, scale_y=2, offset_x_px=3, offset_y_px=-4)
    system = corrected(session(), dataset, suggested).systems[0]
    assert (system.scale, system.offset_px) == ((1.5, 2), (3, -4))


def test_facts_of_one_recording_leave_the_others_alone():
    start = session(recordings=(RecordingEntry("a", fps=10), RecordingEntry("b", fps=20)))
    changed = with_recordings(start, ["a", "b"], {"b": {"pictures": "b.mp4"}})
    expected = RecordingEntry("a", fps=10), RecordingEntry("b", fps=20, pictures="b.mp4")
    assert changed.recordings == expected


def test_an_entry_is_of_the_recording_of_its_name_however_accents_are_stored():
    composed, decomposed = "gr\u00fcn", "gru\u0308n"
    start = session(recordings=(RecordingEntry(decomposed, fps=10), RecordingEntry("b", fps=20)))
    assert recording_entry(start, [composed, "b"], composed).fps == 10
    both = [composed, decomposed, "b"]
    assert recording_entry(start, both, decomposed).fps == 10
    assert recording_entry(start, both, composed).fps is None


def test_the_only_recordings_facts_count_whatever_their_name():
    start = session(recordings=(RecordingEntry("drive", fps=10),))
    assert recording_entry(start, ["r0"], "r0").fps == 10
    changed = with_recordings(start, ["r0"], {"r0": {"pictures": "v.mp4"}})
    assert changed.recordings == (RecordingEntry("r0", fps=10, pictures="v.mp4"),)


@pytest.mark.parametrize(
    ("names", "sources", "expected"),
    [
        (["a"], ["vtest.avi"], {"a": "vtest.avi"}),
        (["a", "b"], ["vtest.avi"], {}),
        (["night_1", "night_10"], ["night_10.mp4", "night_1.mp4"],
         {"night_1": "night_1.mp4", "night_10": "night_10.mp4"}),
        (["set06/V000"], ["set06_V000_visible.zip", "other.zip"],
         {"set06/V000": "set06_V000_visible.zip"}),
        (["a", "b"], ["xa.mp4", "ya.mp4"], {}),
        (["drive_1", "drive_10"], ["drive_10.mp4"], {"drive_10": "drive_10.mp4"}),
        (["drive_1", "drive_2"], ["drive_10.mp4", "drive_2_lwir.mp4"],
         {"drive_2": "drive_2_lwir.mp4"}),
        (["1", "11"], ["cam 1 day.avi", "cam 11 day.avi"],
         {"1": "cam 1 day.avi", "11": "cam 11 day.avi"}),
        (["night", "night_rain"], ["night_rain_lwir.mp4"], {"night_rain": "night_rain_lwir.mp4"}),
        (["night", "night_rain"], ["night_rain.mp4", "night_lwir.mp4"],
         {"night": "night_lwir.mp4", "night_rain": "night_rain.mp4"}),
        (["a", "b"], ["a_b.mp4"], {}),
        (["A", "B"], ["mot/A/img1", "mot/B/img1"], {"A": "mot/A/img1", "B": "mot/B/img1"}),
        (["Nacht_f\u00fcnf", "Tag"], ["Nacht_fu\u0308nf.mp4", "x.mp4"],
         {"Nacht_f\u00fcnf": "Nacht_fu\u0308nf.mp4"}),
    ],
)  # fmt: skip
def test_pictures_find_their_recording_by_name(names, sources, expected):
    assert guess_pictures(names, sources) == expected


@pytest.mark.parametrize("text", ["/etc/passwd", "frames.txt", "1", "a:b"])
def test_frames_of_a_form_are_a_range_and_no_file(text: str):
    with pytest.raises(SessionError, match="expected first:last"):
        checked_frames(text)


def test_no_frames_are_no_frame_list():
    assert checked_frames("  ") is None
    assert checked_frames(" 0:9 ") == "0:9"


TOML = """
[[recording]]
name = "A"
frames = "/home/me/frames.txt"
pictures = "/home/me/video/A.mp4"
[truth]
path = "/home/me/mot/A/gt/gt.txt"
[[system]]
path = ["runs/B/det.txt", "runs/A/det.txt"]
[[system]]
path = "nir*.csv"
"""


NAMES = (
    *("frames.txt", "mot/A/gt/gt.txt", "mot/B/gt/gt.txt", "A/det.txt", "B/det.txt"),
    *("nir_1.csv", "nir_2.csv"),
)


def uploaded(folder: Path, text: str = TOML, names: Sequence[str] = NAMES) -> Session:
    """The session of that text, with files of these names beside it and one video."""
    for name in NAMES:
        write(folder / "upload-1" / name, "1")
    write(folder / "pictures" / "A.mp4", "video")
    return uploaded_session(
        text.encode(), folder / "upload-1", names, [*(folder / "pictures").iterdir()]
    )


def test_a_session_file_finds_its_files_by_the_ends_of_their_paths(tmp_path: Path):
    opened = uploaded(tmp_path)
    assert opened.folder == tmp_path / "upload-1"
    assert opened.truth.path == ("mot/A/gt/gt.txt",)
    paths = [system.path for system in opened.systems]
    assert paths == [("B/det.txt", "A/det.txt"), ("nir_1.csv", "nir_2.csv")]
    facts = RecordingEntry("A", frames="frames.txt", pictures="../pictures/A.mp4")
    assert opened.recordings == (facts,)
    assert not (tmp_path / "upload-1" / "session.toml").exists()  # it does not stay itself


def test_files_in_an_archive_are_found_in_its_folder(tmp_path: Path):
    opened = uploaded(tmp_path, names=["mot", "frames.txt", "A", "B", "nir_1.csv"])
    assert opened.truth.path == ("mot/A/gt/gt.txt",)


@pytest.mark.parametrize(
    "path", ["/etc/passwd", "../../../etc/passwd", "/etc/*.conf", "..", "/", "c:\\windows\\win.ini"]
)
def test_a_session_file_never_reaches_files_that_were_not_sent(tmp_path: Path, path: str):
    text = TOML.replace("/home/me/mot/A/gt/gt.txt", path.replace("\\", "\\\\"))
    with pytest.raises(SessionError, match="which was not sent"):
        uploaded(tmp_path, text)


@pytest.mark.parametrize("key", ["provenance", "alerts", "alert_policy"])
def test_a_file_that_a_system_names_beside_its_boxes_is_one_of_those_sent(tmp_path: Path, key: str):
    text = TOML + f'{key} = "/home/me/runs/A/det.txt"\n'
    assert getattr(uploaded(tmp_path, text).systems[1], key) == "A/det.txt"
    with pytest.raises(SessionError, match=r"'passwd', which was not sent"):
        uploaded(tmp_path, TOML + f'{key} = "../../etc/passwd"\n')


def test_what_a_session_file_says_of_the_driver_is_one_of_the_files_sent(tmp_path: Path):
    text = TOML.replace('name = "A"\n', 'name = "A"\nvisible = "/etc"\n')
    opened = uploaded(tmp_path, text + '[driver]\ndetectability = "/home/me/A/det.txt"\n')
    assert opened.recordings[0].visible is None
    assert opened.driver.detectability == "A/det.txt"
    with pytest.raises(SessionError, match=r"'passwd', which was not sent"):
        uploaded(tmp_path, TOML + '[driver]\ndetectability = "/etc/passwd"\n')


@pytest.mark.parametrize("series", ["speed", "light", "gaze"])
def test_series_and_codes_are_among_the_files_sent(tmp_path: Path, series: str):
    text = TOML.replace('name = "A"\n', f'name = "A"\n{series} = "/home/me/nir_1.csv"\n')
    opened = uploaded(tmp_path, text + '[codes]\npath = "/home/me/nir_2.csv"\n')
    assert (getattr(opened.recordings[0], series), opened.codes_file) == ("nir_1.csv", "nir_2.csv")
    for wrong in (text.replace("nir_1", "passwd"), TOML + '[codes]\npath = "/etc/passwd.csv"\n'):
        with pytest.raises(SessionError, match=r"'passwd.csv', which was not sent"):
            uploaded(tmp_path, wrong)


def test_a_session_file_that_would_be_read_for_hours_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(reading, "SMALL", Allowance(memory_mb=1000, seconds=0.5))
    with pytest.raises(InputError, match=r"reading the session file took more than 0\.5 s"):
        uploaded(tmp_path, "\n".join(f"a{n}.{'.'.join('b' * 9_000)} = 1" for n in range(300)))
    table = f"recording\n{chr(10).join(map(str, range(100_000)))}\n"
    (tmp_path / "upload-1" / "recordings.csv").write_text(table)
    monkeypatch.setattr(reading, "SMALL", Allowance(memory_mb=1000, seconds=0.01))
    from_form = session(tmp_path / "upload-1", recordings_file=RecordingsFile("recordings.csv"))
    with pytest.raises(InputError, match="reading the table of recordings took more than"):
        with_uploaded_recordings(from_form, [])


def test_names_with_signs_that_are_replaced_when_sent_are_found(tmp_path: Path):
    text = """
[[recording]]
name = "A"
pictures = "runs/A 21:20.mp4"
[truth]
path = "truth <v2>.csv"
[[system]]
path = "C:/out/fir 21:20?.csv"
[[system]]
path = "nir:*.csv"
"""
    names = ["truth _v2_.csv", "fir 21_20_.csv", "nir_1.csv"]
    write(tmp_path / "pictures" / "A 21_20.mp4", "video")
    for name in names:
        write(tmp_path / "upload-1" / name, "1")
    opened = uploaded(tmp_path, text, names)
    assert opened.truth.path == ("truth _v2_.csv",)
    assert [system.path for system in opened.systems] == [("fir 21_20_.csv",), ("nir_1.csv",)]
    assert opened.recordings[0].pictures == "../pictures/A 21_20.mp4"


def test_a_name_that_several_files_have_is_not_guessed(tmp_path: Path):
    with pytest.raises(SessionError, match="2 of the files sent have that name"):
        uploaded(tmp_path, TOML.replace("mot/A/gt/gt.txt", "gt.txt"))


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name in ("root/t.csv", "root/a.csv", "root/b.csv", "root/sub/c.csv", "private/p.csv"):
        write(tmp_path / name, "1")
    return tmp_path / "root"


def refusal(one: Session, root: Path) -> str:
    """Why a session may not be read; empty: it may."""
    try:
        check_confined(one, root)
    except SessionError as error:
        return str(error)
    return ""


def test_a_session_inside_the_folder_is_allowed(root: Path):
    assert refusal(session(root, frames="0:9"), root) == ""
    assert refusal(replace(session(root), truth=Source(("*.csv", "sub"))), root) == ""


@pytest.mark.parametrize(
    "path", ["/etc/passwd", "../private/p.csv", "../private/*.csv", "*/../../private/p.csv",
             "sub/../../private", "..", "/etc/**"],
)  # fmt: skip
def test_a_session_that_leaves_the_folder_is_refused(root: Path, path: str):
    assert "outside the folder" in refusal(replace(session(root), truth=Source((path,))), root)


@pytest.mark.parametrize("facts", [{"frames": "../private/p.csv"}, {"pictures": "../private"}])
def test_frame_lists_and_pictures_stay_in_the_folder_as_well(root: Path, facts: dict[str, str]):
    refused = session(root, recordings=(RecordingEntry("r", **facts),))
    assert "outside the folder" in refusal(refused, root)


@pytest.mark.parametrize(
    "asked",
    ["gr\u00fcn.mp4", "gr\u00fcn/1.png", "gr*\u00fcn.mp4", "gr\u00fcn.mp4/*.png", "gr\u00fcn/*"],
)
def test_a_link_with_an_accent_of_a_mac_leads_out_of_no_folder(root: Path, asked: str):
    target = write(root.parent / "private" / "1.png", "1").parent
    (root / "gru\u0308n").symlink_to(target)
    (root / "gru\u0308n.mp4").symlink_to(target / "p.csv")
    refused = session(root, recordings=(RecordingEntry("r", pictures=asked),))
    assert "outside the folder" in refusal(refused, root)


def test_a_record_of_provenance_stays_in_the_folder_as_well(root: Path):
    plain = session(root)
    system = replace(plain.systems[0], provenance="../private/p.csv")
    assert "outside the folder" in refusal(replace(plain, systems=(system,)), root)


@pytest.mark.parametrize("path", ["link.csv", "sub", "*.csv"])
def test_links_that_lead_out_are_refused(root: Path, path: str):
    (root / "link.csv").symlink_to(root.parent / "private" / "p.csv")
    (root / "sub" / "deep").symlink_to(root.parent / "private")
    assert "outside the folder" in refusal(replace(session(root), truth=Source((path,))), root)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("/srv/up/s1/upload-2/truth/annotations/data/t.csv, line 3: x", "truth/t.csv, line 3: x"),
        ("upload-2/truth/t.csv: x", "truth/t.csv: x"),
        ("annotations/data/t.csv: x", "t.csv: x"),
        ("/srv/up/s1/upload-2: not TOML", "the folder: not TOML"),
        ("a ratio of 1/2", "a ratio of 1/2"),
    ],
)
def test_messages_lose_the_folders_of_the_machine(text: str, shown: str):
    assert public_text(text, [Path("/srv/up/s1/upload-2"), Path("/srv/up/s1")]) == shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("/srv/night_07/t.csv: x", "/srv/night_07/t.csv: x"),
        ("/srv/night.bak: x", "/srv/night.bak: x"),
        ("/data/srv/night/t.csv: x", "/data/srv/night/t.csv: x"),
        ("nothing in /srv/night.", "nothing in the folder."),
        ("'/srv/night'", "'the folder'"),
        ("a ratio of 1/2 or srv", "a ratio of 1/2 or srv"),
    ],
)
def test_a_folder_ends_where_its_name_ends(text: str, shown: str):
    assert public_text(text, [Path("/srv/night")]) == shown


@pytest.mark.parametrize("folder", ["/", "."])
def test_a_folder_that_holds_everything_changes_no_message(folder: str):
    text = "night/t.csv, line 3: expected 1/2. See ./notes or /etc."
    assert public_text(text, [Path(folder)]) == text


LONG = "a" * 300
"""Longer than the name of a file may be."""


def test_a_long_name_of_pictures_is_none_that_were_sent(tmp_path: Path):
    assert uploaded(tmp_path, TOML.replace("A.mp4", LONG)).recordings[0].pictures is None


@pytest.mark.parametrize("name", [LONG, f"{LONG}[1]", f"../root/{LONG}"])
def test_a_long_name_inside_the_folder_is_left_to_those_who_open_it(root: Path, name: str):
    assert refusal(replace(session(root), truth=Source((name,))), root) == ""
    pictures = session(root, recordings=(RecordingEntry("r", pictures=name),))
    assert refusal(pictures, root) == ""
