"""Videos in the background: how they end."""

from __future__ import annotations

import threading
from pathlib import Path

from nvcore.errors import MediaError
from ui import background_job
from ui.background_job import JobState, Progress
from ui.video_job import VideoJob

PATIENCE_S = 20.0


def always() -> bool:
    return True


class Writer:
    """Writes two frames; before the second it waits until it may go on."""

    def __init__(self, path: Path):
        self.path = path
        self.is_halfway, self.may_go_on = threading.Event(), threading.Event()

    def __call__(self, progress: Progress) -> bool:
        if not progress(0.5):
            return False
        self.is_halfway.set()
        assert self.may_go_on.wait(PATIENCE_S)
        if not progress(1.0):
            return False
        self.path.write_bytes(b"video")
        return True


def test_a_job_writes_its_video(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    writer.may_go_on.set()
    job = VideoJob(writer.path, "a.mp4", writer, always)
    job.join()
    assert (job.state, job.share) == (JobState.DONE, 1.0)
    assert writer.path.read_bytes() == b"video"


def test_a_cancelled_job_stops_at_the_next_frame(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    job = VideoJob(writer.path, "a.mp4", writer, always)
    assert writer.is_halfway.wait(PATIENCE_S)
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
    job = VideoJob(writer.path, "a.mp4", writer, session.is_set)
    assert writer.is_halfway.wait(PATIENCE_S)
    session.clear()
    writer.may_go_on.set()
    job.join()
    assert job.state is JobState.CANCELLED


def test_a_job_that_fails_says_why(tmp_path: Path):
    def write(_: Progress) -> bool:
        raise MediaError("there is no room", file="a.mp4")

    job = VideoJob(tmp_path / "a.mp4", "a.mp4", write, always)
    job.join()
    assert job.state is JobState.FAILED
    assert "there is no room" in job.error


def test_discarding_removes_the_video(tmp_path: Path):
    writer = Writer(tmp_path / "a.mp4")
    writer.may_go_on.set()
    job = VideoJob(writer.path, "a.mp4", writer, always)
    job.join()
    job.discard()
    assert not writer.path.exists()


def test_a_further_job_waits_until_another_has_ended(tmp_path: Path):
    writers = [
        Writer(tmp_path / f"{number}.mp4") for number in range(background_job.MOST_AT_ONCE + 1)
    ]
    jobs = [VideoJob(one.path, one.path.name, one, always) for one in writers[:-1]]
    assert all(one.is_halfway.wait(PATIENCE_S) for one in writers[:-1])
    waiting = VideoJob(writers[-1].path, "last.mp4", writers[-1], always)
    assert waiting.state is JobState.WAITING
    writers[0].may_go_on.set()
    assert writers[-1].is_halfway.wait(PATIENCE_S)
    assert waiting.state is JobState.RUNNING
    for writer, job in zip(writers, [*jobs, waiting], strict=True):
        writer.may_go_on.set()
        job.join()


def test_a_waiting_job_can_be_cancelled(tmp_path: Path):
    writers = [Writer(tmp_path / f"{number}.mp4") for number in range(background_job.MOST_AT_ONCE)]
    jobs = [VideoJob(one.path, one.path.name, one, always) for one in writers]
    assert all(one.is_halfway.wait(PATIENCE_S) for one in writers)
    waiting = VideoJob(tmp_path / "last.mp4", "last.mp4", Writer(tmp_path / "last.mp4"), always)
    waiting.cancel()
    waiting.join()
    assert waiting.state is JobState.CANCELLED
    for writer, job in zip(writers, jobs, strict=True):
        writer.may_go_on.set()
        job.join()
