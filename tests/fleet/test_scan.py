"""Scans: what is planned, and that whoever runs it makes the same files."""

from __future__ import annotations

from pathlib import Path

import pytest
from fleet_runs import (
    attempts_of, begin_scan, broken_at, files_of, small_fleet, write_store,
)  # fmt: skip

from nvcore.comparison import compare
from nvcore.fleet.location import Location
from nvcore.fleet.pool import in_pool
from nvcore.fleet.scan import finish, status


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> str:
    return write_store(tmp_path_factory.mktemp("fleet") / "store", small_fleet())


@pytest.fixture(scope="module")
def undisturbed(store: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a scan in this process."""
    out = tmp_path_factory.mktemp("undisturbed")
    plan, job = begin_scan(store, out)
    assert list(drive(job, in_process)) == [batch.key for batch in plan.batches]
    finish(Location(str(out)), plan)
    return files_of(out)


def test_processes_and_shards_make_the_same_files(store, undisturbed, tmp_path):
    for name, n in (("one", 1), ("two", 2)):
        plan, job = begin_scan(store, tmp_path / name)
        assert {*in_pool(job, n)} == {batch.key for batch in plan.batches}
        finish(Location(str(tmp_path / name)), plan)
        assert files_of(tmp_path / name) == undisturbed
    plan, job = begin_scan(store, tmp_path / "shards")
    shards = [work(job, part, 3) for part in (2, 0, 1)]
    for shard in shards:  # each its first batch
        next(shard)
    for shard in reversed(shards):
        list(shard)
    finish(Location(str(tmp_path / "shards")), plan)
    assert files_of(tmp_path / "shards") == undisturbed
    assert {*attempts_of(tmp_path / "shards").values()} == {1}


def test_recordings_that_fail_are_set_aside_with_the_reason(store, undisturbed, tmp_path):
    plan, job = begin_scan(store, tmp_path, run=broken_at(["r3", "r8"]))
    list(drive(job, in_process))
    summary = finish(Location(str(tmp_path)), plan)
    assert status(Location(str(tmp_path))).n_quarantined == 2
    assert (summary.recordings, summary.quarantined) == (10, 2)
