"""Tables for people: exact columns, and figures that can be counted by hand."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import Result
from nvcore.inputs.session import RecordingEntry, Session, Source
from nvcore.tables.result import (
    encounters_table,
    events_table,
    findings_table,
    frames_table,
    intervals_table,
    located_events,
    recordings_table,
    worst_events,
    worst_intervals,
)
from nvcore.tables.summary import summary


@pytest.fixture(scope="module")
def result() -> Result:
    """Ten frames at 10 fps: track 7 in the middle; X sees it always, Y never and is wrong once."""
    truth = [at(f, 50, track=7) for f in range(10)]
    x = [at(f, 50, score=0.9) for f in range(10)]
    return result_of(make_dataset(truth, x, [at(3, 10, score=0.5)]))


@pytest.fixture(scope="module")
def two() -> Result:
    """The same in r0; r1 has a track too small to be relevant."""
    truth = [at(f, 50, track=7) for f in range(10)]
    truth += [at(f, 20, track=1, h=2.0, recording=1) for f in range(5)]
    places = [Place(range(10)), Place(range(5))]
    x = [at(f, 50, score=0.9) for f in range(10)]
    return result_of(make_dataset(truth, x, places=places), proximity="height")


@pytest.fixture(scope="module")
def nothing() -> Result:
    return result_of(make_dataset(n_frames=3))


def test_a_row_of_frames_holds_the_frame_s_figures(result: Result):
    row = frames_table(result).iloc[3]
    assert row[["recording", "frame", "time_s", "n_truth"]].tolist() == ["r0", 3, 0.3, 1]
    assert row[["n_det_x", "matched_x", "false_alarms_x"]].tolist() == [1, 1, 0]
    assert row[["n_det_y", "matched_y", "false_alarms_y"]].tolist() == [1, 0, 1]
    # truth in the middle of 100 px: 40 px from Y's box, which is 10 px from the edge
    assert row[["d_miss_x", "d_miss_y", "d_false_y"]].tolist() == [0, 40, 10]
    assert row["similarity_y"] == pytest.approx(1 - (0.9 * 40 + 0.1 * 10) / 50)


def test_a_frame_without_a_salient_miss_has_no_salient_track(result: Result):
    table = frames_table(result)
    assert table["salient_track_x"].isna().all()
    assert table["salient_track_y"].tolist() == [7] * 10


def test_a_row_of_encounters_tells_how_each_system_did(result: Result):
    row = encounters_table(result).iloc[0]
    assert row[["recording", "track", "first_frame", "last_frame", "n_relevant"]].tolist() == [
        "r0", 7, 0, 9, 10,
    ]  # fmt: skip
    assert row["category"] == "x_only"
    assert row[["matched_x", "coverage_x", "detected_x", "miss_class_x"]].tolist() == [
        10, 1.0, True, "none",
    ]  # fmt: skip
    assert row[["matched_y", "coverage_y", "detected_y", "miss_class_y"]].tolist() == [
        0, 0.0, False, "never",
    ]  # fmt: skip


def test_a_distant_encounter_is_neither_detected_nor_missed(two: Result):
    row = encounters_table(two).set_index("recording").loc["r1"]
    assert row["category"] == "distant"
    assert pd.isna(row["detected_x"])
    assert pd.isna(row["detected_y"])


def test_a_saliency_event_is_one_row(result: Result):
    table = events_table(result)
    assert table.iloc[0, :7].tolist() == ["y", "r0", 7, 0, 9, 0.0, 1.0]
    # recency at tau = 1: 1 / (1 + exp(-(1 - 0.5) / 0.1))
    assert table["saliency_s"][0] == pytest.approx(1 / (1 + np.exp(-5)))


def test_an_event_is_found_in_the_frames_and_the_recordings():
    truth = [at(f, 50, track=7, recording=1) for f in range(3, 6)]
    places = [Place(range(10)), Place(range(10))]
    x, y = located_events(result_of(make_dataset(truth, places=places))).to_dict("records")
    for event in (x, y):
        assert (event["recording"], event["recording_row"]) == ("r1", 1)
        assert (event["first_frame"], event["last_frame"]) == (3, 5)
        assert (event["first_row"], event["last_row"]) == (13, 15)


def test_a_low_interval_is_one_row_with_its_worst_frame(result: Result):
    table = intervals_table(result)
    assert table.iloc[0, :6].tolist() == ["y", "r0", 0, 9, 0.0, 1.0]
    # similarity 0.1 without a detection, 0.26 in frame 3
    assert table["depth_s"][0] == pytest.approx((9 * 0.8 + 0.64) * 0.1)
    assert table[["min_similarity", "worst_frame"]].iloc[0].tolist() == pytest.approx([0.1, 0])


def test_the_worst_of_one_system_come_first():
    # missed in frames 1-2, 5, 9-10: late misses are more salient, early ones as severe
    truth = [at(f, 50, track=1) for f in range(12)]
    result = result_of(make_dataset(truth, [truth[f] for f in (0, 3, 4, 6, 7, 8, 11)]))
    events, intervals = worst_events(result, "x", n=2), worst_intervals(result, "x", n=2)
    assert events["first_frame"].tolist() == [9, 5]
    assert intervals["first_frame"].tolist() == [1, 9]
    assert {*events["system"], *intervals["system"]} == {"x"}


def test_recordings_are_counted_apart(two: Result):
    table = recordings_table(two).set_index("recording")
    assert table[["n_frames", "duration_s", "n_truth"]].to_numpy().tolist() == [
        [10, 1.0, 10], [5, 0.5, 5],
    ]  # fmt: skip
    assert table[["both", "x_only", "y_only", "neither", "distant"]].to_numpy().tolist() == [
        [0, 1, 0, 0, 0], [0, 0, 0, 0, 1],
    ]  # fmt: skip
    assert table["encounters_detected_x"].tolist() == [1, 0]
    assert table["mean_similarity_x"]["r0"] == 1
    assert table["saliency_x"].tolist() == [0, 0]
    assert sum(summary(two)["x"]["miss_classes"].values()) == 1  # not the distant one


def test_recordings_and_frames_add_up_to_the_summary(two: Result):
    table, frames, all_ = recordings_table(two), frames_table(two), summary(two)
    assert table["n_frames"].sum() == len(frames) == all_["frames"]
    assert table["n_truth"].sum() == frames["n_truth"].sum() == all_["truth"]["boxes"]
    assert table["false_alarms_y"].sum() == all_["y"]["false_alarms"]
    assert {name: table[name].sum() for name in all_["venn"]} == all_["venn"]
    assert all_["dominant"] == "x"


def test_the_summary_names_saliency_and_similarity_of_both_systems(result: Result):
    row = recordings_table(result).iloc[0]
    assert (row["false_alarms_y"], row["false_alarms_per_minute_y"]) == (1, 60)
    assert np.isnan(row["false_alert_episodes_per_hour_y"])  # a second gives no rate per hour
    all_ = summary(result)
    assert (all_["x"]["saliency"], all_["x"]["mean_similarity"]) == (0, 1)
    assert all_["y"]["min_similarity"] == pytest.approx(0.1)
    assert all_["y"]["mean_similarity"] == pytest.approx((9 * 0.1 + 0.26) / 10)


def test_the_lead_time_counts_encounters_that_both_found():
    truth = [at(f, 50, track=1) for f in range(10)]
    x = [at(f, 50, score=1.0) for f in range(2, 10)]
    y = [at(f, 50, score=1.0) for f in range(5, 10)]
    lead = summary(result_of(make_dataset(truth, x, y)))["lead_time_s"]
    assert lead == {"encounters": 1, "mean": pytest.approx(0.3), "median": pytest.approx(0.3)}


def test_what_is_undefined_is_none_in_the_summary(nothing: Result):
    all_ = summary(nothing)
    assert all_["lead_time_s"] == {"encounters": 0, "mean": None, "median": None}
    assert all_["exclusivity"]["phi"] is None
    assert all_["x"]["mean_similarity"] == 1
    json.dumps(all_, allow_nan=False)


def test_an_infinite_threshold_is_none_in_the_summary():
    all_ = summary(result_of(make_dataset(n_frames=1), threshold_x=np.inf))
    assert all_["x"]["threshold"] is None


@pytest.mark.parametrize("table", [encounters_table, events_table, intervals_table])
def test_an_empty_table_keeps_its_columns(nothing: Result, result: Result, table):
    assert len(table(nothing)) == 0
    assert list(table(nothing)) == list(table(result))


def test_missing_figures_are_missing_and_not_zero(result: Result):
    row = encounters_table(result).iloc[0]
    assert np.isnan(row["lag_s_y"])
    assert row["lag_s_x"] == 0
    assert np.isnan(row["lead_time_s"])
    assert np.isnan(row["occluded_share"])


def test_findings_are_rows_in_the_order_given():
    error = Finding(Severity.ERROR, "no-area", "truth", 3, "What.", "Do.", "gt.txt", "line 4")
    note = Finding(Severity.NOTE, "constant-score", "FIR", 1, "What.", "Do.")
    table = findings_table((error, note))
    assert table.iloc[0].tolist() == [
        "error", "no-area", "truth", 3, "gt.txt", "line 4", "What.", "Do.",
    ]  # fmt: skip
    assert table["severity"].tolist() == ["error", "note"]
    assert list(findings_table(())) == list(table)


def test_distances_of_unknown_boxes_are_counted(result: Result):
    weighted = result_of(result.dataset, proximity="distance")
    all_ = summary(weighted)
    assert all_["truth"]["boxes_without_distance"] == 10
    assert all_["x"]["detections_without_distance"] == 10


def test_borrowed_distances_are_counted_by_lender_and_only_if_asked_for():
    truth = [at(f, 50, track=1) for f in range(4)]
    x = [at(0, 50, distance_m=20.0), at(2, 50, distance_m=18.0)]
    dataset = make_dataset(truth, x, [at(0, 50, distance_m=30.0)])
    names = ["boxes_reported_distance", "boxes_between_distances", "distances_lent"]
    borrowing = {"proximity": "distance", "missing_distance": "borrow"}
    counts = summary(result_of(dataset, **borrowing))["truth"]
    assert [counts[name] for name in names] == [2, 1, {"x": 2, "y": 1}]
    assert counts["distance_spread"] == pytest.approx(10 / 25)
    assert counts["boxes_without_distance"] == 1
    without = summary(result_of(dataset, proximity="distance"))["truth"]
    assert [without[name] for name in (*names, "distance_spread")] == [None] * 4


def test_track_ids_beyond_floats_are_kept():
    track = 2**53 + 1
    table = frames_table(result_of(make_dataset([at(0, 50, track=track)], n_frames=2)))
    assert table["salient_track_x"].tolist() == [track, pd.NA]


def test_a_recording_without_frames_has_no_rates():
    dataset = make_dataset([at(0, 50, track=7)], places=[Place(range(2)), Place([])])
    table = recordings_table(result_of(dataset))
    assert table["n_frames"].tolist() == [2, 0]
    assert np.isnan(table["false_alarms_per_minute_x"].iloc[1])


def test_saliency_is_told_for_each_recording():
    truth = [at(f, 50, track=1, recording=1) for f in range(4)]
    result = result_of(make_dataset(truth, places=[Place(range(4)), Place(range(4))]))
    table = recordings_table(result)
    assert table["saliency_x"].tolist() == [0, 2 * result.x.saliency_s]


def test_recordings_say_what_is_known_of_the_driver_s_view():
    dataset = make_dataset([at(0, 50)], places=[Place(range(2)) for _ in range(3)])
    names = dataset.recordings["name"].tolist()
    assert not recordings_table(result_of(dataset))[["has_visible", "has_gaze"]].any(axis=None)
    entries = (
        RecordingEntry(names[0], visible="v.mp4", light="lux.csv"),
        RecordingEntry(names[2], visible="v.mp4", gaze="gaze.csv"),
    )
    session = Session(folder=Path(), truth=Source(("truth.csv",)), systems=(), recordings=entries)
    table = recordings_table(result_of(replace(dataset, settings=session)))
    assert table["has_visible"].tolist() == [True, False, True]
    assert table["light_by"].tolist() == ["meter", "", "picture"]
    assert table["has_gaze"].tolist() == [False, False, True]
