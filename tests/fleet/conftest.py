"""Where stores lie: a folder, and a bucket of a server of S3."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest
from object_store import make_bucket, options, served

from nvcore.fleet.location import Location

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
