from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from builders import Place, at, make_dataset, result_of, tagged

from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.evidence.subgroups import find_subgroups
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.metrics.encounter_classes import classes_of


def people(**params: object) -> Result:
    """24 recordings of one pedestrian each: the first 12 near and central, 12 far at the edge.

    X detects all of them, Y the near ones and every fourth of the far ones.
    """
    return result_of(crowd(), proximity="height", **params)


def crowd() -> Dataset:
    truth, y = [], []
    for number in range(24):
        is_near = number < 12
        for frame in range(4):
            box = at(
                frame, 50 if is_near else 10, h=40 if is_near else 15, recording=number, track=1,
                w=20 if is_near else 5 + number % 2, occlusion=number % 2,
            )  # fmt: skip
            truth.append(box)
            if is_near or number % 4 == 0:
                y.append(box)
    return make_dataset(truth, truth, y, places=[Place(range(4))] * 24)


def detected(result: Result) -> pd.DataFrame:
    return subgroup_table(result, ["encounters_detected"])


def parts(result: Result) -> dict[tuple[str, str], int]:
    return {
        (subgroup.factor, subgroup.group): int(subgroup.is_member.sum())
        for subgroup in find_subgroups(result)
    }


def test_encounters_are_divided_by_the_ground_truth() -> None:
    sizes = parts(people())
    assert sizes["distance", "near"] == sizes["distance", "far"] == 12
    assert sizes["place", "centre"] == sizes["place", "edge"] == 12
    assert sizes["occlusion", "visible"] == sizes["occlusion", "occluded"] == 12
    assert ("occlusion", "unknown") not in sizes


def test_the_first_row_is_all_encounters_and_parts_add_up_to_it() -> None:
    table = detected(people())
    assert table.iloc[0][["factor", "group", "n"]].tolist() == ["all", "all", 24]
    counts = ["n", "both", "x_only", "y_only", "neither"]
    for factor in ("distance", "place", "occlusion", "pose"):
        total = table.loc[table["factor"] == factor, counts].sum()
        assert total.tolist() == table.iloc[0][counts].tolist(), factor


def test_measures_of_a_subgroup_by_hand() -> None:
    table = detected(people()).set_index(["factor", "group"])
    far, near = table.loc[("distance", "far")], table.loc[("distance", "near")]
    assert far[["both", "x_only", "y_only", "neither"]].tolist() == [3, 9, 0, 0]
    assert (far["x"], far["y"], far["difference"]) == (1, 0.25, 0.75)
    assert 0 < far["low"] < 0.75 < far["high"] < 1
    assert far["p"] == 2 / 2**9
    assert (far["effect"], far["effect_name"]) == (np.inf, "odds ratio")
    assert near["difference"] == 0
    assert np.isnan(near["p"])
    assert "X and Y differ in too few encounters for a test: 0" in near["note"]


def test_near_is_twice_as_high_as_a_box_that_counts_half() -> None:
    # the far ones are 15 px high: with 7.6 px at the step they are just far, with 7.4 all are near,
    # and what does not divide the encounters is left out
    assert parts(people(midpoint=7.6, spread=1))["distance", "near"] == 12
    assert "distance" not in {factor for factor, _ in parts(people(midpoint=7.4, spread=1))}


def test_distant_encounters_are_in_no_subgroup() -> None:
    result = people(midpoint=30, spread=1)
    assert result.venn.distant == 12
    assert all(subgroup.is_member.sum() <= 12 for subgroup in find_subgroups(result))
    assert detected(result)["n"].iloc[0] == 12


def test_unknown_occlusion_is_no_factor() -> None:
    truth = [at(frame, 50, track=1, recording=r) for r in range(12) for frame in range(3)]
    result = result_of(make_dataset(truth, truth, truth, places=[Place(range(3))] * 12))
    assert "occlusion" not in {subgroup.factor for subgroup in find_subgroups(result)}


def test_tags_of_recordings_are_subgroups_and_may_overlap() -> None:
    tags = [("night", "rain")] * 6 + [("night",)] * 6 + [("day",)] * 12
    result = result_of(tagged(crowd(), *tags), proximity="height")
    sizes = {group: n for (factor, group), n in parts(result).items() if factor == "tag"}
    assert sizes == {"day": 12, "night": 12, "rain": 6}


def test_classes_that_the_truth_names_are_groups_derived_ones_are_not() -> None:
    dataset = crowd()
    boxes = dataset.boxes.assign(line=np.arange(len(dataset.boxes), dtype=np.int32))
    of_first = range(4 * 6)  # of the truth: the pedestrians of the first six recordings
    texts = pd.Categorical(["child"] * len(of_first))
    attributes = pd.DataFrame({"file": 0, "line": of_first, "attributes": texts})
    result = result_of(replace(dataset, boxes=boxes, attributes=attributes), proximity="height")
    classes = [part for part in find_subgroups(result) if part.factor == "class"]
    assert [(part.group, int(part.is_member.sum())) for part in classes] == [("child", 6)]
    assert "in_road" in classes_of(result.dataset).members
    rows = subgroup_table(result, ["encounters_detected"]).set_index("group")
    assert rows.loc["child", ["both", "n"]].tolist() == [6, 6]


def test_a_class_of_all_pedestrians_is_no_group() -> None:
    dataset = crowd()
    boxes = dataset.boxes.assign(line=np.arange(len(dataset.boxes), dtype=np.int32))
    lines = range(4 * 24)
    texts = pd.Categorical(["person"] * len(lines))
    attributes = pd.DataFrame({"file": 0, "line": lines, "attributes": texts})
    result = result_of(replace(dataset, boxes=boxes, attributes=attributes), proximity="height")
    assert not [part for part in find_subgroups(result) if part.factor == "class"]
