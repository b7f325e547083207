"""The Export page, driven without a browser."""

from __future__ import annotations

import shutil
import threading
import zipfile
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import av
import numpy as np
import pytest
import small_estimator
import streamlit as st
from export_page import downloads, job_of, opened, uploaded_drive, uploads
from held_estimate import Held
from inputs import drive
from limits import write_limits
from places import ROOT
from streamlit.testing.v1 import AppTest

import nvcore
from nvcore.common.progress import Progress
from nvcore.comparison.compare import Result
from nvcore.figures.overlay import write_video
from nvcore.figures.overlay.annotate import annotate
from nvcore.figures.overlay.brush import Canvas
from nvcore.report.files import REPORT_CONTENTS
from nvcore.subjects.driver.comparison.steps import driver_in
from pages import TIMEOUT_S, begin_with, checked, press, texts
from ui.jobs.background import BackgroundJob, JobState
from ui.views.export.frame import file_stem
from ui.views.export.link import link
from ui.views.export.session import with_public_names
from ui.views.export.video import LONGEST_S, Interval, chosen_interval, why_not
from ui.widgets.recording import nearest_row


def test_the_reports_files_are_told_and_can_be_downloaded():
    page = opened("report")
    assert downloads(page) == [
        "All files (ZIP)",
        *("frames.csv", "encounters.csv", "events.csv", "intervals.csv", "recordings.csv"),
        *("significance.csv", "subgroups.csv", "findings.csv", "finding_entries.csv"),
        *("matches.parquet", "summary.json", "session.toml"),
    ]
    (single,) = [part for part in page.expander if part.label == "Single files"]
    assert len(single.get("download_button")) == 12  # folded: the ZIP has them all
    assert "3,000 evaluated frames" in texts(page)
    assert "beside its inputs: truth.csv, fir.csv, nir.csv, nir2.csv." in texts(
        page
    )  # without folders
    assert "`similarity_x`, `similarity_y` | 0 to 1" in texts(page)
    checked(page.button_group(key="export_columns").set_value("encounters.csv").run())
    assert "`miss_class_x`, `miss_class_y`" in texts(page)
    assert "boxes of truth, X and Y: whom each matches" in texts(page)
    checked(page.button_group(key="export_columns").set_value("matches.parquet").run())
    assert "`iou_x`, `iou_y` | 0 to 1" in texts(page)


def test_every_file_that_a_report_may_have_is_offered_with_what_it_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = write_limits(tmp_path)  # signs have classes
    code = '[[code]]\nrecording = "drive"\nstart_s = 0\nend_s = 0.1\ncode = "glare"\n'
    session.write_text(session.read_text() + code)
    begin_with(session, monkeypatch)
    page = opened("report")
    assert {*REPORT_CONTENTS} == {*downloads(page)} - {"All files (ZIP)"}
    assert "1 stretches of recordings with a code" in texts(page)
    for file in page.button_group(key="export_columns").options:
        checked(page.button_group(key="export_columns").set_value(file).run())


def test_files_are_named_without_folders_when_they_are_made_and_not_in_each_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    made: list[Callable[[], bytes]] = []

    def noted(_: object, label: str, data: Callable[[], bytes], *_args: object, **_more: object):
        if label == "summary.json":
            made.append(data)

    renamed: list[Result] = []

    def renamed_by(result: Result, public: Callable[[object], str]) -> Result:
        renamed.append(with_public_names(result, public))
        return renamed[-1]

    monkeypatch.setattr("streamlit.delta_generator.DeltaGenerator.download_button", noted)
    monkeypatch.setattr("ui.views.export.report.with_public_names", renamed_by)
    opened("report", space=uploaded_drive(tmp_path))
    assert not renamed
    assert str(tmp_path) not in made[-1]().decode()  # no page is drawn any more
    (named,) = renamed
    assert set(named.dataset.inputs["file"]) == {"truth.csv", "fir.csv", "nir.csv"}


@pytest.fixture
def packed(monkeypatch: pytest.MonkeyPatch) -> list[Callable[[], bytes]]:
    """What the buttons make the ZIP by, the newest last."""
    made: list[Callable[[], bytes]] = []
    download_button = st.download_button

    def noted(label: str, data: Callable[[], bytes], *given: object, **more: object):
        if label == "All files (ZIP)":
            made.append(data)
        return download_button(label, data, *given, **more)

    monkeypatch.setattr(st, "download_button", noted)
    return made


