"""The command line: what goes in, what comes out, and with which exit code."""

from __future__ import annotations

import itertools
import json
import tomllib
from pathlib import Path

import pytest
from inputs import FACTS, drive, flags, mot_layout, nvcore, write
from other_params import OTHER

from nvcore.cli.options import flag_of
from nvcore.common.output.files import LOCK


def session(folder: Path, *more: str) -> Path:
    """A session file with relative paths and a frame list in a file."""
    write(folder / "lists" / "frames.txt", *map(str, range(0, 20, 2)))
    return write(
        folder / "session.toml",
        '[defaults]\nsize = "640x480"\nfps = 20',
        '[[recording]]\nname = "rural"\nframes = "lists/frames.txt"',
        '[truth]\npath = "truth.csv"',
        '[[system]]\nname = "FIR"\npath = "fir.csv"\nthreshold = 0.5',
        '[[system]]\nname = "NIR"\npath = "nir.csv"',
        *more,
    )


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}


def written(folder: Path) -> dict:
    return tomllib.loads((folder / "session.toml").read_text(encoding="utf-8"))


# compare


def test_compare_in_full_prints_inputs_audit_and_scorecard(folder: Path):
    result = nvcore("compare", *flags(folder), "--full")
    assert result.exit_code == 0, result.output
    order = ["truth.csv (csv;", "Audit:", "X = fir, all scores", "Who detects whom"]
    places = [result.stdout.index(text) for text in order]
    assert places == sorted(places)


def test_json_prints_the_summary_of_the_report_and_nothing_else_on_stdout(
    folder: Path, tmp_path: Path
):
    result = nvcore("compare", *flags(folder), "--json", "--out", tmp_path / "a")
    assert len(contents(tmp_path / "a")) == 12
    assert contents(tmp_path / "a")["summary.json"].decode() == result.stdout
    assert "Audit:" in result.stderr
    assert f"written to {tmp_path / 'a'}" in result.stderr


RELATIVE = ("--truth", "truth.csv", "--x", "f*.csv", "--y", "./nir.csv", *FACTS,
            "--frames", "frames.txt", "--iou", 0.4)  # fmt: skip


@pytest.mark.parametrize(
    ("given", "n_frames"),
    [(RELATIVE, 6), (("session.toml",), 30), (("--truth", "mot", "--x", "mot", "--y", "mot"), 10)],
    ids=["flags", "session", "folders"],
)
def test_the_written_session_gives_the_same_bytes_elsewhere(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: tuple, n_frames: int
):
    session(folder)
    write(folder / "frames.txt", "1", "2", "3")
    mot_layout(folder / "mot")
    monkeypatch.chdir(folder)
    nvcore("compare", *given, "--out", tmp_path / "a")
    monkeypatch.chdir(tmp_path)
    nvcore("compare", "a/session.toml", "--out", "far/b")
    assert contents(tmp_path / "far" / "b") == contents(tmp_path / "a")
    assert json.loads(contents(tmp_path / "a")["summary.json"])["frames"] == n_frames


def test_a_report_may_replace_itself_but_no_session_that_somebody_wrote(
    folder: Path, tmp_path: Path
):
    nvcore("compare", *flags(folder), "--out", tmp_path / "a")
    before = contents(tmp_path / "a")
    assert nvcore("compare", tmp_path / "a/session.toml", "--out", tmp_path / "a").exit_code == 0
    assert contents(tmp_path / "a") == before
    text = session(folder).read_bytes()
    result = nvcore("compare", folder / "session.toml", "--out", folder)
    assert result.exit_code == 2
    assert "would replace the session file; give another --out" in result.stderr
    assert (folder / "session.toml").read_bytes() == text


def test_a_changed_input_is_reported(folder: Path, tmp_path: Path):
    nvcore("compare", *flags(folder), "--out", tmp_path / "a")
    with (folder / "nir.csv").open("a") as stream:
        stream.write("rural,5,500,200,40,100,0.65\n")
    again = nvcore("compare", tmp_path / "a" / "session.toml")
    assert "nir: The input has changed since the session file was written." in again.stdout
    assert again.exit_code == 0
    assert nvcore("compare", tmp_path / "a" / "session.toml", "--strict").exit_code == 1


# parameters


def test_every_live_parameter_is_a_flag_and_stands_in_the_written_session(
    folder: Path, tmp_path: Path
):
    given = [str(part) for name, value in OTHER.items() for part in (flag_of(name), value)]
    result = nvcore("compare", *flags(folder), *given, "--out", tmp_path / "a")
    assert result.exit_code == 0, result.output
    assert written(tmp_path / "a")["parameters"] == OTHER


def test_a_setting_without_effect_is_named_with_the_choice_that_uses_it(folder: Path):
    ran = nvcore("compare", *flags(folder), "--missing-distance", "borrow")
    assert ran.exit_code == 0, ran.output
    assert (
        "note: --missing-distance borrow has no effect: it is used with --proximity distance, "
        "not height"
    ) in ran.stderr
    ran = nvcore("check", *flags(folder), "--missing-distance", "borrow", "--proximity", "distance")
    assert "has no effect" not in ran.stderr
    assert "No match reports a distance that could be borrowed" in ran.stdout


