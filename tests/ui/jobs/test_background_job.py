"""Jobs in the background: how they end, what they leave, and how many run at a time."""

from __future__ import annotations

import gc
import threading
from pathlib import Path

import pytest
from builders import at, make_dataset

from nvcore.common.errors import MediaError
from nvcore.common.progress import Progress, no_progress
from nvcore.inputs.session import Session, Source
from pages import TIMEOUT_S
from ui.jobs import background
from ui.jobs.background import BackgroundJob, JobState
from ui.session.workspace import Opened, Workspace


class Writer:
    """Writes two frames. Before the second it waits until it may go on."""

    def __init__(self, folder: Path):
        folder.mkdir()
        self.path = folder / "a.mp4"
        self.is_halfway, self.may_go_on = threading.Event(), threading.Event()

    def __call__(self, progress: Progress) -> int:
        progress(0.5, "frames")
        self.is_halfway.set()
        assert self.may_go_on.wait(TIMEOUT_S)
        progress(1.0, "the end")
        return self.path.write_bytes(b"video")

    def start(self, space: Workspace) -> BackgroundJob[int]:
        return BackgroundJob(self, space, folder=self.path.parent, key="its key")

    def halfway(self, space: Workspace) -> BackgroundJob[int]:
        job = self.start(space)
        assert self.is_halfway.wait(TIMEOUT_S)
        return job

    def finish(self, job: BackgroundJob[int]) -> JobState:
        self.may_go_on.set()
        job.join()
        return job.state


def opened(folder: Path) -> Opened:
    session = Session(folder, Source(("t.csv",)), ())
    return Opened.of(session, make_dataset(truth=[at(0, 50)]), "mine")


@pytest.fixture
def writer(tmp_path: Path) -> Writer:
    return Writer(tmp_path / "run")


@pytest.fixture
def space() -> Workspace:
    space = Workspace()
    space.opened = opened(space.folder)
    return space


def test_a_job_says_how_far_it_is_and_its_file_goes_only_when_it_is_discarded(
    writer: Writer, space: Workspace
):
    job = writer.halfway(space)
    assert (job.state, job.share, job.step) == (JobState.RUNNING, 0.5, "frames")
    assert job.output is None
    writer.finish(job)
    job.cancel()  # too late
    assert (job.state, job.share, job.output, job.key) == (JobState.DONE, 1.0, 5, "its key")
    assert writer.path.read_bytes() == b"video"
    job.discard()
    assert not writer.path.exists()


def test_a_file_that_the_session_has_opened_is_not_removed(writer: Writer, space: Workspace):
    job = writer.halfway(space)
    writer.finish(job)
    job.is_kept = True
    job.discard()
    assert writer.path.exists()


def test_a_cancelled_job_stops_at_the_next_frame(writer: Writer, space: Workspace):
    job = writer.halfway(space)
    job.cancel()
    assert writer.finish(job) is JobState.CANCELLED
    assert job.output is None
    assert not writer.path.exists()


def test_a_file_that_is_discarded_while_it_is_written_is_not_left(writer: Writer, space: Workspace):
    job = BackgroundJob(lambda _: writer(no_progress), space, folder=writer.path.parent)
    assert writer.is_halfway.wait(TIMEOUT_S)
    job.discard()  # does not wait for it
    assert job.is_stopping
    assert writer.finish(job) is JobState.CANCELLED
    assert not writer.path.exists()


def test_a_job_that_fails_says_why_and_leaves_nothing(tmp_path: Path, space: Workspace):
    folder = tmp_path / "run"
    folder.mkdir()

    def write(_: Progress) -> None:
        (folder / "a.html").write_text("half a report")
        raise MediaError("there is no room", file="a.html")

    job = BackgroundJob(write, space, folder=folder)
    job.join()
    assert job.state is JobState.FAILED
    assert "there is no room" in str(job.error)
    assert job.error is not None
    assert job.error.__traceback__ is None  # it would keep what the work has loaded
    assert not folder.exists()


@pytest.mark.parametrize("ending", ["close", "forget"])
def test_a_job_ends_with_what_its_workspace_has_open(ending: str, space: Workspace):
    writers = [Writer(space.folder / f"{i}") for i in range(background.MOST_JOBS)]
    jobs = [each.halfway(space) for each in writers]
    for number, job in enumerate(jobs):
        space.put_job(f"kind {number}", job)
    getattr(space, ending)()
    for each, job in zip(writers, jobs, strict=True):
        assert each.finish(job) is JobState.CANCELLED
    assert space.job("kind 0") is None


def test_a_newer_job_of_its_kind_takes_the_place_of_one(space: Workspace):
    jobs = []
    for number in range(2):
        writer = Writer(space.folder / f"{number}")
        jobs.append(writer.start(space))
        writer.finish(jobs[-1])
        space.put_job("video", jobs[-1])
    assert space.job("video") is jobs[1]
    assert [job.folder.exists() for job in jobs] == [False, True]
    assert space.job("report") is None


def test_a_job_does_not_keep_its_workspace():
    space = Workspace()
    space.opened = opened(space.folder)
    writer = Writer(space.folder / "run")
    job = writer.start(space)
    space.put_job("video", job)
    assert writer.is_halfway.wait(TIMEOUT_S)
    folder = space.folder
    del space
    gc.collect()
    assert not folder.exists()
    assert writer.finish(job) is JobState.CANCELLED


def test_a_further_job_waits_until_another_has_ended_and_can_be_cancelled(
    tmp_path: Path, space: Workspace
):
    writers = [Writer(tmp_path / f"{number}") for number in range(background.MOST_JOBS + 2)]
    *running, cancelled, waiting = writers
    jobs = [each.halfway(space) for each in running]
    cancelled.path.write_bytes(b"copied before")
    job = cancelled.start(space)
    job.cancel()
    job.join()
    assert (job.state, cancelled.path.exists()) == (JobState.CANCELLED, False)
    job = waiting.start(space)
    assert job.state is JobState.WAITING
    running[0].may_go_on.set()
    assert waiting.is_halfway.wait(TIMEOUT_S)
    assert job.state is JobState.RUNNING
    for writer, each in zip([*running, waiting], [*jobs, job], strict=True):
        writer.finish(each)
