"""Truth of small hand-made recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from nvcore.sample.camera import HEIGHT, WIDTH
from nvcore.sample.scene import Car, Person, Recording
from nvcore.sample.truth import sightings, truth_table

STANDING = Person(((0, 0.0, 40.0), (15, 0.0, 40.0)))
PARKED = Recording("parked", "the car stands", speed=((0, 0), (15, 0)), people=(STANDING,))


def truth_of(**changes: object) -> pd.DataFrame:
    recording = replace(PARKED, **changes)
    return truth_table(recording, sightings(recording))


def test_a_person_behind_another_is_heavily_occluded_and_behind_nothing_is_not() -> None:
    assert set(truth_of()["occlusion"]) == {0}
    table = truth_of(people=(STANDING, Person(((0, 0.0, 30.0), (15, 0.0, 30.0)))))
    assert set(table[table["track"] == 1]["occlusion"]) == {2}
    assert set(table[table["track"] == 2]["occlusion"]) == {0}


def test_a_person_wholly_behind_a_van_or_too_small_is_not_annotated() -> None:
    assert truth_of(cars=(Car(0.0, 25.0, height_m=2.6, width_m=2.2),)).empty
    assert truth_of(people=(Person(((0, 0.0, 260.0), (15, 0.0, 260.0))),)).empty


def test_a_person_leaving_the_picture_ends_when_half_of_the_box_is_out() -> None:
    table = truth_of(people=(Person(((0, 0.0, 20.0), (15, 15.0, 20.0))),))
    assert np.all(table["x"] + table["w"] <= WIDTH)
    last = table.iloc[-1]
    assert last["frame"] < 299
    assert last["x"] + last["w"] == WIDTH


def test_a_cyclist_is_an_ignore_region() -> None:
    assert set(truth_of(people=(replace(STANDING, cyclist=True),))["ignore"]) == {1}


def test_the_distance_is_measured_over_ground() -> None:
    table = truth_of(people=(Person(((0, 5.0, 40.0), (15, 5.0, 40.0))),))
    assert np.allclose(table["distance_m"], np.hypot(5, 40), atol=0.1)


def test_no_box_of_a_near_person_reaches_below_the_picture() -> None:
    table = truth_of(people=(Person(((0, 0.0, 5.0), (15, 0.0, 5.0))),))
    assert len(table) > 0
    assert np.all(table["y"] + table["h"] == HEIGHT)
