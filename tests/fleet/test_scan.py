"""Scans: what is planned, and that whoever runs it makes the same files."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from pathlib import Path

import pytest
from fleet_runs import (
    PARAMS,
    append_to,
    attempts_of,
    begin_scan,
    broken_at,
    files_of,
    small_fleet,
)

from nvcore.errors import InputError
from nvcore.fleet.location import Location
from nvcore.fleet.pool import in_pool
from nvcore.fleet.scan import drive, finish, in_process, plan, status
from nvcore.fleet.store import Store


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> str:
    return append_to(tmp_path_factory.mktemp("fleet") / "store", small_fleet())


@pytest.fixture(scope="module")
def undisturbed(store: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a scan in this process."""
    out = tmp_path_factory.mktemp("undisturbed")
    its_plan, job = begin_scan(store, out)
    assert list(drive(job, in_process)) == [batch.key for batch in its_plan.batches]
    finish(Location(out), its_plan)
    return files_of(out)


@pytest.mark.parametrize("n_workers", [1, 2])
def test_processes_make_the_same_files(store, undisturbed, tmp_path, n_workers):
    its_plan, job = begin_scan(store, tmp_path)
    batches = list(in_pool(job, n_workers))
    assert {*batches} == {batch.key for batch in its_plan.batches}
    finish(Location(tmp_path), its_plan)
    assert files_of(tmp_path) == undisturbed


def test_shards_in_any_order_make_the_same_files(store, undisturbed, tmp_path):
    its_plan, job = begin_scan(store, tmp_path)
    shards = [drive(job, partial(in_process, part=part, n_parts=3)) for part in (2, 0, 1)]
    first = [next(shard) for shard in shards]
    assert first == [its_plan.batches[part].key for part in (2, 0, 1)]
    for shard in reversed(shards):
        list(shard)
    finish(Location(tmp_path), its_plan)
    assert files_of(tmp_path) == undisturbed
    assert {*attempts_of(tmp_path).values()} == {1}
