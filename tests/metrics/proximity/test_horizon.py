"""The horizon by heights and foot rows: exact cases, outliers, statures, and what does not tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import Box, Place, make_dataset
from places import SAMPLE

from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.metrics.proximity.horizon import (
    LEAST_BOXES,
    MOST_BOXES,
    estimate_horizon,
    estimate_horizons,
)
from nvcore.settings.objects import PEDESTRIAN

HORIZON = 200.0


def people(
    n: int = 6, *, n_boxes: int = 20, noise: float = 0.0, spread: float = 0.0, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Foot rows, heights and numbers of people at all depths, noise in px, statures as a share."""
    draw = np.random.default_rng(seed)
    person = np.repeat(np.arange(n), n_boxes)
    depth = draw.uniform(15, 120, len(person))
    stature = 1.4 * np.exp(spread * draw.standard_normal(n))[person]
    foot = HORIZON + depth + noise * draw.standard_normal(len(person))
    return foot, stature * depth, person


def test_people_of_one_stature_on_flat_ground_give_the_row_exactly() -> None:
    horizon = estimate_horizon(*people())
    assert horizon is not None
    assert horizon.row_px == pytest.approx(HORIZON, abs=1e-6)
    assert horizon.margin_px == pytest.approx(0, abs=1e-6)
    assert (horizon.n_boxes, horizon.n_pedestrians) == (120, 6)
    assert PEDESTRIAN.say(horizon.text) == "row 200 (95 %: 200 to 200; 120 boxes of 6 pedestrians)"
    above = replace(horizon, row_px=-12.4, margin_px=12.0)
    assert above.text.startswith("row −12 (95 %: −24 to 0;")


def test_neither_where_the_picture_starts_nor_its_scale_matters() -> None:
    foot, height, person = people(noise=3, spread=0.08)
    horizon, moved = (
        estimate_horizon(foot, height, person),
        estimate_horizon(2 * foot - 500, 2 * height, person),
    )
    assert horizon is not None
    assert moved is not None
    assert moved.row_px == pytest.approx(2 * horizon.row_px - 500)
    assert moved.margin_px == pytest.approx(2 * horizon.margin_px)


def test_a_child_and_wild_boxes_move_it_little() -> None:
    foot, height, person = people(n=10)
    height[person == 0] *= 0.6
    foot[::17] += 60
    horizon = estimate_horizon(foot, height, person)
    assert horizon is not None
    assert horizon.row_px == pytest.approx(HORIZON, abs=4)


def test_the_interval_holds_the_row_about_as_often_as_it_says() -> None:
    errors, margins = [], []
    for seed in range(60):
        horizon = estimate_horizon(*people(8, noise=4, spread=0.1, seed=seed))
        assert horizon is not None
        errors.append(horizon.row_px - HORIZON)
        margins.append(horizon.margin_px)
    assert np.count_nonzero(np.abs(errors) <= margins) >= 52
    assert np.median(margins) <= 2.4 * np.std(errors)  # Student's t of 8 people, no wider


@pytest.mark.parametrize(
    "boxes",
    [
        people(n=2),
        people(n=6, n_boxes=(LEAST_BOXES - 1) // 6),
        (np.full(60, 300.0), np.linspace(40, 60, 60), np.arange(60) % 6),
        (np.linspace(300, 400, 60), np.linspace(60, 40, 60), np.arange(60) % 6),
        (np.empty(0), np.empty(0), np.empty(0, np.int64)),
    ],
    ids=["two people", "few boxes", "one row", "smaller when nearer", "nobody"],
)
def test_what_does_not_tell_gives_none(boxes: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    assert estimate_horizon(*boxes) is None


def test_of_very_many_boxes_some_are_enough() -> None:
    horizon = estimate_horizon(*people(10, n_boxes=MOST_BOXES // 4, noise=2))
    assert horizon is not None
    assert horizon.n_boxes == 10 * (MOST_BOXES // 4)
    assert horizon.row_px == pytest.approx(HORIZON, abs=1)


def test_each_recording_has_its_own_and_cut_or_hidden_boxes_are_left_out() -> None:
    foot, height, person = people()
    boxes = [
        Box(i, 100, f - h, 30, h, track=int(p), recording=number)
        for number in range(2)
        for i, (f, h, p) in enumerate(zip(foot + 20 * number, height, person, strict=True))
    ]
    # cut by the lower edge, and hidden: their feet are not where the boxes end
    boxes += [Box(i, 100, 380, 30, 100, track=9, recording=0) for i in range(60)]
    boxes += [Box(i, 100, 250, 30, 10, track=8, occlusion=2, recording=0) for i in range(60)]
    size = (range(120), 640.0, 480.0)
    first, second, third = estimate_horizons(
        make_dataset(boxes, places=[Place(*size), Place(*size), Place(*size)])
    )
    assert first is not None
    assert second is not None
    assert (first.n_boxes, first.row_px) == (120, pytest.approx(HORIZON))
    assert second.row_px == pytest.approx(HORIZON + 20)
    assert third is None


def test_an_estimate_with_a_wide_interval_is_none() -> None:
    foot, height, person = people(3, noise=25, spread=0.1, seed=28)
    horizon = estimate_horizon(foot, height, person)
    assert horizon is not None
    assert horizon.margin_px == pytest.approx(69, abs=1)
    boxes = [
        Box(i, 100, f - h, 30, h, track=int(p))
        for i, (f, h, p) in enumerate(zip(foot, height, person, strict=True))
    ]
    assert estimate_horizons(make_dataset(boxes, width=640, height=480)) == (None,)
    (of_large_picture,) = estimate_horizons(make_dataset(boxes, width=640, height=1000))
    assert of_large_picture is not None
    assert of_large_picture.margin_px == pytest.approx(horizon.margin_px)


def test_the_sample_s_own_horizons_lie_within_the_intervals() -> None:
    dataset = load(read_session(SAMPLE))
    stated = dataset.recordings["horizon"]
    for horizon, row_px in zip(estimate_horizons(dataset), stated, strict=True):
        assert horizon is not None
        assert abs(horizon.row_px - row_px) <= horizon.margin_px + 0.5  # boxes in quarters of a px