def test_flags_go_before_the_parameters_of_the_session(folder: Path, tmp_path: Path):
    file = session(folder, "[parameters]\nalpha = 0.5\niou = 0.3\nthreshold_x = 0.6")
    nvcore("compare", file, "--alpha", 0.8, "--out", tmp_path / "a")
    parameters = written(tmp_path / "a")["parameters"]
    assert (parameters["alpha"], parameters["iou"], parameters["threshold_x"]) == (0.8, 0.3, 0.6)


# facts by flag for a session


def test_size_fps_and_frames_by_flag_go_before_the_session(folder: Path, tmp_path: Path):
    file = session(folder, "[[recording]]\nname='urban'\nwidth=100\nheight=100\nfps=5")
    nvcore("compare", file, "--out", tmp_path / "own")
    lines = contents(tmp_path / "own")["recordings.csv"].decode().splitlines()
    assert lines[1].startswith("urban,100,100,5,")
    nvcore("compare", file, "--size", "1280x960", "--fps", 10, "--frames", "0:3",
           "--out", tmp_path / "a")  # fmt: skip
    lines = contents(tmp_path / "a")["recordings.csv"].decode().splitlines()
    assert [line.split(",")[:5] for line in lines[1:]] == [
        ["urban", "1280", "960", "10", ""], ["rural", "1280", "960", "10", ""],
    ]  # fmt: skip


def test_names_choose_among_the_systems_of_a_session_and_name_those_of_flags(folder: Path):
    result = nvcore("compare", session(folder), "--name-x", "NIR")
    assert "X = NIR, all scores; Y = FIR, score >= 0.5" in result.stdout
    result = nvcore("compare", *flags(folder, "--name-x", "warm", "--name-y", "bright"))
    assert "X = warm, all scores; Y = bright, all scores" in result.stdout


def test_a_system_that_becomes_x_is_no_longer_y(folder: Path):
    file = session(folder, '[compare]\nx = "FIR"\ny = "NIR"')
    result = nvcore("compare", file, "--name-x", "NIR")
    assert "X = NIR, all scores; Y = FIR, score >= 0.5" in result.stdout


CORRECTIONS = ("--offset-frames-y", 1, "--offset-px-y", "2,-3.5", "--scale-y", "2",
               "--scale-x", "1,0.5")  # fmt: skip


@pytest.mark.parametrize("kind", ["flags", "session"])
def test_corrections_by_flag_reach_the_boxes_and_the_written_session(
    folder: Path, tmp_path: Path, kind: str
):
    inputs = flags(folder) if kind == "flags" else [session(folder)]
    result = nvcore("compare", *inputs, *CORRECTIONS, "--full", "--out", tmp_path / "a")
    assert "coordinates scaled by 2, 2; boxes moved by 2, -3.5 px; frame numbers moved by +1" in (
        result.stdout
    )
    x, y = written(tmp_path / "a")["system"]
    assert (x["scale"], "offset_px" in x) == ([1.0, 0.5], False)
    assert (y["offset_frames"], y["offset_px"], y["scale"]) == (1, [2.0, -3.5], 2.0)


def test_a_correction_goes_to_the_system_that_is_chosen(folder: Path, tmp_path: Path):
    file = session(folder, '[compare]\nx = "NIR"\ny = "FIR"')
    nvcore("compare", file, "--offset-frames-x", 1, "--out", tmp_path / "a")
    fir, nir = written(tmp_path / "a")["system"]
    assert ("offset_frames" in fir, nir["offset_frames"]) == (False, 1)


def test_a_correction_of_a_system_that_cannot_be_told_is_refused(folder: Path):
    file = session(folder, '[compare]\nx = "NIR"')
    result = nvcore("compare", file, "--offset-frames-y", 1)
    assert result.exit_code == 2
    assert "cannot tell which system of the session is Y" in result.stderr


@pytest.mark.parametrize(
    "given",
    [("--format", "csv"), ("--format-truth", "csv"), ("--format-x", "csv"), ("--format-y", "csv"),
     ("--classes", "person"), ("--frame-base", "0"), ("--box-base", "1")],
)  # fmt: skip
def test_flags_for_reading_files_are_refused_beside_a_session(folder: Path, given: tuple[str, str]):
    result = nvcore("compare", session(folder), *given)
    assert result.exit_code == 2
    assert f"{given[0]} is for files named by flags; in a session file write it" in result.stderr


def test_formats_by_flag_are_taken(folder: Path, tmp_path: Path):
    nvcore("compare", *flags(folder), "--format", "csv", "--format-y", "csv", "--frame-base", 0,
           "--classes", "person, child", "--out", tmp_path / "a")  # fmt: skip
    truth = written(tmp_path / "a")["truth"]
    assert (truth["format"], truth["frame_base"]) == ("csv", 0)
    assert truth["classes"] == ["person", "child"]


# exit codes

