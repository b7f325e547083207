"""Miss classes of X against Y, and what a fusion gains and costs."""

from __future__ import annotations

import numpy as np
import pytest
from builders import at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.dataset.schema import MissClass
from nvcore.tables.encounters.miss_classes import (
    ALL_CLASSES,
    CLASS_COLUMNS,
    FUSION_SYSTEMS,
    class_counts,
    fusion_table,
    miss_class_counts,
    miss_class_totals,
)
from nvcore.tables.summary import summary


@pytest.fixture(scope="module")
def result() -> Result:
    """Tracks 1, 2, 3 in one second; X finds 1 and 2, Y finds 2, nobody 3; Y has a false alarm."""
    truth = [at(f, c, track=t) for f in range(10) for t, c in ((1, 20), (2, 50), (3, 80))]
    x = [at(f, c) for f in range(10) for c in (20, 50)]
    y = [at(f, 50) for f in range(10)] + [at(4, 5)]
    return result_of(make_dataset(truth, x, y))


def test_every_class_of_x_stands_against_every_class_of_y(result: Result):
    table = miss_class_counts(result)
    names = [kind.value for kind in MissClass]
    assert (list(table.index), list(table)) == (names, names)
    assert table.loc["none", "never"] == 1
    assert table.loc["none", "none"] == 1
    assert table.loc["never", "never"] == 1
    assert table.to_numpy().sum() == 3


def test_sums_stand_in_the_last_row_and_column(result: Result):
    table = miss_class_totals(result)
    assert (table.index[-1], table.columns[-1]) == (ALL_CLASSES, ALL_CLASSES)
    assert table.loc["none", ALL_CLASSES] == 2  # X misses one of three, Y two
    assert table.loc[ALL_CLASSES, "never"] == 2
    assert table.loc[ALL_CLASSES, ALL_CLASSES] == 3


def test_distant_encounters_have_no_miss_class():
    truth = [at(0, 50, track=1, h=3), at(0, 20, track=2)]
    table = miss_class_counts(result_of(make_dataset(truth), proximity="height"))
    assert table.to_numpy().sum() == 1


def test_a_fusion_stands_beside_both_systems_with_its_gain_and_its_cost(result: Result):
    table = fusion_table(result).set_index("system")
    assert tuple(table.index) == FUSION_SYSTEMS
    assert table["name"].tolist() == ["x", "y", "x or y", "x and y"]
    assert table["encounters_detected"].tolist() == [2, 1, 2, 1]
    assert table["encounters"].tolist() == [3, 3, 3, 3]
    assert table["gain_on_x"].tolist() == [0, -1, 0, -1]
    assert table["gain_on_y"].tolist() == [1, 0, 1, 0]
    assert table["false_alert_episodes"].tolist() == [0, 1, 1, 0]
    assert table["more_episodes_than_x"].tolist() == [0, 1, 1, 0]
    assert table["more_episodes_than_y"].tolist() == [-1, 0, 0, -1]
    assert table["episodes_per_hour"].tolist() == [0, 3600, 3600, 0]
    assert table["more_episodes_per_hour_than_x"].tolist() == [0, 3600, 3600, 0]


def test_without_frames_the_rates_are_undefined():
    table = fusion_table(result_of(make_dataset(frames=[])))
    assert np.isnan(table["episodes_per_hour"]).all()
    assert table["encounters_detected"].tolist() == [0, 0, 0, 0]


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1))
def test_the_counts_are_those_of_the_summary(seed: int):
    result = compare(draw_scene(seed).dataset())
    told = summary(result)
    counts = miss_class_counts(result)
    assert counts.sum(axis=1).to_dict() == told["x"]["miss_classes"]
    assert counts.sum(axis=0).to_dict() == told["y"]["miss_classes"]
    either, both = fusion_table(result).iloc[2:].to_dict("records")
    for row, key in ((either, "x_or_y"), (both, "x_and_y")):
        assert row["encounters_detected"] == told["fusion"][key]["encounters_detected"]
        assert row["false_alert_episodes"] == told["fusion"][key]["false_alert_episodes"]


def test_encounters_are_counted_by_class_each_in_all_of_its_own():
    """Two cross, of whom X detects both and Y one; with the second walks one whom nobody sees."""
    crossing = [at(frame, 30 + 20 * frame, h=10.0, track=1) for frame in range(3)]
    pair = [at(frame, 30 + 20 * (frame - 3), h=10.0, track=2) for frame in range(3, 6)]
    beside = [at(frame, 35 + 10 * (frame - 3), h=10.0, track=3) for frame in range(3, 5)]
    result = result_of(make_dataset([*crossing, *pair, *beside], [*crossing, *pair], crossing))
    table = class_counts(result)
    assert tuple(table) == CLASS_COLUMNS
    assert table.index.name == "class"
    row = table.loc["crossing"]
    assert row[["both", "x_only", "y_only", "neither", "distant"]].tolist() == [1, 1, 0, 0, 0]
    assert row["severity_s_x"] == 0
    severity = result.y.failures["severity_s"]
    assert row["severity_s_y"] == severity[1]
    assert np.isnan(row["phi"])


def test_without_classes_the_table_of_counts_is_empty():
    result = result_of(make_dataset([at(0, 5, h=10.0, track=1)], [], []))
    table = class_counts(result)
    assert table.empty
    assert tuple(table) == CLASS_COLUMNS
