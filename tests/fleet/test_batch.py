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
from fleet_tables import Tables, assert_same, joined, only, tables_of
from scenes import draw_scene

from nvcore.comparison import Result, compare
from nvcore.dataset import Dataset
from nvcore.errors import InputError, ParameterError
from nvcore.fleet.batch import ScanParams, dataset_of, scan_batch
from nvcore.fleet.results import Summary, exact_sum, typed
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.measures.table import MEASURES
from nvcore.params import Params
from nvcore.schema import ATTRIBUTE_DTYPES, conform
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


def fleet(n_scenes: int = 8) -> Dataset:
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
                    detectability=float(rng.random()) if seed in (2, 5) else NAN,
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


def assert_batches_agree(tables: Tables, params: ScanParams) -> tuple[Tables, Summary]:
    """All at once, by ones, by threes and shuffled: the same bytes. Returns all at once."""
    whole, summary = scan_batch(tables, params)
    names = tables["recordings"]["recording"].to_pylist()
    shuffled = np.random.default_rng(1).permutation(names).tolist()
    for order, size in ((names, 1), (names, 3), (shuffled, 3), (shuffled, len(names))):
        parts = [scan_batch(only(tables, of), params) for of in chunks(order, size)]
        assert_same(joined([part for part, _ in parts]), whole)
        assert Summary.merge([part for _, part in parts]).to_json() == summary.to_json()
    return whole, summary


def assert_as_compared(whole: Tables, summary: Summary, dataset: Dataset, params: Params) -> None:
    """Each recording to the bit as compared by itself, measures to 1e-12 as of all together."""
    for name in dataset.recordings["name"]:
        result = compare(dataset.only(names=name), params)
        for table, make in MADE_BY.items():
            known = make(result)
            own = whole[table].filter(pa.compute.equal(whole[table]["recording"], name))
            for column in known.columns:
                expected = typed(known, pa.schema([own.schema.field(column)]))[column]
                assert own[column].combine_chunks().equals(expected.combine_chunks()), column
    result = compare(dataset, params)
    measures = summary.measures().set_index("key")
    of_system = {measure.key: measure.of for measure in MEASURES if measure.of is not None}
    left_out = {"percentile_5_similarity", "median_margin_s", "median_alert_lead_s"}
    left_out |= {"worst_window_lost_s", "detections_without_distance"}
    assert {key for key in of_system if key not in measures.index} <= left_out | {
        measure.key for measure in MEASURES if measure.only_if and not measure.only_if.holds(result)
    }
    for key in measures.index.intersection([*of_system]):
        for letter, system in result.sides:
            value = of_system[key](result, system)
            assert measures.loc[key, letter] == pytest.approx(value, rel=1e-12, nan_ok=True), key
    assert (summary.venn, summary.boxes) == (result.venn, result.boxes)
    assert summary.total("n_frames") == len(dataset.frames)
    assert summary.total("duration_s") == pytest.approx(result.duration_s, rel=1e-12)


@pytest.mark.parametrize("params", SETTINGS)
def test_the_same_bytes_however_recordings_are_put_together(
    dataset: Dataset, tables: Tables, params: Params
):
    whole, summary = assert_batches_agree(tables, replace(SCAN, params=params))
    assert len(whole["quarantine"]) == 0
    assert min(len(whole[name]) for name in MADE_BY) > 5
    assert_as_compared(whole, summary, dataset, params)
