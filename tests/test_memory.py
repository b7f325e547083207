"""Frames that take more memory than there is are refused before they take it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from inputs import drive, session_of

from nvcore.common import memory
from nvcore.common.errors import InputError
from nvcore.common.memory import check_room, free_bytes
from nvcore.inputs.load import load


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A machine with 8 GB free, of which this process has 40 kB of memory."""
    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/meminfo").write_text("MemAvailable:  7000000 kB\nSwapFree: 1000000 kB\n")
    (tmp_path / "proc/self/statm").write_text("100 10 5 1 0 9 0\n")
    return tmp_path


def limit(machine: Path, file: str, text: str) -> None:
    path = machine / "sys/fs/cgroup" / file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def test_more_frames_than_there_is_room_for_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = session_of(drive(tmp_path), frames="0:3999999")
    monkeypatch.setattr(memory, "free_bytes", lambda: 1_500_000_000)
    with pytest.raises(InputError, match=r"8,000,000 evaluated .* about 4\.0 GB .* 1\.5 GB are"):
        load(session)


def test_many_frames_without_boxes_are_refused_however_much_memory_is_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    session = session_of(drive(tmp_path), frames="1:9999999")
    monkeypatch.setattr(memory, "free_bytes", lambda: 10**12)
    with pytest.raises(InputError, match=r"19,999,998 evaluated frames, but only \d+ boxes"):
        load(session)


def test_an_hour_of_frames_and_what_is_not_known_are_let_through(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(memory, "free_bytes", lambda: 0)
    check_room(108_000, 0)
    monkeypatch.setattr(memory, "free_bytes", lambda: None)
    check_room(10**9, 10**6)


def test_the_least_of_all_limits_holds(machine: Path):
    assert free_bytes(machine) == 8_000_000 * 1024
    limit(machine, "memory.max", "max\n")
    limit(machine, "memory/memory.limit_in_bytes", "9223372036854771712\n")
    assert free_bytes(machine) == 8_000_000 * 1024
    limit(machine, "system.slice/nvcore.service/memory.max", "2000000000\n")
    (machine / "proc/self/cgroup").write_text("0::/system.slice/nvcore.service\n")
    assert 1_999_000_000 < free_bytes(machine) < 2_000_000_000
    limit(machine, "memory.max", "1000000000\n")
    assert 999_000_000 < free_bytes(machine) < 1_000_000_000


def test_where_nothing_is_known_nothing_is_said(tmp_path: Path):
    assert free_bytes(tmp_path) is None


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="of Linux")
def test_a_limit_of_the_shell_counts():
    script = (
        "import resource\nfrom nvcore.common.memory import free_bytes\n"
        "resource.setrlimit(resource.RLIMIT_AS, (10**9, 10**9))\nprint(free_bytes())\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert 0 < int(done.stdout) < 10**9
