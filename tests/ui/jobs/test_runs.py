"""Runs whose files the session may open."""

from __future__ import annotations

from pathlib import Path

import pytest

from nvcore.inputs.session import Session, Source
from ui.jobs import runs
from ui.jobs.runs import FolderJob, new_run_folder
from ui.session.uploads import count_folder
from ui.session.workspace import Workspace


@pytest.fixture
def session(tmp_path: Path) -> Session:
    return Session(folder=tmp_path, truth=Source("truth.csv"), systems=())


def test_a_new_run_removes_the_files_of_the_last_one_and_no_model(
    space: Workspace, session: Session
):
    model = space.folder / "detector-model-1"
    model.mkdir()
    first = new_run_folder(space, session, "run", "detector")
    (first / "boxes.csv").write_bytes(bytes(10))
    count_folder(space, first)
    assert space.used_bytes == 10
    second = new_run_folder(space, session, "run", "detector")
    assert [first.exists(), second.exists(), model.exists()] == [False, True, True]
    assert space.used_bytes == 0


def test_files_count_as_long_as_they_are_there(
    space: Workspace, session: Session, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(runs, "while_open", lambda _: lambda: True)
    folder = new_run_folder(space, session, "run", "driver")
    job = FolderJob(space, folder, lambda _: (folder / "features.csv").write_bytes(bytes(7)))
    space.put_job("run", job)
    job.join()
    for _ in range(2):
        count_folder(space, folder)
        assert space.used_bytes == 7
    space.drop_job("run")
    assert not folder.exists()
    assert space.used_bytes == 0