BAD = [
    ((), "give a session file, or --truth, --x and --y"),
    (("--truth", "truth.csv", "--x", "fir.csv"), "to audit a single system use nvcore check"),
    (("tale.txt",), "tale.txt: is not TOML"),
    (("s.toml", "--truth", "truth.csv"), "give a session file or --truth, --x and --y, not both"),
    (("GOOD", "--size", "640"), "--size: expected a size such as 640x480, got '640'"),
    (("GOOD", "--match", "best"), "'best' is not one of 'iou', 'lateral'"),
    (("GOOD", "--frames", "no.txt"), "cannot be read as a frame list"),
    (("GOOD", "--fps", "1e-300"), "fps: expected a number from 0.001 to 10000, found 1e-300"),
    (("GOOD", "--scale-x", "1,2,3"), "expected one number, or two with a comma between"),
    (("GOOD", "--scale-y", "wide"), "or two with a comma between, found 'wide'"),
    (("GOOD", "--offset-px-x", "3"), "expected two numbers with a comma between, found '3'"),
    (("GOOD", "--x", "broken.csv"), "broken.csv, line 2: "),
    (("--truth", "tale.txt", "--x", "a", "--y", "b"), "tale.txt: no reader recognises this as tr"),
    (("GOOD", "--out", "truth.csv"), "Directory 'truth.csv' is a file"),
    (("GOOD", "--alfa", "1"), "No such option '--alfa'"),
    (("GOOD", "--tables", "parquet"), "--tables is about the files that --out writes; give --out"),
    (("GOOD", "--matches"), "--matches is about the files that --out writes; give --out DIR"),
]


@pytest.mark.parametrize(("arguments", "words"), BAD, ids=[words for _, words in BAD])
def test_bad_input_gives_exit_code_2_and_one_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], words: str
):
    monkeypatch.chdir(folder)
    write(folder / "broken.csv", "recording,frame,x,y,w,h,score", "urban,zero,1,1,1,1,1")
    write(folder / "tale.txt", "once upon a time")
    good = ("--truth", "truth.csv", "--x", "fir.csv", "--y", "nir.csv", *FACTS)
    given = [
        part for argument in arguments for part in (good if argument == "GOOD" else (argument,))
    ]
    result = nvcore("compare", *given)
    assert result.exit_code == 2
    (error,) = [line for line in result.stderr.splitlines() if line.startswith("Error: ")]
    assert words in error
    assert result.stderr.endswith(error + "\n")
    assert result.stdout == ""


def test_an_error_of_the_audit_gives_exit_code_1_after_the_scorecard(folder: Path):
    # every box of X lies in fractions of the picture
    lines = (folder / "fir.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    write(folder / "fir.csv", lines[0], *(",".join([*r[:2], "0.1", "0.1", "0.2", "0.3", r[6]])
                                          for r in rows))  # fmt: skip
    result = nvcore("compare", *flags(folder))
    assert result.exit_code == 1
    assert "Audit: 1 error" in result.stdout
    assert "X = fir" in result.stdout


# check


def test_a_report_is_not_written_into_a_folder_of_inputs(tmp_path: Path):
    drive(tmp_path)
    (tmp_path / "truth").mkdir()
    (tmp_path / "truth.csv").rename(tmp_path / "truth" / "urban.csv")
    systems = ["--x", tmp_path / "fir.csv", "--y", tmp_path / "nir.csv"]
    inputs = ["--truth", tmp_path / "truth", *systems, *FACTS]
    result = nvcore("compare", *inputs, "--out", tmp_path / "truth" / "new")
    assert result.exit_code == 2
    assert "lies in the folder of inputs" in result.stderr
    assert [path.name for path in (tmp_path / "truth").iterdir()] == ["urban.csv"]


def test_check_says_where_the_horizon_seems_to_be_if_it_is_not_stated(tmp_path: Path):
    lines = ["frame,x,y,w,h,track"]
    for track, frame in itertools.product(range(4), range(20)):
        depth = 20 + 4 * frame + track
        lines.append(f"{frame},{50 + 100 * track},{200 - 0.25 * depth},20,{1.25 * depth},{track}")
    truth = write(tmp_path / "night.csv", *lines)
    x = write(tmp_path / "x.csv", "frame,x,y,w,h,score")
    inputs = ["--truth", truth, "--x", x, *FACTS]
    line = "  night: row 200 (95 %: 200 to 200; 80 boxes of 4 pedestrians)\n"
    assert line in nvcore("check", *inputs).stdout
    of_animals = line.replace("pedestrians", "animals")
    assert of_animals in nvcore("check", *inputs, "--objects", "animal").stdout
    table = write(tmp_path / "r.csv", "recording,horizon", "night,190")
    assert "horizon" not in nvcore("check", *inputs, "--recordings", table).stdout


def test_check_audits_without_scoring_and_needs_only_one_system(folder: Path):
    arguments = ("--truth", folder / "truth.csv", "--x", folder / "fir.csv", *FACTS)
    result = nvcore("check", *arguments, "--threshold-x", 0.8)
    assert result.exit_code == 0
    assert "Audit:" in result.stdout
    assert "X = " not in result.stdout
    result = nvcore("check", *arguments[:2])
    assert result.exit_code == 2
    assert "give a session file, or --truth and --x; one system is enough" in result.stderr
