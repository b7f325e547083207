"""State lanes: runs over time in which a system makes the same of a pedestrian."""

from __future__ import annotations

import numpy as np
import pandas as pd
from builders import Box, Place, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.tables.lanes import lanes_table, miss_starts


def lane(result: Result, system: str = "x", recording: int = 0) -> list[tuple[str, int, int]]:
    """State, first and last row of the runs of one system."""
    table = lanes_table(result, recording)
    table = table[table["system"] == system]
    return list(zip(table["state"], table["first_row"], table["last_row"], strict=True))


def walk(frames: range, **more: object) -> list[Box]:
    return [at(f, 50, track=1, **more) for f in frames]


def test_a_run_ends_where_the_state_changes():
    result = result_of(make_dataset(walk(range(6)), x=[at(f, 50) for f in (2, 3, 5)]))
    assert lane(result) == [("missed", 0, 1), ("matched", 2, 3), ("missed", 4, 4),
                            ("matched", 5, 5)]  # fmt: skip
    assert lane(result, "y") == [("missed", 0, 5)]


def test_a_run_stops_at_the_end_of_its_last_frame_s_time_step():
    table = lanes_table(result_of(make_dataset(walk(range(6)), x=[at(0, 50)])), 0)
    assert table["start_s"].tolist() == [0, 0.1, 0]
    assert table["stop_s"].tolist() == [0.1, 0.6, 0.6]


def test_an_ignored_box_of_the_track_is_a_run_of_its_own():
    truth = [at(0, 50, track=1), at(1, 50, track=1, ignore=True), at(2, 50, track=1)]
    result = result_of(make_dataset(truth, x=[at(f, 50) for f in range(3)]))
    assert lane(result) == [("matched", 0, 0), ("ignored", 1, 1), ("matched", 2, 2)]


def test_ignore_regions_and_ignored_tracks_without_an_encounter_have_no_lane():
    truth = [at(0, 50, track=3), at(0, 10, ignore=True), at(0, 90, track=9, ignore=True),
             at(0, 70, track=1, ignore=True)]  # fmt: skip
    assert lanes_table(result_of(make_dataset(truth)), 0)["track"].tolist() == [3, 3]


def test_frames_without_an_annotation_are_no_part_of_a_lane():
    result = result_of(make_dataset([at(f, 50, track=1) for f in (0, 1, 4)], n_frames=6))
    assert lane(result) == [("missed", 0, 1), ("missed", 4, 4)]


def test_lanes_are_sorted_by_encounter_then_system_then_time():
    truth = [at(f, c, track=t) for f in range(2) for t, c in ((5, 20), (2, 80))]
    table = lanes_table(result_of(make_dataset(truth, x=[at(0, 20)])), 0)
    assert list(zip(table["track"], table["system"], table["first_row"], strict=True)) == [
        (2, "x", 0), (2, "y", 0), (5, "x", 0), (5, "x", 1), (5, "y", 0),
    ]  # fmt: skip
    assert table["encounter"].tolist() == [0, 0, 1, 1, 1]


def test_rows_and_encounters_of_a_later_recording_count_over_all():
    truth = [at(0, 50, track=4), at(3, 50, track=4, recording=1)]
    places = [Place(range(5)), Place(range(4), fps=20)]
    table = lanes_table(result_of(make_dataset(truth, places=places)), 1)
    assert table[["encounter", "track", "first_row"]].iloc[0].tolist() == [1, 4, 8]
    assert table[["start_s", "stop_s"]].iloc[0].tolist() == [0.15, 0.2]


def test_a_recording_without_pedestrians_has_no_lanes_but_all_columns():
    table = lanes_table(result_of(make_dataset(x=[at(0, 50)])), 0)
    assert " ".join(table) == ("encounter track system state first_row last_row start_s stop_s")
    assert len(table) == 0
    assert table["first_row"].dtype == np.int64


def test_misses_start_where_a_relevant_pedestrian_is_no_longer_matched():
    truth = walk(range(6)) + [at(f, 10, track=2) for f in (3, 4)]
    result = result_of(make_dataset(truth, x=[at(f, 50) for f in (0, 3, 4)]))
    # track 1 is missed from 1 and from 5, track 2 from 3
    assert miss_starts(result, 0, result.x).tolist() == [1, 3, 5]


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1))
def test_the_matched_and_missed_frames_of_the_lanes_are_those_of_the_encounters(seed: int):
    result = compare(draw_scene(seed).dataset())
    n = len(result.dataset.recordings)
    lanes = pd.concat([lanes_table(result, i) for i in range(n)])
    lanes["n"] = lanes["last_row"] - lanes["first_row"] + 1
    for letter, system in (("x", result.x), ("y", result.y)):
        own = lanes[lanes["system"] == letter]
        judged = own[own["state"].isin(["matched", "missed"])]
        every = range(len(result.encounters))
        relevant = judged.groupby("encounter")["n"].sum().reindex(every, fill_value=0)
        matched = (
            judged[judged["state"] == "matched"]
            .groupby("encounter")["n"].sum().reindex(every, fill_value=0)
        )  # fmt: skip
        assert relevant.tolist() == system.encounters["n_relevant"].tolist()
        assert matched.tolist() == system.encounters["matched"].tolist()
