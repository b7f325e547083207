"""Runs whose files the session may open."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from builders import at, make_dataset

from nvcore.common.errors import InputError
from nvcore.inputs.session import Session, Source
from ui.jobs.background import BackgroundJob
from ui.jobs.page_run import PageRun, open_written
from ui.session import state, uploads
from ui.session.uploads import count_folder
from ui.session.workspace import Opened, Workspace

RUN = PageRun[int]("run", "run", "Running", folder="detector")


@pytest.fixture
def session(tmp_path: Path, space: Workspace, monkeypatch: pytest.MonkeyPatch) -> Session:
    """What is open in `space`."""
    session = Session(folder=tmp_path, truth=Source("truth.csv"), systems=())
    opens(session, space, monkeypatch)
    return session


def opens(session: Session, space: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    space.opened = Opened.of(session, make_dataset(truth=[at(0, 50)]), "mine")
    monkeypatch.setattr(state, "workspace", lambda: space)
    monkeypatch.setattr(state, "opened", lambda: SimpleNamespace(session=session))


def test_a_new_run_removes_the_files_of_the_last_one_and_no_model(space: Workspace, session):
    model = space.folder / "detector-model-1"
    model.mkdir()
    first = RUN.new_folder()
    (first / "boxes.csv").write_bytes(bytes(10))
    count_folder(space, first)
    assert space.used_bytes == 10
    second = RUN.new_folder()
    assert [first.exists(), second.exists(), model.exists()] == [False, True, True]
    assert space.used_bytes == 0


def test_a_run_whose_files_are_open_keeps_them_beside_those_of_an_upload(
    space: Workspace, monkeypatch: pytest.MonkeyPatch
):
    folder = space.folder / "upload-1"
    opens(Session(folder, Source("t.csv"), ()), space, monkeypatch)
    first = RUN.new_folder()
    assert first.parent == folder
    opens(Session(folder, Source(f"{first.name}/t.csv"), ()), space, monkeypatch)
    assert RUN.new_folder() != first
    assert first.exists()


def written() -> BackgroundJob[int]:
    folder = RUN.new_folder()
    work = lambda _: (folder / "features.csv").write_bytes(bytes(7))  # noqa: E731
    RUN.start(work, folder=folder)
    RUN.job.join()
    return RUN.job


def test_files_count_as_long_as_they_are_there(space: Workspace, session):
    job = written()
    for _ in range(2):
        count_folder(space, job.folder)
        assert space.used_bytes == 7
    space.drop_job(RUN.name)
    assert not job.folder.exists()
    assert space.used_bytes == 0


@pytest.mark.parametrize("trouble", ["no room", "refused"])
def test_files_that_could_not_be_opened_go_with_the_job(
    space: Workspace, session, monkeypatch: pytest.MonkeyPatch, trouble: str
):
    job = written()

    def refuse() -> None:
        assert job.is_kept
        raise InputError("refused")

    if trouble == "no room":
        monkeypatch.setattr(uploads, "MAX_SESSION_BYTES", 6)
    with pytest.raises(Exception, match=re.compile("refused|takes")):
        open_written(space, job, refuse)
    space.drop_job(RUN.name)
    assert not job.folder.exists()
