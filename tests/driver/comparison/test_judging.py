"""Whom the driver sees unaided, who of driver, X and Y sees whom, and what a miss weighs."""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import pytest
from approach import approach, only
from builders import NAN, Box, at, make_dataset, result_of
from hypothesis import given
from hypothesis import strategies as st

from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.dataset.schema import Category
from nvcore.evidence.stability.scores import score_setting
from nvcore.settings.params import Params
from nvcore.subjects.driver.comparison.in_time import (
    is_driver_in_time,
    is_in_time_alone,
    is_seen_too_late,
)
from nvcore.subjects.driver.comparison.judging import DriverRegion, DriverView, split_unseen
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.time_left.steps import time_left_in

NEAR, FAR = 40.0, 4.0
"""Heights with k above and below 0.5 in a picture of 100 px."""


def walk(*frames: tuple[float, float], track: int = 1, centre: float = 50.0) -> list[Box]:
    """A pedestrian with a height and a detectability in each frame from 0 on."""
    return [
        at(frame, centre, h=h, track=track, detectability=seen)
        for frame, (h, seen) in enumerate(frames)
    ]


def judged(truth: list[Box], **params: float | str) -> Result:
    return result_of(make_dataset(truth), **{"proximity": "height", **params})


def test_the_largest_detectability_up_to_the_first_relevant_frame_counts():
    result = judged(walk((FAR, 0.1), (FAR, 0.3), (NEAR, 0.2), (NEAR, 0.9)))
    row = driver_in(result).table.iloc[0]
    assert (row["detectability"], row["n_known"], row["seen_row"]) == (0.3, 3, -1)
    assert row["n_seen"] == 0
    assert driver_in(result).is_unseen.tolist() == [True]


def test_the_first_frame_at_the_threshold_is_his_confirmation():
    truth = walk((FAR, 0.1), (FAR, 0.5), (FAR, 0.4), (NEAR, 0.8))
    result = judged(truth)
    assert driver_in(result).table["seen_row"].tolist() == [1]
    assert driver_in(result).table["detectability"].tolist() == [0.8]
    assert driver_in(result).table["n_seen"].tolist() == [2]
    assert driver_in(judged(truth, driver_threshold=0.6)).table["seen_row"].tolist() == [3]
    assert driver_in(judged(truth, driver_threshold=0.9)).is_unseen.tolist() == [True]


def test_a_pedestrian_who_is_near_at_once_is_judged_by_his_first_frame():
    result = judged(walk((NEAR, 0.4), (NEAR, 1.0)))
    assert driver_in(result).table["detectability"].tolist() == [0.4]


def test_frames_of_unknown_detectability_are_passed_over():
    result = judged(walk((FAR, NAN), (FAR, 0.6), (NEAR, NAN)))
    row = driver_in(result).table.iloc[0]
    assert (row["detectability"], row["n_known"], row["seen_row"]) == (0.6, 1, 1)


def test_known_only_later_is_unknown_and_counted_apart():
    truth = [*walk((NEAR, NAN), (NEAR, 0.9)), *walk((NEAR, 0.9), track=2, centre=20)]
    result = judged(truth)
    assert driver_in(result).is_known.tolist() == [False, True]
    assert driver_in(result).counts[DriverRegion.UNKNOWN] == 1
    assert driver_in(result).n_known == 1


def test_of_a_distant_encounter_nothing_is_judged():
    result = judged(walk((FAR, 0.9), (FAR, 0.9)))
    assert np.isnan(driver_in(result).table["detectability"][0])
    assert driver_in(result).region.tolist() == [DriverRegion.DISTANT]
    assert not driver_in(result).has_any


def test_of_a_track_twice_in_a_frame_the_larger_detectability_counts():
    truth = [*walk((NEAR, 0.6)), *walk((NEAR, 0.7), centre=60)]
    row = driver_in(judged(truth)).table.iloc[0]
    assert (row["detectability"], row["n_known"], row["seen_row"]) == (0.7, 1, 0)
    assert row["n_seen"] == 1


def test_without_detectability_nothing_is_known_and_no_column_takes_memory():
    dataset = make_dataset([at(0, 50, track=1)])
    assert not dataset.has_detectability
    assert not driver_in(result_of(dataset)).has_any
    bare = Dataset(dataset.recordings, dataset.frames, dataset.boxes, dataset.systems, "")
    assert not bare.has_detectability


