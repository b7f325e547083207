"""Faults in the middle of a scan, with real processes: what is done stays, the rest completes."""

from __future__ import annotations

import os
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from fleet_runs import (
    PARAMS,
    append_to,
    attempts_of,
    begin_scan,
    files_of,
    hours_later,
    killed_at,
    process,
    quarantine_of,
    small_fleet,
    starved_at,
    stopped_at,
    unpicklable,
    until,
)
from object_store import make_bucket, options, served, troubled

from nvcore.common.errors import InputError, StoreError
from nvcore.subjects.fleet.folder import begin, finish, forget_quarantined, status
from nvcore.subjects.fleet.leases import Lease, seal, unseal
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.on_dask import on_dask
from nvcore.subjects.fleet.plan import Plan
from nvcore.subjects.fleet.scan import Job, Options, drive, in_pool, in_process
from nvcore.subjects.fleet.store import Store

ELSEWHERE = """
import socket, sys
from pathlib import Path
from fleet_runs import begin_scan, stopped_at
from nvcore.subjects.fleet.scan import drive, in_process
store, out, marks = map(Path, sys.argv[1:])
socket.gethostname = lambda: "another machine"
list(drive(begin_scan(store, out, run=stopped_at("r4", marks))[1], in_process))
"""
POOL = """
import sys
from pathlib import Path
from fleet_runs import begin_scan, stopped_at
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.folder import finish
from nvcore.subjects.fleet.scan import in_pool
if __name__ == "__main__":
    store, out, marks = map(Path, sys.argv[1:4])
    plan, job = begin_scan(store, out, run=stopped_at("r4", marks))
    list(in_pool(job, int(sys.argv[4])))
    finish(Location(out), plan)
"""


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Starts a process, which is ended after the test."""
    started: list[subprocess.Popen[bytes]] = []

    def begin(*command: object) -> subprocess.Popen[bytes]:
        started.append(process(*command))
        return started[-1]

    yield begin
    for one in started:
        one.kill()
        one.wait()


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def has_ended(pid: int) -> bool:
    """Also where nobody has asked yet how it ended."""
    try:
        return ") Z " in Path(f"/proc/{pid}/stat").read_text()
    except FileNotFoundError:
        return True


def finished(out: Path, plan: Plan) -> dict[str, bytes]:
    finish(Location(out), plan)
    return files_of(out)


def batch_of(plan: Plan, recording: str) -> str:
    return next(batch.key for batch in plan.batches if recording in batch.recordings)


def test_a_worker_that_is_killed_costs_its_batch_alone(store, undisturbed, out, tmp_path):
    plan, job = begin_scan(store, out, run=killed_at("r4", tmp_path, times=1))
    list(in_pool(job, 2))
    assert finished(out, plan) == undisturbed
    expected = {batch.key: 1 for batch in plan.batches} | {batch_of(plan, "r4"): 2}
    assert attempts_of(out) == expected


def test_workers_that_are_killed_together_do_not_end_the_scan(store, undisturbed, out, tmp_path):
    plan, job = begin_scan(store, out, run=killed_at("", tmp_path, times=2))
    list(in_pool(job, 2))
    assert finished(out, plan) == undisturbed


def test_a_machine_that_does_not_see_the_store_leaves_its_batches(store, undisturbed, out):
    plan, job = begin_scan(store, out)
    elsewhere = Path(store).rename(Path(store).with_name("elsewhere"))
    try:
        for _ in ("before it has read it", "afterwards"):
            with pytest.raises(StoreError, match=r"cannot be read \(it is not there\)"):
                list(drive(job, in_process))
            elsewhere.rename(store)
            batch = batch_of(plan, "r4")
            assert job.run(batch) == "done"
            (out / f"done/{batch}.json").unlink()
            Path(store).rename(elsewhere)
    finally:
        elsewhere.rename(store)
    list(drive(job, in_process))
    assert finished(out, plan) == undisturbed


def test_tasks_that_finish_together_all_succeed(store, undisturbed, out):
    plan, job = begin_scan(store, out)
    list(drive(job, in_process))
    with ThreadPoolExecutor(8) as pool:
        first, *others = pool.map(lambda _: finish(Location(out), plan), range(8))
    assert others == [first] * 7
    assert files_of(out) == undisturbed


def test_an_error_that_does_not_pickle_ends_the_scan_too(store, out):
    _, job = begin_scan(store, out, run=unpicklable)
    with pytest.raises(RuntimeError, match="UnpicklableError: of all"):
        list(in_pool(job, 1))


def test_what_a_worker_prints_does_not_disturb_its_messages(store, out, capfd):
    _, job = begin_scan(store, out, run=print)  # and returns nothing
    with pytest.raises(RuntimeError, match="NoneType"):
        list(in_pool(job, 1))
    printed = capfd.readouterr()
    assert "ScanParams" in printed.err
    assert not printed.out


def test_a_worker_whose_parent_has_died_says_nothing(store, undisturbed, out):
    command = [sys.executable, "-c", "from nvcore.subjects.fleet.scan import work; work()"]
    plan, job = begin_scan(store, out)
    for content in (b"", pickle.dumps((job, 0, 1))):  # it died before it sent the job, and after
        read, write = os.pipe()
        os.close(read)
        with subprocess.Popen(command, stdin=-1, stdout=write, stderr=-1) as worker:
            os.close(write)
            assert worker.stdin
            assert worker.stderr
            os.write(worker.stdin.fileno(), content)
            if not content:
                worker.stdin.close()
            assert worker.stderr.read() == b""
            assert worker.wait() == 0
    assert finished(out, plan) == undisturbed


def test_workers_that_do_not_begin_end_the_scan(store, out, monkeypatch):
    _, job = begin_scan(store, out)
    monkeypatch.setattr("sys.executable", shutil.which("false"))
    with pytest.raises(InputError, match=r"die before they begin \(exit code 1\)"):
        list(in_pool(job, 2))


def test_a_lease_is_written_in_the_order_of_what_is_said(tmp_path, monkeypatch):
    class Watched(Location):
        busy, n_at_once, written = threading.Lock(), 0, b""

        def write(self, path: str, content: bytes) -> None:
            if not self.busy.acquire(blocking=False):
                self.n_at_once += 1
                return
            super().write(path, content)
            self.written = content
            self.busy.release()

    monkeypatch.setattr("nvcore.subjects.fleet.leases.LEASE_S", 1e-4)
    place = Watched(tmp_path)
    with Lease(place, "a", clock=time.time) as lease:
        for number in range(100):
            lease.tell(at=f"r{number}")
    assert place.n_at_once == 0
    assert (unseal(place.written) or {})["ended"] == "done"
    (tmp_path / "leases/a/0001.json").write_bytes(b"")  # of a machine that lost its power
    assert Lease(place, "a", clock=time.time).killed_at == [None]


def test_a_recording_that_kills_its_workers_is_set_aside(store, undisturbed, out, tmp_path):
    plan, job = begin_scan(store, out, run=killed_at("r4", tmp_path, times=99))
    list(in_pool(job, 1))
    deaths = [(tmp_path / f"killed-{i}").read_text() for i in range(5)]
    assert deaths == ["r4 r5", "r4 r5", "r4", "r4", "r4"]
    assert not (tmp_path / "killed-5").exists()
    files = finished(out, plan)
    own = batch_of(plan, "r4")
    others = [name for name in undisturbed if own not in name and "/" in name]
    assert len(others) > len(undisturbed) / 2
    assert all(files[name] == undisturbed[name] for name in others)
    assert quarantine_of(out) == {"r4": "3 workers ended without a word while they compared it"}
    shown = status(Location(out), plan)
    assert (shown.n_frames_done, plan.n_frames) == (11 * 40, 12 * 40)
    assert "440 of 480 frames compared" in str(shown)


def test_a_healthy_recording_that_was_killed_four_times_is_tried_once_more_at_the_end(
    store, undisturbed, out, tmp_path
):
    plan, job = begin_scan(store, out, run=killed_at("r4", tmp_path, times=4))
    batches = list(in_pool(job, 1))
    assert batches[-1] == batch_of(plan, "r4")
    assert finished(out, plan) == undisturbed
    assert quarantine_of(out) == {}


def test_a_scan_that_is_killed_as_a_whole_goes_on_where_it_was(
    store, undisturbed, out, tmp_path, start
):
    scan = start("-c", POOL, store, out, tmp_path, 2)
    until((tmp_path / "stopped").exists, "a worker that stands still")
    until(lambda: len([*(out / "done").glob("*.json")]) >= 5, "all other batches")
    scan.send_signal(signal.SIGKILL)  # the parent alone: its workers end by themselves
    scan.wait()
    worker = int((tmp_path / "stopped").read_text())
    until(lambda: has_ended(worker), "the end of its worker")
    done = {path: path.stat().st_mtime_ns for path in (out / "done").iterdir()}
    plan, job = begin_scan(store, out)
    assert list(drive(job, in_process)) == [batch_of(plan, "r4")]
    assert {path: path.stat().st_mtime_ns for path in done} == done
    assert finished(out, plan) == undisturbed
    assert list(drive(job, in_process)) == []  # there is nothing left


def test_the_batch_of_a_machine_that_died_is_taken_when_its_lease_expires(
    store, undisturbed, out, tmp_path, start
):
    shard = start("-c", ELSEWHERE, store, out, tmp_path)
    until((tmp_path / "stopped").exists, "a worker that stands still")
    shard.kill()
    shard.wait()
    plan, job = begin_scan(store, out)
    batch = batch_of(plan, "r4")
    assert job.run(batch) == "busy"  # nobody knows yet
    assert status(Location(out)).n_running == 1
    late = Options(clock=hours_later)
    assert status(Location(out), clock=late.clock).n_lost == 1
    list(drive(replace(job, options=late), in_process))
    assert finished(out, plan) == undisturbed
    assert attempts_of(out)[batch] == 2


def test_a_worker_that_was_thought_dead_does_no_harm(store, undisturbed, out, tmp_path, start):
    slow = start("-c", ELSEWHERE, store, out, tmp_path)
    until((tmp_path / "stopped").exists, "a worker that stands still")
    plan, job = begin_scan(store, out)
    list(drive(replace(job, options=Options(clock=hours_later)), in_process))
    assert finished(out, plan) == undisturbed
    (tmp_path / "on").touch()
    assert slow.wait() == 0
    assert files_of(out) == undisturbed


def test_two_scans_at_once_share_the_work(store, undisturbed, out, tmp_path, start):
    scans = [start("-c", POOL, store, out, tmp_path, 1)]
    until((tmp_path / "stopped").exists, "the worker of the first, which stands still")
    scans.append(start("-c", POOL, store, out, tmp_path, 1))
    until(lambda: len([*(out / "done").glob("*.json")]) == 5, "all other batches")
    (tmp_path / "on").touch()
    assert [scan.wait() for scan in scans] == [0, 0]
    assert files_of(out) == undisturbed
    assert {*attempts_of(out).values()} == {1}


def test_a_full_disk_ends_the_scan_and_what_is_done_stays(store, undisturbed, out):
    plan, job = begin_scan(store, out, run=starved_at("r4", n_bytes=2000))
    with pytest.raises(StoreError, match="cannot be written"):
        list(in_pool(job, 1))
    done = [*(out / "done").iterdir()]
    assert len(done) == 3
    assert status(Location(out)).n_running == 0
    plan, job = begin_scan(store, out)
    assert len([*drive(job, in_process)]) == len(plan.batches) - 3
    assert finished(out, plan) == undisturbed


def test_damaged_files_cost_their_recordings_alone(tmp_path, out):
    for first, n in ((0, 4), (4, 3)):  # a file each
        append_to(tmp_path / "store", small_fleet(n, first))
    store = tmp_path / "store"
    undamaged, job = begin_scan(store, tmp_path / "other")
    list(drive(job, in_process))
    expected = finished(tmp_path / "other", undamaged)
    damaged = min((store / "boxes").glob("*.parquet"), key=lambda path: path.stat().st_size)
    content = damaged.read_bytes()
    damaged.write_bytes(content[:200] + bytes(len(content) - 400) + content[-200:])
    plan, job = begin_scan(store, out)
    list(drive(job, in_process))
    finished(out, plan)
    reasons = quarantine_of(out)
    assert [*reasons] == ["r4", "r5", "r6"]
    assert all(damaged.name in reason for reason in reasons.values())
    damaged.write_bytes(content)
    forget_quarantined(Location(out), plan)
    list(drive(job, in_process))
    assert finished(out, plan).items() >= expected.items()


def test_a_scan_goes_on_when_the_dask_scheduler_was_restarted(
    store, undisturbed, out, tmp_path, start
):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"

    def cluster() -> list[subprocess.Popen[bytes]]:
        quiet = ("--no-dashboard",)
        at = ("--host", "127.0.0.1", "--port", port)
        alone = ("--no-nanny", "--nthreads", 1, "--local-directory", tmp_path)
        return [
            start("-m", "distributed.cli.dask_scheduler", *at, *quiet),
            start("-m", "distributed.cli.dask_worker", address, *alone, *quiet),
        ]

    killed = cluster()
    plan, job = begin_scan(store, out, run=stopped_at("r4", tmp_path))
    batches = drive(job, partial(on_dask, scheduler=address))
    done = [next(batches) for _ in range(3)]
    until((tmp_path / "stopped").exists, "a worker that stands still")
    for one in killed:
        one.kill()
        one.wait()
    (tmp_path / "on").touch()
    cluster()
    assert {*done, *batches} == {batch.key for batch in plan.batches}
    assert finished(out, plan) == undisturbed
    assert sum(attempts_of(out).values()) == len(plan.batches) + 1


def test_a_server_that_refuses_and_cuts_costs_attempts_alone(store, undisturbed):
    with served() as server, troubled(server) as (address, trouble):
        make_bucket(server, "fleet")
        storage = options(address)
        append_to(Location("s3://fleet/store", storage), small_fleet(4))
        plan, job = begin_scan("s3://fleet/store", "s3://fleet/out", storage=(*storage.items(),))
        list(drive(job, partial(in_pool, n_workers=1)))
        out = Location("s3://fleet/out", storage)
        finish(out, plan)
        files = files_of(out)
        del files["summary.parquet"]
        assert files.items() <= undisturbed.items()
        assert len(files) == 2 * 8
        assert min(trouble["refused"], trouble["cut"]) > 20


def test_other_versions_are_refused(store, out):
    plan, _ = begin_scan(store, out)
    other = replace(plan, programs=plan.programs | {"numba": "0.1"})
    path = out / "plans" / f"{other.key}.json"
    path.write_bytes(other.to_json())
    with pytest.raises(InputError, match=r"numba 0\.1 \(here: .*install these"):
        Job(plan.store, str(out), other.key).run(plan.batches[0].key)
    (out / "newest.json").write_bytes(seal({"plan": other.key}))
    with pytest.raises(InputError, match="compute them anew"):
        begin_scan(store, out)
    begin(Store(store).snapshot(), Location(out), PARAMS, recompute=True)
