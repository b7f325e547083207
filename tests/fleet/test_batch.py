"""Batches: the same numbers however recordings are put together, and those of `compare`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from approach import approach
from builders import NAN, Box, Place, make_dataset
from fleet_tables import Tables, assert_same, joined, only
from places import SAMPLE
from scenes import draw_scene

from nvcore.common.errors import InputError, ParameterError
from nvcore.comparison.compare import compare
from nvcore.comparison.measures.table import MEASURES, hides_rate
from nvcore.dataset import Dataset
from nvcore.dataset.schema import ATTRIBUTE_DTYPES, conform
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.inputs.session.toml import read_session
from nvcore.settings.params import Params
from nvcore.subjects.fleet import batch
from nvcore.subjects.fleet.batch import ScanParams, dataset_of, scan_batch
from nvcore.subjects.fleet.ingest import tables_of
from nvcore.subjects.fleet.results import Summary, typed
from nvcore.tables.result import (
    encounters_table,
    episodes_table,
    events_table,
    frames_table,
    intervals_table,
    recordings_table,
)

SCAN = ScanParams("x", "y", frames=True)
MADE_BY = {
    "recordings": recordings_table,
    "encounters": encounters_table,
    "events": events_table,
    "intervals": intervals_table,
    "episodes": episodes_table,
    "frames": frames_table,
}
SETTINGS = [
    Params(),
    Params(
        proximity="distance", missing_distance="borrow", pairing="matched", saliency_of="each",
        saliency_weight="risk", saliency_scope="encounter", saliency_aggregate="sum", window=3,
    ),
    Params(alerts="policy", driver_weighting="on", match="lateral", match_class="same", alpha=0.6),
]  # fmt: skip


def fleet(n_scenes: int = 5) -> Dataset:
    """Drawn scenes, an approach, a copy of it, a recording without truth and an empty one.

    Classes, attributes and detectability are known in some of the recordings only.
    """
    rng = np.random.default_rng(5)
    places: list[Place] = []
    sources: tuple[list[Box], ...] = ([], [], [])
    for seed in range(n_scenes):
        scene = draw_scene(seed, has_tracks=seed % 3 > 0)
        for boxes, own in zip(sources, (scene.truth, scene.x, scene.y), strict=True):
            boxes += [
                box._replace(
                    recording=box.recording + len(places),
                    label=int(rng.integers(-1, 2)) if seed % 2 else -1,
                    detectability=float(rng.random()) if seed in (2, 4) else NAN,
                )
                for box in own
            ]
        places += scene.places
    road = Place(range(40), horizon=40.0)
    for recording in (len(places), len(places) + 1):
        for boxes, shown in zip(sources, (range(40), range(20, 40), range(35, 40)), strict=True):
            drawn = approach(shown, 5, recording=recording)
            boxes += (
                [box._replace(detectability=0.2) for box in drawn] if boxes is sources[0] else drawn
            )
            boxes += approach(shown, 6, recording=recording, centre=20, track=2)
    sources[1].append(Box(3, 10, 10, 5, 20, score=0.5, recording=len(places) + 2))
    places += [road, road, Place(range(5)), Place([])]
    dataset = make_dataset(*sources, places=places, labels=("adult", "child"), is_independent=False)
    lines = np.arange(len(dataset.truth))
    words = np.array(["child", "with dog", "child; crossing"], dtype=object)[lines % 3]
    has_text = dataset.frames["recording"].to_numpy()[dataset.truth.frame_index] % 4 == 1
    texts = {"line": lines[has_text], "attributes": words[has_text]}
    speed_kmh = np.where(dataset.frames["recording"] % 3 == 0, 30.0, np.nan)
    return replace(
        dataset,
        boxes=dataset.boxes.assign(line=np.arange(len(dataset.boxes))),
        attributes=conform(texts, ATTRIBUTE_DTYPES, n_rows=int(has_text.sum())),
        frames=dataset.frames.assign(speed_kmh=speed_kmh),
    )


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return fleet()


@pytest.fixture(scope="module")
def tables(dataset: Dataset) -> Tables:
    return tables_of(dataset)


def chunks(names: Sequence[str], size: int) -> Iterator[Sequence[str]]:
    for start in range(0, len(names), size):
        yield names[start : start + size]


def summary_of(results: Tables, params: ScanParams = SCAN) -> Summary:
    return Summary.of(results["recordings"], len(results["quarantine"]), params)


def assert_batches_agree(tables: Tables, params: ScanParams) -> Tables:
    """All at once, some by themselves, by threes and shuffled: the same bytes. Returns all."""
    whole = scan_batch(tables, params)
    names = tables["recordings"]["recording"].to_pylist()
    shuffled = np.random.default_rng(1).permutation(names).tolist()
    alone = sorted(names)[::4]
    groups = [[name] for name in alone]
    groups += chunks([name for name in shuffled if name not in alone], 3)
    parts = [scan_batch(only(tables, of), params) for of in groups]
    assert_same(joined(parts), whole)
    return whole


def assert_as_compared(whole: Tables, dataset: Dataset, params: Params) -> None:
    """Each recording to the bit as compared by itself, measures to 1e-12 as of all together."""
    for name in dataset.recordings["name"]:
        result = compare(dataset.only(names=name), params)
        for table, make in MADE_BY.items():
            known = make(result)
            own = whole[table].filter(pa.compute.equal(whole[table]["recording"], name))
            if table == "encounters":  # without children by stature, who need all recordings
                alone = compare(replace(dataset.only(names=name), each_alone=True), params)
                known["classes"] = encounters_table(alone)["classes"]
                del known["aspect_z"]
            for column in known.columns:
                expected = typed(known, pa.schema([own.schema.field(column)]))[column]
                assert own[column].combine_chunks().equals(expected.combine_chunks()), column
    result = compare(dataset, params)
    summary = summary_of(whole)
    measures = summary.measures().set_index("key")
    of_system = {measure.key: measure.of for measure in MEASURES if measure.of is not None}
    left_out = {"percentile_5_similarity", "median_margin_s", "median_alert_lead_s"}
    left_out |= {"worst_window_lost_s", "detections_without_distance"}
    left_out |= {measure.key for measure in MEASURES if hides_rate(measure, result.duration_s)}
    assert {key for key in of_system if key not in measures.index} <= left_out | {
        measure.key for measure in MEASURES if measure.only_if and not measure.only_if.holds(result)
    }
    for key in measures.index.intersection([*of_system]):
        for letter, system in result.sides:
            value = of_system[key](result, system)
            assert measures.loc[key, letter] == pytest.approx(value, rel=1e-12, nan_ok=True), key
    assert summary.totals["boxes_both"] == result.boxes.both
    assert summary.total("n_frames") == len(dataset.frames)
    assert summary.total("duration_s") == pytest.approx(result.duration_s, rel=1e-12)


@pytest.mark.parametrize("params", SETTINGS)
def test_the_same_bytes_however_recordings_are_put_together(
    dataset: Dataset, tables: Tables, params: Params
):
    whole = assert_batches_agree(tables, replace(SCAN, params=params))
    assert len(whole["quarantine"]) == 0
    assert min(len(whole[name]) for name in MADE_BY) > 5
    assert_as_compared(whole, dataset, params)


def test_nothing_is_said_of_an_encounter_that_needs_all_recordings():
    dataset = load(read_session(SAMPLE))
    table = encounters_table(compare(dataset))
    assert table["classes"].str.contains("child").sum() == 3
    assert table["aspect_z"].notna().all()
    scan = ScanParams(*dataset.systems[:2])
    encounters = scan_batch(tables_of(dataset), scan)["encounters"].to_pandas()
    assert len(encounters) == len(table)
    assert not encounters["classes"].str.contains("child").any()
    assert "aspect_z" not in encounters


def test_a_summary_is_the_same_in_any_order_of_recordings(tables: Tables):
    results = scan_batch(tables, SCAN)
    values = [0.1, 1e300, -1e300, 5e-324]
    table = results["recordings"].slice(0, 4)
    place = table.schema.get_field_index("severity_s_x")
    table = table.set_column(place, "severity_s_x", pa.array(values))
    summary = Summary.of(table, 0, SCAN)
    assert summary.totals["severity_s_x"] == 0.1
    assert Summary.of(table.take([2, 0, 3, 1]), 0, SCAN) == summary


def test_thresholds_are_those_of_each_recording_unless_they_are_given(tables: Tables):
    names = tables["recordings"]["recording"].to_pylist()
    sources = tables["sources"].to_pandas()
    is_first = sources["recording"].isin(names[::2]) & (sources["source"] == "x")
    sources.loc[is_first, "threshold"] = 0.6
    mixed = {**tables, "sources": typed(sources, tables["sources"].schema)}
    results = assert_batches_agree(mixed, SCAN)
    high = Params(threshold_x=0.6)
    expected = [
        scan_batch(only(tables, of), replace(SCAN, params=params))
        for of, params in ((names[::2], high), (names[1::2], Params()))
    ]
    assert_same(results, joined(expected))
    given = replace(SCAN, params=high)
    assert_same(scan_batch(mixed, given), scan_batch(tables, given))
    assert not results["frames"].equals(scan_batch(tables, given)["frames"])
    with pytest.raises(InputError, match="threshold of a system"):
        dataset_of(mixed, SCAN)


def test_there_and_back_the_numbers_are_the_same(dataset: Dataset, tables: Tables):
    back = dataset_of(tables, SCAN)
    assert not back.each_alone
    there, here = compare(dataset), compare(back)
    row_of = {name: row for row, name in enumerate(dataset.recordings["name"])}
    for name, make in MADE_BY.items():
        table = make(there)
        order = np.argsort([sorted(row_of).index(of) for of in table["recording"]], kind="stable")
        expected = table.iloc[order].reset_index(drop=True)
        own = make(here)
        order = np.argsort([sorted(row_of).index(of) for of in own["recording"]], kind="stable")
        pd.testing.assert_frame_equal(
            own.iloc[order].reset_index(drop=True), expected, rtol=1e-12, atol=0, obj=name
        )


def damaged(tables: Tables, table: str, column: str, row: int, value: object) -> Tables:
    cells = tables[table][column].to_pylist()
    cells[row] = value
    place = tables[table].schema.get_field_index(column)
    field = tables[table].schema.field(place)
    return {
        **tables, table: tables[table].set_column(place, field, pa.array(cells, field.type))
    }  # fmt: skip


@pytest.mark.parametrize(
    ("table", "column", "value", "reason"),
    [
        ("boxes", "w", 0.0, "expected boxes with a width and a height"),
        ("boxes", "x", NAN, "found x, y, w, h nan"),
        ("boxes", "frame", 999, "a box is in frame 999, which is not listed"),
        ("frames", "frame", 999, "not in order"),
        ("recordings", "fps", 0.0, "expected a positive fps"),
    ],
)
def test_a_damaged_recording_is_quarantined_and_the_rest_is_as_without_it(
    tables: Tables, table: str, column: str, value: object, reason: str
):
    broken = damaged(tables, table, column, 0, value)
    (bad,) = broken[table]["recording"].to_pylist()[:1]
    results = scan_batch(broken, SCAN)
    (row,) = results["quarantine"].to_pylist()
    assert row["recording"] == bad
    assert reason in row["reason"]
    others = [name for name in tables["recordings"]["recording"].to_pylist() if name != bad]
    rest = scan_batch(only(tables, others), SCAN)
    assert_same({**results, "quarantine": rest["quarantine"]}, rest)


def test_a_recording_of_too_many_frames_is_refused(tables: Tables, monkeypatch):
    n_frames = tables["recordings"].to_pandas().set_index("recording")["n_rows"]
    most = n_frames.drop_duplicates().nlargest(2).iloc[1]
    monkeypatch.setattr(batch, "MAX_FRAMES", most)
    results = scan_batch(tables, SCAN)
    refused = sorted(n_frames.index[n_frames > most])
    assert results["quarantine"]["recording"].to_pylist() == refused
    reason = results["quarantine"]["reason"][0].as_py()
    assert reason.startswith(f"it has {n_frames.max():,} frames; a scan compares at most")
    assert len(results["recordings"]) == len(n_frames) - len(refused)


def test_a_recording_that_a_system_was_not_run_on_is_quarantined(tables: Tables):
    sources = tables["sources"].to_pandas()
    is_gone = (sources["recording"] == "r1") & (sources["source"] == "y")
    fewer = {**tables, "sources": typed(sources[~is_gone], tables["sources"].schema)}
    results = scan_batch(fewer, SCAN)
    assert results["quarantine"].to_pylist() == [
        {"recording": "r1", "reason": "there are no results of y for it"}
    ]
    with pytest.raises(InputError, match="'r1': there are no results of y"):
        dataset_of(fewer, SCAN)


def test_without_a_horizon_only_those_that_lack_it_are_refused(tables: Tables):
    lacking = damaged(tables, "recordings", "horizon", 2, None)
    results = scan_batch(lacking, replace(SCAN, params=Params(proximity="horizon")))
    refused = results["quarantine"]["recording"].to_pylist()
    horizon = lacking["recordings"].to_pandas().set_index("recording")["horizon"]
    assert refused == sorted(horizon.index[horizon.isna()])


def test_no_recordings_give_empty_tables(tables: Tables):
    nothing = {name: table.slice(0, 0) for name, table in tables.items()}
    results = scan_batch(nothing, SCAN)
    whole = scan_batch(tables, SCAN)
    assert {name: (len(of), of.schema) for name, of in results.items()} == {
        name: (0, of.schema) for name, of in whole.items()
    }
    assert summary_of(results).measures()["x"].isna().all()


def test_params_survive_json_and_are_of_different_sources():
    scan = ScanParams("a@1", "a@2", "gt", Params(alpha=0.5, threshold_x=0.1), True)
    assert ScanParams.parse(scan.given()) == scan
    with pytest.raises(ParameterError, match="three different sources"):
        ScanParams("a", "a")


@pytest.fixture(scope="module")
def real(realdata: Path) -> list[Dataset]:
    """KITTI 0013 and 0016, and ETH-Sunnyday and PETS09-S2L1."""
    kitti, mot15 = realdata / "kitti_tracking", realdata / "mot15"
    sets = []
    for name in ("0013", "0016"):
        systems = tuple(
            SystemSource((f"{of}/{name}.txt",), name=of) for of in ("rrc_ped", "pointrcnn_ped")
        )
        facts = (RecordingEntry(name, width=1224, height=370, fps=10),)
        sets.append(load(Session(kitti, Source((f"label_02/{name}.txt",)), systems, facts)))
    for name in ("ETH-Sunnyday", "PETS09-S2L1"):
        files = f"{name}/det_frcnn/det.txt", f"{name}/res_devkit/{name}.txt"
        systems = tuple(
            SystemSource((file,), name=of, threshold=threshold)
            for file, of, threshold in zip(files, ("frcnn", "tracker"), (0.5, None), strict=True)
        )
        sets.append(load(Session(mot15, Source((f"{name}/gt/gt.txt",)), systems)))
    return sets


@pytest.mark.realdata
def test_real_recordings_by_themselves_and_in_batches(real: list[Dataset]):
    for number in (0, 2):
        of_camera = real[number : number + 2]
        x, y = of_camera[0].systems
        params = of_camera[0].params_of(x, y)
        tables = {}
        parts = [tables_of(dataset) for dataset in of_camera]
        tables = {name: pa.concat_tables([part[name] for part in parts]) for name in parts[0]}
        scan = ScanParams(x, y, params=params, frames=True)
        assert_batches_agree(tables, scan)
        for dataset in of_camera:
            name = dataset.recordings["name"][0]
            own = scan_batch(only(tables, [name]), scan)
            assert len(own["encounters"]) > 3
            assert_as_compared(own, dataset, params)
