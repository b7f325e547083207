"""The pinhole camera and the boxes it gives, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tools.sample.body import joints
from tools.sample.camera import HEIGHT, N_FRAMES, WIDTH, Camera, travelled
from tools.sample.scene import Person
from tools.sample.truth import body_edges


def test_points_are_projected_as_by_a_pinhole() -> None:
    pixels, depth = Camera().project(np.array([0.0, 1.25, 30.0]))
    assert pixels == pytest.approx([WIDTH / 2, HEIGHT / 2])  # straight ahead, at camera height
    assert depth == pytest.approx(30.0)
    pixels, _ = Camera().project(np.array([1.0, 1.25, 22.0]))
    assert pixels[0] - WIDTH / 2 == pytest.approx(1100 / 22)
    pixels, _ = Camera(horizon=232.0).project(np.array([0.0, 0.0, 1e7]))
    assert pixels[1] == pytest.approx(232.0, abs=1e-3)  # the road far away


def test_the_road_on_an_image_row_projects_back_to_that_row() -> None:
    camera = Camera(horizon=232.0)
    distance = camera.ground_depth(np.array([300.0]))
    pixels, _ = camera.project(np.array([0.0, 0.0, float(distance[0])]))
    assert pixels[1] == pytest.approx(300.0)


def test_the_way_of_a_car_is_the_integral_of_its_speed() -> None:
    assert travelled(((0, 8), (15, 8)))[200] == pytest.approx(80.0)
    slowing = travelled(((0, 8), (10, 0)))
    assert slowing[[200, N_FRAMES - 1]] == pytest.approx([40.0, 40.0])


@pytest.mark.parametrize(("height_m", "distance_m"), [(1.75, 35.0), (1.1, 20.0), (1.9, 60.0)])
def test_a_standing_person_is_focal_length_times_height_over_distance_high(
    height_m: float, distance_m: float
) -> None:
    person = Person(((0, 0.0, distance_m), (15, 0.0, distance_m)), height_m)
    edges, _ = body_edges(person, joints(person), Camera())
    expected = 1100 * height_m / distance_m
    assert edges[0, 3] - edges[0, 1] == pytest.approx(expected, rel=0.03)


def test_the_feet_of_a_walking_person_stay_on_the_road() -> None:
    person = Person(((0, -4.0, 20.0), (15, 14.0, 20.0)), 1.75)
    soles = joints(person)[..., 1].copy()
    lowest = np.nanmin(soles, axis=1) - 0.018 * 1.75
    assert lowest == pytest.approx(np.zeros(N_FRAMES), abs=1e-9)


def test_a_crouching_person_is_lower_than_two_thirds_of_the_standing_height() -> None:
    crouching = Person(((0, 0.0, 20.0), (15, 0.0, 20.0)), 1.75, crouch=((0, 1), (15, 1)))
    edges, _ = body_edges(crouching, joints(crouching), Camera())
    assert edges[0, 3] - edges[0, 1] < 1100 * 1.75 / 20 * 2 / 3
