"""What takes too much ends as an error in words, and nothing else with it."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from contextlib import closing
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from inputs import drive, session_of
from picture_files import number_in, numbered, write_numbered_video, write_picture
from places import ROOT

from nvcore.common.errors import InputError, MediaError, MissingFactError
from nvcore.common.progress import Progress
from nvcore.inputs.load import load
from ui.confined import process as confined
from ui.confined.pictures import PictureProcess
from ui.confined.process import Allowance, Process, call

OOM_SCORE = Path("/proc/self/oom_score_adj")
ENOUGH = Allowance(memory_mb=1000, seconds=300)


def process_id() -> int:
    return os.getpid()


def take(n_mb: int) -> int:
    return len(bytearray(n_mb << 20))


def end() -> None:
    os._exit(3)


def missing() -> None:
    raise MissingFactError("no size", file="a.txt", line=3, facts=("size",))


def test_a_call_is_answered_by_another_process():
    assert call(process_id, allowance=ENOUGH, what="asking") != os.getpid()


def is_loaded(module: str) -> bool:
    return module in sys.modules


def test_what_a_light_meter_needs_is_loaded_before_anybody_waits_for_it():
    assert call(is_loaded, "ui.subjects.driver.confined", allowance=ENOUGH, what="asking")


def test_a_dataset_comes_back_as_it_was_read(tmp_path: Path):
    session = session_of(drive(tmp_path))
    there = call(load, session, allowance=ENOUGH, what="reading")
    assert there.fingerprint == load(session).fingerprint


def large() -> tuple[np.ndarray, np.ndarray, str]:
    return np.arange(4_000_000), np.full(100_001, 0.5), "beside them"


@pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="memory is shared on Linux only")
def test_large_arrays_come_in_shared_memory_and_not_through_the_socket():
    with closing(Process(ENOUGH)) as other:
        numbers, halves, text = other.call(large, what="making")
        assert np.array_equal(numbers, np.arange(4_000_000))
        assert halves.shape == (100_001,)
        assert (halves == 0.5).all()
        assert text == "beside them"
        assert not numbers.flags.writeable  # what is mapped, rather than copied, is read-only
        assert other.call(process_id, what="asking") != os.getpid()  # and it goes on to answer
    assert int(numbers[-1]) == 3_999_999  # the memory outlives the process


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is limited on Linux only")
def test_too_much_memory_is_an_error_in_words():
    small = Allowance(memory_mb=200, seconds=300)
    assert call(take, 50, allowance=small, what="reading") == 50 << 20
    with pytest.raises(InputError, match="reading took more than 200 MB of memory"):
        call(take, 400, allowance=small, what="reading")


@pytest.mark.skipif(not OOM_SCORE.exists(), reason="Linux only")
def test_where_memory_runs_out_the_processes_end_before_the_server():
    theirs = call(OOM_SCORE.read_text, allowance=ENOUGH, what="asking")
    assert int(theirs) == 900 > int(OOM_SCORE.read_text())


def test_too_much_time_and_a_fault_are_errors_in_words():
    with pytest.raises(InputError, match=r"waiting took more than 0\.1 s"):
        call(time.sleep, 1000, allowance=Allowance(1000, 0.1), what="waiting")
    with pytest.raises(InputError, match="reading took too much memory, or ended in a fault"):
        call(end, allowance=ENOUGH, what="reading")


def work(steps: list[float], *, progress: Progress) -> str:
    for share in steps:
        progress(share, f"{share:.0%} done")
    return "done"


def say_nothing(*, progress: Progress) -> None:
    time.sleep(1000)


def test_a_call_tells_its_progress_and_ends_with_who_does_not_want_it():
    told = []
    with_progress = {"what": "working", "progress": lambda *step: told.append(step)}
    assert call(work, [0.25, 0.5], allowance=ENOUGH, **with_progress) == "done"
    assert dict.fromkeys(told) == dict.fromkeys([(0.0, ""), (0.25, "25% done"), (0.5, "50% done")])

    def cancel(*_: object) -> None:
        raise CancelledError

    with closing(Process(ENOUGH)) as process:
        before = process.call(process_id, what="asking")
        with pytest.raises(CancelledError):
            process.call(say_nothing, what="working", progress=cancel)
        assert process.call(process_id, what="asking") != before


def stand_still(*, progress: Progress) -> None:
    for number in range(10):
        progress(0.5, f"try {number}")


def test_a_call_with_progress_may_take_long_but_not_stand_still(monkeypatch: pytest.MonkeyPatch):
    told: set[tuple[float, str]] = set()
    # each step takes 200 s
    clock = SimpleNamespace(monotonic=lambda: 200 * len(told))
    monkeypatch.setattr(confined, "time", clock)

    def tell(*step: float | str) -> None:
        told.add(step)

    steps = [number / 10 for number in range(10)]
    assert call(work, steps, allowance=ENOUGH, what="working", progress=tell) == "done"
    with pytest.raises(InputError, match="working stood still for 300 s, and was stopped"):
        call(stand_still, allowance=ENOUGH, what="working", progress=tell)
    monkeypatch.undo()
    with pytest.raises(InputError, match=r"working stood still for 0\.1 s, and was stopped"):
        call(say_nothing, allowance=Allowance(1000, 0.1), what="working", progress=tell)


def mistake() -> None:
    raise TypeError("'>' not supported")


def no_room() -> None:
    raise OSError(errno.ENOMEM, "cannot map")


def test_a_fault_of_the_program_is_told_as_such():
    words = r"ended in a fault of the program \(TypeError: '>' not"
    with closing(Process(ENOUGH)) as process:
        with pytest.raises(InputError, match=words):
            process.call(mistake, what="reading")
        assert process.call(process_id, what="asking") != os.getpid()


def test_memory_that_the_system_refuses_is_told_as_such():
    with pytest.raises(InputError, match="reading took more than 1000 MB of memory"):
        call(no_room, allowance=ENOUGH, what="reading")


def test_decoders_are_given_no_secret_of_the_servers():
    script = (
        "import subprocess\nfrom ui.confined.process import *\n"
        "print(call(subprocess.getoutput, 'env', allowance=Allowance(1000, 300), what='asking'))"
    )
    secrets = {"NVCORE_METRICS_TOKEN": "a", "NVCORE_LOGIN": "/b", "AWS_SECRET_ACCESS_KEY": "c"}
    known = {"NUMBA_CACHE_DIR": "/tmp/d", "LC_ALL": "C.UTF-8", "TMPDIR": "/tmp"}
    lines = subprocess.run(
        [sys.executable, "-c", script],
        cwd=ROOT,
        env={**os.environ, **secrets, **known},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    names = {line.partition("=")[0] for line in lines}
    assert {*known, "PATH", "PYTHONPATH"} <= names
    assert not set(secrets) & names


def test_a_process_that_cannot_be_started_is_an_error_in_words(monkeypatch: pytest.MonkeyPatch):
    def end_at_once(self: object) -> Connection:
        ours, theirs = Pipe()
        theirs.close()  # as when what it is forked from is killed
        return ours

    monkeypatch.setattr(confined._Nursery, "connect", end_at_once)
    with pytest.raises(InputError, match="no room for another process"):
        call(process_id, allowance=ENOUGH, what="asking")
    with pytest.raises(MediaError, match="no room for another process"):
        PictureProcess().open(Path("a.mp4"))


def test_errors_keep_what_they_say():
    with pytest.raises(MissingFactError) as caught:
        call(missing, allowance=ENOUGH, what="reading")
    error = caught.value
    assert (str(error), error.file, error.line, error.facts) == (
        "a.txt, line 3: no size", "a.txt", 3, ("size",)
    )  # fmt: skip


def test_pictures_are_those_of_the_video(tmp_path: Path):
    with closing(PictureProcess()) as process:
        pictures = process.open(write_numbered_video(tmp_path / "a.mp4"))
        assert (pictures.n, pictures.is_video, pictures.fps) == (100, True, 20.0)
        assert [number_in(pictures.read(index)) for index in (3, 99, 0)] == [3, 99, 0]
        assert pictures.file_names([3]) is None
        with pytest.raises(MediaError, match="there is no picture 100"):
            pictures.read(100)
        with pytest.raises(MediaError, match="no such file"):
            process.open(tmp_path / "b.mp4")
        process.close()
        assert number_in(pictures.read(7)) == 7  # by a new process
        write_picture(tmp_path / "b" / "I07.png", numbered(7))
        assert process.open(tmp_path / "b").file_names([0]) == ["I07.png"]
        pictures.close()


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is limited on Linux only")
def test_a_picture_that_fills_the_memory_ends_neither_the_server_nor_the_others(tmp_path: Path):
    cv2.imwrite(str(tmp_path / "large.png"), np.zeros((5000, 5000, 4), np.uint16))
    cv2.imwrite(str(tmp_path / "small.png"), np.full((20, 30), 9, np.uint8))
    with closing(PictureProcess(Allowance(memory_mb=150, seconds=300))) as process:
        small = process.open(tmp_path / "small.png")
        with pytest.raises(MediaError):
            process.open(tmp_path / "large.png")
        assert small.read(0).tolist() == np.full((20, 30), 9).tolist()


def test_what_is_under_way_ends_with_a_server_that_is_killed():
    script = (
        "import time\nfrom ui.confined.process import *\n"
        "process = Process(Allowance(memory_mb=100, seconds=600))\n"
        "print(process.call(os.getpid, what='asking'), flush=True)\n"
        "process.call(time.sleep, 600, what='waiting')\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], cwd=ROOT, stdout=subprocess.PIPE, text=True
    ) as server:
        number = int(server.stdout.readline())
        assert is_alive(number)
        server.kill()
    deadline = time.monotonic() + 60
    while is_alive(number) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not is_alive(number)


def is_alive(number: int) -> bool:
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(number)], capture_output=True).stdout
    return bool(state.strip()) and not state.startswith(b"Z")
