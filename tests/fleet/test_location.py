"""Folders on a disk and in a bucket do the same, also where the server refuses and cuts."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from object_store import options, troubled

from nvcore.common.errors import InputError, StoreError
from nvcore.subjects.fleet.location import Location


def test_files_are_written_read_listed_and_deleted(place: Location):
    assert place.list() == []
    place.write("a/b", b"1")
    place.write("a/b", b"22")
    place.child("a").write("c", b"")
    there = pickle.loads(pickle.dumps(place))
    assert there.read("a/b") == there.open("a/b").read() == b"22"
    assert [(entry.path, entry.size) for entry in there.list("a")] == [("a/b", 2), ("a/c", 0)]
    there.delete("a/b")
    there.delete("a/b")
    assert [entry.path for entry in place.list()] == ["a/c"]
    for read in (place.read, place.open):
        with pytest.raises(FileNotFoundError, match=r"there is no .*/a/b"):
            read("a/b")


def test_of_many_who_create_a_file_at_once_one_alone_is_told_so(place: Location):
    with ThreadPoolExecutor(12) as pool:
        for race in range(5):
            contents = [f"{race} {number}".encode() for number in range(12)]
            path = f"race/{race}"
            told = list(pool.map(lambda content, path=path: place.create(path, content), contents))
            assert told.count(True) == 1
            assert place.read(path) == contents[told.index(True)]


def test_requests_that_are_refused_or_cut_are_made_again(bucket: Location, s3: str):
    with troubled(s3) as (url, done):
        place = Location(bucket.uri, options(url))
        for number in range(12):
            assert place.create(f"{number}", b"%d" % number)
            assert not place.create(f"{number}", b"of another")
            place.write(f"{number}", b"%d" % (number + 1))
            assert place.read(f"{number}") == place.open(f"{number}").read() == b"%d" % (number + 1)
        assert len(place.list()) == 12
    assert min(done.values()) > 10


def test_a_bucket_that_is_not_there_is_named(s3: str):
    place = Location("s3://nobody/x", options(s3))
    for use in (lambda: place.write("a", b""), lambda: place.create("a", b""), place.list):
        with pytest.raises(StoreError, match=r"the server says NoSuchBucket"):
            use()


def test_storage_that_cannot_be_used_is_named(tmp_path: Path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(StoreError, match=r"file/a: cannot be written \(File exists"):
        Location(tmp_path / "file").write("a", b"")
    gone = Location("s3://x/y", {**options("http://127.0.0.1:9"), "max_retries": "0"})
    with pytest.raises(StoreError, match=r"s3://x/y/a: cannot be read \(.*127.0.0.1:9"):
        gone.read("a")
    with pytest.raises(InputError, match="http:// is no place for a store; expected a folder"):
        Location("http://x/y")
    for name in ("a[1]", "a\\b", "100%25"):
        with pytest.raises(InputError, match="cannot be in the path of a store; name another"):
            Location(tmp_path / name)
    with pytest.raises(InputError, match="'#' cannot be in the path"):
        Location("s3://x/run#2")
    assert Location(tmp_path / "5 % of #1").create("a", b"")
