"""``nvcore top`` and ``nvcore open``: from a scan to its worst moment in the dashboard."""

from __future__ import annotations

import shlex
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pytest
from inputs import nvcore
from places import SAMPLE

import nvcore as nv
from nvcore.common.errors import InputError
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.fleet.folder import begin
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.results import ScanParams, schema, typed
from nvcore.subjects.fleet.store import Store
from nvcore.tables.result import encounters_table


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a store, and below it the results of a scan."""
    folder = tmp_path_factory.mktemp("fleet")
    nv.ingest(SAMPLE, store=folder)
    nv.ingest(SAMPLE, store=folder / ".." / "store")
    nv.scan(folder, folder / "night", x="FIR", y="NIR", params=nv.Params(alpha=0.8), shard="0/1")
    return folder


def test_the_command_of_the_worst_moment_opens_it_with_the_numbers_of_the_scan(
    fleet: Path, tmp_path: Path
):
    # the results are found below the store
    shown = nvcore("top", fleet, "--where", "tag.night and n_frames > 10", "-n", 3).stdout
    lines = shown.splitlines()
    assert len(lines) == 4
    worst = nv.top(fleet / "night", where="tag.night and n_frames > 10").table.iloc[0]
    command = shlex.split(lines[1].partition(" nvcore ")[2])
    assert command == ["open", f"{fleet}/night", worst["recording"], "--at", str(worst["frame"])]
    nvcore(*command[:3], "--out", tmp_path / "one")
    result = nv.compare(nv.load(tmp_path / "one" / "session.toml")).result
    assert result.params.alpha == 0.8
    own = encounters_table(result)
    scanned = nv.top(fleet / "night", where=f"recording = '{worst['recording']}'", n=1000).table
    columns = pa.schema([schema("encounters").field(name) for name in own if name != "aspect_z"])
    ours, theirs = (typed(of.sort_values("track"), columns) for of in (own, scanned))
    assert ours.equals(theirs)


def test_top_and_open_show_the_scan_that_was_finished_last(tmp_path: Path):
    store, out = tmp_path / "store", tmp_path / "out"
    nv.ingest(SAMPLE, store=store)
    first = nv.scan(nv.open_store(store), out, x="FIR", y="NIR", frames=True, shard="0/1")
    assert len(nv.top(out, table="frames", n=3).table) == 3
    params = nv.Params(alpha=0.6)
    swapped = nv.scan(store, out, x="NIR", y="FIR", params=params, shard="0/1")
    assert "\nwith alpha 0.6\n" in str(swapped)
    assert "\nwith the settings by default\n" in str(first)
    assert [str(of).split()[:2] for of in (first, swapped)] == [["FIR", "NIR"], ["NIR", "FIR"]]
    with pytest.raises(InputError, match="no such table of results; is the scan finished"):
        nv.top(out, table="frames")  # of the first one
    begin(
        Store(store).snapshot(),
        Location(out),
        ScanParams("FIR", "NIR", params=nv.Params(alpha=0.7)),
    )
    opened = nv.load(nv.export_recording(out, "rural_road", tmp_path / "one"))
    assert opened.compared() == ("NIR", "FIR")
    assert opened.params_of().alpha != 0.7
    assert nv.scan_status(out).plan.params.params.alpha == 0.7


def test_open_starts_the_dashboard_on_that_recording_at_that_frame(
    fleet: Path, monkeypatch: pytest.MonkeyPatch
):
    served = []

    def serve(given: list[str], *, port: int, **more: Any) -> None:
        session = read_session(Path(given[0].removeprefix("--session=")))
        served.append((nv.load(session), port))
        assert more == {"address": "localhost", "no_browser": True}

    monkeypatch.setattr(import_module("nvcore.subjects.fleet.commands"), "serve", serve)
    systems = ("--x", "NIR", "--y", "FIR")
    shown = nvcore("open", fleet, "rural_road", "--at", 228, "--no-browser", *systems)
    [(dataset, port)] = served
    assert dataset.recordings["name"].tolist() == ["rural_road"]
    assert dataset.compared() == ("NIR", "FIR")
    link = f"http://localhost:{port}/timeline?recording=rural_road&frame=228"
    assert link in shown.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["open", "{fleet}/night", "rural_raod", "--out", "x"], "did you mean 'rural_road'"),
        (["open", "{fleet}", "rural_road", "--out", "x"], "expected two systems to compare, found"),
        (["open", "{fleet}", "rural_road", "--out", "x", "--at", "3"], "--out starts nothing"),
        (["top", "{fleet}/sources"], "expected results of a scan that is finished, found none"),
        (["top", "{fleet}/../store"], "that is finished, found a store; scan it first"),
    ],
)
def test_what_is_not_there_is_an_error_that_helps(fleet: Path, arguments: list[str], message: str):
    ended = nvcore(*(of.format(fleet=fleet) for of in arguments))
    assert ended.exit_code == 2
    assert message in ended.output


def test_the_rows_are_written_as_csv_with_all_columns(fleet: Path, tmp_path: Path):
    file = tmp_path / "a.csv"
    nvcore("top", fleet, "--table", "intervals", "--by", "min_similarity", "--out", file)
    table = pd.read_csv(file)
    assert table["min_similarity"].is_monotonic_increasing
    assert {*schema("intervals").names} <= {*table}
    assert (table["frame"] == table["worst_frame"]).all()
