"""Pictures agree with the truth."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from pathlib import Path

import av
import numpy as np
import pytest

from tools.sample import all_recordings
from tools.sample.camera import HEIGHT, WIDTH, Camera
from tools.sample.canvas import Canvas, project_polygon
from tools.sample.render import pictures
from tools.sample.scene import Recording
from tools.sample.truth import sightings, truth_table
from tools.sample.writing import write_video


@pytest.fixture(scope="module")
def rural() -> Recording:
    return next(r for r in all_recordings() if r.name == "rural_road")


@pytest.fixture(scope="module")
def first(rural: Recording) -> np.ndarray:
    return next(pictures(rural))


def test_people_are_brighter_than_what_is_around_them_and_the_sky_is_cold(
    rural: Recording, first: np.ndarray
) -> None:
    assert first.shape == (HEIGHT, WIDTH)
    table = truth_table(rural, sightings(rural))
    box = table[(table["frame"] == 0) & (table["track"] == 1)].iloc[0]
    left, top = int(box["x"]), int(box["y"])
    right, bottom = int(box["x"] + box["w"]) + 1, int(box["y"] + box["h"]) + 1
    inside = first[top:bottom, left:right].mean()
    beside = first[top:bottom, left - 12 : left - 4].mean()
    assert inside > beside + 15
    assert first[:100].mean() < first[380:].mean() - 20


def test_the_same_recording_gives_the_same_pictures(rural: Recording, first: np.ndarray) -> None:
    assert np.array_equal(first, next(pictures(rural)))


def test_the_noise_changes_from_frame_to_frame_while_the_car_stands(rural: Recording) -> None:
    still = replace(rural, speed=((0, 0), (15, 0)), people=(), cars=())
    picture, following = islice(pictures(still), 2)
    difference = picture.astype(float) - following
    assert 0.5 < difference.std() < 4


@pytest.mark.parametrize("name", ["urban_crossing", "odd_pose", "rural_cyclist", "oncoming_glare"])
def test_every_kind_of_thing_can_be_drawn(name: str) -> None:
    recording = next(r for r in all_recordings() if r.name == name)
    first = next(pictures(recording))
    assert first.std() > 10


def test_a_polygon_that_passes_the_camera_is_cut_at_the_near_plane() -> None:
    wall = np.array([[2.0, 0.0, -5.0], [2.0, 0.0, 20.0], [2.0, 3.0, 20.0], [2.0, 3.0, -5.0]])
    outline = project_polygon(Camera(), wall)
    assert outline is not None
    assert len(outline) == 4
    assert outline[:, 0].min() == pytest.approx(WIDTH / 2 + 1100 * 2 / 20)
    assert project_polygon(Camera(), wall - [0.0, 0.0, 30.0]) is None  # behind the camera


def test_painting_outside_the_picture_changes_nothing() -> None:
    picture = np.zeros((HEIGHT, WIDTH), dtype=np.float32)
    canvas = Canvas(picture)
    square = np.array([[-90.0, -90.0], [-80.0, -90.0], [-80.0, -80.0]])
    canvas.paint([(square, 200.0)])
    canvas.paint([])
    canvas.glow(-500.0, 100.0, 5.0, 100.0)
    canvas.glow(WIDTH + 50.0, 100.0, 60.0, 0.0)
    tile = np.ones((4, 4), dtype=np.float32)
    canvas.sprite(tile, tile, (-50.0, -50.0, -40.0, -40.0), 100.0)
    assert not picture.any()


def test_a_painted_square_has_its_grey_inside_and_nothing_outside() -> None:
    picture = np.zeros((HEIGHT, WIDTH), dtype=np.float32)
    square = np.array([[100.0, 100.0], [120.0, 100.0], [120.0, 120.0], [100.0, 120.0]])
    Canvas(picture).paint([(square, 200.0)])
    assert picture[105:115, 105:115] == pytest.approx(np.full((10, 10), 200.0), abs=1.0)
    assert not picture[:95].any()


def test_a_video_has_as_many_frames_as_pictures(tmp_path: Path) -> None:
    grey = [np.full((HEIGHT, WIDTH), 10 * step, dtype=np.uint8) for step in range(12)]
    write_video(tmp_path / "short.mp4", grey)
    with av.open(str(tmp_path / "short.mp4")) as container:
        frames = [frame.to_ndarray(format="gray") for frame in container.decode(video=0)]
        rate = container.streams.video[0].average_rate
    assert len(frames) == 12
    assert rate == 20