EVERY = list(product([True, False], repeat=3))


def eight() -> Result:
    """One encounter of each region: (driver, X, Y) as in `EVERY`, 10 px apart."""
    truth, x, y = [], [], []
    for number, (driver, by_x, by_y) in enumerate(EVERY):
        person = at(0, 10 + 10 * number, track=number + 1, detectability=0.9 if driver else 0.1)
        truth.append(person)
        x += [person._replace(score=1.0)] if by_x else []
        y += [person._replace(score=1.0)] if by_y else []
    truth.append(at(0, 95, track=9))
    return result_of(make_dataset(truth, x, y))


def test_each_of_the_eight_regions_has_its_encounter_and_the_unknown_stands_apart():
    result = eight()
    expected = ["driver_x_y", "driver_x", "driver_y", "driver", "x_y", "x", "y", "nobody"]
    assert driver_in(result).region.tolist() == [*expected, "unknown"]
    assert [driver_in(result).counts[DriverRegion(name)] for name in expected] == [1] * 8
    venn = driver_in(result)
    assert (venn.n_known, venn.n_seen, venn.n_unseen) == (8, 4, 4)


def test_of_whom_the_driver_does_not_see_the_two_systems_split_as_in_their_own_diagram():
    split = split_unseen(driver_in(eight()))
    assert (split.both, split.x_only, split.y_only, split.neither) == (1, 1, 1, 1)
    assert split.distant == 5


flags = st.lists(st.tuples(*[st.booleans()] * 5), max_size=30)


@given(flags)
def test_the_regions_add_up_to_the_categories_of_the_two_systems(rows):
    near, known, driver, x, y = np.array(rows, dtype=bool).reshape(-1, 5).T
    table = {"detectability": np.where(known, 0.5, np.nan), "seen_row": np.where(driver, 7, -1)}
    view = DriverView(pd.DataFrame(table), near, x, y)
    assert sum(view.counts.values()) == len(rows)
    assert view.counts[DriverRegion.DISTANT] == np.count_nonzero(~near)
    both = view.counts[DriverRegion.DRIVER_X_Y] + view.counts[DriverRegion.X_Y]
    assert both == np.count_nonzero(near & known & x & y)
    assert view.n_seen + view.n_unseen + view.counts[DriverRegion.UNKNOWN] == near.sum()


def test_a_higher_threshold_never_makes_him_see_more():
    truth = [b for i in range(9) for b in walk((NEAR, i / 8), track=i + 1, centre=10 + 9 * i)]
    seen = [driver_in(judged(truth, driver_threshold=t)).is_seen.sum() for t in (0.2, 0.5, 0.75, 1)]
    assert seen == [7, 5, 3, 1]


# weighting, against a calculation by hand: k = 1, W = 100, border = distance to the edge


def pair(**params: str) -> Result:
    """Two missed pedestrians at 50 and 30: the nearer to the middle is seen with 0.8."""
    truth = [at(0, 50, track=1, detectability=0.8), at(0, 30, track=2, detectability=0.5)]
    return result_of(make_dataset(truth), **params)


def test_off_nothing_is_weighed_by_detectability():
    result = pair()
    assert result.k_miss is result.k_truth.k
    assert result.x.similarity == pytest.approx([1 - 0.9 * 50 / 50])


def test_on_similarity_severity_and_saliency_weigh_by_what_he_does_not_see():
    result = pair(driver_weighting="on")
    # 0.2 * 50 = 10 px at 50, 0.5 * 30 = 15 px at 30, of W/2 = 50
    assert result.x.similarity == pytest.approx([1 - 0.9 * 15 / 50])
    assert result.x.salient_row.tolist() == [1]
    # 0.1 s a frame
    assert result.x.failures["severity_s"].tolist() == pytest.approx([0.02, 0.03])
    risk = pair(driver_weighting="on", saliency_of="each", saliency_weight="risk")
    assert risk.x.events["weight_s"].tolist() == pytest.approx([0.02, 0.03])
    assert pair().x.failures["severity_s"].tolist() == pytest.approx([0.1, 0.06])


def test_on_what_counts_and_who_is_detected_stay():
    off, on = pair(), pair(driver_weighting="on")
    assert on.category.tolist() == off.category.tolist() == [Category.NEITHER] * 2
    assert on.x.encounters.equals(off.x.encounters)
    assert on.x.events["relevant_s"].tolist() == [pytest.approx(0.1)]


