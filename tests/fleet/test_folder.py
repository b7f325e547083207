"""Folders of results: no damaged file and no other program gives an answer in silence."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from fleet_runs import PARAMS, append_to, small_fleet
from places import ROOT

import nvcore as nv
from nvcore.cli import main
from nvcore.common.errors import InputError, StoreError
from nvcore.metrics import false_alarms
from nvcore.subjects.fleet import plan
from nvcore.subjects.fleet.calls import Scan
from nvcore.subjects.fleet.folder import begin
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.plan import programs
from nvcore.subjects.fleet.query import worst
from nvcore.subjects.fleet.scan import Job, in_process
from nvcore.subjects.fleet.store import Store

POSITIONS = 2


def scanned(store: str, out: Path) -> Scan:
    return nv.scan(store, out, x="x", y="y", frames_per_batch=1000, engine=in_process)


def answers(out: Path) -> list[pd.DataFrame]:
    return [worst(Location(out), table).table for table in ("encounters", "recordings")]


@pytest.fixture(scope="module")
def results(store: str, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Scan]:
    out = tmp_path_factory.mktemp("results") / "out"
    return out, scanned(store, out)


def one_of_each_kind(out: Path) -> Iterator[Path]:
    kinds: set[tuple[str, ...]] = set()
    for path in sorted(out.rglob("*")):
        kind = path.relative_to(out).parts[:-1] or (path.name,)
        if path.is_file() and kind not in kinds:
            kinds.add(kind)
            yield path.relative_to(out)


def test_a_changed_byte_is_found_and_its_batch_is_computed_anew(store, results, tmp_path):
    out, first = results
    expected, known = answers(out), str(first.status)
    rng = np.random.default_rng(0)
    for path in one_of_each_kind(out):
        content = (out / path).read_bytes()
        for place in rng.integers(len(content), size=POSITIONS if len(content) else 0):
            copy = tmp_path / "copy"
            shutil.copytree(out, copy)
            flipped = content[place] ^ (1 << rng.integers(8))
            (copy / path).write_bytes(content[:place] + bytes([flipped]) + content[place + 1 :])
            asked: list[pd.DataFrame] = []
            with suppress(InputError, StoreError):  # which names the file
                asked = answers(copy)
                assert str(nv.scan_status(copy)).replace(str(copy), str(out)) == known
            # the logs are for other programs: one that cannot be read has to be deleted
            with suppress(*[StoreError] if "_delta_log" in path.parts else []):
                again = scanned(store, copy)
                assert again.summary == first.summary, path
                asked += answers(copy)
            for table, right in zip(asked, expected * 2, strict=False):
                assert table.equals(right), path
            shutil.rmtree(copy)


def test_a_damaged_table_is_named_by_top_and_by_the_scan_that_mends_it(store, results, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(results[0], out)
    damaged = next((out / "encounters").glob("*.parquet"))
    damaged.write_bytes(damaged.read_bytes()[:-1])
    with pytest.raises(InputError, match=rf"{damaged.name}: is missing or damaged; run the scan"):
        answers(out)
    plan = next((out / "plans").iterdir())
    content = plan.read_bytes()
    plan.write_bytes(content[:-1])
    with pytest.raises(InputError, match=rf"plans/{plan.name}: is missing or damaged"):
        nv.export_recording(out, "r0", tmp_path / "one")
    plan.write_bytes(content)
    again = scanned(store, out)
    assert len(again.notes) == 1
    assert f"note: computed anew: {damaged}: is missing or damaged" in str(again)
    assert damaged.read_bytes() == (results[0] / "encounters" / damaged.name).read_bytes()


def test_recordings_that_are_left_out_have_the_exit_code_1(tmp_path):
    fleet = small_fleet(3)
    horizon = fleet.recordings["horizon"].where(fleet.recordings["name"] != "r1")
    facts = fleet.recordings.assign(horizon=horizon)
    store = append_to(tmp_path / "store", replace(fleet, recordings=facts))
    out = str(tmp_path / "out")
    scan = ["scan", store, "--x", "x", "--y", "y", "--out", out, "--proximity", "horizon"]
    for command in ([*scan, "--shard", "1/1"], ["scan", "--status", out]):
        done = CliRunner().invoke(main, command)
        assert done.exit_code == 1, done.output
        assert "80 of 120 frames compared" in done.output
        assert "1 recording in quarantine (table quarantine), such as r1" in done.output


def test_batches_of_another_program_are_refused_or_computed_anew(store, tmp_path, monkeypatch):
    """One constant of a module that a batch imports is another; then only words about it are."""
    out, module, find_source = Location(tmp_path / "out"), tmp_path / "module.py", plan._source_of
    text = Path(false_alarms.__file__).read_text()

    def find(name: str) -> Path | None:
        return module if name == false_alarms.__name__ else find_source(name)

    def missing(code: str, **options: bool) -> list[str]:
        module.write_text(code)
        monkeypatch.setattr(plan, "programs", cache(programs.__wrapped__))
        snapshot = Store(store).snapshot()
        made = begin(snapshot, out, PARAMS, frames_per_batch=100, **options)
        return Job(made.store, out.uri, made.key).missing()

    monkeypatch.setattr(plan, "_source_of", find)
    batches = missing(text)
    assert len(batches) == 6
    for batch in batches:
        out.write(f"done/{batch}.json", b"{}")
    words = '"""Other words."""\n# and a comment\n'
    assert missing(words + text[text.index("from __future__") :]) == []
    with pytest.raises(InputError, match=r"begun with another nvcore \(its code differs\)"):
        missing(text + "\nANOTHER = 1\n")
    assert len({*missing(text + "\nANOTHER = 1\n", recompute=True)} - {*batches}) == 6


def test_all_modules_that_a_batch_imports_are_part_of_its_key(store):
    script = (
        "import sys\n"
        "from nvcore.subjects.fleet.batch import scan_batch\n"
        "from nvcore.subjects.fleet.results import ScanParams\n"
        "from nvcore.subjects.fleet.store import Store\n"
        "from nvcore.settings.params import Params\n"
        "store = Store(sys.argv[1]).snapshot()\n"
        "for given in ({}, dict(alerts='policy', driver_weighting='on', proximity='horizon')):\n"
        "    scan = ScanParams('x', 'y', params=Params(**given), frames=True)\n"
        "    scan_batch(store.read(['r0', 'r1'], scan.sources), scan)\n"
        "imported = {name for name in sys.modules if name.startswith('nvcore')}\n"
        "from nvcore.subjects.fleet.plan import modules_of_batches\n"
        "print(sorted(imported - {*modules_of_batches()}))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, store], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
