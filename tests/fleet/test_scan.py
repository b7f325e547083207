"""Scans: what is planned, and that whoever runs it makes the same files."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from click.testing import CliRunner
from fleet_runs import (
    PARAMS,
    append_to,
    attempts_of,
    begin_scan,
    broken_at,
    compiled_in,
    failures_of,
    files_of,
    quarantine_of,
    small_fleet,
    table_of,
)

from nvcore.cli import main
from nvcore.common.errors import InputError
from nvcore.comparison.compare import compare
from nvcore.settings.params import Params
from nvcore.subjects.fleet.folder import finish, status
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.plan import plan
from nvcore.subjects.fleet.scan import drive, in_pool, in_process
from nvcore.subjects.fleet.store import Store


def test_processes_make_the_same_files_and_compile_nothing(store, undisturbed, tmp_path):
    out = tmp_path / "out"
    its_plan, job = begin_scan(store, out, run=compiled_in(tmp_path))
    batches = list(in_pool(job, 2))
    assert {*batches} == {batch.key for batch in its_plan.batches}
    finish(Location(out), its_plan)
    assert files_of(out) == undisturbed
    compiled = [path.read_text().split() for path in tmp_path.glob("compiled-*")]
    assert compiled
    for n_compiled, n_loaded in compiled:
        assert int(n_compiled) == 0  # by this process, for the fixture
        assert int(n_loaded) > 0


def test_a_script_of_a_few_lines_scans_with_several_processes(store, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import nvcore as nv\n"
        f"done = nv.scan({str(store)!r}, {str(tmp_path / 'out')!r}, x='x', y='y', frames=True,\n"
        "               workers=2, frames_per_batch=400)\n"
        "print(done.summary.recordings, __file__)\n"
    )
    ended = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout == f"12 {script}\n"  # once: no worker runs it


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
    done = next((tmp_path / "done").iterdir())
    content = done.read_bytes()
    done.write_bytes(b"")  # of a machine that lost its power
    assert job.missing() == [done.stem]
    list(drive(job, in_process))
    assert done.read_bytes() == content


def test_recordings_that_fail_are_set_aside_with_the_reason(store, undisturbed, tmp_path):
    its_plan, job = begin_scan(store, tmp_path, run=broken_at(["r3", "r8"]))
    list(drive(job, in_process))
    summary = finish(Location(tmp_path), its_plan)
    assert (summary.recordings, summary.quarantined) == (10, 2)
    assert quarantine_of(tmp_path) == {
        name: f"ZeroDivisionError: of {name}" for name in ("r3", "r8")
    }
    files = files_of(tmp_path)
    others = [name for name in undisturbed if name.startswith("encounters/") and name in files]
    assert len(others) == len(its_plan.batches) - 2
    assert {*attempts_of(tmp_path).values()} == {1}
    assert failures_of(tmp_path) == {*quarantine_of(tmp_path).values()}
    shown = str(status(Location(tmp_path), its_plan))
    assert "2 recordings in quarantine (table quarantine), such as r" in shown
    assert ": ZeroDivisionError: of r" in shown


def test_a_fault_of_the_program_is_not_put_upon_the_recordings(store, tmp_path):
    _, job = begin_scan(store, tmp_path, run=broken_at([f"r{number}" for number in range(12)]))
    with pytest.raises(ZeroDivisionError):
        list(drive(job, in_process))
    assert not (tmp_path / "done").exists()


def keys_of(store: Path, frames_per_batch: int = 400) -> list[str]:
    snapshot = Store(Location(store)).snapshot()
    return [
        batch.key for batch in plan(snapshot, PARAMS, frames_per_batch=frames_per_batch).batches
    ]


def test_what_was_added_or_changed_leaves_the_other_batches_as_they_were(tmp_path):
    fleet = small_fleet(120)
    append_to(tmp_path, fleet)
    before = keys_of(tmp_path)
    assert len(before) > 12
    append_to(tmp_path, small_fleet(10, first=120))
    added = keys_of(tmp_path)
    assert added[: len(before) - 1] == before[:-1]
    # detections of one recording are new
    boxes = fleet.boxes.assign(w=fleet.boxes["w"] + (fleet.boxes["source"] == 1))
    append_to(tmp_path, replace(fleet, boxes=boxes).only(names="r40"))
    again = keys_of(tmp_path)
    assert len({*added} - {*again}) == 1
    # a recording is another, and so comes last
    name = fleet.recordings["name"]
    slower = fleet.recordings.assign(fps=fleet.recordings["fps"].where(name != "r40", 5.0))
    append_to(tmp_path, replace(fleet, recordings=slower).only(names="r40"))
    assert len({*again} - {*keys_of(tmp_path)}) <= 4


def test_recordings_that_a_system_lacks_are_left_out_and_counted(tmp_path):
    append_to(tmp_path, small_fleet(3))
    append_to(tmp_path, small_fleet(2, first=3), without="y")
    made = plan(Store(Location(tmp_path)).snapshot(), PARAMS)
    assert made.left_out == {"y": 2}
    assert [batch.recordings for batch in made.batches] == [("r0", "r1", "r2")]


def test_the_tables_are_those_of_the_scan_that_was_begun_last(store, undisturbed, tmp_path):
    out = Location(tmp_path)
    its_plan, job = begin_scan(store, tmp_path)
    list(drive(job, in_process))
    finish(out, its_plan)
    strict = replace(PARAMS, params=Params(low=0.01))
    other, other_job = begin_scan(store, tmp_path, strict)
    assert status(out).n_done == 0
    list(drive(other_job, in_process))
    finish(out, other)
    n_intervals = len(table_of(tmp_path, "intervals"))
    finish(out, its_plan)  # a process that comes late
    assert len(table_of(tmp_path, "intervals")) == n_intervals
    begin_scan(store, tmp_path)  # asked for again: nothing is to be done
    assert job.missing() == []
    finish(out, its_plan)
    assert len(table_of(tmp_path, "intervals")) > n_intervals
    assert files_of(tmp_path).items() >= undisturbed.items()
    for log in (tmp_path / "intervals/_delta_log").glob("*.json"):  # readers may mind the order
        actions = [json.loads(line) for line in log.read_text().splitlines()]
        added, removed = (
            {of[kind]["path"] for of in actions if kind in of} for kind in ("add", "remove")
        )
        assert not added & removed
    (tmp_path / "newest.json").write_bytes(b"")  # of a machine that failed
    with pytest.raises(InputError, match="there is no scan"):
        status(out)
    begin_scan(store, tmp_path)
    assert status(out).is_finished


def test_the_command_scans_and_says_how_far_it_is(store, tmp_path):
    out = str(tmp_path / "out")
    arguments = ("--x", "x", "--y", "y", "--out", out)
    done = CliRunner().invoke(main, ["scan", store, *arguments, "--shard", "2/3"])
    assert done.exit_code == 0, done.output
    expected = f"x and y of {store}: 1 of 1 batch done, 480 of 480 frames compared"
    assert expected in done.output
    assert CliRunner().invoke(main, ["scan", "--status", out]).output.strip() == expected
    result = compare(small_fleet())
    assert re.search(rf"false alarms +{int(result.x.false_alarms.sum())} ", done.output)
    refused = CliRunner().invoke(main, ["scan", store, *arguments, "--shard", "4/3"])
    assert refused.exit_code == 2
    assert "expected a part such as 17/300" in refused.output
    refused = CliRunner().invoke(main, ["scan", store, *arguments, "--shard", "1/3", "--retry"])
    assert refused.exit_code == 2
    assert "each task would undo what others have done" in refused.output
    into_itself = CliRunner().invoke(main, ["scan", store, *arguments[:4], "--out", store])
    assert "is a store" in into_itself.output
