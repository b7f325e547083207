"""Which picture shows which frame: shown by number, and told by check, compare and report."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
import pytest
from inputs import nvcore
from picture_files import number_in, numbered, write_numbered_video, write_picture
from pictured_drives import write_drive

from nvcore.auditing import opened_pictures, picture_findings
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session.changes import applied
from nvcore.inputs.session.toml import read_session
from nvcore.pictures import session_pictures
from nvcore.pictures.notes import PictureNote, PictureTrait
from nvcore.pictures.video import Video
from nvcore.report.terminal import render_pictures
from nvcore.tables.pictures import pictures_table

NONE = -1


def drive(folder: Path, pictures: str, frames: Iterable[int] = range(60)) -> Dataset:
    return load(read_session(write_drive(folder, pictures, frames)))


def numbers_shown(dataset: Dataset) -> list[int]:
    """The number drawn in the picture of each frame."""
    opened = session_pictures(dataset.settings, dataset)
    return [NONE if i < 0 else number_in(opened.sources[0].read(int(i))) for i in opened.indices[0]]


def by_code(dataset: Dataset) -> dict[str, Finding]:
    return {finding.code: finding for finding in picture_findings(dataset)}


def write_folder(folder: Path, names: Iterable[str], numbers: Iterable[int]) -> None:
    for name, number in zip(names, numbers, strict=True):
        write_picture(folder / name, numbered(number))


def test_a_stray_picture_shifts_no_frame_and_is_named(tmp_path: Path):
    write_folder(tmp_path / "img", [f"img_{n:05}.png" for n in range(60)], range(60))
    write_picture(tmp_path / "img" / "calib.png", numbered(255))
    dataset = drive(tmp_path, "img")
    assert numbers_shown(dataset) == [*range(60)]
    (finding,) = picture_findings(dataset)
    assert (finding.code, finding.severity) == ("pictures-passed-over", Severity.NOTE)
    assert finding.subject == "pictures of drive"
    assert finding.message == (
        "1 file beside the pictures is not of their series and is passed over (calib.png)."
    )
    result = nvcore("check", tmp_path / "session.toml")
    assert result.exit_code == 0
    assert finding.message in result.stdout
    line = "frame 0 shows img_00000.png, frame 30 shows img_00030.png, frame 59 shows img_00059.png"
    assert f"  drive (img): {line}\n" in result.stdout


def test_two_kinds_of_pictures_are_an_error_whose_step_shows_one(tmp_path: Path):
    for ending, first in ((".png", 0), (".jpg", 100)):
        names = [f"FLIR_{n:05}{ending}" for n in range(60)]
        write_folder(tmp_path / "two", names, range(first, first + 60))
    dataset = drive(tmp_path, "two")
    finding = by_code(dataset)["pictures-unreadable"]
    assert finding.severity is Severity.ERROR
    png = Step(Remedy.PICTURES, "two/*.png", "drive")
    assert png in finding.steps
    result = nvcore("check", tmp_path / "session.toml")
    assert result.exit_code == 1
    assert "60 *.jpg and 60 *.png" in result.stdout
    assert 'pictures = "two/*.png"' in result.stdout
    session = applied(dataset.settings, png, dataset.systems)
    assert session is not None
    again = load(session)
    assert numbers_shown(again) == [*range(60)]
    assert by_code(again) == {}
    assert "missing-pictures" not in {finding.code for finding in again.findings}


def test_every_second_frame_exported_is_shown_in_order_and_told(tmp_path: Path):
    write_folder(tmp_path / "half", [f"frame_{n:04}.png" for n in range(1, 61)], range(0, 120, 2))
    dataset = drive(tmp_path, "half", range(0, 120, 2))
    assert numbers_shown(dataset) == [*range(0, 120, 2)]
    finding = by_code(dataset)["pictures-in-order"]
    assert finding.severity is Severity.NOTE
    result = nvcore("check", tmp_path / "session.toml")
    assert (result.exit_code, finding.message in result.stdout) == (0, True)
    assert "frame 118 shows frame_0060.png" in result.stdout


def test_each_page_of_a_tiff_shows_its_frame(tmp_path: Path):
    done, content = cv2.imencodemulti(".tif", [numbered(n) for n in range(60)])
    assert done
    (tmp_path / "seq.tif").write_bytes(bytes(content))
    dataset = drive(tmp_path, "seq.tif")
    assert numbers_shown(dataset) == [*range(60)]
    result = nvcore("check", tmp_path / "session.toml")
    assert (result.exit_code, by_code(dataset)) == (0, {})
    assert "frame 30 shows picture 30" in result.stdout


def test_a_picture_that_makes_the_others_unreadable_is_named(tmp_path: Path):
    write_folder(tmp_path / "img", [f"img_{n:05}.png" for n in range(60)], range(60))
    (tmp_path / "img" / "img_00000.png").write_bytes(b"")
    assert (
        "img: img_00000.png: is no PNG"
        in by_code(drive(tmp_path, "img"))["pictures-unreadable"].message
    )


def test_a_video_that_cannot_be_read_is_an_error(tmp_path: Path):
    path = write_numbered_video(tmp_path / "drive.mp4", n=60)
    content = path.read_bytes()
    path.write_bytes(content[: content.index(b"moov")])
    finding = by_code(drive(tmp_path, "drive.mp4"))["pictures-unreadable"]
    assert finding.severity is Severity.ERROR
    assert "no table of contents" in finding.message
    for command in (["check"], ["compare", "--full"]):
        result = nvcore(*command, tmp_path / "session.toml")
        assert result.exit_code == 1
        assert finding.message in result.stdout
    report = tmp_path / "r.html"
    assert nvcore("report", tmp_path / "session.toml", "--out", report).exit_code == 1
    assert "no table of contents" in report.read_text(encoding="utf-8")


def test_pictures_that_are_not_there_are_one_finding(tmp_path: Path):
    dataset = drive(tmp_path, "none.mp4")
    assert [finding.code for finding in dataset.findings] == ["missing-pictures"]
    assert by_code(dataset) == {}


def test_pictures_that_fit_no_frames_are_not_shown_and_the_first_is_asked_for(tmp_path: Path):
    write_folder(tmp_path / "img", [f"{n:05}.png" for n in range(30, 100)], range(70))
    dataset = drive(tmp_path, "img")
    assert numbers_shown(dataset) == [NONE] * 60
    finding = by_code(dataset)["pictures-unclear"]
    assert (finding.severity, finding.count) == (Severity.ERROR, 60)
    assert finding.steps == (Step(Remedy.FIRST_PICTURE, subject="drive"),)
    assert nvcore("check", tmp_path / "session.toml").exit_code == 1
    report = tmp_path / "r.html"
    nvcore("report", tmp_path / "session.toml", "--out", report)
    frames = report.read_text(encoding="utf-8").partition('id="frames"')[2][:2000]
    assert "which frame is not clear" in frames
    given = applied(dataset.settings, Step(Remedy.FIRST_PICTURE, "0", "drive"), dataset.systems)
    assert given is not None
    assert numbers_shown(load(given)) == [*range(60)]


@pytest.mark.parametrize(("n", "severity"), [(50, Severity.WARNING), (30, Severity.ERROR)])
def test_frames_without_a_picture_are_counted(tmp_path: Path, n: int, severity: Severity):
    write_numbered_video(tmp_path / "drive.mp4", n=n)
    dataset = drive(tmp_path, "drive.mp4")
    assert numbers_shown(dataset) == [*range(n), *[NONE] * (60 - n)]
    (finding,) = picture_findings(dataset)
    assert (finding.code, finding.severity) == ("pictures-missing", severity)
    assert finding.count == 60 - n
    assert finding.cases is not None
    assert finding.cases.rows.tolist() == [*range(n, 60)]
    assert f"{60 - n} of 60 evaluated frames have none, first frame {n}" in finding.message
    assert f"; {60 - n} of 60 frames have none" in nvcore("check", tmp_path / "session.toml").stdout


def test_numbers_of_another_drive_taken_in_order_are_a_warning(tmp_path: Path):
    write_folder(tmp_path / "img", [f"{n:05}.png" for n in range(500, 561)], range(61))
    dataset = drive(tmp_path, "img")
    assert numbers_shown(dataset) == [*range(60)]
    assert by_code(dataset)["pictures-in-order"].severity is Severity.WARNING


def test_pictures_of_another_shape_are_a_warning(tmp_path: Path):
    for n in range(60):
        write_picture(tmp_path / "img" / f"{n}.png", np.zeros((40, 90), np.uint8))
    assert "90 x 40 px" in by_code(drive(tmp_path, "img"))["pictures-other-shape"].message


@pytest.mark.parametrize("trait", PictureTrait)
@pytest.mark.parametrize("count", [1, 3])
def test_every_fact_about_pictures_is_a_finding(
    tmp_path: Path, trait: PictureTrait, count: int, monkeypatch: pytest.MonkeyPatch
):
    write_numbered_video(tmp_path / "drive.mp4", n=60)
    dataset = drive(tmp_path, "drive.mp4")
    with opened_pictures(dataset) as (opened, none):
        assert opened is not None
        assert none == ()
        start = Video.__init__

        def noted(self: Video, path: Path, container_format: str) -> None:
            start(self, path, container_format)
            self.notes = (PictureNote(trait, count, 60, (7, 9, 11)[:count], ("a.png",)),)

        monkeypatch.setattr(Video, "__init__", noted)
        (finding,) = picture_findings(dataset)
    assert finding.code == f"pictures-{trait.value.replace(' ', '-')}"
    assert f"{count} " in finding.message
    assert "{" not in finding.message


def test_the_same_of_several_recordings_is_one_finding(tmp_path: Path):
    write_folder(tmp_path / "img", [f"{n:02}.png" for n in range(20)], range(20))
    path = write_drive(tmp_path, "img")
    text = path.read_text()
    entry = text[: text.index("[truth]")]
    path.write_text(entry.replace("drive", "rain") + text)
    for name in ("truth", "x", "y"):
        head, *rows = (tmp_path / f"{name}.csv").read_text().splitlines()
        lines = [f"{row},{recording}" for recording in ("drive", "rain") for row in rows]
        (tmp_path / f"{name}.csv").write_text("\n".join([f"{head},recording", *lines]))
    (finding,) = picture_findings(load(read_session(path)))
    assert (finding.code, finding.count) == ("pictures-missing", 80)
    assert finding.message.endswith("The same goes for 1 more recording.")


def test_the_verdict_does_not_depend_on_pictures(tmp_path: Path):
    write_numbered_video(tmp_path / "drive.mp4", n=10)
    write_drive(tmp_path, "drive.mp4")
    output = nvcore("compare", tmp_path / "session.toml").stdout
    assert "50 of 60 evaluated frames have none" in output
    assert "that it lists" not in output  # the caveat would say so of a finding on numbers


def test_without_the_extra_it_is_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write_numbered_video(tmp_path / "drive.mp4", n=10)
    dataset = drive(tmp_path, "drive.mp4")
    for name in [name for name in sys.modules if name.startswith("nvcore.pictures")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delitem(sys.modules, "nvcore.auditing.pictures", raising=False)
    monkeypatch.setitem(sys.modules, "av", None)
    (finding,) = picture_findings(dataset)
    assert (finding.code, finding.severity) == ("pictures-not-opened", Severity.NOTE)
    assert "nvcore[report]" in finding.message


def test_names_with_accents_as_a_mac_stores_them_are_found(tmp_path: Path):
    write_folder(tmp_path / "Stra\u00dfe_gru\u0308n", [f"{n}.png" for n in range(60)], range(60))
    dataset = drive(tmp_path, "Stra\u00dfe_gr\u00fcn")
    assert numbers_shown(dataset) == [*range(60)]
    assert (dataset.findings, by_code(dataset)) == ((), {})


def test_the_table_names_three_frames_of_each_recording(tmp_path: Path):
    write_folder(tmp_path / "img", [f"{n:02}.png" for n in range(10, 60)], range(50))
    dataset = drive(tmp_path, "img")
    with opened_pictures(dataset) as (opened, _):
        assert opened is not None
        table = pictures_table(dataset, opened)
    assert table.iloc[0].to_dict() == {
        "recording": "drive",
        "pictures": "img",
        "n_pictures": 50,
        "n_frames": 60,
        "n_without": 10,
        "first_frame": 0,
        "first_picture": "none",
        "middle_frame": 30,
        "middle_picture": "30.png",
        "last_frame": 59,
        "last_picture": "59.png",
    }
    assert "frame 0 shows none, frame 30 shows 30.png" in render_pictures(table)
    assert render_pictures(table.iloc[:0]) == ""


def test_the_report_has_the_table(tmp_path: Path):
    write_folder(tmp_path / "img", [f"img_{n:03}.png" for n in range(60)], range(60))
    write_drive(tmp_path, "img")
    report = tmp_path / "r.html"
    assert nvcore("report", tmp_path / "session.toml", "--out", report).exit_code == 0
    page = report.read_text(encoding="utf-8")
    assert "Which picture shows which frame" in page
    assert "30: img_030.png" in page
