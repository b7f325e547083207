"""Pipes as inputs: read once, kept for the run, refused where nobody keeps them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from inputs import drive, flags, nvcore
from places import ROOT

import nvcore as nv
from nvcore.common.errors import InputError
from nvcore.inputs.files import pipes
from nvcore.inputs.files.find import find_files
from nvcore.inputs.session import Source
from nvcore.inputs.session.toml import read_session

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a POSIX system")


@contextmanager
def piped(path: Path, content: bytes) -> Iterator[Path]:
    """A named pipe through which the content comes once."""

    def send() -> None:
        with suppress(BrokenPipeError):  # who reads has seen enough
            path.write_bytes(content)

    os.mkfifo(path)
    sender = threading.Thread(target=send)
    sender.start()
    yield path
    sender.join(timeout=60)
    assert not sender.is_alive()


def test_a_shell_s_process_substitution_is_read_as_the_file(tmp_path: Path):
    drive(tmp_path)
    plain = nvcore("compare", *flags(tmp_path), "--json").stdout
    command = (
        'cat truth.csv | "$0" -m nvcore compare --truth /dev/stdin --x <(gzip -c fir.csv) '
        "--y nir.csv --name-x fir --size 640x480 --fps 20 --frames <(seq 0 19) --json --out report"
    )
    run = subprocess.run(
        ["bash", "-c", command, sys.executable],
        capture_output=True, text=True, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    ours, theirs = json.loads(run.stdout), json.loads(plain)
    del ours["fingerprint"], theirs["fingerprint"]
    assert ours == theirs
    assert "dev/fd/" in run.stderr
    piped_in = read_session(tmp_path / "report" / "session.toml").pipes
    assert "/dev/stdin" in piped_in
    assert sum(path.startswith("/dev/fd/") for path in piped_in) == 2


def test_the_session_of_a_report_says_what_was_a_pipe_and_so_does_running_it(tmp_path: Path):
    drive(tmp_path)
    truth = (tmp_path / "truth.csv").read_bytes()
    with piped(tmp_path / "pipe", truth) as pipe:
        (name, _, *others) = flags(tmp_path)
        run = nvcore("compare", name, pipe, *others, "--out", tmp_path / "report")
    assert run.exit_code == 0, run.output
    path = tmp_path / "report" / "session.toml"
    session = read_session(path)
    assert session.pipes == session.truth.path == (str(pipe),)
    again = nvcore("compare", path)
    assert again.exit_code == 2
    assert f"{pipe}: was a pipe when the session was written" in again.stderr
    named = path.read_text().replace(f'path = "{pipe}"', f'path = "{tmp_path / "truth.csv"}"')
    path.write_text(named)
    assert nvcore("compare", path).exit_code == 0


def test_a_name_that_no_file_can_have_is_no_pipe():
    assert not pipes.is_pipe(Path("a" * 5000))


def test_an_error_in_a_pipe_names_it_and_the_line(tmp_path: Path):
    drive(tmp_path)
    with piped(tmp_path / "pipe", b"frame,x,y,w,h\n1,1,1,9,9\n2,a,1,9,9\n") as pipe:
        run = nvcore("check", "--truth", pipe, "--x", tmp_path / "fir.csv")
    assert run.exit_code == 2
    assert "pipe, line 3: expected a number as x" in run.stderr


def test_python_reads_a_pipe_anew_at_each_call(tmp_path: Path):
    drive(tmp_path)
    for n_frames in (3, 4):
        lines = "".join(f"{frame},100,200,40,100\n" for frame in range(n_frames))
        with piped(tmp_path / f"pipe{n_frames}", f"frame,x,y,w,h\n{lines}".encode()) as pipe:
            dataset = nv.load(truth=pipe, x=pipe, size=(640, 480), fps=20)
        assert len(dataset.frames) == n_frames
    assert not [*Path(tempfile.gettempdir()).glob("nvcore-pipe-*")]


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="needs files without names")
def test_what_came_through_a_pipe_is_gone_with_the_process_however_it_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    with piped(tmp_path / "pipe", b"content") as pipe, pipes.pipes_kept():
        for _ in range(2):
            with pipes.open_stored(pipe) as stream:
                assert stream.read() == b"content"
        assert [*(tmp_path / "temporary").iterdir()] == []  # a process that is killed leaves none


def test_what_comes_through_a_pipe_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(pipes, "MAX_PIPE_BYTES", 1000)
    with (
        piped(tmp_path / "pipe", b"frame,x,y,w,h\n" + b"1,1,1,9,9\n" * 1000) as pipe,
        pytest.raises(InputError, match="come through this pipe; give a file"),
    ):
        nv.load(truth=pipe, x=pipe, size=(640, 480), fps=20)


def test_a_pipe_that_nobody_keeps_is_refused_and_not_waited_for(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="pipe: is a pipe; expected a file"):
        find_files(Source("pipe"), tmp_path, "truth")


def test_a_device_is_called_so():
    with pytest.raises(InputError, match=r"/dev/null: is a device or a socket; expected a file"):
        find_files(Source("/dev/null"), Path("/"), "truth")