def test_the_zip_holds_the_estimates_that_its_session_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, packed: list[Callable[[], bytes]]
):
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    begin_with(small_estimator.write_session(theirs), monkeypatch)
    held = Held(theirs, monkeypatch)
    held.ends()
    held.beside("export")
    page = opened("report", space=held.space)
    names = ["detectability.csv", "driver.json"]
    assert names == [name for name in downloads(page) if name in names]
    assert (
        "put `session.toml`, detectability.csv and driver.json (the ZIP has what was made here) "
        "beside its inputs: truth.csv, x.csv, y.csv." in texts(page)
    )
    beside = tmp_path / "beside"
    with zipfile.ZipFile(BytesIO(packed[-1]())) as archive:
        archive.extractall(beside)
    for name in ("truth.csv", "x.csv", "y.csv"):
        shutil.copy(theirs / name, beside / name)
    again = nvcore.compare(beside / "session.toml").result
    assert again.dataset.fingerprint == held.space.opened.dataset.fingerprint
    assert driver_in(again).counts == driver_in(held.space.result).counts
    assert driver_in(again).n_seen == 1


def test_errors_of_the_audit_are_in_the_findings(tmp_path: Path):
    drive(tmp_path)
    with (tmp_path / "truth.csv").open("a") as stream:
        stream.write("urban,3,300,200,40,100,1\n")
    page = opened("report", space=uploads(tmp_path))
    (line,) = [text.value for text in page.markdown if "findings of the audit" in text.value]
    assert int(line.split()[0]) >= 1
    assert str(tmp_path) not in texts(page)


def test_without_pictures_boxes_are_drawn_on_a_blank_and_a_link_says_what_it_cannot_do(
    tmp_path: Path,
):
    page = opened("link", "frame", space=uploaded_drive(tmp_path))
    assert "no pictures" in texts(page)
    assert "Picture (PNG)" in downloads(page)
    assert "Works in this tab only." in page.warning[0].value
    assert "for everybody" not in texts(page)
    assert str(tmp_path) not in page.code[0].value


def test_hostile_names_are_shown_as_text(tmp_path: Path):
    drive(tmp_path)
    for name in ("truth", "fir", "nir"):
        path = tmp_path / f"{name}.csv"
        path.write_text(path.read_text().replace("urban", "<b>[x](http://y)"))
    page = opened("link", "report", "html", "frame", "video", space=uploads(tmp_path))
    shown = "\n".join(text.value for text in (*page.caption, *page.markdown))
    assert "<b>" not in shown.replace("\\<b\\>", "")


