"""Every figure for tags of recordings and for groups of pedestrians."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from approach import PLACE, approach, only
from builders import Box, Place, at, make_dataset, result_of, tagged
from scenes import draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.table import EVIDENCE_KEYS, evidence_keys, inference_of
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.operating_points import AS_SET
from nvcore.evidence.subgroups.table import COLUMNS, subgroup_table
from nvcore.evidence.table import evidence_table
from nvcore.metrics.detection.curves import detection_curve
from nvcore.metrics.detection.miss_rate import log_average_miss_rate
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.time_left.steps import time_left_of

NIGHT = 10
"""Of the 20 recordings of `drives`, so many, the last ones, are tagged night."""


def drives(*, n: int = 20, night: int = NIGHT, **params: object) -> Result:
    """Recordings of 4 frames of 0.1 s, with a person in the middle and one at the edge.

    X finds everybody. Y finds who is in the middle, and by day also who is at the edge, and in
    every night recording but the first makes one false alarm.
    """
    truth, y = [], []
    for number in range(n):
        is_night = number >= n - night
        for frame in range(4):
            middle = at(frame, 50, recording=number, track=1, score=0.9)
            edge = at(frame, 8, recording=number, track=2, score=0.8)
            truth += [middle, edge]
            y += [middle] if is_night else [middle, edge]
        if is_night and number > n - night:
            y.append(Box(0, 70, 30, 5, 50, score=0.5, recording=number))
    dataset = make_dataset(truth, truth, y, places=[Place(range(4))] * n)
    tags = [("all of them", "night" if number >= n - night else "day") for number in range(n)]
    return result_of(tagged(dataset, *tags), **params)


@pytest.fixture(scope="module")
def table() -> pd.DataFrame:
    """Every figure of `drives`."""
    return subgroup_table(drives())


def of(result: Result, figure: str, **options: object) -> pd.DataFrame:
    return subgroup_table(result, [figure], **options).set_index(["factor", "group"])


def test_the_table_has_each_measure_for_all_and_every_group(table: pd.DataFrame):
    assert tuple(table.columns) == COLUMNS
    keys = evidence_keys(drives())
    assert table["figure"].unique().tolist() == list(keys)
    sizes = table.groupby("figure").size()
    assert sizes.tolist() == [6] * len(keys)  # all, centre, edge, three tags
    assert (table.groupby("figure").nth(0)["factor"] == "all").all()


def test_useful_alerts_are_split_as_they_are_compared_and_all_else_as_the_group():
    truth = [at(0, 30 + 10 * i, track=i + 1, detectability=0.1 if i < 3 else 0.9) for i in range(5)]
    x = [box._replace(score=1.0) for box in truth[:2] + truth[3:]]
    result = result_of(make_dataset(truth, x, [truth[2]._replace(score=1.0)]))
    keys = ["encounters_detected", "useful_alerts", "useful_alerts_by_unit"]
    table = subgroup_table(result, keys)
    of_all = table[table["factor"] == "all"].set_index("figure")
    counts = of_all[["n", "both", "x_only", "y_only", "neither"]]
    assert counts.loc["useful_alerts"].tolist() == [3, 0, 2, 1, 0]
    assert counts.loc["encounters_detected"].tolist() == [5, 0, 4, 1, 0]
    assert counts.loc["useful_alerts_by_unit"].tolist()[1:] == [0, 4, 1, 0]


def test_the_row_of_all_is_that_of_the_whole_comparison(table: pd.DataFrame):
    whole = evidence_table(drives()).set_index("figure")
    everybody = table[table["factor"] == "all"].set_index("figure")
    shared = [column for column in whole.columns if column != "p_corrected"]
    keys = list(evidence_keys(drives()))
    pd.testing.assert_frame_equal(everybody.loc[keys, shared], whole.loc[keys, shared])


def test_a_tag_of_all_recordings_has_the_measures_of_all_by_blocks():
    table = subgroup_table(drives(n=3, night=1)).set_index(["group", "figure"])
    same = [column for column in table.columns if column not in ("factor", "p_corrected")]
    tag = table.loc["all of them", same]
    pd.testing.assert_frame_equal(tag, table.loc["all", same])
    assert np.isfinite(tag["x"]).all()


def test_a_tag_has_the_measures_of_its_recordings_alone(table: pd.DataFrame):
    table = table.set_index(["group", "figure"])
    # in all recordings together the operating points are unequal, by day they are equal
    table["note"] = table["note"].str.removesuffix(f"; {AS_SET}")
    boxes_by_day = drives(n=NIGHT, night=0)
    alone = subgroup_table(boxes_by_day).set_index(["group", "figure"])
    same = [column for column in table.columns if column not in ("factor", "p_corrected")]
    pd.testing.assert_frame_equal(table.loc["day", same], alone.loc["all", same])


def test_measures_of_a_tag_by_hand(table: pd.DataFrame):
    table = table.set_index(["group", "figure"])
    night = table.loc["night"]
    assert night.loc["mean_similarity", "n"] == NIGHT
    # at night Y misses one person at 8 of 100 px in each frame: D(G, S) = 8 px to the border
    similarity = 1 - 0.9 * 8 / 50
    false_alarm = 0.1 * 22.5 / 50  # in one frame of nine recordings, 22.5 px from the person
    assert night.loc["mean_similarity", "y"] == pytest.approx(similarity - 9 / 40 * false_alarm)
    assert night.loc["mean_similarity", "x"] == 1
    assert night.loc["share_low", "x"] == 0
    assert night.loc["false_alert_episodes_per_hour", "y"] == pytest.approx(9 / 4.0 * 3600)
    assert night.loc["encounters_detected_by_unit", ["x", "y"]].tolist() == [1, 0.5]
    assert (table.loc["day", "x"] == table.loc["day", "y"]).all()


def test_frames_and_false_alerts_belong_to_no_group_of_pedestrians(table: pd.DataFrame):
    is_of_some = table["factor"] == "place"
    lacking = {key: why for key in EVIDENCE_KEYS if (why := inference_of(key).not_of_pedestrians)}
    assert set(lacking) == {
        "mean_similarity", "share_low", "lost_s_per_min", "false_alert_episodes_per_hour",
        "alerts_unwanted_per_hour",
    }  # fmt: skip
    assert "alerts_unwanted_per_hour" not in set(table["figure"])  # alerts are not asked for
    for figure, why in lacking.items():
        if figure == "alerts_unwanted_per_hour":
            continue
        rows = table[is_of_some & (table["figure"] == figure)]
        assert len(rows) == 2
        assert (
            rows[["x", "y", "difference", "low", "high", "p", "p_corrected"]].isna().all(axis=None)
        )
        assert (rows["note"] == PEDESTRIAN.say(why)).all()
        assert (rows["n"] == 0).all()
    rest = table[is_of_some & ~table["figure"].isin(list(lacking))]
    assert rest[["x", "y"]].notna().all(axis=None)


def test_saliency_of_a_group_is_that_of_the_misses_of_its_pedestrians():
    result = drives(saliency_aggregate="sum")
    table = of(result, "saliency")
    event_s = result.y.events["saliency_s"].to_numpy()
    assert len(event_s) == NIGHT  # who is at the edge, in each night
    edge = table.loc[("place", "edge")]
    assert edge["y"] == pytest.approx(event_s.sum() / 20)
    assert edge["x"] == 0
    assert table.loc[("place", "centre"), ["x", "y"]].tolist() == [0, 0]
    assert table.loc[("tag", "night"), "y"] == pytest.approx(event_s.sum() / NIGHT)


def test_saliency_of_a_group_is_over_the_recordings_that_have_its_pedestrians():
    places = [Place(range(4))] * 10
    edge = [at(f, 8, recording=r, track=2) for r in range(4) for f in range(4)]
    middle = [at(f, 50, recording=r, track=1) for r in range(10) for f in range(4)]
    result = result_of(make_dataset([*middle, *edge], [*middle, *edge], middle, places=places))
    table = of(result, "saliency")
    row = table.loc[("place", "edge")]
    assert row["n"] == 4
    assert row["y"] == pytest.approx(result.y.events["saliency_s"].mean())
    assert "too few recordings for an interval: 4" in row["note"]
    assert np.isnan(row["low"])
    assert table.loc[("all", "all"), "y"] == pytest.approx(0.4 * row["y"])


@pytest.mark.parametrize("aggregate", ["max", "sum"])
def test_with_blocks_of_time_saliency_is_the_mean_over_recordings(aggregate: str):
    result = drives(n=3, night=2, saliency_aggregate=aggregate)
    row = of(result, "saliency").loc[("tag", "night")]
    assert row["unit"] == "blocks"
    assert row["y"] == pytest.approx(result.y.events["saliency_s"].sum() / 2)
    assert ("cannot be shared out to blocks" in row["note"]) == (aggregate == "max")
    assert "2 recordings only" in row["note"]


def test_miss_rate_of_a_group_by_hand():
    table = of(drives(), MISS_RATE)
    # Y finds nobody at the edge by night: half of them at any threshold; false positives are
    # those of everybody, 9 in 80 images, with a lower score than any pedestrian
    edge = table.loc[("place", "edge")]
    assert (edge["x"], edge["y"]) == (0, pytest.approx(0.5))
    assert table.loc[("place", "centre"), ["x", "y"]].tolist() == [0, 0]
    assert table.loc[("tag", "night"), "y"] == pytest.approx(0.5)
    assert table.loc[("all", "all"), "y"] == pytest.approx(0.25)


@pytest.mark.parametrize("seed", [0, 2, 4, 5, 7, 8])
def test_miss_rate_of_a_group_is_that_of_truth_without_the_others(seed: int):
    """By deleting nothing: a second dataset in which the others are marked as ignored."""
    scene = draw_scene(seed)
    for boxes in (scene.x, scene.y):
        boxes[:] = [box._replace(score=0.3 if np.isnan(box.score) else box.score) for box in boxes]
    result = result_of(scene.dataset())
    offset = dict(zip(zip(result.encounters.recording, result.encounters.track, strict=True),
                      result.encounters.lateral_offset, strict=True))  # fmt: skip
    table = of(result, MISS_RATE)
    assert list(table.loc["place"].index) == ["centre", "edge"]
    for group in ("centre", "edge"):
        truth = [
            box._replace(ignore=box.ignore or is_other(offset, box, group)) for box in scene.truth
        ]
        dataset = make_dataset(truth, scene.x, scene.y, places=scene.places)
        for letter in "xy":
            expected = log_average_miss_rate(detection_curve(dataset, letter, result.params))
            assert table.loc[("place", group), letter] == pytest.approx(expected, nan_ok=True)


def is_other(offset: dict[tuple[int, int], float], box: Box, group: str) -> bool:
    at_centre = offset.get((box.recording, box.track), 0.0) < 0.5
    return at_centre != (group == "centre")


def test_without_scores_no_group_has_a_miss_rate_and_all_say_so():
    truth = [at(f, c, recording=r, track=c) for r in range(9) for f in range(2) for c in (8, 50)]
    result = result_of(make_dataset(truth, truth, truth[::2], places=[Place(range(2))] * 9))
    table = of(result, MISS_RATE)
    assert table["x"].isna().all()
    assert table["note"].str.contains("detections with scores").all()


def test_holm_corrects_over_the_groups_of_all_measures(table: pd.DataFrame):
    repeated = ["encounters_detected", "lost_s_per_min"]
    is_counted = (table["factor"] != "all") & ~table["figure"].isin(repeated)
    assert table.loc[~is_counted, "p_corrected"].isna().all()
    known = table.loc[is_counted, "p"].dropna()
    assert len(known) > 2
    assert table["p_corrected"].min() == pytest.approx(min(len(known) * known.min(), 1))


def test_a_tag_without_a_pedestrian_still_has_similarity_and_false_alerts():
    dataset = make_dataset(
        [at(0, 50, recording=0, track=1)], [], [at(0, 30, recording=1)],
        places=[Place(range(4))] * 2,
    )  # fmt: skip
    table = subgroup_table(result_of(tagged(dataset, ("city",), ("empty",))))
    empty = table[table["group"] == "empty"].set_index("figure")
    assert empty.loc["false_alert_episodes_per_hour", "y"] == pytest.approx(1 / 0.4 * 3600)
    assert np.isfinite(empty.loc["mean_similarity", "y"])
    assert np.isnan(empty.loc["encounters_detected", "x"])
    assert empty.loc["encounters_detected", "n"] == 0


def test_swapping_x_and_y_turns_the_signs_of_every_measure(table: pd.DataFrame):
    result = drives()
    back = subgroup_table(compare(result.dataset, result.params, x="y", y="x"))
    assert back["difference"].to_numpy() == pytest.approx(-table["difference"], nan_ok=True)
    assert back["p"].to_numpy() == pytest.approx(table["p"], nan_ok=True)


def test_urgent_encounters_belong_to_their_groups_and_have_evidence_by_recordings():
    truth, x, y = [], [], []
    for recording in range(10):
        for track, centre in ((1, 50), (2, 90)):
            boxes = approach(range(40), 5, centre=centre, track=track, recording=recording)
            truth += boxes
            x += boxes if recording else only(boxes, range(38, 40))
            y += boxes if track == 1 and recording % 2 else only(boxes, range(30, 40))
    places = [PLACE] * 10
    result = result_of(make_dataset(sorted(truth, key=lambda b: (b.recording, b.frame)), x, y,
                                    places=places))  # fmt: skip
    whole = evidence_table(result).set_index("figure")
    assert whole.loc["in_time", ["x", "y"]].tolist() == [0.9, 0.25]
    assert whole.loc["in_time_by_unit", ["x", "y"]].tolist() == [0.9, 0.25]
    late = time_left_of(result.y)["impact_kmh"].max()
    assert whole.loc["mean_impact_kmh", ["x", "y"]].tolist() == pytest.approx([5, 0.75 * late])
    assert whole.loc["in_time_by_unit", "p"] < 0.05
    assert np.isnan(whole.loc["in_time", "p_corrected"])  # asked again by recordings
    for key in ("in_time", "in_time_by_unit"):
        groups = of(result, key).xs("place", level="factor")
        assert groups[["x", "y"]].to_numpy().tolist() == [[0.9, 0.5], [0.9, 0.0]]  # centre, edge
    assert of(result, "in_time").loc[("place", "edge"), "n"] == 10


def test_encounters_in_time_are_split_by_who_is_in_time():
    boxes = [approach(range(40), 5, recording=recording) for recording in range(3)]
    boxes.append([at(frame, 50, recording=3, track=1) for frame in range(40)])  # never nearer
    truth = [box for own in boxes for box in own]
    y = [*boxes[0], *only(boxes[1], range(30, 40)), *boxes[3]]
    result = result_of(make_dataset(truth, truth, y, places=[PLACE] * 4))
    table = subgroup_table(result, ["encounters_detected", "in_time"])
    counts = ["n", "both", "x_only", "y_only", "neither"]
    whole = table[table["factor"] == "all"].set_index("figure")[counts]
    assert whole.loc["encounters_detected"].tolist() == [4, 2, 2, 0, 0]
    assert whole.loc["in_time"].tolist() == [3, 1, 2, 0, 0]


def test_without_frames_nothing_is_defined_and_nothing_fails():
    table = subgroup_table(result_of(make_dataset(n_frames=0)), EVIDENCE_KEYS)
    assert len(table) == len(EVIDENCE_KEYS)
    assert table[["x", "y", "low", "p"]].isna().all(axis=None)