def test_on_unknown_detectability_weighs_in_full():
    truth = [at(0, 50, track=1), at(0, 30, track=2, detectability=1.0)]
    result = result_of(make_dataset(truth), driver_weighting="on")
    assert result.k_miss.tolist() == [1.0, 0.0]


def test_on_without_any_detectability_nothing_changes():
    result = result_of(make_dataset([at(0, 50, track=1)]), driver_weighting="on")
    assert result.k_miss is result.k_truth.k


# time left: contact after 5 s, last chance in frame 29 (see tests/helpers/approach.py)


def met(seen_from: int | None, x: range, y: range, **params: float) -> Result:
    """A pedestrian driven up to whom the driver sees from a frame on; None: unknown."""
    truth = [
        b._replace(detectability=NAN if seen_from is None else float(b.frame >= seen_from))
        for b in approach(range(40), 5)
    ]
    sides = only(approach(range(40), 5), x), only(approach(range(40), 5), y)
    # near enough to count when h = 50 / (5 - t) is 20 px, in frame 25
    return result_of(
        make_dataset(truth, *sides), **{"proximity": "height", "midpoint": 20.0, **params}
    )


ALL, LATE = range(40), range(30, 40)


@pytest.mark.parametrize(
    ("seen_from", "by_driver", "alone_y"),
    [(2, True, False), (27, True, False), (35, False, True), (None, False, False)],
)
def test_neither_the_driver_nor_x_in_time_but_y(seen_from, by_driver, alone_y):
    result = met(seen_from, LATE, ALL)
    assert time_left_in(result).is_urgent.tolist() == [True]
    assert is_driver_in_time(result).tolist() == [by_driver]
    assert is_in_time_alone(result, result.y).tolist() == [alone_y]
    assert is_in_time_alone(result, result.x).tolist() == [False]


def test_who_is_seen_after_he_counts_but_before_the_last_chance_is_in_time_though_unseen():
    result = met(27, LATE, ALL)  # counts from frame 25 on, last chance 29
    assert driver_in(result).is_unseen.tolist() == [True]
    assert is_driver_in_time(result).tolist() == [True]
    assert not is_seen_too_late(result).any()


def test_seen_at_the_last_chance_is_too_late():
    assert is_seen_too_late(met(29, LATE, ALL, midpoint=30.0)).tolist() == [True]
    # near enough to count only when h is 30 px, in frame 34
    assert is_driver_in_time(met(28, LATE, ALL, midpoint=30.0)).tolist() == [True]
    assert is_driver_in_time(met(29, LATE, ALL, midpoint=30.0)).tolist() == [False]


def test_what_both_systems_confirm_in_time_belongs_to_neither_alone():
    result = met(35, ALL, ALL)
    assert not is_in_time_alone(result, result.x).any()
    assert not is_in_time_alone(result, result.y).any()


def test_the_threshold_is_more_than_zero():
    with pytest.raises(Exception, match="driver_threshold: expected more than 0 to 1"):
        Params(driver_threshold=0.0)


@pytest.mark.parametrize("saliency_of", ["most_salient", "each"])
def test_on_a_map_of_settings_weighs_as_the_comparison_does(saliency_of: str):
    heights = [(12.0, 0.9), (20.0, 0.1), (30.0, 0.6), (40.0, 0.2)]
    truth = [*walk(*heights), *walk(*heights[::-1], track=2, centre=30)]
    dataset = make_dataset(truth, [at(1, 40)])
    same = {"proximity": "height", "driver_weighting": "on", "saliency_of": saliency_of}
    start, moved = result_of(dataset, **same), result_of(dataset, midpoint=25.0, **same)
    key = (("midpoint", 25.0),)
    at_0, at_1 = score_setting(start, "similarity", key, ("x",), {})["x"]
    alpha = start.params.alpha
    assert (1 - alpha) * at_0 + alpha * at_1 == pytest.approx(moved.x.summary.mean)
    _, saliency_s = score_setting(start, "saliency", key, ("x",), {})["x"]
    assert saliency_s == pytest.approx(moved.x.saliency_s)
    assert moved.x.saliency_s != pytest.approx(result_of(dataset, midpoint=25.0).x.saliency_s)