def test_the_picture_of_a_frame_is_that_of_the_timeline(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    shown = []

    def drawn(result: Result, pictures: object, index: int, row: int, **options: object) -> Canvas:
        shown.append(index)
        return annotate(result, pictures, index, row, **options)

    monkeypatch.setattr("ui.views.export.frame.annotate", drawn)
    page = opened("frame", recording="rural_child", frame="120")
    space = page.session_state["workspace"]
    place, _ = page.session_state["place"]
    indices = space.pictures.indices
    space.pictures = replace(space.pictures, indices={**indices, place: indices[place] - 7})
    checked(page.run())
    assert shown == [120, 113]


def test_the_link_keeps_recording_and_frame_which_can_be_gone_to():
    page = opened("link", "frame", recording="rural_child", frame="120")
    assert page.code[0].value.endswith("/timeline?recording=rural_child&frame=120")
    assert "for everybody" in texts(page)
    checked(page.button_group(key="export_place").set_value("").run())
    assert "/timeline" not in page.code[0].value
    (field,) = [field for field in page.number_input if field.label == "Frame"]
    checked(field.set_value(130).run())
    assert page.query_params["frame"] == "130"


def test_the_link_is_complete_after_a_swap():
    page = opened("swap", "link", threshold_x="0.7")
    press(page, "sidebar_swap")
    assert "for everybody" in texts(page)
    # the threshold went with its system, and the session of who follows the link has another
    query = parse_qs(urlsplit(page.code[0].value).query)
    assert (query["x"], query["y"], query["threshold_y"]) == (["NIR"], ["FIR"], ["0.7"])


def test_names_in_a_link_are_quoted():
    assert link("https://h/export", "timeline", {"recording": "a b&c"}) == (
        "https://h/timeline?recording=a+b%26c"
    )


@pytest.mark.parametrize(("wanted", "row"), [(21, 2), (19, 0), (38, 2), (900, 2), (-5, 0)])
def test_a_step_to_a_frame_that_is_not_evaluated_goes_to_the_next(wanted: int, row: int):
    assert nearest_row(np.array([0, 20, 40]), wanted, 1) == row


def test_file_names_hold_no_slashes():
    assert file_stem("../a b/c") == "a_b_c"
    assert file_stem("///") == "recording"


@pytest.mark.parametrize(
    ("times", "ends", "speed", "expected"),
    [
        (np.arange(100) / 20, (1.0, 2.0), 1.0, Interval(20, 41, pytest.approx(20))),  # both ends
        (np.arange(100) / 20, (0.0, 4.95), 0.5, Interval(0, 100, pytest.approx(10))),
        (np.array([0.0, 2.0, 4.0]), (0, 4), 1.0, Interval(0, 3, 0.5)),  # as slow as taken
        (np.array([0.0]), (0, 0), 1.0, Interval(0, 1, 20)),  # for a frame period
    ],
)
def test_an_interval_plays_at_the_pace_of_its_frames(times, ends, speed, expected):
    assert chosen_interval(times, *ends, speed, 20) == expected


def test_a_video_may_be_two_minutes_long():
    assert why_not(Interval(0, 20 * int(LONGEST_S), 20)) == ""
    assert "at most 120 s" in why_not(Interval(0, 20 * int(LONGEST_S) + 1, 20))


def test_an_interval_without_frames_is_told():
    assert "choose a later end" in why_not(chosen_interval(np.arange(3) / 1, 2, 1, 1.0, 1))


def test_an_interval_that_is_too_long_cannot_be_made(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("ui.views.export.video.LONGEST_S", 5.0)
    page = opened("video")
    assert "at most 5 s" in texts(page)
    assert page.button(key="make_video").disabled


def test_a_video_of_the_timelines_pictures_is_made_in_the_background_and_offered(
    monkeypatch: pytest.MonkeyPatch,
):
    given = []

    def written(*positional: object, indices: np.ndarray, **named: object) -> None:
        given.append(indices)
        write_video(*positional, indices=indices, **named)

    monkeypatch.setattr("ui.views.export.video.write_video", written)
    page = opened("video", recording="rural_child", frame="0")
    (end,) = [field for field in page.number_input if field.label == "To (s)"]
    checked(end.set_value(0.45).run())
    press(page, "make_video")
    job = job_of(page, "video")
    job.join()
    checked(page.run())
    assert (job.state, job.outlasts) == (JobState.DONE, True)
    assert downloads(page)[-1] == "rural_child-0-9.mp4"
    assert "MB. It stays here until the next one." in texts(page)
    space = page.session_state["workspace"]
    assert given[0] is space.pictures.indices[page.session_state["place"][0]]
    with av.open(str(job.folder / job.title)) as video:
        assert sum(1 for _ in video.decode(video=0)) == 10
        assert '"fingerprint"' in video.metadata["comment"]
        assert str(ROOT) not in str(video.metadata)


def test_while_it_is_cancelled_the_video_says_so():
    is_halfway, may_go_on = threading.Event(), threading.Event()

    def write(progress: Progress) -> None:
        progress(0.5, "frames")
        is_halfway.set()
        assert may_go_on.wait(TIMEOUT_S)
        progress(1.0, "frames")

    page = opened("video")
    space = page.session_state["workspace"]
    job = BackgroundJob(write, space, title="night.mp4")
    space.put_job("video", job)
    assert is_halfway.wait(TIMEOUT_S)
    assert progress_of(checked(page.run())) == [r"Making night\.mp4: 50 % (frames)"]
    assert page.button(key="make_video").disabled
    press(page, "video_cancel")
    assert progress_of(page) == ["Cancelling"]
    assert page.button(key="video_cancel").disabled
    may_go_on.set()
    job.join()
    assert job.state is JobState.CANCELLED


def progress_of(page: AppTest) -> list[str]:
    return [progress.proto.text for progress in page.get("progress")]
