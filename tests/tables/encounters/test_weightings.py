"""One encounter by height, horizon and distance: what a whole comparison by each would say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Box, Place, make_dataset
from places import SAMPLE

from nvcore.comparison.compare import Result, compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.settings.params import Params
from nvcore.tables.encounters.weightings import KINDS, compare_weightings
from nvcore.tables.result import encounters_table

SIZE = {"width": 640, "height": 480, "fps": 10.0}


@pytest.fixture(scope="module")
def sample() -> Result:
    return compare(load(read_session(SAMPLE)))


@pytest.mark.parametrize("kind", KINDS)
def test_each_row_is_what_a_comparison_by_that_kind_says(sample: Result, kind: str) -> None:
    params = replace(sample.params, proximity=kind)
    table = encounters_table(compare(sample.dataset, params))
    rows = [compare_weightings(sample, i).table.loc[kind] for i in range(len(table))]
    ours = pd.DataFrame(rows).reset_index(drop=True)
    assert ours["is_known"].all()
    assert ours["n_relevant"].tolist() == table["n_relevant"].tolist()
    for letter in "xy":
        missed = (table["n_relevant"] - table[f"matched_{letter}"]).tolist()
        assert ours[f"missed_{letter}"].tolist() == missed
        np.testing.assert_allclose(
            ours[f"severity_s_{letter}"].astype(float), table[f"severity_s_{letter}"]
        )
        classes = (each[f"miss_class_{letter}"].fillna("") for each in (ours, table))
        assert len({tuple(column) for column in classes}) == 1


def test_the_curve_in_use_is_the_weight_of_the_result(sample: Result) -> None:
    encounters = sample.encounters
    for encounter in range(0, len(encounters), 7):
        weightings = compare_weightings(sample, encounter)
        rows = encounters.order[slice(*encounters.offsets[encounter : encounter + 2])]
        frame_row = sample.dataset.truth.frame_index[rows]
        assert (np.diff(frame_row) > 0).all()  # by frame, once in each
        assert weightings.curves["row"].tolist() == frame_row.tolist()
        assert weightings.curves["k_height"].tolist() == sample.k_truth.k[rows].tolist()
        assert weightings.in_use == "height"


def test_the_child_of_the_sample_counts_earlier_by_distance_than_by_height(sample: Result) -> None:
    encounters, names = sample.encounters, sample.dataset.recordings["name"].tolist()
    is_child = (encounters.recording == names.index("rural_child")) & (encounters.track == 3)
    table = compare_weightings(sample, int(np.flatnonzero(is_child)[0])).table
    assert table["first_frame"].tolist() == [215, 214, 204]
    assert table["missed_y"].tolist() == [13, 14, 24]
    assert table.loc["distance", "severity_s_y"] > 1.9 * table.loc["height", "severity_s_y"]


def walk(*distances: float, track: int = 1) -> list[Box]:
    return [
        Box(i, 300, 200, 40, 60, track=track, distance_m=metres)
        for i, metres in enumerate(distances)
    ]


def test_what_is_not_known_is_missing_not_guessed() -> None:
    result = compare(make_dataset(walk(NAN, NAN), walk(NAN, track=-1), **SIZE))
    weightings = compare_weightings(result, 0)
    assert weightings.table["is_known"].tolist() == [True, False, False]
    facts = weightings.table.loc["height"]
    assert (facts["n_relevant"], facts["missed_x"], facts["missed_y"]) == (2, 1, 2)
    assert weightings.table.loc["horizon"].drop("is_known").isna().all()
    assert weightings.curves[["k_horizon", "k_distance"]].isna().all(axis=None)
    assert weightings.curves["matched_x"].tolist() == [True, False]


def test_boxes_without_a_distance_count_by_height_and_are_counted() -> None:
    result = compare(make_dataset(walk(60.0, NAN, 10.0), **SIZE))
    weightings = compare_weightings(result, 0)
    facts = weightings.table.loc["distance"]
    names = ["n_by_height", "n_relevant", "first_frame", "last_frame"]
    assert facts[names].tolist() == [1, 2, 1, 2]
    assert np.isnan(weightings.curves["k_distance"]).tolist() == [False, True, False]


def test_a_horizon_of_its_own_is_enough_whatever_other_recordings_have() -> None:
    boxes = [*walk(NAN), *(box._replace(recording=1) for box in walk(NAN))]
    places = [Place(range(1), 640, 480, horizon=200.0), Place(range(1), 640, 480)]
    result = compare(make_dataset(boxes, places=places))
    known = [compare_weightings(result, i).table.loc["horizon", "is_known"] for i in range(2)]
    assert known == [True, False]
    by_setting = compare(result.dataset, Params(horizon=230.0, proximity="horizon"))
    for i in range(2):
        weightings = compare_weightings(by_setting, i)
        assert weightings.table.loc["horizon", "is_known"]
        assert weightings.curves["k_horizon"].tolist() == [by_setting.k_truth.k[i]]
        assert weightings.in_use == "horizon"


def test_borrowed_distances_weigh_where_they_are_set_to() -> None:
    reports = [box._replace(track=-1) for box in walk(40.0, NAN, 20.0)]
    dataset = make_dataset(walk(NAN, NAN, NAN), reports, **SIZE)
    without = compare_weightings(compare(dataset), 0)
    assert not without.table.loc["distance", "is_known"]
    borrowed = compare_weightings(compare(dataset, Params(missing_distance="borrow")), 0)
    assert borrowed.table.loc["distance", "n_by_height"] == 0
    assert np.isfinite(borrowed.curves["k_distance"]).all()


def test_a_track_twice_in_a_frame_is_one_pedestrian() -> None:
    twin = Box(0, 500, 200, 40, 100, track=1)
    result = compare(make_dataset([*walk(NAN, NAN), twin], [twin._replace(track=-1)], **SIZE))
    weightings = compare_weightings(result, 0)
    assert len(weightings.curves) == 2
    assert weightings.curves["matched_x"].tolist() == [True, False]
    assert weightings.curves["k_height"][0] == result.k_truth.k.max()
