"""A recording of a store as a session: the same numbers as in the scan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from builders import Box, Place, make_dataset
from fleet_tables import Tables, only
from published import load_kaist
from scenes import draw_scene

from nvcore.common.errors import InputError
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.dataset.schema import ATTRIBUTE_DTYPES, conform
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.settings.params import Params
from nvcore.subjects.fleet.batch import dataset_of, scan_batch
from nvcore.subjects.fleet.ingest import tables_of
from nvcore.subjects.fleet.opening import FILES, write_recording
from nvcore.subjects.fleet.results import ScanParams, typed
from nvcore.tables import result as made_by

TABLES = ("recordings", "encounters", "events", "intervals", "frames")


def full_of_facts() -> Dataset:
    """A recording of which everything is known that a store holds, in odd frames."""
    rng = np.random.default_rng(3)
    scene = draw_scene(4, has_tracks=True)
    frames = np.array(scene.places[0].frames)
    number = dict(zip(frames.tolist(), (7 + 3 * np.arange(len(frames))).tolist(), strict=True))
    truth, x, y = (
        [
            box._replace(
                frame=number[box.frame],
                recording=0,
                label=-1 if boxes is scene.y or box.ignore else int(rng.integers(0, 2)),
                detectability=float(rng.random()) if boxes is scene.truth else np.nan,
            )
            for box in boxes
            if box.recording == 0
        ]
        for boxes in (scene.truth, scene.x, scene.y)
    )
    place = scene.places[0]._replace(frames=[*number.values()], horizon=41.5, context=0.25)
    dataset = make_dataset(truth, x, y, places=[place], labels=("adult", "child"))
    n_truth, n = len(dataset.truth), len(dataset.boxes)
    is_truth = np.arange(n) < n_truth
    words = np.array(["with dog", "crossing; =1"], object)
    texts = {"line": np.arange(0, n_truth, 2), "attributes": np.resize(words, (n_truth + 1) // 2)}
    speed_kmh = np.where(np.arange(len(frames)) < 2, np.nan, 30 + rng.random(len(frames)))
    return replace(
        dataset,
        recordings=dataset.recordings.assign(
            name='../"it\'s" \u00fc',
            unit="car 1",
            tags=pd.Series([("night", "road=rural")], dtype=object),
        ),
        boxes=dataset.boxes.assign(
            line=np.arange(n),
            detectability_sd=np.where(is_truth, rng.random(n), np.nan),
            is_outside=is_truth & (rng.random(n) < 0.5),
            is_adapted=is_truth & (rng.random(n) < 0.5),
        ),
        frames=dataset.frames.assign(speed_kmh=speed_kmh),
        attributes=conform(texts, ATTRIBUTE_DTYPES, n_rows=len(texts["line"])),
    )


def assert_opens_as_scanned(tables: Tables, params: ScanParams, folder: Path) -> Dataset:
    scanned = scan_batch(tables, params)
    session = read_session(write_recording(dataset_of(tables, params), folder))
    with pytest.raises(InputError, match="exists; name another folder"):
        write_recording(dataset_of(tables, params), folder)
    opened = load(session)
    assert not opened.findings
    assert not len(opened.left_out)
    result = compare(opened)
    for table in TABLES:
        known = getattr(made_by, f"{table}_table")(result)
        for column in known.columns.intersection(scanned[table].column_names):
            field = pa.schema([scanned[table].schema.field(column)])
            again = typed(known, field)[column].combine_chunks()
            assert again.equals(scanned[table][column].combine_chunks()), (table, column)
    return opened


@pytest.mark.parametrize(
    "settings",
    [Params(), Params(driver_weighting="on", match_class="same", alpha=0.7, threshold_y=0.4)],
)
def test_a_recording_opens_with_all_that_the_store_knows_of_it(tmp_path, settings):
    params = ScanParams("x", "y", params=settings, frames=True)
    dataset = full_of_facts()
    own = replace(dataset.settings, params=Params(threshold_x=0.25))
    tables = tables_of(dataset.with_settings(own))
    opened = assert_opens_as_scanned(tables, params, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*FILES}
    [recording] = opened.recordings.to_dict("records")
    assert recording["name"] == '../"it\'s" \u00fc'
    assert (recording["unit"], recording["tags"]) == ("car 1", ("night", "road=rural"))
    assert opened.settings.params.threshold_x == 0.25


def test_recordings_open_as_scanned_with_pictures_where_there_are_any(tmp_path):
    session = Path(__file__).parents[2] / "sample_data" / "session.toml"
    tables = tables_of(load(read_session(session).of_all))
    params = ScanParams("FIR", "NIR", frames=True)
    for name in tables["recordings"]["recording"].to_pylist()[:2]:
        part = only(tables, [name])
        assert_opens_as_scanned(part, params, tmp_path / name)
        data = dataset_of(part, params)
        file = write_recording(data, tmp_path / name, pictures="/videos/a.mp4", force=True)
        assert read_session(file).recordings[0].pictures == "/videos/a.mp4"


@pytest.mark.realdata
def test_a_real_recording_opens_as_scanned(tmp_path, realdata):
    dataset = load_kaist(realdata)
    tables = tables_of(dataset)
    params = ScanParams(*dataset.systems[:2], frames=True)
    name = tables["recordings"]["recording"][0].as_py()
    assert_opens_as_scanned(only(tables, [name]), params, tmp_path)


def test_a_recording_without_truth_opens_and_one_without_frames_is_refused(tmp_path):
    alarm = Box(3, 10, 10, 5, 20, score=0.5)
    dataset = make_dataset([], [alarm], [], places=[Place(range(5)), Place([])])
    tables, params = tables_of(dataset), ScanParams("x", "y", frames=True)
    assert_opens_as_scanned(only(tables, ["r0"]), params, tmp_path)
    with pytest.raises(InputError, match="recording 'r1' has no evaluated frame"):
        write_recording(dataset_of(only(tables, ["r1"]), params), tmp_path)
