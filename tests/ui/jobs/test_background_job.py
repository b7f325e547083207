"""Jobs in the background: how they end, what they leave, and how many run at a time."""

from __future__ import annotations

import gc
import threading
from pathlib import Path

import pytest
from places import ROOT

from nvcore.errors import MediaError
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.progress import Progress, no_progress
from pages import TIMEOUT_S
from ui.jobs import background
from ui.jobs.background import BackgroundJob, FileJob, JobState, new_path, while_open
from ui.session.workspace import Opened, Workspace

SAMPLE = ROOT / "sample_data" / "session.toml"


def always() -> bool:
    return True


class Writer:
    """Writes two frames; before the second it waits until it may go on."""

    def __init__(self, path: Path):
        self.path = path
        self.is_halfway, self.may_go_on = threading.Event(), threading.Event()

    def __call__(self, progress: Progress) -> None:
        progress(0.5, "frames")
        self.is_halfway.set()
        assert self.may_go_on.wait(TIMEOUT_S)
        progress(1.0, "frames")
        self.path.write_bytes(b"video")


def test_a_job_writes_its_video(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    writer.may_go_on.set()
    job = FileJob(writer.path, "a.mp4", writer, always)
    job.join()
    assert (job.state, job.share) == (JobState.DONE, 1.0)
    assert writer.path.read_bytes() == b"video"


def test_a_cancelled_job_stops_at_the_next_frame(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    job = FileJob(writer.path, "a.mp4", writer, always)
    assert writer.is_halfway.wait(TIMEOUT_S)
    assert (job.state, job.share) == (JobState.RUNNING, 0.5)
    job.cancel()
    writer.may_go_on.set()
    job.join()
    assert job.state is JobState.CANCELLED
    assert not writer.path.exists()


def test_a_job_whose_session_has_ended_stops(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    session = threading.Event()
    session.set()
    job = FileJob(writer.path, "a.mp4", writer, session.is_set)
    assert writer.is_halfway.wait(TIMEOUT_S)
    session.clear()
    writer.may_go_on.set()
    job.join()
    assert job.state is JobState.CANCELLED


def test_a_job_that_fails_says_why(tmp_path: Path):
    def write(_: Progress) -> None:
        raise MediaError("there is no room", file="a.mp4")

    job = FileJob(tmp_path / "a.mp4", "a.mp4", write, always)
    job.join()
    assert job.state is JobState.FAILED
    assert "there is no room" in job.error


def test_discarding_removes_the_video(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    writer.may_go_on.set()
    job = FileJob(writer.path, "a.mp4", writer, always)
    job.join()
    job.discard()
    assert not writer.path.exists()


def test_a_file_that_is_discarded_while_it_is_written_is_not_left(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    job = FileJob(writer.path, "a.mp4", lambda _: writer(no_progress), always)
    assert writer.is_halfway.wait(TIMEOUT_S)
    job.discard()  # does not wait for it
    assert job.is_stopping
    writer.may_go_on.set()
    job.join()
    assert job.state is JobState.CANCELLED
    assert not writer.path.exists()


def test_a_file_that_is_there_stays_when_cancelled_too_late(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    writer.may_go_on.set()
    job = FileJob(writer.path, "a.mp4", writer, always)
    job.join()
    job.cancel()
    assert job.state is JobState.DONE
    assert writer.path.exists()


def test_what_a_job_that_fails_has_written_is_removed(tmp_path: Path):
    path = tmp_path / "a.html"

    def write(_: Progress) -> None:
        path.write_text("half a report")
        raise MediaError("there is no room", file="a.html")

    FileJob(path, "a.html", write, always).join()
    assert not path.exists()


def test_a_computation_gives_what_it_found():
    def compute(progress: Progress) -> int:
        progress(0.25, "multiplying")
        return 42

    job = BackgroundJob(compute, always, key="six times seven")
    job.join()
    assert (job.output, job.key, job.share) == (42, "six times seven", 0.25)


def test_a_cancelled_computation_finds_nothing():
    is_started, may_go_on = threading.Event(), threading.Event()

    def compute(progress: Progress) -> int:
        is_started.set()
        assert may_go_on.wait(TIMEOUT_S)
        progress(0.5, "multiplying")
        raise AssertionError("a step too many")

    job = BackgroundJob(compute, always)
    assert is_started.wait(TIMEOUT_S)
    job.cancel()
    may_go_on.set()
    job.join()
    assert (job.state, job.output) == (JobState.CANCELLED, None)


def opened_workspace() -> Workspace:
    space = Workspace()
    session = read_session(SAMPLE)
    space.opened = Opened(session, load(session), "sample")
    return space


@pytest.mark.parametrize("ending", ["close", "forget"])
def test_a_job_ends_with_what_its_workspace_has_open(ending: str, tmp_path: Path):
    space = opened_workspace()
    writers = [Writer(new_path(space, ".mp4")) for _ in range(background.MOST_AT_ONCE)]
    jobs = [FileJob(one.path, "a.mp4", one, while_open(space)) for one in writers]
    for number, job in enumerate(jobs):
        space.put_job(f"kind {number}", job)
    assert all(one.is_halfway.wait(TIMEOUT_S) for one in writers)
    getattr(space, ending)()
    for writer, job in zip(writers, jobs, strict=True):
        writer.may_go_on.set()
        job.join()
    assert [job.state for job in jobs] == [JobState.CANCELLED] * len(jobs)
    assert space.job("kind 0") is None
    next_one = Writer(tmp_path / "next.mp4")
    next_one.may_go_on.set()
    after = FileJob(next_one.path, "next.mp4", next_one, always)
    after.join()
    assert after.state is JobState.DONE  # the slots are free


def test_a_newer_job_of_its_kind_takes_the_place_of_one():
    space = opened_workspace()
    jobs = []
    for name in ("old", "new"):
        writer = Writer(new_path(space, ".mp4"))
        writer.may_go_on.set()
        jobs.append(FileJob(writer.path, name, writer, while_open(space)))
        jobs[-1].join()
        space.put_job("video", jobs[-1])
    assert space.job("video") is jobs[1]
    assert [job.path.exists() for job in jobs] == [False, True]
    assert space.job("report") is None


def test_a_job_does_not_keep_its_workspace():
    space = opened_workspace()
    writer = Writer(new_path(space, ".mp4"))
    job = FileJob(writer.path, "a.mp4", writer, while_open(space))
    space.put_job("video", job)
    assert writer.is_halfway.wait(TIMEOUT_S)
    folder = space.folder
    del space
    gc.collect()
    assert not folder.exists()
    writer.may_go_on.set()
    job.join()
    assert job.state is JobState.CANCELLED


def test_a_further_job_waits_until_another_has_ended(tmp_path: Path):
    writers = [Writer(tmp_path / f"{number}.mp4") for number in range(background.MOST_AT_ONCE + 1)]
    jobs = [FileJob(one.path, one.path.name, one, always) for one in writers[:-1]]
    assert all(one.is_halfway.wait(TIMEOUT_S) for one in writers[:-1])
    waiting = FileJob(writers[-1].path, "last.mp4", writers[-1], always)
    assert waiting.state is JobState.WAITING
    writers[0].may_go_on.set()
    assert writers[-1].is_halfway.wait(TIMEOUT_S)
    assert waiting.state is JobState.RUNNING
    for writer, job in zip(writers, [*jobs, waiting], strict=True):
        writer.may_go_on.set()
        job.join()


def test_a_waiting_job_can_be_cancelled(tmp_path: Path):
    writers = [Writer(tmp_path / f"{number}.mp4") for number in range(background.MOST_AT_ONCE)]
    jobs = [FileJob(one.path, one.path.name, one, always) for one in writers]
    assert all(one.is_halfway.wait(TIMEOUT_S) for one in writers)
    waiting = FileJob(tmp_path / "last.mp4", "last.mp4", Writer(tmp_path / "last.mp4"), always)
    waiting.cancel()
    waiting.join()
    assert waiting.state is JobState.CANCELLED
    for writer, job in zip(writers, jobs, strict=True):
        writer.may_go_on.set()
        job.join()
