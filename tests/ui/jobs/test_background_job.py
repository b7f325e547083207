"""Jobs in the background: how they end, what they leave, and how many run at a time."""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from builders import at, make_dataset

from nvcore.errors import MediaError
from nvcore.inputs.session import Session, Source
from nvcore.progress import Progress, no_progress
from pages import TIMEOUT_S
from ui.jobs import background
from ui.jobs.background import BackgroundJob, FileJob, JobState, new_path, while_open
from ui.session.workspace import Opened, Workspace


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

    def start(self, is_wanted: Callable[[], bool] = always) -> FileJob:
        return FileJob(self.path, self.path.name, self, is_wanted)

    def finish(self, job: FileJob) -> FileJob:
        self.may_go_on.set()
        job.join()
        return job


@pytest.fixture
def writer(tmp_path: Path) -> Writer:
    return Writer(tmp_path / "a.mp4")


def test_a_file_stays_when_its_job_is_cancelled_too_late_and_goes_with_it(writer: Writer):
    job = writer.finish(writer.start())
    job.cancel()
    assert (job.state, job.share) == (JobState.DONE, 1.0)
    assert writer.path.read_bytes() == b"video"
    job.discard()
    assert not writer.path.exists()


def test_a_cancelled_job_stops_at_the_next_frame(writer: Writer):
    job = writer.start()
    assert writer.is_halfway.wait(TIMEOUT_S)
    assert (job.state, job.share) == (JobState.RUNNING, 0.5)
    job.cancel()
    assert writer.finish(job).state is JobState.CANCELLED
    assert not writer.path.exists()


def test_a_job_whose_session_has_ended_stops(writer: Writer):
    session = threading.Event()
    session.set()
    job = writer.start(session.is_set)
    assert writer.is_halfway.wait(TIMEOUT_S)
    session.clear()
    assert writer.finish(job).state is JobState.CANCELLED


def test_a_file_that_is_discarded_while_it_is_written_is_not_left(writer: Writer):
    job = FileJob(writer.path, "a.mp4", lambda _: writer(no_progress), always)
    assert writer.is_halfway.wait(TIMEOUT_S)
    job.discard()  # does not wait for it
    assert job.is_stopping
    assert writer.finish(job).state is JobState.CANCELLED
    assert not writer.path.exists()


def test_a_job_that_fails_says_why_and_leaves_nothing(tmp_path: Path):
    path = tmp_path / "a.html"

    def write(_: Progress) -> None:
        path.write_text("half a report")
        raise MediaError("there is no room", file="a.html")

    job = FileJob(path, "a.html", write, always)
    job.join()
    assert job.state is JobState.FAILED
    assert "there is no room" in job.error
    assert not path.exists()


def test_a_computation_gives_its_output_and_a_cancelled_one_none():
    is_started, may_go_on = threading.Event(), threading.Event()

    def compute(progress: Progress) -> int:
        progress(0.25, "multiplying")
        is_started.set()
        assert may_go_on.wait(TIMEOUT_S)
        progress(0.5, "multiplying")
        return 42

    cancelled = BackgroundJob(compute, always)
    assert is_started.wait(TIMEOUT_S)
    cancelled.cancel()
    may_go_on.set()
    cancelled.join()
    assert (cancelled.state, cancelled.output) == (JobState.CANCELLED, None)
    job = BackgroundJob(compute, always, key="six times seven")
    job.join()
    assert (job.output, job.key, job.share) == (42, "six times seven", 0.5)


def opened_workspace() -> Workspace:
    space = Workspace()
    session = Session(space.folder, Source(("t.csv",)), ())
    space.opened = Opened.of(session, make_dataset(truth=[at(0, 50)]), "mine")
    return space


@pytest.mark.parametrize("ending", ["close", "forget"])
def test_a_job_ends_with_what_its_workspace_has_open(ending: str, writer: Writer):
    space = opened_workspace()
    writers = [Writer(new_path(space, ".mp4")) for _ in range(background.MOST_AT_ONCE)]
    jobs = [each.start(while_open(space)) for each in writers]
    for number, job in enumerate(jobs):
        space.put_job(f"kind {number}", job)
    assert all(each.is_halfway.wait(TIMEOUT_S) for each in writers)
    getattr(space, ending)()
    for each, job in zip(writers, jobs, strict=True):
        assert each.finish(job).state is JobState.CANCELLED
    assert space.job("kind 0") is None
    assert writer.finish(writer.start()).state is JobState.DONE  # the slots are free


def test_a_newer_job_of_its_kind_takes_the_place_of_one():
    space, jobs = opened_workspace(), []
    for _ in range(2):
        writer = Writer(new_path(space, ".mp4"))
        jobs.append(writer.finish(writer.start(while_open(space))))
        space.put_job("video", jobs[-1])
    assert space.job("video") is jobs[1]
    assert [job.path.exists() for job in jobs] == [False, True]
    assert space.job("report") is None


def test_a_job_does_not_keep_its_workspace():
    space = opened_workspace()
    writer = Writer(new_path(space, ".mp4"))
    job = writer.start(while_open(space))
    space.put_job("video", job)
    assert writer.is_halfway.wait(TIMEOUT_S)
    folder = space.folder
    del space
    gc.collect()
    assert not folder.exists()
    assert writer.finish(job).state is JobState.CANCELLED


def test_a_further_job_waits_until_another_has_ended_and_can_be_cancelled(tmp_path: Path):
    writers = [Writer(tmp_path / f"{number}.mp4") for number in range(background.MOST_AT_ONCE + 2)]
    *running, cancelled, waiting = writers
    jobs = [each.start() for each in running]
    assert all(each.is_halfway.wait(TIMEOUT_S) for each in running)
    job = cancelled.start()
    job.cancel()
    job.join()
    assert job.state is JobState.CANCELLED
    job = waiting.start()
    assert job.state is JobState.WAITING
    running[0].may_go_on.set()
    assert waiting.is_halfway.wait(TIMEOUT_S)
    assert job.state is JobState.RUNNING
    for writer, each in zip([*running, waiting], [*jobs, job], strict=True):
        writer.finish(each)


def test_a_job_says_what_it_is_doing(writer: Writer):
    job = writer.start()
    assert writer.is_halfway.wait(TIMEOUT_S)
    assert (job.share, job.step) == (0.5, "frames")
    writer.finish(job)
