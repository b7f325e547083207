"""Where stores lie: a folder, and a bucket of a server of S3; and a small fleet, scanned."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest
from fleet_runs import append_to, begin_scan, failures_of, files_of, small_fleet
from object_store import make_bucket, options, served

from nvcore.subjects.fleet.folder import finish
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.scan import drive, in_process

NUMBERS = count()


@pytest.fixture(scope="session")
def s3() -> Iterator[str]:
    """Address of a server of S3."""
    with served() as url:
        yield url


@pytest.fixture
def bucket(s3: str) -> Location:
    """A folder in an empty bucket of it."""
    name = f"bucket{next(NUMBERS)}"
    make_bucket(s3, name)
    return Location(f"s3://{name}/of/ours", options(s3))


@pytest.fixture(params=["folder", "bucket"])
def place(request: pytest.FixtureRequest, tmp_path: Path) -> Location:
    """A new folder on a disk, and then one in a bucket."""
    if request.param == "bucket":
        made: Location = request.getfixturevalue("bucket")
        return made
    return Location(tmp_path / "new" / "store")


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> str:
    """URI of a store with `small_fleet`."""
    return append_to(tmp_path_factory.mktemp("fleet") / "store", small_fleet())


@pytest.fixture(scope="module")
def undisturbed(store: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of a scan of it in this process."""
    out = tmp_path_factory.mktemp("undisturbed")
    plan, job = begin_scan(store, out)
    assert list(drive(job, in_process)) == [batch.key for batch in plan.batches]
    assert not failures_of(out)
    finish(Location(out), plan)
    return files_of(out)
