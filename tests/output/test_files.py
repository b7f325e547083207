"""A file is written whole or not at all, and a folder holds the files of one run."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from places import ROOT

from nvcore.common.errors import InputError
from nvcore.common.output.files import LOCK, MANIFEST, check_folder, write_run, write_whole

NAMES = [f"{number}.csv" for number in range(8)]


def run(content: str, names: list[str] = NAMES) -> Iterator[tuple[str, bytes]]:
    yield from ((name, f"{content} {name}".encode()) for name in names)


def files_in(folder: Path) -> dict[str, str]:
    """Texts of the files, after a look whether they are those of the manifest."""
    contents = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}
    lines = contents.pop(MANIFEST).decode().splitlines()
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    assert dict(reversed(line.split("  ")) for line in lines) == hashes
    return {name: content.decode() for name, content in contents.items()}


def test_a_run_replaces_the_older_one_and_keeps_what_is_not_its_own(tmp_path: Path):
    (tmp_path / "notes.txt").write_text("mine")
    write_run(tmp_path, run("old"), known=NAMES)
    write_run(tmp_path, run("new", NAMES[:3]), known=NAMES)
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {*NAMES[:3], MANIFEST, LOCK, "notes.txt"}
    assert (tmp_path / "1.csv").read_text() == "new 1.csv"


@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError(28, "No space left on device")])
def test_a_run_that_is_stopped_leaves_the_older_one(tmp_path: Path, stop: BaseException):
    def stopped() -> Iterator[tuple[str, bytes]]:
        yield from run("new", NAMES[:5])
        raise stop

    write_run(tmp_path, run("old"), known=NAMES)
    with pytest.raises((KeyboardInterrupt, InputError)):
        write_run(tmp_path, stopped(), known=NAMES)
    assert files_in(tmp_path) == {name: f"old {name}" for name in NAMES}


def test_a_run_that_is_killed_leaves_the_older_one_and_its_rest_goes_with_the_next(tmp_path: Path):
    program = (
        "import os, sys; from pathlib import Path\n"
        "from nvcore.common.output.files import write_run\n"
        "def killed():\n"
        "    yield '0.csv', b'new'\n"
        "    os.kill(os.getpid(), 9)\n"
        "write_run(Path(sys.argv[1]), killed(), known=['0.csv'])"
    )
    write_run(tmp_path, run("old"), known=NAMES)
    killed = subprocess.run([sys.executable, "-c", program, tmp_path], cwd=ROOT)
    assert killed.returncode < 0
    assert (tmp_path / "0.csv").read_text() == "old 0.csv"
    assert len(list(tmp_path.iterdir())) == len(NAMES) + 3
    write_run(tmp_path, run("next"), known=NAMES)
    assert files_in(tmp_path) == {name: f"next {name}" for name in NAMES}


def test_runs_at_the_same_time_do_not_mix(tmp_path: Path):
    with ThreadPoolExecutor(6) as pool:
        jobs = [pool.submit(write_run, tmp_path, run(str(n)), known=NAMES) for n in range(24)]
        for job in jobs:
            job.result()
    assert len({text.split()[0] for text in files_in(tmp_path).values()}) == 1


def test_a_link_goes_on_pointing_to_the_file_and_its_rights_stay(tmp_path: Path):
    (tmp_path / "real.html").write_text("old")
    (tmp_path / "real.html").chmod(0o640)
    (tmp_path / "link.html").symlink_to("real.html")
    write_whole(tmp_path / "link.html", b"new")
    assert (tmp_path / "link.html").is_symlink()
    assert (tmp_path / "real.html").read_text() == "new"
    assert (tmp_path / "real.html").stat().st_mode & 0o777 == 0o640
    assert len(list(tmp_path.iterdir())) == 2


def test_a_file_that_cannot_be_written_stays_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def full(path: Path, content: bytes) -> int:
        with path.open("wb") as file:
            file.write(content[:1])
        raise OSError(28, "No space left on device")

    (tmp_path / "a.html").write_text("old")
    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"a\.html: cannot be written \(No space left"):
        write_whole(tmp_path / "a.html", b"new")
    assert [path.name for path in tmp_path.iterdir()] == ["a.html"]
    assert (tmp_path / "a.html").read_text() == "old"


def test_a_folder_that_cannot_be_listed_is_refused_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def unlisted(path: Path) -> Iterator[Path]:
        raise PermissionError(13, "Permission denied", str(path))

    check_folder(tmp_path, NAMES)
    write_run(tmp_path, run("old"), known=NAMES)
    monkeypatch.setattr(Path, "iterdir", unlisted)  # permissions do not bind root
    with pytest.raises(InputError, match=r"cannot be listed \(Permission denied\); give another"):
        check_folder(tmp_path, NAMES)


def test_a_pipe_is_written_to(tmp_path: Path):
    reading, writing = os.pipe()
    write_whole(Path(f"/dev/fd/{writing}"), b"text")
    os.close(writing)
    assert os.read(reading, 10) == b"text"
    os.close(reading)
