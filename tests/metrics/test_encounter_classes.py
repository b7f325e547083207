"""Classes of encounters: texts of the truth, and what follows from the boxes, counted by hand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import Box, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.dataset.schema import ATTRIBUTE_DTYPES
from nvcore.metrics.encounter_classes import classes_named, classes_of


def with_texts(truth: Sequence[Box], texts: Iterable[str]) -> Dataset:
    """These boxes of the truth, line after line, with the texts of their lines; empty: none."""
    dataset = make_dataset(truth)
    table = pd.DataFrame(
        [(0, line, text) for line, text in enumerate(texts, 1) if text],
        columns=list(ATTRIBUTE_DTYPES),
    )
    boxes = dataset.boxes
    boxes = boxes.assign(line=np.arange(1, len(boxes) + 1, dtype=np.int32))
    return replace(dataset, boxes=boxes, attributes=table.astype({"attributes": "category"}))


def members(dataset: Dataset) -> dict[str, list[int]]:
    return {
        name: np.flatnonzero(is_member).tolist()
        for name, is_member in classes_of(dataset).members.items()
    }


def far_left(frame: int, track: int, **more: float) -> Box:
    """Of a pedestrian who shows no class: 4.25 times their height to the left of the middle."""
    return at(frame, 7.5, h=10.0, track=track, **more)


def test_the_most_frequent_text_of_an_encounter_counts_frames_without_one_do_not():
    truth = [far_left(frame, 1) for frame in range(6)]
    dataset = with_texts(truth, ["", "", "", "stroller", "child", "child"])
    classes = classes_of(dataset)
    assert classes.attributes.tolist() == ["child"]
    assert classes.texts.tolist() == ["child"]
    assert classes.named == ("child",)


def test_of_equally_frequent_texts_the_first_counts():
    truth = [far_left(frame, 1) for frame in range(4)]
    assert classes_of(with_texts(truth, "baab")).attributes.tolist() == ["b"]
    assert classes_of(with_texts(truth, "abba")).attributes.tolist() == ["a"]


def test_a_text_may_name_several_classes_and_each_encounter_has_its_own():
    truth = [far_left(frame, track) for frame, track in enumerate((1, 1, 2, 2, 3))]
    dataset = with_texts(truth, ["child; dog ", "child; dog ", "dog", "dog", ""])
    assert members(dataset) == {"child": [0], "dog": [0, 1]}
    assert classes_of(dataset).texts.tolist() == ["child;dog", "dog", ""]
    assert classes_of(dataset).attributes.tolist() == ["child; dog ", "dog", ""]


def test_texts_of_ignored_boxes_belong_to_nobody():
    truth = [far_left(0, 1), far_left(1, 1, ignore=True)]
    assert members(with_texts(truth, ["", "child"])) == {}


def test_without_a_column_there_are_no_named_classes():
    classes = classes_of(make_dataset([far_left(0, 1)]))
    assert (classes.attributes.tolist(), classes.texts.tolist()) == ([""], [""])
    assert classes.named == ()


def test_without_pedestrians_there_are_no_classes():
    classes = classes_of(make_dataset(n_frames=3))
    assert classes.members == {}
    assert len(classes.texts) == 0


def test_a_named_class_and_a_derived_one_of_the_same_name_are_one():
    truth = [at(frame, 30 + 10 * frame, h=10.0, track=1) for frame in range(5)]
    truth += [far_left(frame, 2) for frame in range(5, 8)]
    dataset = with_texts(truth, [""] * 5 + ["crossing"] * 3)
    assert members(dataset)["crossing"] == [0, 1]


def test_who_was_on_both_sides_of_the_middle_is_crossing():
    paths = {
        1: (44, 56),  # from 0.12 left to 0.12 right
        2: (46, 60),  # 0.08 left is too little
        3: (52, 90),  # right all the time
        4: (95, 5),  # from right to left
    }
    truth = [
        at(2 * track + number, centre, h=1.0, track=track)
        for track, path in paths.items()
        for number, centre in enumerate(path)
    ]
    assert members(make_dataset(truth))["crossing"] == [0, 3]


def test_who_is_within_a_lane_for_half_of_his_frames_is_in_the_road():
    # of 17 px, a person of 1.7 m: 10 px are a metre, the lane's width is 35 px
    truth = [at(0, 84, h=17.0, track=1)]
    truth += [at(1, 86, h=17.0, track=2)]
    truth += [at(2, 84, h=17.0, track=3), at(3, 90, h=17.0, track=3)]
    truth += [at(4, 84, h=17.0, track=4), at(5, 90, h=17.0, track=4), at(6, 90, h=17.0, track=4)]
    assert members(make_dataset(truth)) == {"in_road": [0, 2]}


def test_who_has_another_beside_him_in_half_of_his_frames_is_in_a_group():
    # of 17 px, a person of 1.7 m: beside is up to 15 px
    def pair(frame: int, apart: float, *, h: float = 17.0) -> list[Box]:
        first, second = 2 * frame + 1, 2 * frame + 2
        return [at(frame, 150, h=17.0, track=first), at(frame, 150 + apart, h=h, track=second)]

    truth = [*pair(0, 14), *pair(1, 16), *pair(2, 14, h=13.0)]
    truth += [at(3, 150, h=17.0, track=7), at(3, 155, h=17.0, ignore=True)]  # nobody
    truth += [*pair(4, 14), at(5, 150, h=17.0, track=9), at(6, 150, h=17.0, track=9)]
    dataset = make_dataset(truth, width=200)
    assert members(dataset) == {"group": [0, 1, 8]}  # track 9 is alone in two frames of three


def test_a_box_given_twice_is_no_company():
    truth = [at(0, 150, h=17.0, track=1), at(0, 151, h=17.0, track=1)]
    assert members(make_dataset(truth, width=200)) == {}


def people(statures: Sequence[float], *, has_distance: bool) -> list[Box]:
    """At depths of 10, 20, ... px below the horizon in row 20, one a frame, far to the left."""
    boxes = []
    for number, stature in enumerate(statures):
        depth = 10.0 * (number % 3 + 1)
        distance = 100 / depth if has_distance else np.nan
        box = at(number, 5, h=stature * depth, foot=20 + depth, track=number, distance_m=distance)
        boxes.append(box)
    return boxes


@pytest.mark.parametrize("has_distance", [True, False])
def test_who_is_small_for_where_he_stands_is_a_child(has_distance: bool):
    truth = people([0.4, 0.4, 0.4, 0.29, 0.31, 0.4], has_distance=has_distance)
    horizon = np.nan if has_distance else 20.0
    dataset = make_dataset(truth, horizon=horizon)
    assert members(dataset)["child"] == [3]
    assert "child" not in members(make_dataset([box._replace(distance_m=np.nan) for box in truth]))


def test_four_people_are_too_few_to_say_who_is_small():
    truth = people([0.4, 0.4, 0.4, 0.2], has_distance=True)
    assert "child" not in members(make_dataset(truth))


def test_a_box_cut_by_the_edge_has_no_stature():
    truth = people([0.4] * 5 + [0.2], has_distance=True)
    assert members(make_dataset(truth))["child"] == [5]
    cut = [*truth[:5], truth[5]._replace(x=0.5)]
    assert "child" not in members(make_dataset(cut))


def test_names_are_stripped_sorted_and_once_each():
    named = classes_named(np.array(["b;a", "", "a; a;", ";"], dtype=object))
    assert {name: mask.tolist() for name, mask in named.items()} == {
        "a": [True, False, True, False],
        "b": [True, False, False, False],
    }
