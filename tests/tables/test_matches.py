"""Every box with its partner: countable by hand, and the same numbers as in the other tables."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from builders import at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw_scene, three_frames

from nvcore.comparison.compare import Result, compare
from nvcore.settings.params import Params
from nvcore.tables.boxes import matches
from nvcore.tables.boxes.matches import MATCH_COLUMNS, matches_parquet, matches_table
from nvcore.tables.result import frames_table


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    return matches_table(three_frames())


def cells(table: pd.DataFrame, source: str, *columns: str) -> list[list[object]]:
    rows = table[table["source"] == source][list(columns)].astype(object)
    return rows.where(rows.notna(), None).to_numpy().tolist()


def test_truth_and_systems_name_each_other_by_their_numbers(table: pd.DataFrame):
    columns = ("box", "frame", "outcome_x", "match_x", "outcome_y", "match_y")
    assert cells(table, "truth", *columns) == [
        [0, 0, "matched", 0, "matched", 0],
        [1, 0, "matched", 1, "missed", None],
        [2, 2, "not_judged", None, "not_judged", None],
    ]
    assert cells(table, "x", "box", "frame", "outcome_x", "match_x", "outcome_y") == [
        [0, 0, "matched", 0, None],
        [1, 0, "matched", 1, None],
        [2, 2, "absorbed", None, None],
        [3, 2, "false_alarm", None, None],
    ]
    y = cells(table, "y", "outcome_y", "match_y", "counts")
    assert y[0] == ["matched", 0, True]
    assert {tuple(row) for row in y[1:]} == {("below", None, False)}


def test_the_overlap_and_the_distance_are_those_of_the_pair():
    truth = [at(0, 30, w=10), at(0, 80, w=10, ignore=True)]
    result = result_of(make_dataset(truth, x=[at(0, 32, w=10)], y=[]), iou=0.5)
    table = matches_table(result)
    iou = pytest.approx(8 / 12)
    assert cells(table, "truth", "iou_x", "nearest_px_x", "iou_y", "nearest_px_y") == [
        [iou, pytest.approx(2), None, None],
        [None, None, None, None],
    ]
    assert cells(table, "x", "iou_x", "nearest_px_x", "cost") == [[iou, pytest.approx(2), None]]


def test_distance_and_occlusion_are_those_of_the_inputs():
    truth = [at(0, 30, distance_m=25.5, occlusion=1), at(1, 30)]
    x = [at(0, 30, distance_m=24.0)]
    table = matches_table(result_of(make_dataset(truth, x=x, y=[])))
    assert cells(table, "truth", "distance_m", "occlusion") == [[25.5, 1], [None, None]]
    assert cells(table, "x", "distance_m", "occlusion") == [[24.0, None]]


def test_boxes_that_stand_in_no_file_have_no_line(table: pd.DataFrame):
    assert table[["file", "line"]].isna().all(axis=None)


def check_against_frames(result: Result) -> None:
    """Counts and largest terms of each frame are those of the frames table."""
    table, frames = matches_table(result), frames_table(result)
    assert list(table) == [column.name for column in MATCH_COLUMNS]
    assert len(table) == len(result.dataset.boxes)
    keys = ["recording", "frame"]
    frames = frames.set_index(keys)
    half_width = result.dataset.frame_columns.half_width
    truth = table[table["source"] == "truth"]
    for side in "xy":
        rows = table[table["source"] == side]
        for part, outcome, count in (
            (truth, "matched", "matched"),
            (rows, "false_alarm", "false_alarms"),
        ):
            n = part[part[f"outcome_{side}"] == outcome].groupby(keys, observed=True).size()
            expected = frames[f"{count}_{side}"]
            assert n.reindex(frames.index, fill_value=0).tolist() == expected.tolist()
        for part, distance in ((truth, "d_miss"), (rows, "d_false")):
            largest = part.groupby(keys, observed=True)[f"term_{side}"].max()
            largest = largest.reindex(frames.index).fillna(0).to_numpy()
            np.testing.assert_allclose(largest, frames[f"{distance}_{side}"] / half_width)
        pairs = rows.dropna(subset=[f"match_{side}"]).set_index("box")[f"match_{side}"]
        back = truth.dropna(subset=[f"match_{side}"]).set_index("box")[f"match_{side}"]
        assert dict(zip(pairs, pairs.index, strict=True)) == back.to_dict()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_the_table_agrees_with_the_frames(seed: int):
    check_against_frames(compare(draw_scene(seed).dataset(), Params(threshold_x=0.4)))


def test_parts_of_the_frames_make_the_same_file(monkeypatch: pytest.MonkeyPatch):
    result = three_frames()
    whole = pq.read_table(io.BytesIO(matches_parquet(result)))
    assert [field.name for field in whole.schema] == [column.name for column in MATCH_COLUMNS]
    monkeypatch.setattr(matches, "FRAMES_AT_ONCE", 2)
    in_parts = pq.ParquetFile(io.BytesIO(matches_parquet(result)))
    assert in_parts.num_row_groups == 2
    assert in_parts.read().equals(whole)
